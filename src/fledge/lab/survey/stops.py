"""How a UAV stops: the linear law of `UavStop`, fitted to the stops of flights, and how far it misses.

A stop begins when the command becomes zero, and may begin as well in any of the ticks after that, with what the vehicle
is doing then. The law says how far it still goes, by what moves now and by what was sent and is not obeyed yet:

    rest = speed v + tilt theta + rate theta' + followed f + period (commands on their way)

per heading axis, and in height without tilt. It is the nets' own (`safety.tube.uav_tube`), asked with one coefficient
set and the others zero, so what is fitted here is what is flown there. States are smoothed, not estimated: what the
estimator adds is the contract's `velocity_error` and `rate_error`.

*The fit* is weighted least squares over the place a vehicle has come to after `SETTLED`. *The error* of a stop is how
far it goes, before it stands, beyond the hull of all that the law predicts for commands that act at once, or late; the
largest over the ticks it may begin in. The bound is `bounds.bound` of those.

A stop is over when the vehicle stands: what the air does with it afterwards is drift, and holding a place is a net's.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from fledge.geometry import Quat, Vec3
from fledge.lab.survey.bounds import bound
from fledge.lab.survey.smoothing import smooth
from fledge.lab.survey.traces import Trace
from fledge.safety.contract import Contract, UavStop
from fledge.safety.tube import Pace, Sent, filter_share, uav_tube
from fledge.supervision.watchdog import TICK
from fledge.world import UavState

LONG = 100
"""Ticks without a command that make a stop worth looking at."""
LATER = 40
"""Ticks in which it may begin as well: after that it is nearly over."""
SETTLED = 90
"""Ticks after which it has come to its rest, or will not."""
STANDS, FOR = 0.1, 10
"""[m/s] below which it stands, if it does so for that many ticks; chosen: the contract's velocity error."""
LEAST_WAY = 0.05
"""[m] added to the way that a sample weighs by; chosen: what does not move counts a little, too."""
ROUND = 72
"""Directions in which a hull is looked at."""
ZERO = UavStop(speed=0.0, tilt=0.0, rate=0.0, followed=0.0, error_speed=0.0, speed_up=0.0, followed_up=0.0)


class Flown(NamedTuple):
    """One flight, as far as stops go."""

    state: UavState
    """As it was at the stamps, smoothed; arrays of shape (ticks,)."""
    age: np.ndarray
    """Of the poses [s]."""
    commands: np.ndarray
    """In the world's axes [m/s], shape (ticks, 3); NaN where none was obeyed."""
    known: np.ndarray
    """Whether there were poses."""


class Stop(NamedTuple):
    """Where one is in a flight."""

    begin: int
    """Its first tick."""
    end: int
    """The tick after its last one without a command, or without much."""


@dataclass(frozen=True, slots=True)
class Law:
    """A law, and what speaks for it."""

    stop: UavStop
    level: np.ndarray
    """How far each stop went beyond what was predicted, in the plane [m]."""
    height: np.ndarray
    """And in height [m]."""
    speeds: np.ndarray
    """At which the stops in the plane began [m/s]."""


def flown(trace: Trace) -> Flown:
    """A flight with the UAV's states as they really were."""
    same = np.cumprod(np.where((trace.attitude[1:] * trace.attitude[:-1]).sum(axis=1) < 0.0, -1.0, 1.0))
    attitude = trace.attitude * np.concatenate([[1.0], same])[:, None]
    way, turn = smooth(trace.stamp, trace.position), smooth(trace.stamp, attitude)
    q = Quat(*(turn.value / np.linalg.norm(turn.value, axis=1)[:, None]).T)
    state = UavState(Vec3(*way.value.T), Vec3(*way.slope.T), q, _rates(q, Quat(*turn.slope.T)), trace.stamp)
    forward, left, up, _ = trace.told.T
    x, y = q.heading().to_world(forward, left)
    return Flown(state, trace.t - trace.stamp, np.stack([x, y, up], axis=1), way.known & turn.known)


def _rates(q: Quat, d: Quat) -> Vec3:
    """Body rates [rad/s] from an attitude and how it changes: twice the vector part of conj(q) d."""
    return Vec3(
        2.0 * (q.w * d.x - q.x * d.w - q.y * d.z + q.z * d.y),
        2.0 * (q.w * d.y - q.y * d.w - q.z * d.x + q.x * d.z),
        2.0 * (q.w * d.z - q.z * d.w - q.x * d.y + q.y * d.x),
    )


def found(flight: Flown, axes: Sequence[int]) -> list[Stop]:
    """The stops along these of the world's axes."""
    told = np.abs(flight.commands[:, list(axes)]).max(axis=1)
    still = np.concatenate([[False], (told == 0.0) & flight.known, [False]])
    begins, ends = np.flatnonzero(still[1:] & ~still[:-1]), np.flatnonzero(~still[1:] & still[:-1])
    moved = (Stop(int(a), int(b)) for a, b in zip(begins, ends, strict=True) if b - a >= LONG and a > 0)
    return [one for one in moved if told[one.begin - 1] > 0.0]


def fit(flights: Sequence[Flown], contract: Contract, lag: float) -> Law:
    """The law that fits best, with bounds on what it misses; `lag` [s] is that of the command filter."""
    zero = replace(ZERO, lag=lag)
    level = _solved(_level(flights, contract, zero))
    height = _solved(_height(flights, contract, zero))
    names = ("speed", "tilt", "rate", "followed", "speed_up", "followed_up")
    stop = replace(zero, **dict(zip(names, (*level, *height), strict=True)))
    beside, above, speeds = overruns(flights, contract, stop)
    stop = replace(stop, error=bound(beside), error_up=bound(above))
    return Law(stop, beside, above, speeds)


def overruns(
    flights: Sequence[Flown], contract: Contract, stop: UavStop
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(how far every stop goes beyond the prediction in the plane [m], in height [m], the speeds of the former)."""
    beside, above, speeds = [], [], []
    for flight in flights:
        rests = _rests(flight, contract, stop)
        p, v = flight.state.position, flight.state.velocity
        speed = np.hypot(v.x, v.y)
        for one in found(flight, (0, 1)):
            end = _over(speed, one)
            beside.append(max(_beside(p, rests, i, end) for i in range(one.begin, min(_last(one), end))))
            speeds.append(speed[one.begin])
        for one in found(flight, (2,)):
            end = _over(np.abs(v.z), one)
            above.append(max(_above(p.z, rests, i, end) for i in range(one.begin, min(_last(one), end))))
    return np.array(beside), np.array(above), np.array(speeds)


def pushes(flights: Sequence[Flown], contract: Contract, stop: UavStop) -> tuple[np.ndarray, np.ndarray]:
    """After every stop: (how fast it drifts [m/s], which acceleration moves the point of its rest [m/s^2])."""
    drifts, pushed = [], []
    for flight in flights:
        (*_, late), p = _rests(flight, contract, stop), flight.state.position
        for one in found(flight, (0, 1)):
            a, b = one.begin + LATER + LATER // 2, one.end - 1
            time = (b - a) * TICK
            drifts.append(np.hypot(p.x[b] - p.x[a], p.y[b] - p.y[a]) / time)
            x, y = p.x + late.x, p.y + late.y
            pushed.append(np.hypot(x[b] - x[a], y[b] - y[a]) / time / stop.speed)
    return np.array(drifts), np.array(pushed)


def _last(one: Stop) -> int:
    return min(one.begin + LATER, one.end)


def _over(speed: np.ndarray, one: Stop) -> int:
    """The tick after which the vehicle stands."""
    stands = (speed[one.begin : one.end] < STANDS).astype(int)
    lasting = np.convolve(stands, np.ones(FOR, int), "valid") == FOR
    later = np.flatnonzero(lasting[LATER // 2 :])
    return one.begin + LATER // 2 + int(later[0]) + FOR if len(later) else one.end


def _rests(flight: Flown, contract: Contract, stop: UavStop) -> tuple[Vec3, ...]:
    """What the nets predict in every tick [m]."""
    return uav_tube(
        contract, stop, flight.state, _sent(flight, contract, stop), Pace(0.0, 0.0), flight.age
    ).rests


def _sent(flight: Flown, contract: Contract, stop: UavStop) -> tuple[Sent, Sent, Sent]:
    """What had been sent before each tick, as a net remembers it."""
    share, count = filter_share(contract, stop), len(Sent.nothing(contract, 0.0).newest)
    told = np.nan_to_num(flight.commands)
    past = np.concatenate([np.zeros((count + 1, 3)), told])[:-1]
    before = np.zeros_like(told)
    for i in range(1, len(told)):
        before[i] = before[i - 1] + (past[i] - before[i - 1]) * share
    newest = [past[count - k : len(past) - k] for k in range(count)]
    x, y, z = (Sent(tuple(one[:, axis] for one in newest), before[:, axis]) for axis in range(3))
    return x, y, z


def _level(flights: Sequence[Flown], contract: Contract, zero: UavStop) -> Iterator[tuple[np.ndarray, ...]]:
    """(what each coefficient stands for, what the vehicle did), along x and along y."""
    names = ("speed", "tilt", "rate", "followed")
    for flight in flights:
        p, none = flight.state.position, _rests(flight, contract, zero)[-1]
        each = [_rests(flight, contract, replace(zero, **{name: 1.0}))[-1] for name in names]
        begins, ends = _samples(found(flight, (0, 1)))
        for axis in ("x", "y"):
            place, coming = getattr(p, axis), getattr(none, axis)[begins]
            parts = [getattr(one, axis)[begins] - coming for one in each]
            yield np.stack(parts, axis=1), place[ends] - place[begins] - coming


def _height(flights: Sequence[Flown], contract: Contract, zero: UavStop) -> Iterator[tuple[np.ndarray, ...]]:
    """The same, in height."""
    for flight in flights:
        z, none = flight.state.position.z, _rests(flight, contract, zero)[-1].z
        names = ("speed_up", "followed_up")
        each = [_rests(flight, contract, replace(zero, **{name: 1.0}))[-1].z - none for name in names]
        begins, ends = _samples(found(flight, (2,)))
        yield np.stack(each, axis=1)[begins], z[ends] - z[begins] - none[begins]


def _samples(stops: Sequence[Stop]) -> tuple[np.ndarray, np.ndarray]:
    """All ticks in which a stop may begin, and those in which it has settled."""
    begins = [i for one in stops for i in range(one.begin, _last(one))]
    ends = [min(i + SETTLED, one.end - 1) for one in stops for i in range(one.begin, _last(one))]
    return np.array(begins, int), np.array(ends, int)


def _solved(parts: Iterator[tuple[np.ndarray, ...]]) -> np.ndarray:
    """Least squares; a sample weighs as much as its way is long, since long ways miss by most."""
    known, asked = (np.concatenate(one) for one in zip(*parts, strict=True))
    weight = LEAST_WAY + np.abs(asked)
    return np.linalg.lstsq(known * weight[:, None], asked * weight, rcond=None)[0]


def _beside(p: Vec3, rests: tuple[Vec3, ...], i: int, end: int) -> float:
    """How far [m] a stop that begins in tick i leaves the hull of what was predicted."""
    angles = np.linspace(0.0, 2.0 * np.pi, ROUND, endpoint=False)
    x, y = np.cos(angles), np.sin(angles)
    hull = np.max([np.zeros(ROUND), *(rest.x[i] * x + rest.y[i] * y for rest in rests)], axis=0)
    dx, dy = p.x[i : end + 1] - p.x[i], p.y[i : end + 1] - p.y[i]
    return float((np.outer(dx, x) + np.outer(dy, y) - hull).max())


def _above(z: np.ndarray, rests: tuple[Vec3, ...], i: int, end: int) -> float:
    """The same in height, upwards or downwards."""
    ahead, moved = [0.0, *(rest.z[i] for rest in rests)], z[i : end + 1] - z[i]
    return float(max(moved.max() - max(ahead), min(ahead) - moved.min()))
