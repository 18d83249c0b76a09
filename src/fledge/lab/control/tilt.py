"""The velocity loop of an AR.Drone: a velocity command -> PCMD, whose roll and pitch are shares of a tilt.

Per heading axis, with c the command, v the velocity measured and theta the tilt towards that axis:

    followed   f' = (c - f) / lag                      the command, lest a jump of it be a jolt
    asked      a  = p (f - v) + ahead f' + drag f + push
    expected   m' = p (f - m) + ahead f', and after `behind` more      how an undisturbed vehicle goes along
    push'         = i (expected - v)                   against wind and bad trim; rests while the tilt is at its stop
    sent       a / g + lead (a / g - theta)            more tilt than wanted, for as long as the airframe lags behind

The integral sees only what departs from the expected answer, so that a step asks nothing of it and does not overshoot.
`ahead` makes it brake at once instead of waiting for an error to grow. In the end v answers c much as the simulator's
vehicle does, for which policies were trained: by a first-order lag of some 0.4 s. The gains are chosen for the shortest
stop that neither rings nor comes back, on the airframes of `tests/lab/control/test_tilt.py`, which answer a tilt within
0.1 to 0.2 s and have a drag of 0.2 to 0.5 1/s.

Height and heading are for the firmware's own loops: gaz and yaw are shares of `most_up` and `most_turn`.

*Without poses*, or with old ones only, the vehicle is taken to go on as expected: a loop closed over what was long ago
would swing. After `patience` of that a command to hover becomes the drone's own hover mode, which sees the floor
through its bottom camera.

Limits are the drone's configuration, which `ardrone_udp` sets; those of ardrone_autonomy (commit d35607b,
launch/ardrone.launch).
"""

from dataclasses import dataclass
from math import inf, tan
from typing import NamedTuple

from fledge.dynamics import GRAVITY
from fledge.lab.wire.ardrone import Pcmd
from fledge.scalars import clip
from fledge.supervision.inputs import HOVER
from fledge.world import UavState, VelocityCommand


class Axis(NamedTuple):
    """What is remembered of one heading axis."""

    followed: float = 0.0
    """[m/s]."""
    ideal: float = 0.0
    """How fast a vehicle would be that tilts at once [m/s]."""
    expected: float = 0.0
    """How fast this one ought to be [m/s]."""
    error: float = 0.0
    """By how much it was slower, when last seen [m/s]."""
    push: float = 0.0
    """[m/s^2]."""


class Memory(NamedTuple):
    """What the loop remembers."""

    forward: Axis = Axis()
    left: Axis = Axis()
    t: float | None = None
    """When it was last asked [s]."""
    stamp: float = -inf
    """Of the last pose that it went by [s]."""


@dataclass(frozen=True, slots=True)
class Tilt:
    """Gains and limits."""

    p: float = 2.5  # [1/s]
    i: float = 1.0  # [1/s^2]
    ahead: float = 0.4  # [1]
    lead: float = 1.0  # [1]
    drag: float = 0.4  # [1/s] of the indoor hull; a guess
    lag: float = 0.1  # [s]
    behind: float = 0.15  # [s] of airframe, estimator and wires
    most_push: float = (
        0.8  # [m/s^2] the contract's disturbance, and half a degree of bad trim several times over
    )
    patience: float = 0.1  # [s] a pose may be old; as long as the nets hold a vehicle by one
    tick: float = 0.01  # [s] between two calls; ten times less, or five times more, counts as that
    most_tilt: float = 0.21  # [rad] euler_angle_max
    most_up: float = 0.7  # [m/s] control_vz_max
    most_turn: float = 1.75  # [rad/s] control_yaw

    def init(self) -> Memory:
        """At rest."""
        return Memory()

    def step(self, memory: Memory, uav: UavState, command: VelocityCommand, t: float) -> tuple[Memory, Pcmd]:
        """(memory, what to send) at time `t` [s], by the clock of the stamps."""
        dt = self.tick if memory.t is None else clip(t - memory.t, 0.1 * self.tick, 5.0 * self.tick)
        fresh = uav.stamp > memory.stamp and t - uav.stamp <= self.patience
        stamp = uav.stamp if fresh else memory.stamp
        speed_forward, speed_left = uav.attitude.heading().from_world(uav.velocity.x, uav.velocity.y)
        roll, pitch, _ = uav.attitude.tilt()
        forward, pitch_share = self._axis(memory.forward, command.forward, speed_forward, pitch, fresh, dt)
        left, roll_share = self._axis(memory.left, command.left, speed_left, -roll, fresh, dt)
        memory = Memory(forward, left, t, stamp)
        if t - stamp > self.patience and command == HOVER:
            return memory, Pcmd.hover()
        up, turn = clip(command.up / self.most_up, -1.0, 1.0), clip(command.turn / self.most_turn, -1.0, 1.0)
        return memory, Pcmd(roll=-roll_share, pitch=-pitch_share, gaz=up, yaw=-turn)

    def _axis(
        self, axis: Axis, command: float, speed: float, lean: float, fresh: bool, dt: float
    ) -> tuple[Axis, float]:
        """(memory, share of the tilt) of one axis; `lean` is the tilt towards it [rad]."""
        rate = (command - axis.followed) / (self.lag + dt)
        followed = axis.followed + rate * dt
        most = GRAVITY * self.most_tilt
        ideal = axis.ideal + clip(self.p * (followed - axis.ideal) + self.ahead * rate, -most, most) * dt
        expected = axis.expected + (ideal - axis.expected) * dt / (self.behind + dt)
        error = expected - speed if fresh else axis.error
        asked = self.p * (followed - expected + error) + self.ahead * rate + self.drag * followed + axis.push
        wanted = asked / GRAVITY
        share = (wanted + self.lead * (wanted - tan(lean)) if fresh else wanted) / self.most_tilt
        rests = not fresh or share * error > abs(error)
        push = axis.push if rests else clip(axis.push + self.i * error * dt, -self.most_push, self.most_push)
        return Axis(followed, ideal, expected, error, push), clip(share, -1.0, 1.0)
