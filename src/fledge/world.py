"""The records every room of the house speaks of: the arena, the vehicles, what they are told, what was sent.

Frames: world ENU (x east, y north, z up), body FLU (x forward, y left, z up). SI units throughout.
Each record describes ONE scene: its fields are numbers. Arrays in their place describe many scenes, or one
scene over time; nothing here notices. The records carry no checks, because JAX rebuilds them with tracers
inside; whatever comes from outside is checked once, where it enters.
"""

from dataclasses import dataclass, replace
from enum import IntEnum
from math import inf

from fledge.errors import FledgeError, OutOfRange
from fledge.geometry import Box, Quat, Vec3
from fledge.scalars import Scalar, where

MOST_OBSTACLES = 64
"""Chosen: everything that steers or guards looks at every obstacle, up to a hundred times a second."""


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A box that stands on the floor."""

    footprint: Box
    height: Scalar
    """Height of its top above the floor [m]."""


@dataclass(frozen=True, slots=True)
class Arena:
    """Where the vehicles may be: a box of air over a floor, and what stands in it."""

    bounds: Box
    """The walls [m]."""
    ceiling: Scalar
    """Highest altitude [m]."""
    obstacles: tuple[Obstacle, ...] = ()

    @classmethod
    def square(cls, side: float = 10.0, ceiling: float = 6.0) -> "Arena":
        """The paper's simulated arena, 10 x 10 m, origin at its centre; the ceiling is our choice (D10)."""
        half = side / 2.0
        return cls(Box(-half, half, -half, half), ceiling)

    @classmethod
    def lab(cls) -> "Arena":
        """The paper's physical arena, the 6.6 x 5 m its motion capture covers; the ceiling is our choice (D10)."""
        return cls(Box(-3.3, 3.3, -2.5, 2.5), 4.0)

    def padded(self, obstacles: int) -> "Arena":
        """The same with `obstacles` boxes; those added stand out of reach, so that arenas can be stacked."""
        nowhere = Obstacle(Box(1e4, 1e4 + 1.0, 1e4, 1e4 + 1.0), 1.0)
        return replace(self, obstacles=self.obstacles + (nowhere,) * (obstacles - len(self.obstacles)))


def check_arena(arena: Arena) -> Arena:
    """The arena itself, if its rectangles are upright and finite and all obstacles stand in it, if only in part.

    Raises:
        FledgeError: names what is wrong; obstacles count from 1, as in a flight's scene.
    """
    if len(arena.obstacles) > MOST_OBSTACLES:
        raise OutOfRange("number of obstacles", len(arena.obstacles), f"at most {MOST_OBSTACLES}")
    _check_box("bounds", arena.bounds)
    _check_height("ceiling", arena.ceiling)
    for i, obstacle in enumerate(arena.obstacles, start=1):
        _check_box(f"obstacle {i}", obstacle.footprint)
        _check_height(f"height of obstacle {i}", obstacle.height)
        if not obstacle.footprint.overlaps(arena.bounds):
            raise FledgeError(
                f"obstacle {i} stands outside, at {_spans(obstacle.footprint)}: "
                f"valid is at least in part within the bounds, {_spans(arena.bounds)}"
            )
    return arena


def _check_box(name: str, box: Box) -> None:
    for axis, low, high in (("x", box.x_min, box.x_max), ("y", box.y_min, box.y_max)):
        if not -inf < low < high < inf:
            raise FledgeError(
                f"{name} has {axis}_min {low} m and {axis}_max {high} m: "
                f"valid is a finite {axis}_min below a finite {axis}_max"
            )


def _check_height(name: str, height: float) -> None:
    if not 0.0 < height < inf:
        raise OutOfRange(f"{name} [m]", height, "a positive number")


def _spans(box: Box) -> str:
    return f"x {box.x_min}..{box.x_max} m, y {box.y_min}..{box.y_max} m"


@dataclass(frozen=True, slots=True)
class UavState:
    """Where the UAV is and how it moves."""

    position: Vec3
    """World position [m]."""
    velocity: Vec3
    """World velocity [m/s]."""
    attitude: Quat
    """Rotation world_from_body."""
    rates: Vec3
    """Body angular rates [rad/s]."""
    stamp: Scalar
    """When this was measured [s]."""


@dataclass(frozen=True, slots=True)
class UgvState:
    """Where a UGV is and how it moves."""

    x: Scalar
    """World position [m]."""
    y: Scalar
    """World position [m]."""
    heading: Scalar
    """Direction of its nose, counter-clockwise from east [rad]; not wrapped."""
    speed: Scalar
    """Forward speed [m/s]; negative in reverse."""
    turn_rate: Scalar
    """Yaw rate [rad/s]."""
    stamp: Scalar
    """When this was measured [s]."""


@dataclass(frozen=True, slots=True)
class WorldState:
    """All vehicles at one instant."""

    t: Scalar
    """Time since the flight began [s]."""
    uav: UavState
    ugvs: tuple[UgvState, ...]


@dataclass(frozen=True, slots=True)
class VelocityCommand:
    """What a vehicle is told: velocities in its own heading frame. A UGV obeys `forward` and `turn` only."""

    forward: Scalar
    """[m/s]."""
    left: Scalar
    """[m/s]."""
    up: Scalar
    """[m/s]."""
    turn: Scalar
    """Yaw rate, counter-clockwise positive [rad/s]."""

    @classmethod
    def hover(cls) -> "VelocityCommand":
        """The one word for "safe": a UAV holds its place, a UGV stands still."""
        return cls(0.0, 0.0, 0.0, 0.0)

    def scaled(self, factor: Scalar) -> "VelocityCommand":
        """Every component times `factor`."""
        return VelocityCommand(
            self.forward * factor, self.left * factor, self.up * factor, self.turn * factor
        )

    def __add__(self, other: "VelocityCommand") -> "VelocityCommand":
        return VelocityCommand(
            self.forward + other.forward,
            self.left + other.left,
            self.up + other.up,
            self.turn + other.turn,
        )


@dataclass(frozen=True, slots=True)
class Commands:
    """One command for every vehicle."""

    uav: VelocityCommand
    ugvs: tuple[VelocityCommand, ...]


class Reason(IntEnum):
    """Why a vehicle was not sent what was proposed; the number stands in `Verdict.reason`."""

    NONE = 0
    # Layer one, the nets: what the vehicle would have come too near to.
    WALL = 1
    OBSTACLE = 2
    VEHICLE = 3
    FLOOR = 4
    CEILING = 5
    NOT_FINITE = 6
    """A command that is no number."""
    # Layer two, the watchdog: what was wrong with the data.
    STALE = 10
    FUTURE = 11
    BACKWARD = 12
    DUPLICATE = 13
    BAD_POSE = 14
    """A pose that is no number, or out of this world."""
    JUMP = 15
    SWAP = 16
    """Two vehicles' poses changed places."""
    POLICY_LATE = 17
    LINK_LOST = 18
    BATTERY_LOW = 19
    INCONSISTENT = 20
    """Positions that contradict the velocities measured with them."""
    CLOCK = 21
    """A clock that stands still, runs backwards or is no number."""
    # Layer two, the supervisor: who took the command away.
    NOT_READY = 30
    TAKE_OVER = 31
    STOPPED = 32
    LANDING = 33
    TERMINATED = 34
    RECOVERING = 35
    """The command fades back to the policy's."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a safety net let through to one vehicle, and why."""

    command: VelocityCommand
    """The command really sent."""
    intervened: Scalar
    """Whether it differs from the command proposed."""
    reason: Scalar
    """A `Reason`, as a number; 0 when nothing was changed."""
    clearance: Scalar
    """Free distance the net saw [m]; infinite if it does not look."""


def settle_on_floor(uav: UavState) -> UavState:
    """The floor is hard and does not bounce: a UAV that would sink into it stops there."""
    below = uav.position.z < 0.0
    return replace(
        uav,
        position=replace(uav.position, z=where(below, 0.0 * uav.position.z, uav.position.z)),
        velocity=replace(uav.velocity, z=where(below, 0.0 * uav.velocity.z, uav.velocity.z)),
    )
