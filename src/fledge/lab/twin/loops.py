"""The AR.Drone's inner loops, 500 times a second: what it was told, and what it senses, to four rotor thrusts.

    tilt       aim -> rate aim = k_angle (aim - angle) -> torque = I k_rate (rate aim - rate)
    turn       torque = I_z k_turn (turn aim - turn rate)
    climb      thrust = m (g + k_climb (climb aim - climb rate) + trim) / cos(tilt); trim integrates the error
    height     where no climb is asked for: climb aim = k_height (height held - height)
    hover      tilt aim = -(k_hover v + drift) / g, with v by the bottom camera; drift integrates it

Aims are lagged. With these gains a tilt is there after 0.2 to 0.3 s, a climb rate after about a second, a hover takes
out 1 m/s in about as long: what tum_ardrone's model of the real one says (commit 3464fb7, DroneKalmanFilter.cpp: time
constants of 0.1 s for tilt and turn rate, 0.7 s for climb). Parrot's own loops are not public; the gains are chosen.

The loops believe in a mass and in inertias of their own, near the true ones; the integrals find out the rest. Frames:
body FLU for torques, the heading frame for aims.
"""

from dataclasses import dataclass
from typing import NamedTuple

from fledge.dynamics import GRAVITY
from fledge.lab.twin.bodies import Airframe
from fledge.lab.twin.senses import Sensed
from fledge.scalars import clip

Thrusts = tuple[float, float, float, float]
"""[N] front left, rear left, rear right, front right."""

STILL: Thrusts = (0.0, 0.0, 0.0, 0.0)


class Wish(NamedTuple):
    """What the loops are told."""

    motors: bool
    """Whether the rotors turn at all."""
    lifted: bool = True
    """Whether to fly; else they turn slowly."""
    hover: bool = True
    """Hold the place; then `roll` and `pitch` mean nothing."""
    roll: float = 0.0
    """[rad]."""
    pitch: float = 0.0
    """[rad]."""
    climb: float = 0.0
    """[m/s]; 0 holds the height."""
    turn: float = 0.0
    """[rad/s], counter-clockwise."""
    height: float | None = None
    """To be gone to [m]; None: where it is."""


class Inside(NamedTuple):
    """What the loops remember."""

    roll: float = 0.0
    """Aims after their lag [rad]."""
    pitch: float = 0.0
    drift_forward: float = 0.0
    """What hovering has learnt of wind and of how level it is [m/s^2]."""
    drift_left: float = 0.0
    trim: float = 0.0
    """What climbing has learnt of mass and rotors [m/s^2]."""
    height: float | None = None
    """Held [m]; None while it climbs."""


RESTED = Inside()


@dataclass(frozen=True, slots=True)
class Loops:
    """The gains; all chosen, see above."""

    airframe: Airframe = Airframe()
    lag: float = 0.02  # [s] of the tilt aim
    angle: float = 7.0  # [1/s]
    rate: float = 18.0  # [1/s]
    turn: float = 8.0  # [1/s]
    climb: float = 1.8  # [1/s]
    climb_drift: float = 0.6  # [1/s^2]
    height: float = 1.2  # [1/s]
    most_climb: float = 0.6  # [m/s] by which a height is gone to
    foresight: float = 0.5  # [s] a climb that ends goes on for about as long
    hover: float = 1.6  # [1/s]
    hover_drift: float = 0.25  # [1/s^2]
    braking: float = 0.2  # [m/s]
    most_drift: float = 0.6  # [m/s^2] that hovering learns at most
    blind: float = 0.2  # [m] below which the camera sees nothing sharp
    most_trim: float = 2.0  # [m/s^2]
    most_yaw: float = 0.3  # [N] of a rotor that turning may take; tilt and lift go first
    idle: float = 0.12  # [N] of a rotor that turns slowly

    def step(
        self, inside: Inside, wish: Wish, sensed: Sensed, most_tilt: float, dt: float
    ) -> tuple[Inside, Thrusts]:
        """One step of `dt` [s]."""
        if not wish.motors:
            return RESTED, STILL
        if not wish.lifted:
            return RESTED, (self.idle, self.idle, self.idle, self.idle)
        roll, pitch, ahead, aside = self._tilts(inside, wish, sensed, most_tilt, dt)
        trim, height, lift = self._lift(inside, wish, sensed, dt)
        return Inside(roll, pitch, ahead, aside, trim, height), self._mix(roll, pitch, lift, wish, sensed)

    def _tilts(
        self, inside: Inside, wish: Wish, sensed: Sensed, most: float, dt: float
    ) -> tuple[float, float, float, float]:
        """The tilts to be aimed at now, roll and pitch [rad], and what hovering has learnt [m/s^2]."""
        roll, pitch, ahead, aside = wish.roll, wish.pitch, inside.drift_forward, inside.drift_left
        if wish.hover:
            seeing = 1.0 if sensed.altitude > self.blind else 0.0
            pitch = seeing * (ahead - self.hover * sensed.forward) / GRAVITY
            roll = -seeing * (aside - self.hover * sensed.left) / GRAVITY
            ahead = self._learnt(ahead, sensed.forward, seeing * dt)
            aside = self._learnt(aside, sensed.left, seeing * dt)
        share = dt / (dt + self.lag)
        roll = inside.roll + share * (clip(roll, -most, most) - inside.roll)
        pitch = inside.pitch + share * (clip(pitch, -most, most) - inside.pitch)
        return roll, pitch, ahead, aside

    def _learnt(self, drift: float, velocity: float, dt: float) -> float:
        """What hovering knows of a push after `dt` [s]; a velocity that it is still braking is none."""
        if abs(velocity) > self.braking:
            return drift
        return clip(drift - self.hover_drift * velocity * dt, -self.most_drift, self.most_drift)

    def _lift(
        self, inside: Inside, wish: Wish, sensed: Sensed, dt: float
    ) -> tuple[float, float | None, float]:
        """What climbing has learnt [m/s^2], the height it holds [m], the thrust of all rotors [N]."""
        climb, height = wish.climb, None
        if wish.height is not None or climb == 0.0:
            height = inside.height if wish.height is None else wish.height
            if height is None:
                height = sensed.altitude + self.foresight * sensed.up
            climb = clip(self.height * (height - sensed.altitude), -self.most_climb, self.most_climb)
        short = climb - sensed.up
        trim = clip(inside.trim + self.climb_drift * short * dt, -self.most_trim, self.most_trim)
        lift = self.airframe.mass * (GRAVITY + self.climb * short + trim) / max(sensed.upright, 0.5)
        return trim, height, lift

    def _mix(self, roll: float, pitch: float, lift: float, wish: Wish, sensed: Sensed) -> Thrusts:
        """Share lift and torques out among the rotors."""
        body, w = self.airframe, sensed.rates
        ix, iy, iz = body.inertia
        arm, k = 4.0 * body.rotor_offset, self.rate
        x = ix * k * (self.angle * (roll - sensed.roll) - w.x) / arm
        y = iy * k * (self.angle * (pitch - sensed.pitch) - w.y) / arm
        z = iz * self.turn * (wish.turn - w.z) / (4.0 * body.rotor_drag)
        z = clip(z, -self.most_yaw, self.most_yaw)
        low, most, each = self.idle, body.most_thrust, 0.25 * lift
        return (
            clip(each + x - y - z, low, most),
            clip(each + x + y + z, low, most),
            clip(each - x + y - z, low, most),
            clip(each - x - y + z, low, most),
        )
