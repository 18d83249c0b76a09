"""How data look that something has spoilt: pure functions of what would have come in during a tick.

A spoil gets the inputs and the `Moment`, and gives the inputs as they come in instead. Those that spoil poses are made
by `poses` of what happens to one vehicle's `Sample`. `deaf` is the odd one: what vehicles do that hear no command.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import fields, is_dataclass, replace
from math import nan, pi
from typing import Any, NamedTuple

from fledge.dynamics import P3_DX
from fledge.geometry import Quat, Vec3
from fledge.safety.contract import UavStop, UgvStop
from fledge.scalars import Scalar, cos, sin, where
from fledge.supervision.inputs import HOVER, Inputs
from fledge.supervision.tracking import Motion, VehicleState
from fledge.world import Commands, UavState, UgvState, VelocityCommand, WorldState

CLEARLY = 0.3
"""[m/s] at which a vehicle moves clearly enough for a velocity of the wrong sign to contradict its positions."""
HOLD_OVERS = (UavStop().hold_over, UgvStop.of(P3_DX).hold_over)
"""[s] for which a UAV, and a UGV, goes on as it was told last when its link is lost."""


class Moment(NamedTuple):
    """One tick in which something is wrong."""

    since: Scalar
    """For how long it has been [s]."""
    struck: tuple[Scalar, ...]
    """Which vehicles it concerns; flags, the UAV's first."""
    luck: Scalar
    """Drawn once, in [0, 1)."""
    odds: Scalar
    """Drawn anew in every tick, in [0, 1)."""
    last: Inputs
    """What came in one tick before."""
    past: WorldState
    """What was seen some time before; how long, the fault says."""
    obeyed: Commands
    """What the vehicles obeyed one tick before."""


class Sample(NamedTuple):
    """One vehicle's pose in such a tick."""

    now: VehicleState
    last: VehicleState
    past: VehicleState
    moment: Moment

    def moved(self, by: Vec3) -> VehicleState:
        """The pose so far from where it is [m]."""
        return placed(self.now, Motion.of(self.now).position + by)

    def aside(self, far: Scalar) -> Vec3:
        """So far [m], one way for a whole flight."""
        angle = 2.0 * pi * self.moment.luck
        return Vec3(far * cos(angle), far * sin(angle), 0.0 * far)


Spoil = Callable[[Inputs, Moment], Inputs]


# Poses.


def poses(change: Callable[[Sample], VehicleState]) -> Spoil:
    """Changes the pose of every vehicle struck."""

    def spoil(inputs: Inputs, moment: Moment) -> Inputs:
        worlds = map(_states, (inputs.seen, moment.last.seen, moment.past))
        rows = zip(moment.struck, *worlds, strict=True)
        changed = (
            where(struck, change(Sample(now, last, past, moment)), now) for struck, now, last, past in rows
        )
        return _seeing(inputs, changed)

    return spoil


def dropped(share: float) -> Spoil:
    """The sample before stands in for one that does not come."""
    return poses(lambda sample: where(sample.moment.odds < share, sample.last, sample.now))


def one_field(bad: float) -> Spoil:
    """One number, any one, is another one."""

    def change(sample: Sample) -> VehicleState:
        numbers = list(_numbers(sample.now))
        nth = sample.moment.luck * len(numbers)
        chosen = (where((nth >= i) & (nth < i + 1), bad, x) for i, x in enumerate(numbers))
        return _rebuilt(sample.now, chosen)

    return poses(change)


def _numbers(record: Any) -> Iterator[Scalar]:
    for field in fields(record):
        value = getattr(record, field.name)
        yield from _numbers(value) if is_dataclass(value) else (value,)


def _rebuilt(record: Any, numbers: Iterator[Scalar]) -> Any:
    parts = (getattr(record, field.name) for field in fields(record))
    return type(record)(*(_rebuilt(part, numbers) if is_dataclass(part) else next(numbers) for part in parts))


def exchanged(inputs: Inputs, moment: Moment) -> Inputs:
    """The vehicles struck, a pair, are where the other one is."""
    states = _states(inputs.seen)
    places = [Motion.of(state).position for state in states]
    changed = []
    for i, state in enumerate(states):
        for j, place in enumerate(places):
            if j != i:
                state = where(moment.struck[i] & moment.struck[j], placed(state, place), state)
        changed.append(state)
    return _seeing(inputs, changed)


def backwards(sample: Sample) -> VehicleState:
    """The velocity has the wrong sign."""
    state = sample.now
    if isinstance(state, UgvState):
        return replace(state, speed=-state.speed)
    return replace(state, velocity=state.velocity * -1.0)


def clearly_moving(inputs: Inputs, moment: Moment) -> Scalar:
    """Whether a vehicle struck moves `CLEARLY`."""
    moving = False
    for struck, state in zip(moment.struck, _states(inputs.seen), strict=True):
        v = Motion.of(state).velocity
        moving = moving | (struck & (v.x * v.x + v.y * v.y + v.z * v.z > CLEARLY * CLEARLY))
    return moving


def mirrored(sample: Sample) -> VehicleState:
    """As the world looks with its y axis the other way round."""
    state = sample.now
    if isinstance(state, UgvState):
        return replace(state, y=-state.y, heading=-state.heading, turn_rate=-state.turn_rate)
    p, v, q, w = state.position, state.velocity, state.attitude, state.rates
    turned = Quat(q.w, -q.x, q.y, -q.z)
    return UavState(Vec3(p.x, -p.y, p.z), Vec3(v.x, -v.y, v.z), turned, Vec3(-w.x, w.y, -w.z), state.stamp)


def placed(state: VehicleState, place: Vec3) -> VehicleState:
    """The same vehicle elsewhere."""
    if isinstance(state, UgvState):
        return replace(state, x=place.x, y=place.y)
    return replace(state, position=place)


def _states(world: WorldState) -> tuple[VehicleState, ...]:
    return (world.uav, *world.ugvs)


def _seeing(inputs: Inputs, states: Iterable[Any]) -> Inputs:
    uav, *ugvs = states
    return replace(inputs, seen=WorldState(inputs.seen.t, uav, tuple(ugvs)))


# All else that comes in.


def clock(by: float) -> Spoil:
    """The clock is wrong by so much [s]."""
    return lambda inputs, moment: replace(inputs, seen=replace(inputs.seen, t=inputs.seen.t + by))


def stopped_clock(inputs: Inputs, moment: Moment) -> Inputs:
    """The clock stands still."""
    return replace(inputs, seen=replace(inputs.seen, t=moment.last.seen.t))


def silent(inputs: Inputs, moment: Moment) -> Inputs:
    """The operator's link is lost: all there is of people is what they said last."""
    return replace(inputs, heard=moment.last.heard, operators=moment.last.operators)


def undecided(inputs: Inputs, moment: Moment) -> Inputs:
    """The policy decides nothing new."""
    return replace(inputs, decided=moment.last.decided, proposed=moment.last.proposed)


def proposing(x: float) -> Spoil:
    """The policy proposes this number, on every axis of every vehicle struck."""
    garbage = VelocityCommand(x, x, x, x)

    def spoil(inputs: Inputs, moment: Moment) -> Inputs:
        told = zip(moment.struck, _told(inputs.proposed), strict=True)
        uav, *ugvs = (where(struck, garbage, command) for struck, command in told)
        return replace(inputs, proposed=Commands(uav, tuple(ugvs)))

    return spoil


def broken_stick(inputs: Inputs, moment: Moment) -> Inputs:
    """What a stick asks for is no number."""
    people = zip(moment.struck, inputs.operators, strict=True)
    broken = tuple(
        where(struck, replace(person, command=replace(person.command, left=nan)), person)
        for struck, person in people
    )
    return replace(inputs, operators=broken)


def battery(share: float) -> Spoil:
    """So much is left of it, it says."""

    def spoil(inputs: Inputs, moment: Moment) -> Inputs:
        batteries = zip(moment.struck, inputs.batteries, strict=True)
        return replace(inputs, batteries=tuple(where(struck, share, full) for struck, full in batteries))

    return spoil


def deaf(told: Commands, moment: Moment) -> Commands:
    """A vehicle struck goes on as it was told last, until its own watchdog ends that."""
    rows = zip(moment.struck, _told(moment.obeyed), _told(told), strict=True)
    uav, *ugvs = (
        where(struck, where(moment.since < HOLD_OVERS[i > 0], last, HOVER), new)
        for i, (struck, last, new) in enumerate(rows)
    )
    return Commands(uav, tuple(ugvs))


def _told(commands: Commands) -> tuple[VelocityCommand, ...]:
    return (commands.uav, *commands.ugvs)
