"""What disturbs a flight: wind, noisy commands, late and noisy sight; and the chance behind them.

`Conditions` are drawn once per flight and stay; `RowNoise` is drawn for every row. Both are inputs to the
simulator, never made inside it, so that the same chance can be flown twice, on either backend.

Sources: command noise is tum_simulator's (commit a020d89: uniform +-0.05 on every message and a uniform drift of
+-0.03 that is drawn anew every 5 s). Wind, sensing noise and delay are chosen: a draught that the vehicle's drag
hardly feels, one pixel, and the 50-150 ms that an AR.Drone's video takes.
"""

from dataclasses import dataclass, replace

import numpy as np

from fledge.geometry import Vec3
from fledge.observation import ROW_RATE, Observation
from fledge.scalars import Scalar, exp, maximum, sqrt, where
from fledge.world import VelocityCommand

DRIFT_ROWS = 100
"""The command drift is drawn anew every 5 s (motionDriftNoiseTime)."""

GUST_MEMORY = 2.0
"""[s] correlation time of gusts; chosen."""

SIGHT_ROWS = 5
"""Length of the sensing delay line: up to 0.2 s."""


@dataclass(frozen=True, slots=True)
class Conditions:
    """One flight's weather; `draw` gives a nominal day, `Conditions()` a perfect one."""

    wind: Vec3 = Vec3(0.0, 0.0, 0.0)
    """Mean wind [m/s]."""
    gust: Scalar = 0.0
    """Standard deviation of the gusts about it, per axis [m/s]."""
    command_noise: Scalar = 0.0
    """Half width of the uniform noise on every command [m/s, rad/s]."""
    command_drift: Scalar = 0.0
    """Half width of the uniform drift of the commands [m/s, rad/s]."""
    pixel_noise: Scalar = 0.0
    """Standard deviation on image features [px]."""
    motion_noise: Scalar = 0.0
    """Standard deviation on altitude [m] and velocities [m/s, rad/s]."""
    delay: Scalar = 0.0
    """Age of what the pilot sees [s], up to 0.2."""
    offset: Vec3 = Vec3(0.0, 0.0, 0.0)
    """Where the UAV starts, from straight above the formation at its ideal altitude [m]."""
    yaw: Scalar = 0.0
    """Where its nose points at the start [rad]."""

    @classmethod
    def draw(cls, rng: np.random.Generator) -> "Conditions":
        """A nominal day."""
        direction, strength = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.0, 0.5)
        return cls(
            wind=Vec3(float(strength * np.cos(direction)), float(strength * np.sin(direction)), 0.0),
            gust=0.2,
            command_noise=0.05,
            command_drift=0.03,
            pixel_noise=1.0,
            motion_noise=0.02,
            delay=rng.uniform(0.05, 0.15),
            offset=Vec3(rng.uniform(-0.15, 0.15), rng.uniform(-0.15, 0.15), rng.uniform(-0.1, 0.1)),
            yaw=rng.uniform(-np.pi, np.pi),
        )


@dataclass(frozen=True, slots=True)
class RowNoise:
    """The chance of one row: `normal` numbers are standard normal, `uniform` ones lie in [-1, 1]."""

    gust: Vec3
    """Normal."""
    command: VelocityCommand
    """Uniform."""
    drift: VelocityCommand
    """Uniform."""
    sight: tuple[Scalar, ...]
    """Normal: centroid u and v, radius, altitude, four velocities."""
    pilot: tuple[Scalar, Scalar, Scalar, Scalar]
    """Normal."""


NORMALS, UNIFORMS = 15, 8
"""How many numbers of each kind a row takes."""


def row_noise(normal: list[Scalar], uniform: list[Scalar]) -> RowNoise:
    """Deal out `NORMALS` standard normal and `UNIFORMS` uniform numbers."""
    a, b, c, d = normal[11:15]
    return RowNoise(
        Vec3(*normal[0:3]),
        VelocityCommand(*uniform[0:4]),
        VelocityCommand(*uniform[4:8]),
        tuple(normal[3:11]),
        (a, b, c, d),
    )


def next_gust(gust: Vec3, noise: RowNoise, conditions: Conditions) -> Vec3:
    """The gust one row later: an Ornstein-Uhlenbeck process, stepped exactly."""
    keep = exp(-1.0 / (ROW_RATE * GUST_MEMORY))
    return gust * keep + noise.gust * (conditions.gust * sqrt(1.0 - keep * keep))


def next_drift(
    drift: VelocityCommand, row: Scalar, noise: RowNoise, conditions: Conditions
) -> VelocityCommand:
    """The command drift of this row: drawn anew every `DRIFT_ROWS`."""
    fresh = noise.drift.scaled(conditions.command_drift)
    return where(row % DRIFT_ROWS == 0, fresh, drift)


def sense(views: tuple[Observation, ...], noise: RowNoise, conditions: Conditions) -> Observation:
    """What the pilot sees, of the exact views of the last `SIGHT_ROWS` rows, newest first."""
    rows = conditions.delay * ROW_RATE
    weights = [maximum(0.0 * rows, 1.0 - abs(rows - i)) for i in range(SIGHT_ROWS)]

    def late(name: str) -> Scalar:
        return sum(weight * getattr(view, name) for weight, view in zip(weights, views, strict=True))

    px, motion, n = conditions.pixel_noise, conditions.motion_noise, noise.sight
    return replace(
        views[0],
        ugv_u=late("ugv_u") + px * n[0],
        ugv_v=late("ugv_v") + px * n[1],
        radius=late("radius") + px * n[2],
        altitude=late("altitude") + motion * n[3],
        forward=late("forward") + motion * n[4],
        left=late("left") + motion * n[5],
        up=late("up") + motion * n[6],
        turn=late("turn") + motion * n[7],
    )
