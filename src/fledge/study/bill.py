"""What a net did to one flight, and what would have become of the flight without it.

Counted row by row at 20 Hz:

* *Interventions*: rows in which a vehicle was sent something else than proposed, in any of the five ticks.
* *Needless ones*: beside the flight runs its shadow, cloned from it when the net steps in and flown on without any
  net, closed loop and with the same chance. If nothing touches anything within `HORIZON`, all interventions since were
  needless. So are those that the end of a flight leaves undecided.
* *Holds*: in the paper a vehicle that its net has stopped waits for a person to lead it away. A vehicle waits for one
  that is sent something else for `HELD` on end, and does not budge.

Touching is judged by `clearance`, which the nets do not use, where a row begins.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial, reduce
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from fledge.clearance import clearances, from_things
from fledge.conditions import RowNoise
from fledge.episode import Episode
from fledge.manoeuvres import FormationTrack
from fledge.pytrees import pytree, register
from fledge.safety import NoNet
from fledge.scalars import Scalar, maximum, minimum, where
from fledge.simulation import Case, Crew, Engine, FlightState, Rig, fly_row, start
from fledge.study.evaluation import Score, score
from fledge.world import Arena, Verdict, WorldState

HORIZON = 60
"""Rows for which a flight is followed without its net: 3 s, by then every vehicle could have stopped twice."""
HELD = 100
"""Rows after which a vehicle that does not get on waits for a person: 5 s."""
BUDGE = 0.25
"""[m] a vehicle that moved so far meanwhile is not held; chosen, half of a Pioneer."""

Scene = tuple[Case, Crew, Rig]


class Shadow(NamedTuple):
    """The flight as it goes on without the net."""

    state: FlightState
    left: Scalar
    """Rows for which it is still followed; 0 if it is not."""
    judged: tuple[Scalar, ...]
    """Interventions it is to judge: those on each vehicle, and on any."""
    hit: Scalar
    """1 if something was touched."""


class Row(NamedTuple):
    """What is seen of a flight in a row."""

    episode: Episode
    gaps: tuple[Scalar, ...]
    """From every hull to whatever is nearest [m]."""
    things: tuple[Scalar, ...]
    """From every hull to the nearest wall or obstacle [m]."""
    needless: tuple[Scalar, ...]
    """Interventions found needless: those on each vehicle, and on any."""


@pytree
@dataclass(frozen=True, slots=True)
class Bill:
    """Of many flights; the first axis of every array is theirs, the second one's vehicles: the UAV, then the UGVs."""

    score: Score
    interventions: Any
    """Rows with one; in a last column, with one on any vehicle."""
    needless: Any
    """Those without which nothing would have been touched, likewise."""
    gap: Any
    """Smallest from hull to whatever was nearest [m]; at most 0 where they touched."""
    thing: Any
    """Smallest from hull to a wall or an obstacle [m]."""
    held: Any
    """How often a vehicle waited for a person."""


def watched(
    scene: Scene, chance: Any, noise_of: Callable[[Any], RowNoise], engine: Engine
) -> tuple[Row, tuple[Scalar, ...]]:
    """(all rows of a flight, the interventions its end leaves undecided): a `Rollout` for `simulation.fly`."""
    case, crew, rig = scene
    bare = (case, replace(crew, net=NoNet()), rig)

    def step(carry: tuple[FlightState, Shadow], inputs: tuple[FormationTrack, Any]) -> tuple[Any, Row]:
        (flight, shadow), (target, drawn) = carry, inputs
        noise = noise_of(drawn)
        after, row = fly_row(flight, target, noise, scene, engine)
        shadow = _alarmed(shadow, flight, row.verdicts)
        followed, _ = fly_row(shadow.state, target, noise, bare, engine)
        gaps, _ = _around(rig, case.plan.arena, followed.world, engine)
        shadow, needless = _judged(shadow._replace(state=followed), gaps)
        seen = Row(row, *_around(rig, case.plan.arena, flight.world, engine), needless)
        return (after, shadow), seen

    begin = start(case, crew, rig)
    zero = 0.0 * begin.row
    shadow = Shadow(replace(begin, net=()), zero, (zero,) * (2 + len(begin.world.ugvs)), zero)
    register(shadow)
    (_, shadow), rows = engine.scan(step, (begin, shadow), (case.plan.track, chance))
    return rows, tuple(where(shadow.hit > 0.0, zero, count) for count in shadow.judged)


def _around(
    rig: Rig, arena: Arena, world: WorldState, engine: Engine
) -> tuple[tuple[Scalar, ...], tuple[Scalar, ...]]:
    """(gaps to whatever is nearest, to the nearest wall or obstacle) of every vehicle [m]."""

    def gaps(look: Callable[..., Any], arena: Arena, world: WorldState) -> tuple[Scalar, ...]:
        return tuple(near.gap for near in look(arena, world, rig.uav, rig.formation.fleet))

    everything, things = (
        engine.apart(partial(gaps, look), arena, world) for look in (clearances, from_things)
    )
    return everything, things


def _alarmed(shadow: Shadow, flight: FlightState, verdicts: tuple[Verdict, ...]) -> Shadow:
    """The shadow, cloned anew from the flight if the net steps in and it judges nothing yet."""
    alarms = tuple(verdict.intervened for verdict in verdicts)
    alarms = (*alarms, reduce(maximum, alarms))
    zero = 0.0 * shadow.left
    fresh = Shadow(replace(flight, net=()), zero + HORIZON, (zero,) * len(alarms), zero)
    shadow = where((alarms[-1] > 0.0) & (shadow.left <= 0.0), fresh, shadow)
    return shadow._replace(judged=tuple(a + b for a, b in zip(shadow.judged, alarms, strict=True)))


def _judged(shadow: Shadow, gaps: tuple[Scalar, ...]) -> tuple[Shadow, tuple[Scalar, ...]]:
    """(the shadow one row later, what it has found needless)."""
    zero = 0.0 * shadow.left
    hit = where(reduce(minimum, gaps) <= 0.0, 1.0 + zero, shadow.hit)
    over = shadow.left == 1.0
    needless = tuple(where(over & (hit <= 0.0), count, zero) for count in shadow.judged)
    judged = tuple(where(over, zero, count) for count in shadow.judged)
    return Shadow(shadow.state, maximum(shadow.left - 1.0, zero), judged, hit), needless


@cache
def billed(rig: Rig) -> Callable[[tuple[Row, tuple[Any, ...]]], Bill]:
    """What makes the bill of watched flights, leaves (flights, rows)."""

    def bill(flown: tuple[Row, tuple[Any, ...]]) -> Bill:
        rows, undecided = flown
        intervened = [verdict.intervened for verdict in rows.episode.verdicts]
        world = rows.episode.world
        places = [(world.uav.position.x, world.uav.position.y, world.uav.position.z)]
        places += [(ugv.x, ugv.y, 0.0 * ugv.x) for ugv in world.ugvs]
        return Bill(
            score=score(rows.episode, rig),
            interventions=_columns(
                one.sum(axis=-1) for one in (*intervened, reduce(jnp.maximum, intervened))
            ),
            needless=_columns(a.sum(axis=-1) + b for a, b in zip(rows.needless, undecided, strict=True)),
            gap=_columns(gap.min(axis=-1) for gap in rows.gaps),
            thing=_columns(gap.min(axis=-1) for gap in rows.things),
            held=_columns(holds(*both) for both in zip(intervened, places, strict=True)),
        )

    return jax.jit(bill)


def _columns(arrays: Any) -> Any:
    return jnp.stack([jnp.asarray(one) for one in arrays], axis=-1)


def holds(intervened: Any, place: tuple[Any, Any, Any]) -> Any:
    """How often a vehicle was held, from where it was intervened on and where it was; rows along the last axis."""
    since = jnp.cumsum(intervened > 0.0, axis=-1)
    moved = sum((axis[..., HELD:] - axis[..., :-HELD]) ** 2 for axis in map(jnp.asarray, place))
    held = (since[..., HELD:] - since[..., :-HELD] == HELD) & (moved < BUDGE**2)
    return (jnp.diff(held.astype(int), axis=-1, prepend=0) == 1).sum(axis=-1)
