"""Controller and twin joined by a loop in one process: as fast as it goes, and every byte through the codecs.

In tick k the twin moves by 10 ms, hearing what the controller said in tick k - 1, and what it says reaches the
controller in tick k, or `late` ticks after. No clock, no chance but the twin's: the same seed, the same flight.

The flight is over when the vehicle is back on the floor, or where its time is up; what came of it is judged by the
truth (`tally`), and by the twin's own contacts.
"""

from collections import deque
from collections.abc import Iterator
from typing import Any, NamedTuple, Protocol

from fledge.lab.control.phases import Phase
from fledge.lab.control.tick import Controller, Said
from fledge.lab.shell.tally import Tally, summary
from fledge.lab.wire.datagrams import Datagram, Heard
from fledge.supervision.watchdog import TICK
from fledge.world import Arena, WorldState

LONGEST = 180.0
"""[s] after which a flight is not waited for any more; chosen: half of it takes off, flies for 30 s and lands."""


class Moving(Protocol):
    """A twin, as far as a flight in lock-step goes."""

    contacts: Any
    """Who touched what, one entry for each time."""

    def tick(self, heard: Heard) -> tuple[Datagram, ...]:
        """10 ms later."""
        ...

    def world(self) -> WorldState:
        """The truth."""
        ...


class Tick(NamedTuple):
    """One of a flight's."""

    heard: Heard
    """By the controller."""
    said: Said
    world: WorldState
    """The truth."""


def fly_lockstep(
    controller: Controller, twin: Moving, seconds: float = LONGEST, late: int = 0
) -> Iterator[Tick]:
    """Fly, tick by tick, until the flight is over, or for so many seconds; datagrams arrive `late` ticks late."""
    memory, said = controller.init(), ()
    under_way: deque[tuple[Datagram, ...]] = deque([()] * late)
    for number in range(round(seconds / TICK)):
        t = number * TICK
        under_way.append(twin.tick(Heard(t, said)))
        heard = Heard(t, under_way.popleft())
        memory, spoken = controller.step(memory, heard)
        said = spoken.datagrams
        yield Tick(heard, spoken, twin.world())
        if spoken.phase is Phase.OVER:
            return


def judged(flight: Iterator[Tick], twin: Moving, arena: Arena) -> dict[str, Any]:
    """Fly to the end, and say what came of it, in plain JSON values; contacts are those that the twin found."""
    tally = Tally(arena)
    count, phase = tally.init(), Phase.WAIT
    for _, said, world in flight:
        count, phase = tally.step(count, world.t, said, world), said.phase
    found = summary(count)
    return found | {
        "ticks": count.ticks,
        "landed": phase is Phase.OVER,
        "contacts": len(twin.contacts),
        "touched": sorted({f"{one.who}, {one.what}" for one in twin.contacts}),
    }
