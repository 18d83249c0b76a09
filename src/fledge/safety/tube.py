"""The stop tube: where a vehicle may still go if it is told to stop now, and how much room that leaves.

Everything that must not be touched is a `Face`: a half-space the vehicle has to stay in. Obstacles are convex, so a
vehicle that stays beyond one of an obstacle's faces cannot touch it; of side and top the roomier is taken. `room` is
the free distance that remains when the whole stop, the contract's worst errors and the other vehicle's own stop are
taken off. Room that is not negative means: whatever happens within the contract, the stop ends before the face.

Nothing here decides; what a net does with the room is its own affair.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial, reduce
from math import inf, nan
from typing import NamedTuple

from fledge.geometry import Box, Heading, Vec3
from fledge.safety.contract import Contract, UavStop, UgvStop
from fledge.scalars import Scalar, clip, cond, exp, isfinite, maximum, minimum, sqrt, surely, where
from fledge.world import Arena, Reason, UavState, UgvState

TINY = 1e-9
FREE = 1e3
"""[m] room where there is nothing to be touched."""


class Face(NamedTuple):
    """Something to stay clear of, as one vehicle sees it."""

    x: Scalar
    """Unit normal, away from the thing."""
    y: Scalar
    z: Scalar
    gap: Scalar
    """Free distance from hull to hull [m]."""
    room: Scalar
    """What remains of it after a stop that begins now [m]."""
    reason: Reason

    def closer(self, by: Scalar) -> "Face":
        """With so much less room [m]."""
        return Face(self.x, self.y, self.z, self.gap, self.room - by, self.reason)


class Around(NamedTuple):
    """What a vehicle has to mind."""

    gap: Scalar
    """The smallest free distance from hull to hull, of all things [m]."""
    faces: list[Face]
    """Those that it may come up to, or else the nearest; a compiled program looks at all."""

    @classmethod
    def of(cls, gaps: Sequence[Scalar], faces: list[Face], reach: Scalar) -> "Around":
        """Of all gaps, and of no fewer faces than those with no more room than `reach` [m]."""
        near = [face for face in faces if not surely(face.room > reach)]
        return cls(reduce(minimum, gaps), near or [min(faces, key=lambda face: face.room)])


class UavTube(NamedTuple):
    """Where the UAV comes to rest if it is told to hover now, from where it was measured."""

    rests: tuple[Vec3, ...]
    """[m] if commands act at once, after half the contract's latency, and after all of it."""
    error: Scalar
    """[m] by which the stop may miss that, sideways."""
    error_up: Scalar
    """[m] and in height."""

    @property
    def late(self) -> Vec3:
        """[m] if commands act as late as they may."""
        return self.rests[-1]

    @property
    def reach(self) -> Scalar:
        """How far the stop may go at most, in the plane [m]."""
        return self.error + reduce(maximum, (sqrt(rest.x * rest.x + rest.y * rest.y) for rest in self.rests))

    def advance(self, x: Scalar, y: Scalar) -> Scalar:
        """How far the stop goes along the horizontal unit vector (x, y) [m]."""
        ahead = 0.0 * self.error
        for rest in self.rests:
            ahead = maximum(ahead, rest.x * x + rest.y * y)
        return ahead

    def sink(self) -> Scalar:
        """How far down the stop goes [m]."""
        down = 0.0 * self.error
        for rest in self.rests:
            down = maximum(down, -rest.z)
        return down

    def rise(self) -> Scalar:
        """How far up the stop goes [m]."""
        up = 0.0 * self.error
        for rest in self.rests:
            up = maximum(up, rest.z)
        return up


class Pace(NamedTuple):
    """How fast the UAV was told to move lately: the most of it, which fades."""

    speed: Scalar
    """In the plane [m/s]."""
    turn: Scalar
    """[rad/s]."""

    def then(self, x: Scalar, y: Scalar, turn: Scalar, share: float = 0.0) -> "Pace":
        """One command more; `share` is how much of what was before has faded meanwhile."""
        speed, left = sqrt(x * x + y * y), 1.0 - share
        return Pace(maximum(self.speed * left, speed), maximum(self.turn * left, abs(turn)))


class Turn(NamedTuple):
    """How far the nose of a UGV may turn to its left, and to its right [rad]."""

    left: Scalar
    right: Scalar


class UgvTube(NamedTuple):
    """How far a UGV goes that has gone on with a command until its own watchdog ended it."""

    nose: Heading
    ahead: Scalar
    """Length of its way forwards [m]."""
    astern: Scalar
    """Length of its way in reverse [m]."""
    turn: Turn
    """Meanwhile; as if it were turned so far from the start, so that it does not matter how fast it goes."""

    def shares(self, x: Scalar, y: Scalar) -> tuple[Scalar, Scalar]:
        """Which share of its way forwards, and in reverse, leads along the unit vector (x, y), however it turns."""
        towards = self.nose.cos * x + self.nose.sin * y
        across = self.nose.cos * y - self.nose.sin * x
        left, right = self.turn
        # With a the angle to that vector and b a turn towards it, cos(a - b) <= cos a + |sin a| b. A tail goes right
        # where the nose turns left.
        nose, tail = where(across > 0.0, (left, right), (right, left))
        aside = abs(across)
        return clip(towards + aside * nose, 0.0, 1.0), clip(aside * tail - towards, 0.0, 1.0)

    def along(self, shares: tuple[Scalar, Scalar]) -> Scalar:
        """How far it goes, of these shares [m]."""
        forwards, backwards = shares
        return maximum(self.ahead * forwards, self.astern * backwards)


class UgvSweep(NamedTuple):
    """How far a UGV goes that turns by and by."""

    tube: UgvTube
    """As if it were turned from the start as it is at the end."""
    ahead: Turn
    """On average of its way forwards."""
    astern: Turn
    """And in reverse."""

    def advance(self, x: Scalar, y: Scalar) -> Scalar:
        """How far it goes along the unit vector (x, y) [m].

        What leads away at first takes nothing off, since it may be gone slowly; the average counts, but all of its way
        leads there by no more than its end does.
        """
        nose, tube = self.tube.nose, self.tube
        towards = nose.cos * x + nose.sin * y
        across = nose.cos * y - nose.sin * x
        ahead, astern = where(
            across > 0.0, (self.ahead.left, self.astern.right), (self.ahead.right, self.astern.left)
        )
        aside = abs(across)
        forwards, backwards = tube.shares(x, y)
        forwards = minimum(forwards, maximum(towards, 0.0) + aside * ahead)
        backwards = minimum(backwards, maximum(-towards, 0.0) + aside * astern)
        return tube.along((forwards, backwards))


class Sent(NamedTuple):
    """What was sent to the UAV along one axis: the newest commands, and those before them as its filter has them."""

    newest: tuple[Scalar, ...]
    """[m/s], newest first, as far back as the contract's delay."""
    before: Scalar
    """[m/s]."""

    @classmethod
    def nothing(cls, contract: Contract, zero: Scalar) -> "Sent":
        """At the start of a flight."""
        return cls((zero,) * round((contract.age + contract.latency) / contract.period), zero)

    def then(self, command: Scalar, share: float) -> "Sent":
        """One command later; `share` is how much of it the filter takes up in a period."""
        old = self.newest[-1]
        return Sent((command, *self.newest[:-1]), self.before + (old - self.before) * share)

    def instead(self, command: Scalar) -> "Sent":
        """The newest command was this one."""
        return Sent((command, *self.newest[1:]), self.before)

    def held_over(self, period: float, hold_over: float) -> tuple[Scalar, Scalar]:
        """(least, most) that may come to all that was sent [m], whichever command is the last that is heard."""
        least = most = missed = 0.0 * self.before
        for command in self.newest[: 1 + round(hold_over / period)]:
            instead = command * hold_over - missed
            least, most = minimum(least, instead), maximum(most, instead)
            missed = missed + command * period
        return least, most


class Held(NamedTuple):
    """The commands in one direction that a UGV may still be going on with: of newer ones none need have been heard."""

    most: Scalar
    """The largest of them [m/s or rad/s]."""
    left: Scalar
    """[s] for which that may still be so; as measured, so after the contract's delay it is over."""
    newer: Scalar
    """The largest of those that were sent after it."""

    @classmethod
    def nothing(cls, zero: Scalar) -> "Held":
        """At the start of a flight."""
        return cls(zero, zero, zero)

    def then(self, command: Scalar, elapsed: float, lasts: float) -> "Held":
        """One command more, so long after the last [s], which may be gone on with for so long [s]."""
        left, none = self.left - elapsed, 0.0 * self.left
        # Whatever is the largest then was sent earlier; it is as if it was sent now.
        most, newer, left = where(left <= 0.0, (self.newer, none, lasts), (self.most, self.newer, left))
        left, newer = where(command >= most, (lasts, none), (left, maximum(newer, command)))
        return Held(maximum(most, command), left, newer)

    def way(self, delay: float, hold_over: float) -> Scalar:
        """How far the UGV may yet go [m or rad] with any of them, after the contract's delay [s]."""
        return maximum(self.most * maximum(self.left - delay, 0.0), self.newer * hold_over)


class UgvSent(NamedTuple):
    """What was sent to a UGV, as far as it matters yet."""

    ahead: Held
    astern: Held
    left: Held
    """Turning to its left."""
    right: Held

    @classmethod
    def nothing(cls, zero: Scalar) -> "UgvSent":
        """At the start of a flight."""
        return cls(*(Held.nothing(zero),) * 4)

    def then(
        self, contract: Contract, stop: UgvStop, forward: Scalar, turn: Scalar, elapsed: float
    ) -> "UgvSent":
        """One command more, so long after the last [s]; at once, if it was sent instead of that."""
        lasts = stop.hold_over + contract.age + contract.latency
        commands = zip(self, (forward, -forward, turn, -turn), strict=True)
        return UgvSent(*(held.then(command, elapsed, lasts) for held, command in commands))


class Phases(NamedTuple):
    """A motion in one direction until it rests [m or rad], in its three phases."""

    top: Scalar
    """The largest speed [m/s or rad/s]."""
    reacting: Scalar
    """Before the command is obeyed."""
    held: Scalar
    """While it is gone on with."""
    braking: Scalar

    @property
    def whole(self) -> Scalar:
        """Of all three."""
        return self.reacting + self.held + self.braking

    def turned(self, turn: "Phases", growing: Scalar) -> Scalar:
        """How far a nose that turns meanwhile has turned, on average of this way [rad].

        By `growing` it turns, on average, while the command is gone on with.
        """
        by = 0.5 * self.reacting * turn.reacting + self.held * (turn.reacting + growing)
        return (by + self.braking * turn.whole) / (self.whole + TINY)


def pending(
    sent: tuple[Sent, Sent, Sent], parts: list[Scalar], share: float
) -> tuple[tuple[Scalar, Scalar], ...]:
    """For each axis (the sum of these parts of the newest commands; what the filter follows before them)."""
    x, y, z = (axis.newest for axis in sent)
    fx, fy, fz = (axis.before for axis in sent)
    dx = dy = dz = 0.0
    for k in reversed(range(len(parts))):
        part = parts[k]
        taken = share * (1.0 - part)
        dx, dy, dz = dx + part * x[k], dy + part * y[k], dz + part * z[k]
        fx, fy, fz = fx + (x[k] - fx) * taken, fy + (y[k] - fy) * taken, fz + (z[k] - fz) * taken
    return (dx, fx), (dy, fy), (dz, fz)


def within(periods: Scalar, commands: int) -> list[Scalar]:
    """Which part of each of the newest commands, the newest first, lies within the last so many periods."""
    return [clip(periods - k, 0.0, 1.0) for k in range(commands)]


def filter_share(contract: Contract, stop: UavStop) -> float:
    """How much of a command the UAV's filter takes up in a period."""
    return 1.0 - float(exp(-contract.period / stop.lag))


def uav_tube(
    contract: Contract,
    stop: UavStop,
    uav: UavState,
    sent: tuple[Sent, Sent, Sent],
    pace: Pace,
    age: Scalar,
) -> UavTube:
    """The stop of a UAV measured `age` [s] ago that was sent commands along the world's axes, at such a pace."""
    heading = uav.attitude.heading()
    roll, pitch, _ = uav.attitude.tilt()
    forward, left = heading.from_world(uav.velocity.x, uav.velocity.y)
    forward = stop.speed * forward + stop.tilt * pitch + stop.rate * uav.rates.y
    left = stop.speed * left - stop.tilt * roll - stop.rate * uav.rates.x
    up = stop.speed_up * uav.velocity.z
    share = filter_share(contract, stop)

    def rest(periods: Scalar) -> Vec3:
        parts = within(periods, len(sent[0].newest))
        (x, fx), (y, fy), (z, fz) = pending(sent, parts, share)
        follow_forward, follow_left = heading.from_world(fx, fy)
        dx, dy = heading.to_world(
            forward + stop.followed * follow_forward, left + stop.followed * follow_left
        )
        T = contract.period
        return Vec3(dx + T * x, dy + T * y, up + stop.followed_up * fz + T * z)

    height = stop.speed_up * contract.velocity_error + stop.error_up
    error, error_up = uav_error(contract, stop, uav, pace), contract.position_error + max(stop.hold, height)
    since, lag = age / contract.period, contract.latency / contract.period
    rests = (rest(since), rest(since + 0.5 * lag), rest(since + lag))
    return UavTube(rests, error, error_up + 0.0 * error)


def uav_error(contract: Contract, stop: UavStop, uav: UavState, pace: Pace) -> Scalar:
    """By how much the UAV's stop may miss its point, sideways [m]."""
    side = stop.speed * contract.velocity_error + stop.tilt * contract.angle_error
    side = side + stop.rate * contract.rate_error + uav_miss(stop, uav, pace)
    # A stop ends beyond its point by `side`, or is pushed off the point it holds by `hold`; never by both.
    return contract.position_error + maximum(stop.hold, side)


def uav_miss(stop: UavStop, uav: UavState, pace: Pace) -> Scalar:
    """The part of that which the linear law misses, of a UAV that moves, however it came to be that fast [m]."""
    moving = pace.then(uav.velocity.x, uav.velocity.y, 0.0)
    return stop.miss(moving.speed, moving.turn)


class UgvMotion(NamedTuple):
    """A UGV as a command finds it that is sent now: where it is, and how fast it may be by then."""

    contract: Contract
    stop: UgvStop
    ugv: UgvState
    sent: UgvSent
    nose: Heading
    reaction: Scalar
    """The time since it was seen included [s]."""
    ahead: Scalar
    """[m/s]."""
    astern: Scalar
    """[m/s]."""
    left: Scalar
    """[rad/s]."""
    right: Scalar

    @classmethod
    def of(cls, contract: Contract, stop: UgvStop, ugv: UgvState, sent: UgvSent, age: Scalar) -> "UgvMotion":
        """Of one that was seen `age` [s] ago, and was sent something before."""
        reaction = age + contract.latency + contract.period

        def fastest(seen: Scalar, error: float, gain: float, sent: Held) -> Scalar:
            speed = seen + error
            # Before a command bites the speed may still chase an earlier one.
            return maximum(maximum(speed, minimum(sent.most, speed + gain * reaction)), 0.0)

        drive, steering = (
            (contract.velocity_error, stop.acceleration),
            (contract.rate_error, stop.turn_acceleration),
        )
        return cls(
            contract,
            stop,
            ugv,
            sent,
            Heading.of(ugv.heading),
            reaction,
            ahead=fastest(ugv.speed, *drive, sent.ahead),
            astern=fastest(-ugv.speed, *drive, sent.astern),
            left=fastest(ugv.turn_rate, *steering, sent.left),
            right=fastest(-ugv.turn_rate, *steering, sent.right),
        )

    @property
    def known(self) -> Scalar:
        """Whether all that was seen of it is a number."""
        ugv = self.ugv
        return isfinite(ugv.x + ugv.y + ugv.heading + ugv.speed + ugv.turn_rate)

    @property
    def brake(self) -> float:
        """How it slows down at least [m/s^2]."""
        return self.stop.acceleration - self.contract.disturbance

    def reach(self, told: Scalar) -> Scalar:
        """How far it may go at most, told to go no faster than this [m/s]: a stop, and all of what it is told [m]."""
        speed = maximum(self.ahead, self.astern)
        braking = (speed * speed + told * told) / (2.0 * self.brake)
        return speed * self.reaction + told * self.stop.hold_over + braking

    def told(self, forward: Scalar, turn: Scalar) -> UgvTube:
        """Its stop if it hears a command and goes on with it until its watchdog ends it; (0, 0) is to stop now."""
        return self._tube(self._phases(self._gone_on_with(forward, turn)))

    def sweep(self, forward: Scalar, turn: Scalar) -> UgvSweep:
        """The same, as its nose turns by and by."""
        return self._sweep(self._gone_on_with(forward, turn))

    def committed(self) -> UgvSweep:
        """Its stop, if nobody knows which of the commands it was sent was the last that it heard."""
        surely_heard = self.contract.age + self.contract.latency
        return self._sweep(tuple((one.most, one.way(surely_heard, self.stop.hold_over)) for one in self.sent))

    def _gone_on_with(self, forward: Scalar, turn: Scalar) -> tuple[tuple[Scalar, Scalar], ...]:
        """(speed, way) ahead, astern, and of turning left and right, of a command until the watchdog ends it."""
        on = self.stop.hold_over
        return (forward, forward * on), (-forward, -forward * on), (turn, turn * on), (-turn, -turn * on)

    def _phases(self, held: tuple[tuple[Scalar, Scalar], ...]) -> tuple[Phases, Phases, Phases, Phases]:
        """Of going ahead and astern, and of turning left and right; `held` as of `_gone_on_with`."""

        def motion(speed: Scalar, brake: float, held: tuple[Scalar, Scalar]) -> Phases:
            told, way = held
            top = maximum(speed, told)
            return Phases(top, speed * self.reaction, maximum(way, 0.0), top * top / (2.0 * brake))

        brake, turn_brake = self.brake, self.stop.turn_acceleration
        return (
            motion(self.ahead, brake, held[0]),
            motion(self.astern, brake, held[1]),
            motion(self.left, turn_brake, held[2]),
            motion(self.right, turn_brake, held[3]),
        )

    def _tube(self, phases: tuple[Phases, Phases, Phases, Phases]) -> UgvTube:
        ahead, astern, left, right = phases
        error = self.contract.angle_error
        ends = Turn(error + left.whole, error + right.whole)
        return UgvTube(self.nose, ahead.whole, astern.whole, ends)

    def _sweep(self, held: tuple[tuple[Scalar, Scalar], ...]) -> UgvSweep:
        phases = self._phases(held)
        ahead, astern, left, right = phases

        def growing(turn: Phases, told: Scalar) -> Scalar:
            # It turns at a steady rate, once it has eased off to it; slower if told less; never by more than all of it.
            told = maximum(told, 0.0)
            eased = turn.top - told
            steady = 0.5 * told * self.stop.hold_over + eased * eased / (2.0 * self.stop.turn_acceleration)
            return minimum(steady, turn.held + turn.braking)

        growing_left, growing_right = growing(left, held[2][0]), growing(right, held[3][0])

        def mean(way: Phases) -> Turn:
            error = self.contract.angle_error
            return Turn(error + way.turned(left, growing_left), error + way.turned(right, growing_right))

        return UgvSweep(self._tube(phases), mean(ahead), mean(astern))


class UavCommitment(NamedTuple):
    """What the UAV may yet do, as others have to see it: whatever command is the last that it heard is gone on with."""

    tube: UavTube
    """Its stop, if it hears everything."""
    least: Vec3
    """[m] by which it may rest elsewhere, axis by axis, from here..."""
    most: Vec3
    """...to there."""

    @classmethod
    def of(
        cls, tube: UavTube, sent: tuple[Sent, Sent, Sent], period: float, hold_over: float
    ) -> "UavCommitment":
        """Of a UAV that was sent this, and goes on with a command for so long [s]."""
        (x, ahead), (y, aside), (z, above) = (axis.held_over(period, hold_over) for axis in sent)
        return cls(tube, Vec3(x, y, z), Vec3(ahead, aside, above))

    def advance(self, x: Scalar, y: Scalar) -> Scalar:
        """How far it goes along the horizontal unit vector (x, y) [m]."""
        least, most = self.least, self.most
        return self.tube.advance(x, y) + maximum(least.x * x, most.x * x) + maximum(least.y * y, most.y * y)

    def sink(self) -> Scalar:
        """How far down it goes [m]."""
        return self.tube.sink() - self.least.z

    def sinking(self, by: Scalar) -> "UavCommitment":
        """As if it might come down by so much more [m]."""
        return self._replace(least=self.least - Vec3(0.0 * by, 0.0 * by, by))


@dataclass(frozen=True)
class UgvCommitment:
    """What a UGV may yet do, as others have to see it; worked out for whom it may come near."""

    motion: UgvMotion

    @cached_property
    def reach(self) -> Scalar:
        """How far it may go at most [m]; no number if not all is known of it."""
        motion, sent = self.motion, self.motion.sent
        return where(motion.known, motion.reach(maximum(sent.ahead.most, sent.astern.most)), nan)

    @cached_property
    def sweep(self) -> UgvSweep:
        """Its stop."""
        return self.motion.committed()


@dataclass(frozen=True)
class UgvProposal:
    """What a UGV would do with a command; worked out for whom it matters."""

    motion: UgvMotion
    forward: Scalar
    """[m/s]."""
    turn: Scalar
    """[rad/s]."""

    def slower(self, forward: Scalar) -> UgvTube:
        """Its way if it is told this speed instead [m/s], turning the same."""
        return self.motion.told(forward, self.turn)

    @cached_property
    def sweep(self) -> UgvSweep:
        """Its way, as its nose turns by and by."""
        return self.motion.sweep(self.forward, self.turn)


def wall_faces(arena: Arena, x: Scalar, y: Scalar, radius: float) -> tuple[tuple[float, float, Scalar], ...]:
    """(normal x, normal y, gap [m]) of the four walls."""
    b = arena.bounds
    return (
        (1.0, 0.0, x - b.x_min - radius),
        (-1.0, 0.0, b.x_max - x - radius),
        (0.0, 1.0, y - b.y_min - radius),
        (0.0, -1.0, b.y_max - y - radius),
    )


def side_of_box(box: Box, x: Scalar, y: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """(normal x, normal y, distance [m]) of the side of a box that (x, y) is beyond; no distance inside it."""
    dx, dy = box.gap(x, y)
    far = sqrt(dx * dx + dy * dy)
    return dx / (far + TINY), dy / (far + TINY), far


def side_of_point(x: Scalar, y: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """(normal x, normal y, distance [m]) of what stands at the origin, seen from (x, y)."""
    far = sqrt(x * x + y * y)
    return x / (far + TINY), y / (far + TINY), far


def beyond(gap: Scalar, reach: Scalar) -> bool:
    """Whether something is surely farther than that [m]; infinitely far is no place, and not known to be far."""
    return surely((gap > reach) & (gap < inf))


def around_uav(
    contract: Contract,
    stop: UavStop,
    reach: Scalar,
    arena: Arena,
    uav: UavState,
    tube: UavTube,
    ugvs: Sequence[UgvCommitment],
) -> Around:
    """All that the UAV must stay clear of that leaves no more room than `reach` [m]."""
    x, y, z = uav.position.x, uav.position.y, uav.position.z
    low, high = z - stop.half_height, arena.ceiling - z - stop.half_height
    sink = tube.error_up + tube.sink()
    far = reach + tube.reach

    def to_thing(nx: Scalar, ny: Scalar, gap: Scalar) -> Scalar:
        return gap - tube.error - tube.advance(-nx, -ny)

    def to_ugv(nx: Scalar, ny: Scalar, gap: Scalar, one: UgvCommitment) -> Scalar:
        return to_thing(nx, ny, gap) - contract.position_error - one.sweep.advance(nx, ny)

    gaps, faces = [low, high], []
    for nx, ny, gap in wall_faces(arena, x, y, stop.radius):
        gaps.append(gap)
        if not beyond(gap, far):
            faces.append(Face(nx, ny, 0.0, gap, to_thing(nx, ny, gap), Reason.WALL))
    faces.append(Face(0.0, 0.0, 1.0, low, low - sink, Reason.FLOOR))
    faces.append(Face(0.0, 0.0, -1.0, high, high - tube.error_up - tube.rise(), Reason.CEILING))
    for obstacle in arena.obstacles:
        nx, ny, distance = side_of_box(obstacle.footprint, x, y)
        gap, above = distance - stop.radius, low - obstacle.height
        gaps.append(maximum(gap, above))
        if not beyond(gap, far):
            beside = partial(to_thing, nx, ny, gap)
            faces.append(_side_or_top(nx, ny, gap, beside, above, above - sink, Reason.OBSTACLE))
    for one in ugvs:
        ugv = one.motion
        nx, ny, distance = side_of_point(x - ugv.ugv.x, y - ugv.ugv.y)
        gap, above = distance - stop.radius - ugv.stop.radius, low - ugv.stop.height
        gaps.append(maximum(gap, above))
        if not beyond(gap - contract.position_error - one.reach, far):
            beside = partial(to_ugv, nx, ny, gap, one)
            faces.append(_side_or_top(nx, ny, gap, beside, above, above - sink, Reason.VEHICLE))
    return Around.of(gaps, faces, reach)


def _side_or_top(
    nx: Scalar,
    ny: Scalar,
    gap: Scalar,
    beside: Callable[[], Scalar],
    above: Scalar,
    room_above: Scalar,
    reason: Reason,
) -> Face:
    """Beside or above is enough: the roomier of the two. Beside there is never more room than the gap."""
    zero = 0.0 * nx
    room = zero - FREE if surely(room_above >= gap) else beside()
    x, y, z = where(room_above > room, (zero, zero, 1.0 + zero), (nx, ny, zero))
    return Face(x, y, z, maximum(gap, above), maximum(room, room_above), reason)


def around_ugv(
    contract: Contract,
    motion: UgvMotion,
    reach: Scalar,
    arena: Arena,
    others: Sequence[UgvCommitment],
    uav: tuple[UavStop, UavState, UavCommitment],
) -> Around:
    """All that a UGV must stay clear of that may go as far as `reach` [m].

    The room does not yet count its own way, which its command decides.
    """
    stop, ugv, error = motion.stop, motion.ugv, contract.position_error
    still = [(gap, nx, ny, Reason.WALL) for nx, ny, gap in wall_faces(arena, ugv.x, ugv.y, stop.radius)]
    for obstacle in arena.obstacles:
        nx, ny, far = side_of_box(obstacle.footprint, ugv.x, ugv.y)
        still.append((far - stop.radius, nx, ny, Reason.OBSTACLE))
    near = [one for one in still if not surely(one[0] - error > reach)] or [min(still)]
    # Where one of them is near, so is the nearest: no other gap is smaller.
    faces = [Face(nx, ny, 0.0, gap, gap - error, reason) for gap, nx, ny, reason in near]
    for other in others:
        nx, ny, far = side_of_point(ugv.x - other.motion.ugv.x, ugv.y - other.motion.ugv.y)
        gap = far - stop.radius - other.motion.stop.radius
        room = gap - 2.0 * error
        # Where the two cannot meet, however the other turns, by how much is all the same.
        apart = beyond(room - other.reach, reach)
        way = other.reach if apart else other.sweep.advance(nx, ny)
        faces.append(Face(nx, ny, 0.0, gap, room - way, Reason.VEHICLE))
    uav_stop, state, commitment = uav
    nx, ny, far = side_of_point(ugv.x - state.position.x, ugv.y - state.position.y)
    gap = far - stop.radius - uav_stop.radius
    above = state.position.z - uav_stop.half_height - stop.height
    # To stay above is the UAV's own affair; it is a UGV's not to drive under one that is coming down.
    over = above - commitment.tube.error_up - commitment.sink() >= 0.0
    room = cond(
        over,
        lambda: 0.0 * gap + FREE,
        lambda: gap - error - commitment.tube.error - commitment.advance(nx, ny),
    )
    faces.append(Face(nx, ny, 0.0, maximum(gap, above), room, Reason.VEHICLE))
    return Around.of([face.gap for face in faces], faces, reach)
