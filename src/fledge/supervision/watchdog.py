"""The watchdog: what may be believed of what comes in, and how bad it is if not. The eyes of layer two.

Every tick it vets the clock, each vehicle's pose (`tracking`), the policy's command and its age, what the operator
says, the link and the batteries. Whoever flies on sees poses that are plausible or, failing that, old ones with their
true age, and one alarm per vehicle: the worst, and why.

How old is too old stands in tables of ages. A datum from the future, or of an age that is no number, asks for "hold":
it cannot be trusted, but nothing says that the vehicle has to come down.
"""

from dataclasses import dataclass, field
from enum import IntEnum
from math import inf
from typing import NamedTuple

from fledge.scalars import Scalar, negate, where
from fledge.supervision.inputs import Inputs, finite, sane
from fledge.supervision.tracking import LEAD, Sight, Track, Tracker
from fledge.world import Reason, WorldState

TICK = 0.01
"""[s] from one check to the next: the watchdog's own clock goes on by it where the one given cannot be right."""


class Severity(IntEnum):
    """What an alarm asks for; the number stands in `Alarm.severity`."""

    OK = 0
    WARN = 1
    """Say so."""
    BRAKE = 2
    """Stand still while it lasts."""
    HOLD = 3
    """Brake, hold, and go on when it has been gone for a while."""
    STOP = 4
    """Brake, hold, and wait for a person."""
    LAND = 5


Ages = tuple[tuple[float, Severity], ...]
"""From which age [s] a datum asks for what."""

POSE_AGES: Ages = ((0.1, Severity.BRAKE), (0.5, Severity.HOLD), (2.0, Severity.LAND))
"""By a pose older than 0.1 s no net holds a vehicle; 0.5 and 2 s are the Crazyflie's for set-points (2a18fc2)."""
POLICY_AGES: Ages = ((0.5, Severity.HOLD),)
"""Ten decisions missed; the Crazyflie levels out at this age of a set-point."""
LINK_AGES: Ages = ((10.0, Severity.LAND),)
"""PX4's COM_DL_LOSS_T. A person who flies by hand is missed sooner: see the supervisor."""


class Alarm(NamedTuple):
    """The worst that is wrong with what one vehicle flies on."""

    severity: Scalar
    """A `Severity`, as a number."""
    reason: Scalar
    """A `Reason`, as a number; 0 when nothing is wrong."""


class Watch(NamedTuple):
    """The watchdog's memory."""

    t: Scalar
    """The time it believes in [s]."""
    tracks: tuple[Track, ...]


@dataclass(frozen=True, slots=True)
class Watchdog:
    """Limits."""

    tracker: Tracker = Tracker()
    leap: float = 0.5  # [s] that the clock may go on by in a tick with nothing else to bear it out; chosen
    poses: Ages = field(default=POSE_AGES, metadata={"static": True})
    policy: Ages = field(default=POLICY_AGES, metadata={"static": True})
    link: Ages = field(default=LINK_AGES, metadata={"static": True})
    low: float = (
        0.2  # share of the battery at which to land; chosen: over two minutes of an AR.Drone's twelve
    )

    def init(self, world: WorldState) -> Watch:
        """What is wrong with the first poses shows in the first check."""
        return Watch(world.t - TICK, self.tracker.init(world))

    def check(self, memory: Watch, inputs: Inputs) -> tuple[Watch, WorldState, tuple[Alarm, ...]]:
        """(memory, the world as far as it can be believed, the worst alarm of each vehicle)."""
        ticking = self._ticking(memory, inputs.seen)
        now = where(ticking, inputs.seen.t, memory.t + TICK)
        tracks, sights = self.tracker.follow(memory.tracks, inputs.seen, now)
        common = _worst(
            alarm(negate(ticking), Severity.HOLD, Reason.CLOCK),
            late(now - inputs.decided, self.policy, Reason.POLICY_LATE),
            late(now - inputs.heard, self.link, Reason.LINK_LOST),
        )
        commands = (inputs.proposed.uav, *inputs.proposed.ugvs)
        vehicles = zip(tracks, sights, commands, inputs.operators, inputs.batteries, strict=True)
        alarms = tuple(
            _worst(
                self._pose(now - track.trusted.stamp, sight),
                common,
                alarm(negate(finite(command) & sane(operator)), Severity.HOLD, Reason.NOT_FINITE),
                self._battery(battery),
            )
            for track, sight, command, operator, battery in vehicles
        )
        uav, *ugvs = (track.trusted for track in tracks)
        return Watch(now, tracks), WorldState(now, uav, tuple(ugvs)), alarms

    def _ticking(self, memory: Watch, seen: WorldState) -> Scalar:
        """Whether the clock goes on; a leap is believed if some pose was measured after it."""
        t = seen.t
        borne_out = t - memory.t <= self.leap
        for state in (seen.uav, *seen.ugvs):
            borne_out = borne_out | (abs(t - state.stamp) <= self.leap)
        return (abs(t) < inf) & negate(t <= memory.t) & borne_out

    def _pose(self, age: Scalar, sight: Sight) -> Alarm:
        """A dropped sample is worth a word; what hurts is the age of the last good one."""
        old, dropped = late(age, self.poses, Reason.STALE), sight.dropped > 0.0
        fading = Alarm(
            where(dropped & (old.severity == 0.0), float(Severity.WARN), old.severity),
            where(dropped, sight.dropped, old.reason),
        )
        moved = sight.elsewhere > 0.0
        return _worst(
            Alarm(where(moved, float(Severity.STOP), 0.0), sight.elsewhere),
            alarm(sight.contradicts, Severity.STOP, Reason.INCONSISTENT),
            fading,
        )

    def _battery(self, share: Scalar) -> Alarm:
        """An unknown share is no reason to come down."""
        severity = where((share >= self.low) & (share < inf), 0.0, float(Severity.HOLD))
        severity = where(share < self.low, float(Severity.LAND), severity)
        return Alarm(severity, where(severity > 0.0, float(Reason.BATTERY_LOW), 0.0))


def alarm(condition: Scalar, severity: Severity, reason: Reason) -> Alarm:
    """An alarm that is on or off."""
    return Alarm(where(condition, float(severity), 0.0), where(condition, float(reason), 0.0))


def late(age: Scalar, ages: Ages, reason: Reason) -> Alarm:
    """The alarm of a datum of that age [s]."""
    severity = 0.0
    for limit, level in ages:
        severity = where(age > limit, float(level), severity)
    severity = where(age >= -LEAD, severity, float(Severity.HOLD))
    return Alarm(severity, where(severity > 0.0, float(reason), 0.0))


def _worst(*alarms: Alarm) -> Alarm:
    """The first of the most severe."""
    worst = alarms[0]
    for other in alarms[1:]:
        worst = where(other.severity > worst.severity, other, worst)
    return worst
