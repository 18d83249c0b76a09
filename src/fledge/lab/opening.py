"""How a day in the twin's lab begins: the formation's plan, its corners, and the pad the UAV takes off from.

The plan is lateral motion, as in the paper's physical part: `FixedAltitude` along a held-out path, a circumradius of
0.7 to 0.8 m, a reach of 0.7 m about the middle of the safe area (D10). It is drawn until all corners it begins at are
clear of walls and obstacles. The pad lies near that corner of the safe area which is farthest from everything else.
"""

from collections.abc import Sequence
from dataclasses import fields, replace
from math import inf
from typing import Any

import numpy as np

from fledge.dynamics import REAL_AR_DRONE
from fledge.errors import FledgeError
from fledge.formation import FormationControl
from fledge.geometry import Box
from fledge.manoeuvres import FixedAltitude, FormationTrack, Plan
from fledge.manoeuvres.paths import HELD_OUT_FAMILIES
from fledge.scalars import sqrt
from fledge.world import Arena

SPREADS = (0.7, 0.75, 0.8)
"""[m] (D10)."""
REACH = 0.7
"""[m]; leaves every UGV 0.6 m to the lab's walls."""
FREE = 0.15
"""[m] between hull and wall or obstacle at the corners; chosen, a little more than the guidance keeps."""
TRIES = 200
INSET = 0.8
"""[m] from the walls to the middle of the pad; chosen, more than the nets ask of a UAV that stands."""


def draw(rng: np.random.Generator, arena: Arena, rows: int, formation: FormationControl) -> Plan:
    """A plan of `rows` rows at 20 Hz, in plain numbers.

    Raises:
        FledgeError: the formation has no room in this arena.
    """
    for _ in range(TRIES):
        plan = _drawn(rng, arena, rows)
        if all(_free(arena, *corner) > FREE for corner in _corners(plan, formation)):
            return plan
    raise FledgeError(
        f"the UGVs' formation, {SPREADS[0]} to {SPREADS[-1]} m about its middle, found no place to begin in "
        f"{TRIES} tries: valid is an arena with room for it about the middle of its bounds"
    )


def pad(arena: Arena, ugvs: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Where the UAV stands [m], the UGVs being there.

    Raises:
        FledgeError: none of the four corners is free.
    """
    b = arena.bounds
    corners = [(x, y) for x in (b.x_min + INSET, b.x_max - INSET) for y in (b.y_min + INSET, b.y_max - INSET)]
    room = [_free(arena, x, y, REAL_AR_DRONE.radius, ugvs) for x, y in corners]
    best = max(room)
    if best < FREE:
        raise FledgeError(
            f"no corner of the safe area has room for the UAV to take off: valid is one free {INSET} m from its walls"
        )
    return corners[room.index(best)]


def _drawn(rng: np.random.Generator, arena: Arena, rows: int) -> Plan:
    b = arena.bounds
    manoeuvre = FixedAltitude(HELD_OUT_FAMILIES, float(rng.choice(SPREADS)), REACH, arena)
    plan = manoeuvre.plan(rng, rows)
    track = replace(
        plan.track,
        x=plan.track.x + 0.5 * (b.x_min + b.x_max),
        y=plan.track.y + 0.5 * (b.y_min + b.y_max),
    )
    lists: list[Any] = [getattr(track, field.name).tolist() for field in fields(FormationTrack)]
    return Plan(arena, FormationTrack(*lists), float(plan.orientation))


def _corners(plan: Plan, formation: FormationControl) -> list[tuple[float, float, float]]:
    """Middle and radius of every UGV in the first row [m]."""
    first = FormationTrack(*(getattr(plan.track, field.name)[0] for field in fields(FormationTrack)))
    places = formation.corners(first, plan.orientation)
    return [(x, y, model.radius) for (x, y, _, _), model in zip(places, formation.fleet, strict=True)]


def _free(
    arena: Arena, x: float, y: float, radius: float, others: Sequence[tuple[float, float]] = ()
) -> float:
    """How far a disc is from the walls, from obstacles and from other vehicles' middles [m]."""
    within = -arena.bounds.distance(x, y)
    boxes = [_apart(one.footprint, x, y) for one in arena.obstacles]
    middles = [sqrt((x - a) ** 2 + (y - b) ** 2) for a, b in others]
    return min([within, *boxes, *middles], default=inf) - radius


def _apart(box: Box, x: float, y: float) -> float:
    return box.distance(x, y)
