"""The clock of a stream without one: frame number and receipt -> when the frame was measured.

Vicon counts its frames and stamps none (`vicon`). Counted at `rate`, a frame was measured at

    stamp = number / rate + offset - least,    offset = the least of received - number / rate seen lately

so the fastest datagram of late is taken to have been under way for `least`, and every other for as much longer as it
came later. That is the assumption, and all that is assumed: a delay that every datagram shares beyond `least` shows
nowhere. The offset forgets by `drift`, so that it follows two quartzes that disagree; between two frames it hardly
moves, and velocities are differences of stamps.

Lost, late, repeated and reordered frames are stamped as what they are. A number that is ahead of its time counts as
measured at its receipt. One that is more than `patience` behind is stamped as old as it says it is. Either way the
counter may have started anew: that is believed once `agreeing` frames in a row arrive at the pace at which they are
counted. What waited in a buffer arrives faster, and stays old.

A sender that stamps its messages by a clock of its own, as in ROS, is read in the same way: its stamps are numbers, at
a rate of 1.
"""

from dataclasses import dataclass
from typing import NamedTuple


class Reading(NamedTuple):
    """What is remembered of a stream."""

    offset: float
    """From counted time to ours [s]."""
    received: float
    """When the last frame came [s]."""
    other: float
    """The offset that frames out of step ask for [s]."""
    agreed: int
    """How many of those in a row asked for it."""


@dataclass(frozen=True, slots=True)
class Clock:
    """Whose stream, and how far it is trusted."""

    rate: float = 100.0  # [frames/s] the paper's Vicon
    least: float = 0.005  # [s] the fastest datagram takes; chosen: capture and network take 5 to 10 ms
    drift: float = 1e-4  # [s/s] chosen: two quartzes differ by less
    early: float = 0.02  # [s] by which a frame may be faster than all before it, chosen: two frames
    patience: float = 2.0  # [s] that a datagram may be late; chosen: beyond it, poses are too old to fly by
    agreeing: int = 10  # frames that make a new beginning; chosen, 0.1 s
    pace: float = 0.02  # [s] that those may come earlier or later than counted; chosen, two frames

    def init(self) -> Reading | None:
        """Nothing came yet."""
        return None

    def step(self, memory: Reading | None, number: float, received: float) -> tuple[Reading, float]:
        """(memory, when the frame was measured [s]); `received` is our time [s] of its receipt."""
        counted = number / self.rate
        found = received - counted
        if memory is None:
            memory = Reading(found, received, found, 0)
        elif found < memory.offset - self.early or found > memory.offset + self.patience:
            memory = self._astray(memory, found, received)
        else:
            offset = memory.offset + self.drift * max(received - memory.received, 0.0)
            memory = Reading(min(offset, found), received, found, 0)
        return memory, min(counted + memory.offset, received) - self.least

    def _astray(self, memory: Reading, found: float, received: float) -> Reading:
        """After a frame that is out of step with those before."""
        if not abs(found - memory.other) <= self.pace or memory.agreed == 0:
            return Reading(memory.offset, received, found, 1)
        if memory.agreed + 1 < self.agreeing:
            return memory._replace(received=received, agreed=memory.agreed + 1)
        return Reading(found, received, found, 0)
