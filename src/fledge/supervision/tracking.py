"""Which poses may be believed: every sample is held against the ones before it.

A sample is dropped, and the last good one kept with its stamp, when it is no pose, comes from the future or from the
past, or is where no vehicle can have got to. So every fault of the pose stream ends as an age, and an age is what a
net knows how to handle.

* **Jump.** A pose that moved further than `fastest` dt + 3 position errors is not followed. If it jumps back, it is
  believed at once. If it stays away, quietly, for `patience`, it is believed again, since an old pose guards nothing;
  but one of the two places was wrong, nothing here can say which, and `Sight.elsewhere` calls for a person.
* **Swap.** Two poses that jump, each to where the other was: the same, under another name.
* **Contradiction.** `Track.strain` sums up moved - velocity dt and forgets it over `window` T. With position errors up
  to e_p and velocity errors up to e_v it stays within e_v T + 2 e_p (sum by parts); the limit is e_v T + 3 e_p, the
  third being for sampling. So nothing is called a contradiction within these errors, and a velocity that is wrong by
  more than e_v + 5 e_p / T, 0.3 m/s, always is: from 0.15 m/s if it is its sign that is wrong. Either may be right,
  so the sample is not dropped.

What it cannot see: a slow bias, axes flipped from the start, anything about which positions and velocities agree.

NaN passes no comparison: conditions say what is good, never what is bad.
"""

from dataclasses import dataclass
from itertools import combinations
from math import inf
from typing import Any, NamedTuple

from fledge.geometry import Heading, Quat, Vec3
from fledge.safety.contract import Contract
from fledge.scalars import Scalar, maximum, negate, where
from fledge.world import Reason, UavState, UgvState, WorldState

LEAD = 0.02
"""[s] that a stamp may be ahead of the clock: two ticks; chosen."""

NOWHERE = Vec3(0.0, 0.0, 0.0)

VehicleState = UavState | UgvState


class Motion(NamedTuple):
    """One sample of how a vehicle moves, whatever its kind."""

    position: Vec3
    """World [m]."""
    velocity: Vec3
    """World [m/s]."""
    stamp: Scalar
    """[s]."""

    @classmethod
    def of(cls, state: VehicleState) -> "Motion":
        """A UGV moves along its nose, on the floor."""
        if isinstance(state, UgvState):
            vx, vy = Heading.of(state.heading).to_world(state.speed, 0.0)
            return cls(Vec3(state.x, state.y, 0.0), Vec3(vx, vy, 0.0), state.stamp)
        return cls(state.position, state.velocity, state.stamp)


class Track(NamedTuple):
    """What is remembered of one vehicle's poses."""

    trusted: Any
    """The last state believed, a `VehicleState`."""
    latest: Motion
    """The last one that came in good order, believed or not."""
    strain: Vec3
    """Recent contradiction between positions and velocities [m]."""
    shift: Vec3
    """Sum of the jumps for which the pose is not believed [m]."""
    jumped: Scalar
    """Stamp of the last jump [s]."""
    lost: Scalar
    """`JUMP` or `SWAP` while the pose is not believed, else 0."""


class News(NamedTuple):
    """A sample against the latest one."""

    state: VehicleState
    motion: Motion
    dt: Scalar
    """Time in between [s]."""
    moved: Vec3
    """Way in between [m]."""
    reach: Scalar
    """How far that could seem to be [m]."""
    fault: Scalar
    """The `Reason` not to look at it any further, or 0."""
    fresh: Scalar
    """Whether it is in good order, and new."""
    jumped: Scalar
    """Whether it is fresh, but nothing moves that far in that time."""


class Sight(NamedTuple):
    """What came of one sample."""

    dropped: Scalar
    """The `Reason` why it is not believed, or 0."""
    elsewhere: Scalar
    """The `Reason` why it had not been believed, in the tick in which it is believed again in another place; else 0."""
    contradicts: Scalar
    """Whether positions and velocities contradict each other."""


@dataclass(frozen=True, slots=True)
class Tracker:
    """Limits of what a vehicle can do, and a pose be wrong by."""

    contract: Contract = Contract()
    """Whose errors of position and velocity a pose may have."""
    far: float = 100.0  # [m] from the origin: farther off is a slip of units; chosen
    fastest: float = 5.0  # [m/s]; chosen: 2 m/s along both axes, and the overshoot that the UAV can have
    wild: float = 50.0  # [m/s, rad/s]: a velocity or rate beyond it is none; chosen
    window: float = 0.5  # [s]; chosen: shorter sees less, longer takes longer
    gap: float = 0.1  # [s]; chosen: beyond it, two velocities say little of what was in between
    patience: float = 1.0  # [s]; chosen

    def reach(self, dt: Scalar) -> Scalar:
        """How far a vehicle can seem to move in that time [s], in metres."""
        return self.fastest * dt + 3.0 * self.contract.position_error

    def init(self, world: WorldState) -> tuple[Track, ...]:
        """The first poses are believed; one that is none counts as endlessly old, and binds nothing after it."""
        return tuple(self._begin(state) for state in (world.uav, *world.ugvs))

    def _begin(self, state: VehicleState) -> Track:
        possible = self._possible(state)
        trusted = where(possible, state, _unknown(state))
        latest = where(possible, Motion.of(state), Motion(NOWHERE, NOWHERE, -inf))
        return Track(trusted, latest, NOWHERE, NOWHERE, trusted.stamp, 0.0)

    def follow(
        self, tracks: tuple[Track, ...], seen: WorldState, now: Scalar
    ) -> tuple[tuple[Track, ...], tuple[Sight, ...]]:
        """(tracks, what came of the samples), the UAV first; `now` [s] is what the stamps are held against."""
        states = (seen.uav, *seen.ugvs)
        news = [self._compare(track, state, now) for track, state in zip(tracks, states, strict=True)]
        found = [
            self._follow(track, new, swapped)
            for track, new, swapped in zip(tracks, news, _swapped(tracks, news), strict=True)
        ]
        return tuple(track for track, _ in found), tuple(sight for _, sight in found)

    def _compare(self, track: Track, state: VehicleState, now: Scalar) -> News:
        sample, last = Motion.of(state), track.latest
        dt, moved = sample.stamp - last.stamp, sample.position - last.position
        way, reach = _squared(moved), self.reach(dt)
        # The same sample once more is no fault: nothing new has come, and that shows as age.
        fault = where((dt == 0.0) & (way > 0.0), float(Reason.DUPLICATE), 0.0)
        fault = where(dt < 0.0, float(Reason.BACKWARD), fault)
        fault = where(now - sample.stamp >= -LEAD, fault, float(Reason.FUTURE))
        fault = where(self._possible(state), fault, float(Reason.BAD_POSE))
        fresh = (fault == 0.0) & negate(dt <= 0.0)
        jumped = fresh & negate(way <= reach * reach)
        return News(state, sample, dt, moved, reach, fault, fresh, jumped)

    def _possible(self, state: VehicleState) -> Scalar:
        """Whether a pose is of this world."""
        far, wild = self.far, self.wild
        if isinstance(state, UgvState):
            inside = (abs(state.x) <= far) & (abs(state.y) <= far) & (abs(state.heading) < inf)
            moving = (abs(state.speed) <= wild) & (abs(state.turn_rate) <= wild)
        else:
            p, q = state.position, state.attitude
            norm = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z
            inside = (abs(p.x) <= far) & (abs(p.y) <= far) & (abs(p.z) <= far) & (abs(norm - 1.0) <= 0.1)
            moving = (_squared(state.velocity) <= wild * wild) & (_squared(state.rates) <= wild * wild)
        return inside & moving & (abs(state.stamp) < inf)

    def _follow(self, track: Track, new: News, swapped: Scalar) -> tuple[Track, Sight]:
        fresh = new.fresh
        jumped = where(new.jumped, new.motion.stamp, track.jumped)
        shift = where(new.jumped, track.shift + new.moved, track.shift)
        away = where(new.jumped, where(swapped, float(Reason.SWAP), float(Reason.JUMP)), track.lost)
        back = fresh & (_squared(shift) <= new.reach * new.reach)
        stayed = fresh & (new.motion.stamp - jumped >= self.patience)
        lost = where(back | stayed, 0.0, away)
        strain = where(fresh, self._strain(track, new), track.strain)
        limit = self.contract.velocity_error * self.window + 3.0 * self.contract.position_error
        sight = Sight(
            where(new.fault > 0.0, new.fault, lost),
            where(stayed & negate(back), away, 0.0),
            negate(_squared(strain) <= limit * limit),
        )
        followed = Track(
            where(fresh & (lost == 0.0), new.state, track.trusted),
            where(fresh, new.motion, track.latest),
            strain,
            where(lost > 0.0, shift, NOWHERE),
            jumped,
            lost,
        )
        return followed, sight

    def _strain(self, track: Track, new: News) -> Vec3:
        """The contradiction between positions and velocities after a sample [m]."""
        dt = maximum(new.dt, 0.0)
        gone = new.moved - (track.latest.velocity + new.motion.velocity) * (0.5 * dt)
        strain = track.strain + where(dt <= self.gap, gone, NOWHERE)
        return where(new.jumped, NOWHERE, strain * (self.window / (self.window + dt)))


def _unknown(state: VehicleState) -> VehicleState:
    """A pose of this kind that nobody ever saw; of numbers, lest a net remember nonsense."""
    if isinstance(state, UgvState):
        return UgvState(0.0, 0.0, 0.0, 0.0, 0.0, -inf)
    return UavState(NOWHERE, NOWHERE, Quat(1.0, 0.0, 0.0, 0.0), NOWHERE, -inf)


def _swapped(tracks: tuple[Track, ...], news: list[News]) -> list[Scalar]:
    """Whether each vehicle jumped to where another was that jumped to where it was; seen from above."""
    swapped = [new.jumped & False for new in news]
    for i, j in combinations(range(len(news)), 2):
        both = news[i].jumped & news[j].jumped
        both = both & _meets(news[i], tracks[j].latest) & _meets(news[j], tracks[i].latest)
        swapped[i], swapped[j] = swapped[i] | both, swapped[j] | both
    return swapped


def _meets(new: News, other: Motion) -> Scalar:
    """Whether a vehicle came to where another was."""
    dx, dy = new.motion.position.x - other.position.x, new.motion.position.y - other.position.y
    return dx * dx + dy * dy <= new.reach * new.reach


def _squared(v: Vec3) -> Scalar:
    return v.x * v.x + v.y * v.y + v.z * v.z
