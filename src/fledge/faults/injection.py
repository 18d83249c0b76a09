"""Faults injected behind the supervisor's back, flown by the thousand in one compiled program.

The UAV is flown by the visual servo and the UGVs keep their formation, or all of them are pushed at a wall. Who flies
knows the truth, so a fault of the data spoils the data and nothing else. Poses are late and wrong, commands late, and
vehicles pushed as far as the contract allows (`trouble`); then the drill's fault begins. Touching is judged by
`clearance`, which the nets do not use.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, partial
from math import inf, pi
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from fledge.clearance import Nearest, clearances
from fledge.dynamics import UavMemory
from fledge.engines import COMPILED, apart, compiled, scan
from fledge.falsification.attacks import drive
from fledge.falsification.scenarios import Terms
from fledge.falsification.trouble import Line, measured, push, weakened
from fledge.faults.catalogue import FAULTS, Fault, Moment
from fledge.faults.drills import Drill, Report
from fledge.geometry import Vec3
from fledge.manoeuvres import FormationTrack
from fledge.observation import observe
from fledge.pilots import Servo
from fledge.pytrees import register, stack
from fledge.scalars import Scalar, cos, maximum, minimum, sin, sqrt, where
from fledge.simulation import TICK, TICKS_PER_ROW, Rig, fly_tick
from fledge.supervision.inputs import Inputs
from fledge.supervision.posts import Decision
from fledge.supervision.supervisor import IDLE, Supervisor
from fledge.world import Commands, Reason, VelocityCommand, WorldState

GROUND = 0.02
"""[m] under the hull at which a UAV has landed."""
BY_HAND = 0.5
"""[s] after which a person takes over, where one flies."""


class Flying(NamedTuple):
    """All that changes during a flight."""

    world: WorldState
    near: tuple[Nearest, ...]
    uav: UavMemory
    stick: Commands
    """What servo and guidance last asked for."""
    poses: Line
    sent: Line
    past: WorldState
    """What was seen lately, leaves of shape (ticks,), each tick at its number modulo their count."""
    last: Inputs
    obeyed: Commands
    memory: Any
    report: Report


class Scene(NamedTuple):
    """What surrounds one flight."""

    supervisor: Supervisor
    terms: Terms
    rig: Rig
    """As the disturbance leaves it."""
    drill: Drill

    def of(self, values: Sequence[float]) -> Scalar:
        """The flight's own one of numbers, one per fault."""
        return jnp.array(values)[self.drill.fault.astype(int)]

    @property
    def struck(self) -> tuple[Scalar, ...]:
        """Whom the fault concerns."""
        return tuple(flag > 0.5 for flag in self.drill.struck)


def fly_drills(
    drills: Sequence[Drill], keys: Sequence[Sequence[int]], supervisor: Supervisor = Supervisor()
) -> Report:
    """Fly drills, with the chance of their keys, in one compiled program; NumPy leaves of shape (drills,)."""
    seeds = np.array([np.random.SeedSequence(list(key)).generate_state(2) for key in keys], dtype=np.uint32)
    return jax.tree.map(np.asarray, _program(supervisor, Terms())(stack(drills), seeds))


@cache
def _program(supervisor: Supervisor, terms: Terms) -> Callable[[Drill, Any], Report]:
    return compiled(jax.vmap(partial(fly_drill, supervisor, terms)))


# One flight, in JAX.


def fly_drill(supervisor: Supervisor, terms: Terms, drill: Drill, seed: Any) -> Report:
    """One flight with one fault."""
    formation = terms.rig.formation
    formation = replace(formation, fleet=weakened(formation.fleet, terms.contract, drill.trouble))
    scene = Scene(supervisor, terms, replace(terms.rig, formation=formation), drill)

    def row(flying: Flying, inputs: tuple[Any, ...]) -> tuple[Flying, tuple[()]]:
        number, target, key = inputs
        flying = flying._replace(stick=_decided(scene, flying.world, target))
        ticks = number * TICKS_PER_ROW + jnp.arange(TICKS_PER_ROW)
        return scan(partial(_tick, scene), flying, (ticks, jax.random.uniform(key, ticks.shape)))

    rows = len(drill.track.x)
    keys = jax.random.split(jax.random.wrap_key_data(seed), rows)
    flying, _ = scan(row, _begin(scene), (jnp.arange(rows), drill.track, keys))
    return flying.report


def _begin(scene: Scene) -> Flying:
    (supervisor, terms, rig, drill), world = scene, scene.drill.world
    zero, vehicles = 0.0 * world.t, terms.vehicles
    hover = VelocityCommand(zero, zero, zero, zero)
    still = Commands(hover, (hover,) * len(world.ugvs))
    register((world, Inputs.unattended(world, still)))
    near = clearances(drill.arena, world, rig.uav, rig.formation.fleet)
    longest = 1 + round(terms.late(max(terms.contract.age, terms.contract.latency)))
    seen = measured(terms.contract, drill.trouble, world, near, zero)
    past = jax.tree.map(lambda leaf: jnp.full(1 + max(map(_ticks, FAULTS)), leaf), seen)
    inputs = _attended(scene, seen, still, world, zero)
    moment = Moment(zero, scene.struck, drill.luck, zero, inputs, seen, still)
    spoilt = _changed(scene, inputs, lambda fault: fault.spoil(inputs, moment))
    inputs = where(drill.begins <= 0.0, spoilt, inputs)
    never = (zero + inf,) * vehicles
    flying = Flying(
        world,
        near,
        rig.uav.init(world.uav),
        still,
        Line.full_of(world, longest),
        Line.full_of(still, longest),
        past,
        inputs,
        still,
        supervisor.init(drill.arena, inputs.seen),
        Report(never, (zero,) * vehicles, (zero,) * vehicles, never, zero, zero),
    )
    register(flying)
    return flying


def _decided(scene: Scene, world: WorldState, target: FormationTrack) -> Commands:
    """What servo and guidance want, or whoever pushes at the wall."""
    rig, drill, zero = scene.rig, scene.drill, 0.0 * world.t
    _, action = Servo().act((), observe(world, rig.lens, rig.ideal_radius), (zero, zero, zero, zero))
    told = rig.formation.commands(world.ugvs, target, drill.orientation, drill.arena)
    forward, left = world.uav.attitude.heading().from_world(zero + rig.sticks.horizontal, zero)
    models = zip(rig.formation.fleet, world.ugvs, strict=True)
    pushed = tuple(drive(model, ugv, Vec3(1.0, 0.0, 0.0)) for model, ugv in models)
    pushing = Commands(VelocityCommand(forward, left, zero, zero), pushed)
    return where(drill.pushing > 0.5, pushing, Commands(rig.sticks.command(action), told))


def _tick(scene: Scene, flying: Flying, inputs: tuple[Any, Any]) -> tuple[Flying, tuple[()]]:
    """10 ms."""
    (number, odds), drill, trouble, now = inputs, scene.drill, scene.drill.trouble, flying.world
    t = number * TICK
    active = (t >= drill.begins) & (t < drill.ends)
    poses = flying.poses.then(now)
    seen = measured(scene.terms.contract, trouble, poses.late(trouble.age), flying.near, t)
    past, before = _remembered(scene, flying.past, seen, number)
    decided = (number // TICKS_PER_ROW) * (TICK * TICKS_PER_ROW)
    given = _attended(scene, seen, flying.stick, now, decided)
    moment = Moment(t - drill.begins, scene.struck, drill.luck, odds, flying.last, before, flying.obeyed)
    spoilt = where(active, _changed(scene, given, lambda fault: fault.spoil(given, moment)), given)
    shows = active & _changed(scene, False, lambda fault: fault.shows(given, moment))
    memory, decisions = apart(scene.supervisor.step, flying.memory, spoilt)
    uav, *ugvs = (decision.verdict.command for decision in decisions)
    sent = flying.sent.then(Commands(uav, tuple(ugvs)))
    told = sent.late(trouble.latency)
    obeyed = where(active, _changed(scene, told, lambda fault: fault.obey(told, moment)), told)
    world, uav_memory = _moved(scene, flying, obeyed, decisions[0].mode, active, t)
    rig = scene.rig
    near = apart(lambda a, w: clearances(a, w, rig.uav, rig.formation.fleet), drill.arena, world)
    report = _noted(scene, flying.report, decisions, near, world, moment.since, shows)
    return (
        Flying(world, near, uav_memory, flying.stick, poses, sent, past, spoilt, obeyed, memory, report),
        (),
    )


def _changed(scene: Scene, before: Any, change: Callable[[Fault], Any]) -> Any:
    """`before`, as the flight's own fault changes it."""
    after = before
    for i, fault in enumerate(FAULTS):
        here = scene.drill.fault == float(i)
        # Most faults leave most of it alone; what they leave is the same object.
        after = jax.tree.map(
            lambda new, old, now: now if new is old else where(here, new, now),  # noqa: B023
            *(change(fault), before, after),
        )
    return after


def _ticks(fault: Fault) -> int:
    return round(fault.delay / TICK)


def _remembered(
    scene: Scene, past: WorldState, seen: WorldState, number: Scalar
) -> tuple[WorldState, WorldState]:
    """(what was seen lately, what was seen `Fault.delay` ago)."""
    depth = len(past.t)
    past = jax.tree.map(lambda line, leaf: line.at[number % depth].set(leaf), past, seen)
    # At first that reaches back to before the beginning, of which the line is full.
    before = (number - scene.of(list(map(_ticks, FAULTS)))) % depth
    return past, jax.tree.map(lambda line: line[before], past)


def _attended(scene: Scene, seen: WorldState, told: Commands, world: WorldState, decided: Scalar) -> Inputs:
    """What comes in where nothing is wrong: somebody arms, and flies the UAV by hand where the fault says so."""
    inputs = Inputs.unattended(seen, told)
    person, *others = inputs.operators
    hand = scene.of([float(fault.by_hand) for fault in FAULTS])
    person = replace(person, switch=where(seen.t >= BY_HAND, hand, 0.0), command=told.uav)
    belly = world.uav.position.z - scene.rig.uav.half_height
    airborne = where(belly > GROUND, 1.0, 0.0)
    return replace(inputs, decided=decided, operators=(person, *others), airborne=airborne)


def _moved(
    scene: Scene, flying: Flying, told: Commands, mode: Scalar, active: Scalar, t: Scalar
) -> tuple[WorldState, UavMemory]:
    """The vehicles one tick later, pushed; a UAV whose motors are off stays where it is."""
    rig, drill, contract = scene.rig, scene.drill, scene.terms.contract
    gust, angle = scene.of([fault.push for fault in FAULTS]), 2.0 * pi * drill.luck
    gust = where(active, gust, 0.0)
    force = push(contract, drill.trouble, flying.near[0]) + Vec3(gust * cos(angle), gust * sin(angle), 0.0)
    tilt = where(active, scene.of([fault.tilt for fault in FAULTS]), 1.0)
    uav = replace(rig.uav, tilt=replace(rig.uav.tilt, limit=rig.uav.tilt.limit * tilt))
    rig = replace(rig, uav=uav)
    memory, world = apart(
        lambda memory, world, told, wind, t: fly_tick(rig, memory, world, told, wind, t, COMPILED),
        # Wind pushes through drag alone: this wind pushes with the force.
        *(flying.uav, flying.world, told, force * (1.0 / rig.uav.drag), t + TICK),
    )
    off = False
    for idle in IDLE:
        off = off | (mode == float(idle))
    still = Vec3(0.0 * t, 0.0 * t, 0.0 * t)
    rested = replace(flying.world.uav, velocity=still, rates=still, stamp=t + TICK)
    return replace(world, uav=where(off, rested, world.uav)), where(off, uav.init(rested), memory)


def _noted(
    scene: Scene,
    report: Report,
    decisions: tuple[Decision, ...],
    near: tuple[Nearest, ...],
    world: WorldState,
    since: Scalar,
    shows: Scalar,
) -> Report:
    """The report after one more tick."""
    named = tuple(
        where(_names(scene, decision) & (since >= 0.0), minimum(before, since), before)
        for before, decision in zip(report.named, decisions, strict=True)
    )
    slowest = 0.0 * since
    for struck, when in zip(scene.struck, named, strict=True):
        slowest = maximum(slowest, where(struck, when, 0.0))
    showing = where(shows & (slowest == inf), report.showing + TICK, 0.0)
    within = scene.of([fault.within if fault.reasons else inf for fault in FAULTS])
    v = world.uav.velocity
    return Report(
        tuple(minimum(gap, nearest.gap) for gap, nearest in zip(report.gaps, near, strict=True)),
        tuple(decision.mode for decision in decisions),
        (sqrt(v.x * v.x + v.y * v.y + v.z * v.z), *(abs(ugv.speed) for ugv in world.ugvs)),
        named,
        showing,
        where(showing > within, 1.0, report.overdue),
    )


def _names(scene: Scene, decision: Decision) -> Scalar:
    """Whether what is said of a vehicle is one of the fault's names."""
    said = False
    for k in range(max(len(fault.reasons) for fault in FAULTS)):
        # What no fault is called is never said.
        name = scene.of([float((*fault.reasons, *(Reason.NONE,) * 9)[k]) or -1.0 for fault in FAULTS])
        said = said | (decision.alarm.reason == name) | (decision.verdict.reason == name)
    return said
