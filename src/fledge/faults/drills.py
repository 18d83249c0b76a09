"""Flights in which something goes wrong: what is drawn before them, and how what came of them is judged.

Three phases: climbing in from low above the UGVs, cruising through a Combined flight among obstacles, and pushing at a
wall with all four vehicles. A drill uses up the contract like an attack (`scenarios.draw_trouble`).
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fledge.falsification.scenarios import Terms, draw_trouble
from fledge.falsification.trouble import Trouble
from fledge.faults.catalogue import FAULTS, FLYING_ON, Fault
from fledge.geometry import Vec3
from fledge.manoeuvres import Combined, FormationTrack
from fledge.manoeuvres.combined import OBSTACLES
from fledge.pilots import Servo
from fledge.scalars import Scalar
from fledge.simulation import Case, Crew, start
from fledge.supervision.modes import Mode
from fledge.world import Arena, WorldState

PHASES = {"climb": (0.5, 2.0), "cruise": (4.0, 8.0), "wall": (4.0, 6.0)}
"""When a fault begins in each, earliest and latest [s]."""
ROWS = 800
"""Of a flight at 20 Hz: a lost link lands it after 10 s, from up to 4 m, at 0.3 m/s, and it may have to go aside."""
LOW = 0.8
"""[m] above the floor, from which a UAV climbs in."""
ASIDE = 1.2
"""[m] from the wall at which the first of those that push at it begins."""


STANDING = 0.15
"""[m/s] below which a vehicle holds, or stands: above the drift that the contract allows."""


class Drill(NamedTuple):
    """Everything drawn before a flight but the chance of its ticks."""

    fault: Scalar
    """An index into `FAULTS`."""
    begins: Scalar
    """[s]."""
    ends: Scalar
    """[s]."""
    struck: tuple[Scalar, ...]
    """Flags, the UAV's first."""
    luck: Scalar
    """In [0, 1)."""
    arena: Arena
    world: WorldState
    track: FormationTrack
    """Where the formation should be, leaves of shape (rows,)."""
    orientation: Scalar
    trouble: Trouble
    pushing: Scalar
    """1: everybody is told to go east, into the wall."""


class Report(NamedTuple):
    """What came of one drill; per vehicle, the UAV first."""

    gaps: tuple[Scalar, ...]
    """Smallest gap to anything [m]; who touched something has at most 0."""
    modes: tuple[Scalar, ...]
    """The last."""
    speeds: tuple[Scalar, ...]
    """At the end [m/s]."""
    named: tuple[Scalar, ...]
    """[s] from the fault to its name; infinite if it was never named."""
    showing: Scalar
    """[s] for which the data have shown it without a break, and it was not named."""
    overdue: Scalar
    """1: that was once longer than it may be."""


class Judgement(NamedTuple):
    """Of many drills with one fault; arrays of shape (drills,)."""

    touched: np.ndarray
    """Whether anybody touched anything."""
    safe: np.ndarray
    """Whether everybody ended in a mode that was declared, and stood if it was to stand."""
    named: np.ndarray
    """[s] until the fault was named for every vehicle struck; infinite if it was not."""
    overdue: np.ndarray
    """Whether that took too long."""


def draw_drill(fault: Fault, phase: str, key: Sequence[int], terms: Terms = Terms()) -> Drill:
    """The drill that a key stands for; faults differ in how long they last and whom they strike."""
    rng = np.random.default_rng(list(key))
    case = Case.draw(Combined(), rng.integers(2**31, size=2).tolist(), ROWS)
    first, length, group, luck = rng.uniform(size=4).tolist()
    earliest, latest = (0.0, 0.0) if fault.from_start else PHASES[phase]
    shortest, longest = fault.lasts
    begins = earliest + first * (latest - earliest)
    lasts = shortest if shortest == longest else shortest + length * (longest - shortest)
    struck = fault.strikes[int(group * len(fault.strikes))]
    arena, world = _scene(phase, case, terms)
    return Drill(
        float(FAULTS.index(fault)),
        begins,
        begins + lasts,
        tuple(float(i in struck) for i in range(terms.vehicles)),
        luck,
        arena.padded(OBSTACLES),
        world,
        case.plan.track,
        case.plan.orientation,
        # Links are for the faults to cut.
        draw_trouble(rng, terms)._replace(cut=0.0),
        float(phase == "wall"),
    )


def _scene(phase: str, case: Case, terms: Terms) -> tuple[Arena, WorldState]:
    """Where a phase begins."""
    arena, world = case.plan.arena, start(case, Crew(Servo()), terms.rig).world
    if phase == "climb":
        place = replace(world.uav.position, z=LOW)
        return arena, replace(world, uav=replace(world.uav, position=place))
    if phase == "wall":
        east = arena.bounds.x_max - ASIDE - max(ugv.x for ugv in world.ugvs)
        uav = replace(world.uav, position=world.uav.position + Vec3(east, 0.0, 0.0))
        ugvs = tuple(replace(ugv, x=ugv.x + east) for ugv in world.ugvs)
        return replace(arena, obstacles=()), WorldState(world.t, uav, ugvs)
    return arena, world


def judge(fault: Fault, report: Report, drills: Sequence[Drill]) -> Judgement:
    """What came of drills with one fault, held against what was said of it beforehand."""
    gaps, modes, speeds, named = map(np.array, (report.gaps, report.modes, report.speeds, report.named))
    struck = np.array([drill.struck for drill in drills]).T > 0.5
    declared = np.where(struck, np.isin(modes, fault.ends), np.isin(modes, (*fault.ends, *FLYING_ON)))
    stands = ~np.isin(modes, (Mode.HOLD, Mode.STOPPED)) | (speeds < STANDING)
    return Judgement(
        np.any(gaps <= 0.0, axis=0),
        np.all(declared & stands, axis=0),
        np.where(struck, named, 0.0).max(axis=0),
        np.asarray(report.overdue) > 0.5,
    )
