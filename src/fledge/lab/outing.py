"""One flight of the physical experiment: controller and twin in lock-step, kept row by row, and what came of it.

A flight goes from the pad back to the floor; it is scored from the moment its pilot first flies, for `seconds`,
*whatever happens meanwhile*: if a net holds the vehicle while the formation drives away, or an alarm brings it down,
that is in the rows. (The counts of `tally` are taken while the pilot flies, and from the climb to the order to land.)

A row is five ticks: the world as it truly was when it began, what was seen and said, and what became of it.

A flight may be `reversed`: both sticks of its pilot are, as if somebody had mixed up a sign, and nobody leads it back
to a formation that it has lost. That is what a net is for.

The way of the formation comes from the seed alone, so the simulator can fly the same one (`track`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any, NamedTuple

import numpy as np

from fledge.episode import Episode, Flight, over
from fledge.formation import FormationControl
from fledge.lab import opening
from fledge.lab.control.outfit import AXES, Outfit
from fledge.lab.control.phases import ALOFT, Phase
from fledge.lab.control.tick import Controller
from fledge.lab.lockstep import Tick, fly_lockstep, judged
from fledge.lab.shell.rows import spread, together
from fledge.lab.twin.twin import Options, Twin
from fledge.manoeuvres import Plan
from fledge.observation import ROW_RATE, Axes
from fledge.pilots import AbstractPilot
from fledge.safety import AbstractNet
from fledge.supervision.watchdog import TICK
from fledge.world import Arena

TICKS_PER_ROW = round(1.0 / (ROW_RATE * TICK))
GETTING_THERE = 60.0
"""[s] for what comes before and after; a take-off, a climb and a landing take half of it."""
SPARE = 5.0
"""[s] that the formation's way lasts longer than the flight: it begins once the UAV was overhead for a second."""
REVERSED = Axes(-1.0, -1.0, 0.0)


@dataclass(frozen=True, slots=True)
class Outing:
    """What is to be flown."""

    pilot: AbstractPilot
    net: AbstractNet
    seed: int
    """Of the twin: the formation's way, the weather, the errors of sensors and cameras."""
    names: tuple[str, str] = ("pilot", "net")
    """What pilot and net are called."""
    arena: Arena = Arena.lab()
    seconds: float = 30.0
    """For how long the pilot flies."""
    reversed: bool = False

    @property
    def rows(self) -> int:
        """How many there are of a flight."""
        return round(self.seconds * ROW_RATE)

    def controller(self) -> Controller:
        """Who flies it; nobody attends."""
        pilot, net = self.names
        outfit = Outfit(self.arena, pilot, net, duration=self.seconds, unattended=True)
        made = outfit.controller(self.pilot, self.net)
        if not self.reversed:
            return made
        guidance, phases = replace(made.guidance, axes=REVERSED), replace(made.phases, lost=inf)
        return replace(made, guidance=guidance, phases=phases)


class Found(NamedTuple):
    """What came of a flight."""

    numbers: dict[str, Any]
    """In plain JSON: those of `lockstep.judged`; `aloft_s`; the share of rows in which the UAV was `held`; how many
    contacts came after the order to land."""
    flight: Flight | None
    """None if its pilot never flew."""


def fly(outing: Outing) -> Found:
    """Fly it."""
    twin = Twin(outing.arena, outing.seed, Options(duration=outing.seconds + SPARE))
    ticks = fly_lockstep(outing.controller(), twin, outing.seconds + GETTING_THERE)
    notes = Notes()
    numbers = judged(_kept(ticks, notes, outing.rows), twin, outing.arena)
    held = [bool(row.verdicts[0].intervened > 0.5) for row in notes.rows]
    numbers |= {
        "seed": outing.seed,
        "rows": len(held),
        "aloft_s": round(notes.aloft * TICK, 2),
        "held": sum(held) / len(held) if held else None,
        "contacts_landing": sum(one.t > notes.landing for one in twin.contacts),
    }
    return Found(numbers, _flight(outing, together(notes.rows)) if held else None)


def track(seed: int, arena: Arena, seconds: float) -> Plan:
    """The formation's way in a flight with this seed, as arrays of `seconds` at 20 Hz."""
    rows = round((seconds + SPARE) * ROW_RATE)
    plan = opening.draw(np.random.default_rng([seed, 0]), arena, rows, FormationControl())
    some = {name: np.array(getattr(plan.track, name))[: round(seconds * ROW_RATE)] for name in TRACK}
    return replace(plan, track=replace(plan.track, **some))


TRACK = ("x", "y", "vx", "vy", "spread", "spread_rate")


@dataclass(slots=True)
class Notes:
    """What is taken down while a flight is flown; the one record here that changes."""

    rows: list[Episode] = field(default_factory=list)
    aloft: int = 0
    """Ticks from the climb to the order to land."""
    landing: float = inf
    """When that was [s]."""


def _kept(ticks: Iterator[Tick], notes: Notes, most: int) -> Iterator[Tick]:
    """The same ticks, taken down as they pass; `most` rows."""
    row: list[Tick] = []
    begun = False
    for tick in ticks:
        phase = tick.said.phase
        begun = begun or phase is Phase.FLY
        notes.aloft += phase in ALOFT
        if phase is Phase.LAND:
            notes.landing = min(notes.landing, tick.heard.t)
        if begun and len(notes.rows) < most:
            row.append(tick)
            if len(row) == TICKS_PER_ROW:
                notes.rows.append(as_row(row))
                row = []
        yield tick


def as_row(ticks: Sequence[Tick]) -> Episode:
    """A row of a flight, of its five ticks; its leaves are numbers."""
    world, said = ticks[0].world, ticks[0].said
    assert said.observation is not None and said.action is not None and said.proposed is not None
    vehicles = zip(*(tick.said.decisions for tick in ticks), strict=True)
    verdicts = tuple(over([one.verdict for one in decisions]) for decisions in vehicles)
    return Episode(world, said.observation, said.action, said.proposed, verdicts, spread(world))


def _flight(outing: Outing, episode: Episode) -> Flight:
    pilot, net = outing.names
    return Flight(episode, "lab", pilot, net, outing.seed, 0, AXES, outing.arena)
