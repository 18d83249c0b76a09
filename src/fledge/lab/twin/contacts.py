"""Who touched what in the twin's room, when, and who says so.

*Physics*: MuJoCo found two hulls in touch, as they really are, a box and a cylinder, say.

*Referee*: `clearance` found no distance left. To it hulls are discs, somewhat larger than the things themselves, the
safe area has walls, and so has its ceiling. It is the referee of the study, so both count the same; and it is
stricter.

That the UAV stands on the floor is no contact, and that it comes down or takes off neither; but to touch the floor
while it is to fly is one.
"""

from collections.abc import Iterable
from dataclasses import replace
from enum import Enum
from typing import NamedTuple

from fledge.clearance import clearance, clearances, from_things
from fledge.dynamics import REAL_AR_DRONE, UGV_FLEET
from fledge.geometry import Box, Vec3
from fledge.lab.twin.bodies import NAMES, UAV_NAME
from fledge.world import Arena, WorldState

VEHICLES = (UAV_NAME, *NAMES)
FLOOR = "floor"
AREA = "edge of the safe area"

FAR = 1e6
NOWHERE = Box(-FAR, FAR, -FAR, FAR)
"""Walls that nobody reaches [m]."""


class Witness(Enum):
    """Who says so."""

    PHYSICS = "physics"
    REFEREE = "referee"


class Contact(NamedTuple):
    """One touch, from when it began."""

    t: float
    """[s] of the twin's time."""
    who: str
    """A vehicle."""
    what: str
    """Another, an obstacle, the floor, or the edge of the safe area."""
    witness: Witness


Touch = tuple[str, str, Witness]
"""Who, what, and who says so."""


def physical(touching: Iterable[tuple[str, str]]) -> set[Touch]:
    """What MuJoCo found, the vehicle first, of two vehicles that which comes first in `VEHICLES`."""
    found: set[Touch] = set()
    for pair in touching:
        who, what = sorted(pair, key=lambda name: VEHICLES.index(name) if name in VEHICLES else len(VEHICLES))
        found.add((who, what, Witness.PHYSICS))
    return found


def refereed(arena: Arena, world: WorldState) -> set[Touch]:
    """What the referee finds; the UAV on the floor included."""
    gaps = clearances(arena, world, REAL_AR_DRONE, UGV_FLEET)
    if all(nearest.gap > 0.0 for nearest in gaps):
        return set()
    return {
        (VEHICLES[i], what, Witness.REFEREE)
        for i, nearest in enumerate(gaps)
        if nearest.gap <= 0.0
        for what in _touched(arena, world, i)
    }


def _touched(arena: Arena, world: WorldState, i: int) -> list[str]:
    """The names of all that a vehicle touches; one thing after the other is looked at by itself."""
    found = [
        f"obstacle{k}" for k in range(1, 1 + len(arena.obstacles)) if _gap(_only(arena, k), world, i) <= 0.0
    ]
    z, half_height = world.uav.position.z, REAL_AR_DRONE.half_height
    if _gap(replace(arena, obstacles=()), world, i) <= 0.0 or (i == 0 and z + half_height >= arena.ceiling):
        found.append(AREA)
    if i == 0 and z - half_height <= 0.0:
        found.append(FLOOR)
    return found + [VEHICLES[j] for j in range(i + 1, len(VEHICLES)) if _between(world, i, j) <= 0.0]


def _gap(arena: Arena, world: WorldState, i: int) -> float:
    """From a vehicle to walls and obstacles [m]."""
    return from_things(arena, world, REAL_AR_DRONE, UGV_FLEET)[i].gap


def _only(arena: Arena, k: int) -> Arena:
    """Its obstacle `k`, counted from 1, and nothing else anywhere near."""
    return Arena(NOWHERE, FAR, arena.obstacles[k - 1 : k])


def _between(world: WorldState, i: int, j: int) -> float:
    """From one vehicle to another, the first before the second in `VEHICLES` [m]."""
    up = Vec3(0.0, 0.0, FAR)
    uav = world.uav if i == 0 else replace(world.uav, position=up)
    chosen = [k - 1 for k in (j, i) if k > 0]
    pair = WorldState(world.t, uav, tuple(world.ugvs[k] for k in chosen))
    fleet = tuple(UGV_FLEET[k] for k in chosen)
    return clearance(Arena(NOWHERE, FAR), pair, REAL_AR_DRONE, fleet, 1).gap
