"""The UGVs' own computers: what a robot was told, to the speeds of its wheels.

    (speed, turn rate) told -> both after bounded accelerations -> wheels: (speed -+ turn track / 2) / radius

A robot obeys its last command, and stops when it has heard none for 0.6 s, as rosaria does (commit c289f1d,
RosAria.cpp, cmd_vel_timeout). It brakes harder than it speeds up, and both are more than `dynamics.Pioneer` has: a
real robot's computer can be set so, and what the nets count on is a lower bound.

`track` is the distance between the wheels, or what it comes to if the robot skids (`bodies`).
"""

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from fledge.geometry import Heading
from fledge.lab.twin.bodies import BASES, Base
from fledge.scalars import clip


class Memory(NamedTuple):
    """What a robot's computer remembers."""

    speed: float = 0.0
    """What the wheels are told [m/s]."""
    turn: float = 0.0
    """[rad/s]."""
    told: tuple[float, float] = (0.0, 0.0)
    """Speed and turn rate that it was told."""
    heard: float = -inf
    """When that was [s]."""
    odometry: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Where it thinks it is, from where it was switched on: forward, left [m], turned [rad]."""


@dataclass(frozen=True, slots=True)
class Driver:
    """One robot's computer."""

    base: Base
    speeding_up: float = 1.2  # [m/s^2]; chosen, see above
    braking: float = 1.5  # [m/s^2]; likewise
    turning: float = 5.0  # [rad/s^2]; likewise
    patience: float = 0.6  # [s]

    def hear(self, memory: Memory, t: float, speed: float, turn: float) -> Memory:
        """A command that came at `t` [s], held within what the robot can do."""
        hull = self.base.hull
        told = (
            clip(speed, -hull.max_speed, hull.max_speed),
            clip(turn, -hull.max_turn_rate, hull.max_turn_rate),
        )
        return memory._replace(told=told, heard=t)

    def step(self, memory: Memory, t: float, dt: float) -> tuple[Memory, tuple[float, float]]:
        """(memory, what the left and the right wheels are told [rad/s]) for the next `dt` [s]."""
        speed, turn = memory.told if t - memory.heard <= self.patience else (0.0, 0.0)
        harder = abs(speed) < abs(memory.speed) or speed * memory.speed < 0.0
        most = (self.braking if harder else self.speeding_up) * dt
        speed = memory.speed + clip(speed - memory.speed, -most, most)
        turn = memory.turn + clip(turn - memory.turn, -self.turning * dt, self.turning * dt)
        across, r = 0.5 * self.base.track * turn, self.base.wheel_radius
        after = memory._replace(speed=speed, turn=turn, odometry=_moved(memory.odometry, speed, turn, dt))
        return after, ((speed - across) / r, (speed + across) / r)


def _moved(
    place: tuple[float, float, float], speed: float, turn: float, dt: float
) -> tuple[float, float, float]:
    """A place after `dt` [s], if the wheels do as they are told."""
    x, y, heading = place
    ahead, aside = Heading.of(heading + 0.5 * turn * dt).to_world(speed * dt, 0.0)
    return x + ahead, y + aside, heading + turn * dt


DRIVERS = tuple(Driver(base) for base in BASES)
"""In the order of `dynamics.UGV_FLEET`."""
