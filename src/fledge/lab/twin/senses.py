"""What the AR.Drone's own sensors make of the truth: near it, never quite there.

* The attitude is off by a constant, until the drone is told that it stands level (FTRIM).
* The heading creeps, as a gyro's does. So does its zero: it is where the nose pointed when the drone was switched on.
* Horizontal velocity comes from the bottom camera. Its error wanders: that is why a drone that hovers drifts away.
* Altitude and climb rate come from the ultrasound and the accelerometers: small errors that wander, too. Altitude
  counts from the floor, below the hull; that it jumps over things that stand there is not modelled.

Wandering errors are Ornstein-Uhlenbeck processes, stepped exactly. All sizes are chosen, within what people report of
the vehicle: a few degrees before trimming, a drift of up to a metre in half a minute. Frames: the UAV's heading frame.
"""

from dataclasses import dataclass
from math import atan2, exp, sqrt
from typing import NamedTuple

from fledge.geometry import Vec3
from fledge.lab.twin.plant import Motion

NORMALS = 4
"""Standard normal numbers that a tick takes."""
BIRTH_NORMALS = 7
"""Those that a drone takes when it is switched on."""


class Sensed(NamedTuple):
    """What the drone knows of itself; its heading frame: x forward, y left, z up."""

    roll: float
    """[rad]."""
    pitch: float
    """[rad]."""
    rates: Vec3
    """Body rates [rad/s]."""
    forward: float
    """[m/s]."""
    left: float
    """[m/s]."""
    up: float
    """[m/s]."""
    altitude: float
    """Of its belly above the floor [m]."""
    yaw: float
    """From where it has its zero, counter-clockwise [rad]."""
    upright: float
    """Cosine of the angle between its axis and up."""


class Errors(NamedTuple):
    """By how much the sensors are off now."""

    roll: float
    """[rad]."""
    pitch: float
    """[rad]."""
    turn: float
    """[rad/s]."""
    yaw: float
    """From the true heading to what it takes for it [rad]."""
    forward: float
    """[m/s]."""
    left: float
    """[m/s]."""
    up: float
    """[m/s]."""
    altitude: float
    """[m]."""


@dataclass(frozen=True, slots=True)
class Senses:
    """How good the sensors are: standard deviations, and how long errors last."""

    level: float = 0.01  # [rad] attitude before trimming
    trimmed: float = 0.002  # [rad] after
    turn: float = 0.002  # [rad/s] 7 degrees a minute
    velocity: float = 0.025  # [m/s]
    up: float = 0.01  # [m/s]
    altitude: float = 0.01  # [m]
    memory: float = 8.0  # [s] correlation time of what wanders
    half_height: float = 0.065  # [m] from the middle to the belly

    def init(self, heading: float, normal: list[float]) -> Errors:
        """A drone just switched on, its nose pointing at `heading` [rad]; `BIRTH_NORMALS` standard normal numbers."""
        n = normal
        v = self.velocity
        return Errors(
            self.level * n[0],
            self.level * n[1],
            self.turn * n[2],
            -heading,
            v * n[3],
            v * n[4],
            self.up * n[5],
            self.altitude * n[6],
        )

    def wander(self, errors: Errors, normal: list[float], dt: float) -> Errors:
        """The same `dt` [s] later; `NORMALS` standard normal numbers."""
        keep = exp(-dt / self.memory)
        kick = sqrt(1.0 - keep * keep)
        return errors._replace(
            yaw=errors.yaw + errors.turn * dt,
            forward=keep * errors.forward + kick * self.velocity * normal[0],
            left=keep * errors.left + kick * self.velocity * normal[1],
            up=keep * errors.up + kick * self.up * normal[2],
            altitude=keep * errors.altitude + kick * self.altitude * normal[3],
        )

    def trim(self, errors: Errors, normal: list[float]) -> Errors:
        """Told that it stands level."""
        return errors._replace(roll=self.trimmed * normal[0], pitch=self.trimmed * normal[1])

    def sense(self, errors: Errors, motion: Motion) -> Sensed:
        """What the drone takes for true."""
        roll, pitch, upright = motion.attitude.tilt()
        v, w = motion.velocity, motion.rates
        nose = motion.attitude.heading()
        forward, left = nose.from_world(v.x, v.y)
        return Sensed(
            roll + errors.roll,
            pitch + errors.pitch,
            Vec3(w.x, w.y, w.z + errors.turn),
            forward + errors.forward,
            left + errors.left,
            v.z + errors.up,
            motion.position.z - self.half_height + errors.altitude,
            atan2(nose.sin, nose.cos) + errors.yaw,
            upright,
        )
