"""When a tick may begin: slots of a fixed length, one tick to each, on a grid that does not drift.

A tick begins when a pose arrives, in its slot; if none does, when the slot ends. A tick that is late begins in the
slot it finds itself in: those that passed without one are missed, counted, and never made up for.

The grid is absolute, but for one thing: where poses come, it is moved so that they come in the middle of their
slots, by at most 50 us a tick. Two clocks differ by some 50 ppm, so without that a pose would cross the edge of a slot
every few minutes, and two poses meet in one tick while the next has none.

Times are whole nanoseconds of one monotonic clock.
"""

from dataclasses import dataclass
from typing import NamedTuple

PERIOD = 10_000_000
"""[ns] 100 Hz."""


class Slot(NamedTuple):
    """When one tick may begin."""

    begins: int
    """[ns]."""
    ends: int
    """[ns]."""


@dataclass(frozen=True, slots=True)
class Pacer:
    """How slots follow each other."""

    period: int = PERIOD
    """[ns]."""
    slew: int = 50_000
    """[ns] by which the grid moves in a tick at most; chosen: to the middle within a second, 0.5 % of a period."""
    gain: int = 16
    """One part in so many of what a pose is off is made up for in a tick; chosen: jitter of 1 ms moves it by 50 us."""

    def first(self, now: int) -> Slot:
        """The slot that begins now."""
        return Slot(now, now + self.period)

    def next(self, slot: Slot, now: int, pose: int | None = None) -> tuple[Slot, int]:
        """(the next slot in which a tick can begin, how many were missed before it).

        Args:
            slot: That of the tick that is just over.
            now: [ns].
            pose: When the newest pose came that the tick saw [ns]; None if there was none.
        """
        begins = slot.ends + self._moved(slot, pose)
        missed = max((now - begins) // self.period, 0)
        return self.first(begins + missed * self.period), missed

    def _moved(self, slot: Slot, pose: int | None) -> int:
        if pose is None:
            return 0
        off = pose - (slot.begins + slot.ends) // 2
        return min(max(off // self.gain, -self.slew), self.slew)
