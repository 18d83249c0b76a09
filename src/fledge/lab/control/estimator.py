"""Poses -> how the vehicles move: the lab's only source of velocities.

    velocity = (newest position - oldest position) / (time in between)

over the real stamps of one run of poses, `shortest` to `longest` seconds apart, at 100 Hz 40 ms; body rates and turn
rates alike, from attitudes. UGVs move along their noses; headings are unwrapped. Positions are passed on as they came.

*The error.* A mean velocity differs from the last one by at most acceleration x time / 2, and two positions that are
each wrong by up to `noise` make a difference wrong by twice that:

    |error| <= 2 noise / shortest + acceleration longest / 2

No filter that knows nothing but positions does better by its weights: their absolute values sum up to 2 / time, where
least squares over the same time comes to 3 / time. With 0.5 mm and the 2.4 m/s^2 of a tilt of 0.21 rad and its drag
the bound is 0.094 m/s. Stamps that are wrong count as noise: their error times the speed. For rotations this holds to
the first order in the angle turned meanwhile.

*What is wrong stays wrong.* Nothing is smoothed away: the watchdog (`tracking`) sees each pose that is no number, out
of order or elsewhere as it came, with the last velocity, which it will not believe; unless a better pose came in the
same tick. But no velocity is taken across it. Poses follow each other if the later one is within `longest` and within a
vehicle's reach; what follows nothing begins a run of its own, and is forgotten when the old run goes on, or replaces it
once it is long enough. So a single bad pose leaves no trace, and after a pause, in which there is no velocity to tell,
a vehicle shows up again only with a velocity that keeps the bound; until then its last pose grows old.

Not seen here: a pose that repeats itself under new frame numbers looks like a vehicle that stands.
"""

from dataclasses import dataclass, replace
from math import atan2, inf, isfinite, remainder, sqrt, tau
from typing import NamedTuple

from fledge.geometry import Heading, Quat, Vec3
from fledge.supervision.tracking import Tracker, VehicleState
from fledge.world import UavState, UgvState, WorldState

UAV = 0
"""The number of the vehicle that flies; the others drive."""


class Pose(NamedTuple):
    """Where a body was."""

    stamp: float
    """[s]."""
    position: Vec3
    """World position [m]."""
    attitude: Quat
    """Rotation world_from_body."""


class Sample(NamedTuple):
    """A pose in a run."""

    pose: Pose
    heading: float
    """Of a UGV, not wrapped [rad]."""


class Seen(NamedTuple):
    """What is remembered of one vehicle."""

    run: tuple[Sample, ...] = ()
    """Poses that follow each other, oldest first, none older than `longest` when the last one came."""
    stray: tuple[Sample, ...] = ()
    """The same, of poses that did not follow those."""
    known: float = -inf
    """Stamp of the last pose that was shown with a velocity of its own [s]."""
    state: VehicleState | None = None
    """As of then."""
    doubt: VehicleState | None = None
    """A pose that came since then, and is to be shown to be found out."""
    renewed: bool = False
    """Whether a pose with a velocity came in this tick."""


@dataclass(frozen=True, slots=True)
class Estimator:
    """Between which poses velocities are taken."""

    shortest: float = 0.025  # [s] chosen: at 100 Hz 30 ms, should the fourth frame back be lost
    longest: float = 0.045  # [s] chosen: at 100 Hz 40 ms; more is less noise and more lag
    tracker: Tracker = Tracker()
    """Whose idea of a vehicle's reach counts."""

    def init(self, vehicles: int) -> tuple[Seen, ...]:
        """Nobody was seen yet."""
        return (Seen(),) * vehicles

    def begin(self, memory: tuple[Seen, ...]) -> tuple[Seen, ...]:
        """The memory as a new tick begins, of which `world` is asked once, in the end."""
        return tuple(seen._replace(renewed=False) if seen.renewed else seen for seen in memory)

    def see(self, memory: tuple[Seen, ...], vehicle: int, pose: Pose) -> tuple[Seen, ...]:
        """The memory after a pose of one vehicle."""
        seen = self._see(memory[vehicle], pose, vehicle == UAV)
        return (*memory[:vehicle], seen, *memory[vehicle + 1 :])

    def world(self, memory: tuple[Seen, ...], t: float) -> WorldState | None:
        """All vehicles at time `t` [s], as last seen; None until every one was seen for long enough."""
        uav, *ugvs = (seen.doubt or seen.state for seen in memory)
        if uav is None or None in ugvs:
            return None
        return WorldState(t, uav, tuple(ugvs))  # pyright: ignore[reportArgumentType]

    def velocity_error(self, noise_m: float, acceleration: float) -> float:
        """Bound [m/s] with positions wrong by up to `noise_m` [m], of a vehicle that accelerates by no more [m/s^2]."""
        return self._error(noise_m, acceleration)

    def rate_error(self, noise_rad: float, angular_acceleration: float) -> float:
        """The same [rad/s] of body rates and turn rates, from errors [rad] and accelerations [rad/s^2] of rotations."""
        return self._error(noise_rad, angular_acceleration)

    def _error(self, noise: float, acceleration: float) -> float:
        return 2.0 * noise / self.shortest + acceleration * self.longest / 2.0

    def _see(self, seen: Seen, pose: Pose, flies: bool) -> Seen:
        if not _is_number(pose):
            return _shown_as_it_is(seen, pose)
        if self._follows(seen.run, pose):
            run = self._then(seen.run, _sample(seen.run, pose, flies))
            return self._known(seen._replace(run=run, stray=()), flies)
        if self._follows(seen.stray, pose):
            stray = self._then(seen.stray, _sample(seen.stray, pose, flies))
        else:
            stray = (_sample(seen.run, pose, flies),)
        if self._span(stray) >= self.shortest:
            return self._known(seen._replace(run=stray, stray=()), flies)
        seen = seen._replace(stray=stray)
        # Only what the watchdog is sure to find out: its velocity is not its own.
        out_of_order = pose.stamp <= seen.known
        elsewhere = self._goes_on(seen) and pose.stamp - seen.known <= self.longest
        return _shown_as_it_is(seen, pose) if out_of_order or elsewhere else seen

    def _follows(self, run: tuple[Sample, ...], pose: Pose) -> bool:
        if not run:
            return False
        last = run[-1].pose
        dt, way = pose.stamp - last.stamp, pose.position - last.position
        reach = self.tracker.reach(dt)
        return 0.0 < dt <= self.longest and way.x * way.x + way.y * way.y + way.z * way.z <= reach * reach

    def _then(self, run: tuple[Sample, ...], sample: Sample) -> tuple[Sample, ...]:
        oldest = sample.pose.stamp - self.longest
        return (*(one for one in run if one.pose.stamp >= oldest), sample)

    def _span(self, run: tuple[Sample, ...]) -> float:
        return run[-1].pose.stamp - run[0].pose.stamp

    def _goes_on(self, seen: Seen) -> bool:
        """Whether the last pose of the run was shown with its velocity."""
        return bool(seen.run) and seen.run[-1].pose.stamp == seen.known

    def _known(self, seen: Seen, flies: bool) -> Seen:
        """With what the run says, if it is long enough to say something."""
        if self._span(seen.run) < self.shortest:
            return seen
        first, last = seen.run[0], seen.run[-1]
        state = _uav(first.pose, last.pose) if flies else _ugv(first, last)
        return seen._replace(known=last.pose.stamp, state=state, doubt=None, renewed=True)


def _is_number(pose: Pose) -> bool:
    p, q = pose.position, pose.attitude
    return isfinite(pose.stamp + p.x + p.y + p.z + q.w + q.x + q.y + q.z)


def _sample(run: tuple[Sample, ...], pose: Pose, flies: bool) -> Sample:
    """A pose, and of a UGV the heading that is nearest to the last one of a run [rad]."""
    nose = pose.attitude.heading()
    angle, last = atan2(nose.sin, nose.cos), run[-1].heading if run else 0.0
    return Sample(pose, 0.0 if flies else last + remainder(angle - last, tau))


def _shown_as_it_is(seen: Seen, pose: Pose) -> Seen:
    """A pose that nobody is to believe, with the last velocity; not if the watchdog has yet to see that one."""
    if seen.state is None or seen.renewed:
        return seen
    p = pose.position
    if isinstance(seen.state, UavState):
        return seen._replace(doubt=replace(seen.state, position=p, attitude=pose.attitude, stamp=pose.stamp))
    return seen._replace(doubt=replace(seen.state, x=p.x, y=p.y, stamp=pose.stamp))


def _uav(first: Pose, last: Pose) -> UavState:
    share = 1.0 / (last.stamp - first.stamp)
    velocity = (last.position - first.position) * share
    rates = _turned(first.attitude, last.attitude) * share
    return UavState(last.position, velocity, last.attitude, rates, last.stamp)


def _ugv(first: Sample, last: Sample) -> UgvState:
    a, b = first.pose, last.pose
    share = 1.0 / (b.stamp - a.stamp)
    way = b.position - a.position
    speed, _ = Heading.of(last.heading).from_world(way.x * share, way.y * share)
    turn_rate = (last.heading - first.heading) * share
    return UgvState(b.position.x, b.position.y, last.heading, speed, turn_rate, b.stamp)


def _turned(a: Quat, b: Quat) -> Vec3:
    """The rotation from attitude `a` to `b`, in body axes [rad]."""
    w = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z
    x = a.w * b.x - a.x * b.w - a.y * b.z + a.z * b.y
    y = a.w * b.y - a.y * b.w - a.z * b.x + a.x * b.z
    z = a.w * b.z - a.z * b.w - a.x * b.y + a.y * b.x
    if w < 0.0:  # the same rotation, the short way
        w, x, y, z = -w, -x, -y, -z
    half = sqrt(x * x + y * y + z * z)
    scale = 2.0 * atan2(half, w) / half if half > 0.0 else 2.0
    return Vec3(x * scale, y * scale, z * scale)
