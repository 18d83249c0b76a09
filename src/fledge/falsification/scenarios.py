"""What is drawn before an attack: arena, starts, how badly the contract's bounds are used, and the attack itself.

Drawn on the host in NumPy, once per flight, as manoeuvres are: it takes rejection sampling, and then is data to the
compiled program. What is rejected is counted. Starts crowd near walls and obstacles, where nets are tried.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import hypot
from typing import NamedTuple

import numpy as np

from fledge.clearance import clearance
from fledge.errors import FledgeError
from fledge.falsification.attacks import SEGMENTS, Nature
from fledge.falsification.trouble import Trouble
from fledge.geometry import Box, Quat, Vec3
from fledge.safety import Contract
from fledge.scalars import Scalar
from fledge.simulation import TICK, Rig
from fledge.world import Arena, Obstacle, UavState, UgvState, WorldState

ROOMY = (0.3, 0.2)
"""[m] free hull to hull that the UAV, and a UGV, has at the start and needs for a way out: a stop at a crawl."""
NEAR, CROWDED = 1.0, 0.6
"""A start is near a wall or an obstacle within so many [m]; this share of them is looked for there."""
MOST_OBSTACLES = 10
PASSAGE = 1.6
"""[m] least width of a gap between things that is not closed altogether: every vehicle gets through."""
TRIES = 50
"""To place an obstacle."""
HALLS = ((0.7, (5.0, 5.0, 6.0)), (1.0, (3.3, 2.5, 4.0)))
"""(cumulative odds, (half length, half width, ceiling) [m]): the paper's arena and a room like its lab."""
PLACES = 400
"""Tried for the vehicles of one scenario."""
STARTS = 100
"""Tried in an arena that is given."""


@dataclass(frozen=True, slots=True)
class Terms:
    """What scenarios are drawn for."""

    rig: Rig = Rig()
    contract: Contract = Contract()
    factor: float = 1.0
    """By which the contract is overstepped; up to 1 is within it."""
    arena: Arena | None = None
    """Where to fly, if not in random arenas."""
    attack_ticks: int = 1000
    """Length of the attack [10 ms]."""
    retreat_ticks: int = 1000
    """Length of the retreat after it [10 ms]."""

    @property
    def ticks(self) -> int:
        """Of a whole flight."""
        return self.attack_ticks + self.retreat_ticks

    @property
    def vehicles(self) -> int:
        """How many there are, the UAV among them."""
        return 1 + len(self.rig.formation.fleet)

    def late(self, bound: float) -> float:
        """A delay [s] of the contract in ticks, as far as it is overstepped."""
        return bound * self.factor / self.contract.period


class Scenario(NamedTuple):
    """Everything drawn before a flight but the attackers' chance."""

    arena: Arena
    world: WorldState
    trouble: Trouble
    nature: Nature
    focus: Scalar
    """Which vehicle is led away at the end; 0 is the UAV."""


class Draw(NamedTuple):
    """A scenario, and what drawing it took."""

    scenario: Scenario
    rejected: int
    """Arenas before this one: gaps too narrow, or no room for the vehicles."""
    near: int
    """Vehicles that start within `NEAR` of a wall or an obstacle."""


class Start(NamedTuple):
    """Where everybody stands."""

    world: WorldState
    near: int


def draw_scenario(
    rng: np.random.Generator, family: int, focus: int, terms: Terms, script: np.ndarray | None = None
) -> Draw:
    """A scenario for a family of attacks; `script`, shape (segments, 3), is drawn where none is given.

    Raises:
        FledgeError: an arena was given that has no room for the vehicles.
    """
    arena, start, rejected = _place(rng, terms)
    trouble = draw_trouble(rng, terms)
    lines = rng.uniform(-1.0, 1.0, (SEGMENTS, 3)) if script is None else script
    nature = Nature(
        float(family),
        _vector(rng.uniform(-1.0, 1.0, 3)),
        float(rng.uniform(0.05, 1.2)),
        float(rng.uniform(0.1, 1.5)),
        tuple(map(_vector, lines)),
        terms.attack_ticks * TICK,
    )
    return Draw(Scenario(arena, start.world, trouble, nature, float(focus)), rejected, start.near)


def draw_trouble(rng: np.random.Generator, terms: Terms) -> Trouble:
    """The whole of every bound on half the flights, some of it on the others."""
    way = rng.normal(size=3)
    way /= np.linalg.norm(way)
    worst = rng.random() < 0.5
    age, latency = terms.late(terms.contract.age), terms.late(terms.contract.latency)
    return Trouble(
        float(round(age if worst else rng.uniform(0.0, age))),
        float(round(latency if worst else rng.uniform(0.0, latency))),
        terms.factor * (1.0 if worst else rng.uniform()),
        float(rng.random() < 0.5),
        _vector(way),
        float(rng.random() < 0.5),
    )


def _vector(numbers: np.ndarray) -> Vec3:
    return Vec3(*map(float, numbers))


# Arenas.


def draw_arena(rng: np.random.Generator) -> tuple[Arena, int]:
    """(a random arena with 0 to 10 obstacles, how many were rejected before it)."""
    count, rejected = int(rng.integers(MOST_OBSTACLES + 1)), 0
    while True:
        arena = _try_arena(rng, count)
        if arena is not None:
            return arena, rejected
        rejected += 1


def _try_arena(rng: np.random.Generator, count: int) -> Arena | None:
    """None if an obstacle finds no place."""
    odds = rng.random()
    x_half, y_half, ceiling = next(hall for most, hall in HALLS if odds < most)
    bounds = Box(-x_half, x_half, -y_half, y_half)
    placed: list[Box] = []
    for _ in range(count):
        boxes = (_box(rng, x_half, y_half) for _ in range(TRIES))
        fitting = (box for box in boxes if not any(0.0 < gap < PASSAGE for gap in _gaps(box, bounds, placed)))
        box = next(fitting, None)
        if box is None:
            return None
        placed.append(box)
    return Arena(bounds, ceiling, tuple(Obstacle(box, float(rng.uniform(0.3, 2.5))) for box in placed))


def _box(rng: np.random.Generator, x_half: float, y_half: float) -> Box:
    x, y, w, h = rng.uniform((-x_half, -y_half, 0.1, 0.1), (x_half, y_half, 0.6, 0.6)).tolist()
    return Box(x - w, x + w, y - h, y + h)


def _gaps(box: Box, bounds: Box, others: Sequence[Box]) -> Iterator[float]:
    """Width [m] of every gap beside a box; 0 where it is closed."""
    walls = (
        box.x_min - bounds.x_min,
        bounds.x_max - box.x_max,
        box.y_min - bounds.y_min,
        bounds.y_max - box.y_max,
    )
    yield from (max(gap, 0.0) for gap in walls)
    for other in others:
        across = max(other.x_min - box.x_max, box.x_min - other.x_max, 0.0)
        along = max(other.y_min - box.y_max, box.y_min - other.y_max, 0.0)
        yield hypot(across, along)


# Starts.


class Places(NamedTuple):
    """Where a vehicle could start; arrays of shape (places,)."""

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    heading: np.ndarray


def _place(rng: np.random.Generator, terms: Terms) -> tuple[Arena, Start, int]:
    """(an arena, a start in it, how many arenas were rejected before it)."""
    if terms.arena is not None:
        return terms.arena, _start_in(rng, terms.arena, terms.rig), 0
    rejected = 0
    while True:
        arena, more = draw_arena(rng)
        rejected += more
        start = _start(rng, arena, terms.rig)
        if start is not None:
            return arena, start, rejected
        rejected += 1


def _start_in(rng: np.random.Generator, arena: Arena, rig: Rig) -> Start:
    """A start in an arena that was given."""
    for _ in range(STARTS):
        start = _start(rng, arena, rig)
        if start is not None:
            return start
    raise FledgeError(
        f"the arena has no room for a UAV and {len(rig.formation.fleet)} UGVs: valid is one where they "
        f"can stand {ROOMY[0]} m and {ROOMY[1]} m from everything"
    )


def _start(rng: np.random.Generator, arena: Arena, rig: Rig) -> Start | None:
    """Everybody at rest where there is room, many near a wall or an obstacle; None if no such places were found."""
    places = _places(rng, arena)
    taken: list[int] = []
    near = 0
    for i in range(1 + len(rig.formation.fleet)):
        room = _room(places, arena, rig, i)
        good = room > ROOMY[i > 0]
        if rng.random() < CROWDED:
            good &= room < NEAR
        if i:
            for j in taken[1:]:
                good &= _apart(places, j, rig)
        chosen = np.flatnonzero(good)
        if not len(chosen):
            return None
        taken.append(int(chosen[0]))
        near += int(room[chosen[0]] < NEAR)
    return Start(_at(places, taken), near)


def _places(rng: np.random.Generator, arena: Arena) -> Places:
    b = arena.bounds
    return Places(
        rng.uniform(b.x_min, b.x_max, PLACES),
        rng.uniform(b.y_min, b.y_max, PLACES),
        rng.uniform(0.8, arena.ceiling - 0.5, PLACES),
        rng.uniform(-np.pi, np.pi, PLACES),
    )


def _room(places: Places, arena: Arena, rig: Rig, i: int) -> np.ndarray:
    """Free distance [m] of vehicle `i` at each place, all others being far away; the floor is not near the UAV."""
    zero = np.zeros(PLACES)
    still, far = Vec3(zero, zero, zero), zero + 1e3
    uav = UavState(Vec3(places.x, places.y, far if i else places.z), still, Quat.from_yaw(zero), still, zero)
    ugvs = [UgvState(far + 100.0 * j, far, zero, zero, zero, zero) for j in range(len(rig.formation.fleet))]
    if i:
        ugvs[i - 1] = replace(ugvs[i - 1], x=places.x, y=places.y)
    world = WorldState(zero, uav, tuple(ugvs))
    return np.asarray(clearance(arena, world, rig.uav, rig.formation.fleet, i).gap)


def _apart(places: Places, j: int, rig: Rig) -> np.ndarray:
    """Where a UGV leaves room to the one at place `j`."""
    widest = max(model.radius for model in rig.formation.fleet)
    return np.hypot(places.x - places.x[j], places.y - places.y[j]) > 2.0 * (widest + ROOMY[1])


def _at(places: Places, taken: Sequence[int]) -> WorldState:
    """The vehicles at rest at these places, the UAV's first."""
    x, y, z, heading = (column[list(taken)].tolist() for column in places)
    still = Vec3(0.0, 0.0, 0.0)
    uav = UavState(Vec3(x[0], y[0], z[0]), still, Quat.from_yaw(heading[0]), still, 0.0)
    ugvs = zip(x[1:], y[1:], heading[1:], strict=True)
    return WorldState(0.0, uav, tuple(UgvState(*ugv, 0.0, 0.0, 0.0) for ugv in ugvs))
