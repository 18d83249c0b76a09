"""One attack on a net and the retreat after it, flown by the thousand in one compiled program.

Every vehicle is attacked at once; at the end one of them, in turn, is led away by a retreat pilot while the others
stand, which shows whether the net keeps it prisoner. The net sees the world late and with errors, and its commands act
late (`trouble`). Beside the flight runs its shadow, cloned from it when the net steps in and flown on without it: if
nothing is touched there within `HORIZON`, the alarm was false.

Touching is judged by `clearance`, which the nets do not use.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from fledge.clearance import Nearest
from fledge.engines import apart, compiled, scan
from fledge.falsification.attacks import Chance
from fledge.falsification.melee import Bodies, Scene, begin, draw_chance, drive, move, obeyed
from fledge.falsification.retreat import lead, place, way_out
from fledge.falsification.scenarios import MOST_OBSTACLES, Scenario, Terms
from fledge.falsification.trouble import Line, Link, measured
from fledge.geometry import Vec3
from fledge.pilots import AbstractPilot
from fledge.pytrees import register, stack
from fledge.safety import AbstractNet, UavStop, UgvStop
from fledge.scalars import Scalar, maximum, minimum, where
from fledge.simulation import TICK
from fledge.world import Commands, VelocityCommand, Verdict, WorldState

HORIZON = 200
"""Ticks for which a flight without the net is followed [10 ms]."""
BREACH = 0.5
"""[m] the paper's margin about a vehicle's centre; coming nearer is a breach."""
LEFT = 0.5
"""[m] a vehicle that moved so far in its retreat was no prisoner."""
PATIENCE, STUCK = 250, 0.1
"""A way that in so many ticks [10 ms] has not led so far [m] is given up for another; a UGV has to turn first."""


@dataclass(frozen=True, slots=True)
class Trial:
    """What a program is compiled for: the net on trial, and on which terms."""

    net: AbstractNet
    terms: Terms = Terms()
    record: bool = False
    """Whether to keep every tick, which takes twice as long."""


class Tally(NamedTuple):
    """What happened in a flight."""

    least: tuple[Scalar, ...]
    """Smallest gap of every vehicle [m]."""
    first: Scalar
    """Tick of the first contact; -1 if there was none."""
    breached: Scalar
    """1 if a centre came nearer than `BREACH`."""
    interventions: Scalar
    """Vehicle ticks in which the net changed a command."""
    alarms: Scalar
    """Those that were followed without the net."""
    false_alarms: Scalar
    """Those in which nothing was touched."""


class Track(NamedTuple):
    """A flight tick by tick, leaves of shape (ticks,)."""

    world: WorldState
    told: Commands
    verdicts: tuple[Verdict, ...]


class Outcome(NamedTuple):
    """Of a whole flight."""

    tally: Tally
    way: Scalar
    """1 if at the end of the attack there was a way out for the vehicle in focus."""
    deadlock: Scalar
    """1 if there was, and yet it could not be led away."""
    track: Track | tuple[()]
    """Empty if it was not recorded."""


class Shadow(NamedTuple):
    """The flight without the net."""

    bodies: Bodies
    left: Scalar
    """Ticks for which it is still followed; 0 if it is not."""
    hit: Scalar
    """1 if something was touched."""


class Flying(NamedTuple):
    """All that changes during a flight."""

    bodies: Bodies
    seen: Line
    """Worlds, on their way to the net."""
    sent: Line
    """Commands, on their way to the vehicles."""
    links: tuple[Link, ...]
    net: Any
    shadow: Shadow
    tally: Tally


def fly_sorties(
    trial: Trial,
    scenarios: Sequence[Scenario],
    keys: Sequence[Sequence[int]],
    pilot: AbstractPilot | None = None,
) -> Outcome:
    """Fly scenarios in one compiled program; NumPy leaves of shape (flights, ...).

    Args:
        trial: the net, and the terms on which the scenarios were drawn.
        scenarios: one per flight.
        keys: the attackers' chance in each flight.
        pilot: flies the UAV, if the attackers do not.
    """
    most = max(MOST_OBSTACLES, *(len(scenario.arena.obstacles) for scenario in scenarios))
    padded = [scenario._replace(arena=scenario.arena.padded(most)) for scenario in scenarios]
    seeds = np.array([np.random.SeedSequence(list(key)).generate_state(2) for key in keys], dtype=np.uint32)
    register(pilot)
    return jax.tree.map(np.asarray, _program(trial)(pilot, stack(padded), seeds))


def traceable(net: AbstractNet, scenario: Scenario) -> bool:
    """Whether JAX can compile a net."""
    hover = VelocityCommand.hover()
    told = Commands(hover, (hover,) * len(scenario.world.ugvs))
    register((scenario, told))

    def judge(arena: Any, world: WorldState, told: Commands) -> Any:
        memory = net.init(arena, world)
        register(memory)
        return net.filter(memory, world, told)

    try:
        jax.eval_shape(judge, scenario.arena, scenario.world, told)
    except (TypeError, ValueError):  # JAX's own errors are TypeErrors
        return False
    return True


@cache
def _program(trial: Trial) -> Callable[..., Outcome]:
    return compiled(jax.vmap(partial(fly_sortie, trial), in_axes=(None, 0, 0)))


def fly_sortie(trial: Trial, pilot: AbstractPilot | None, scenario: Scenario, seed: Any) -> Outcome:
    """One attack and one retreat."""
    scene = Scene.of(trial.terms, scenario, pilot)
    flying, attacked = _attack(trial, scene, _begin(trial, scene), seed)
    flying, gone, way, led = _retreat(trial, scene, flying)
    track = jax.tree.map(lambda *parts: jnp.concatenate(parts), attacked, led)
    return Outcome(flying.tally, where(way, 1.0, 0.0), where(way & ~gone, 1.0, 0.0), track)


def _begin(trial: Trial, scene: Scene) -> Flying:
    bodies, contract = begin(scene), trial.terms.contract
    zero = 0.0 * bodies.world.t
    hover = VelocityCommand(zero, zero, zero, zero)
    still = Commands(hover, (hover,) * len(bodies.world.ugvs))
    longest = 1 + round(trial.terms.late(max(contract.age, contract.latency)))
    flying = Flying(
        bodies,
        Line.full_of(bodies.world, longest),
        Line.full_of(still, longest),
        (Link(zero, hover),) * trial.terms.vehicles,
        trial.net.init(scene.scenario.arena, bodies.world),
        Shadow(bodies, zero, zero),
        Tally((zero + 100.0,) * trial.terms.vehicles, zero - 1.0, zero, zero, zero, zero),
    )
    register(flying)
    return flying


def _attack(trial: Trial, scene: Scene, flying: Flying, seed: Any) -> tuple[Flying, Any]:
    """(the flight after it, its track)."""

    def step(flying: Flying, inputs: tuple[Any, Any]) -> tuple[Flying, Any]:
        tick, key = inputs
        chance = draw_chance(key, trial.terms.vehicles)
        before = flying.bodies
        mind, told = drive(scene, before, chance, tick)
        flying = flying._replace(bodies=before._replace(mind=mind))
        flying, row, alarm = _tick(trial, scene, flying, told, tick)
        begins = alarm & (flying.shadow.left <= 0.0)
        shadow = where(begins, Shadow(before, 0.0 * tick + HORIZON, 0.0 * tick), flying.shadow)
        return _follow(scene, flying._replace(shadow=shadow), chance, tick), row

    ticks = trial.terms.attack_ticks
    keys = jax.random.split(jax.random.wrap_key_data(seed), ticks)
    return scan(step, flying, (jnp.arange(ticks, dtype=float), keys))


def _tick(
    trial: Trial, scene: Scene, flying: Flying, told: Commands, tick: Scalar
) -> tuple[Flying, Any, Scalar]:
    """One tick with the net: (the flight, its row of the track, whether the net stepped in)."""
    trouble, before = scene.scenario.trouble, flying.bodies
    seen = flying.seen.then(before.world)
    late = apart(
        lambda seen, near, t: measured(trial.terms.contract, trouble, seen.late(trouble.age), near, t),
        *(seen, before.near, tick * TICK),
    )
    net, verdicts = apart(trial.net.filter, flying.net, late, told)
    commands = Commands(verdicts[0].command, tuple(verdict.command for verdict in verdicts[1:]))
    sent = flying.sent.then(obeyed(scene.rig, commands))
    links, done = _heard(scene, flying.links, sent.late(trouble.latency), verdicts)
    bodies = move(scene, before, done, tick)
    stepped_in = sum(verdict.intervened for verdict in verdicts)
    tally = _counted(scene, flying.tally, bodies.near, stepped_in, tick)
    row = Track(before.world, told, verdicts) if trial.record else ()
    return Flying(bodies, seen, sent, links, net, flying.shadow, tally), row, stepped_in > 0.0


def _heard(
    scene: Scene, links: tuple[Link, ...], told: Commands, verdicts: tuple[Verdict, ...]
) -> tuple[tuple[Link, ...], Commands]:
    """(links, what the vehicles do); a link is lost at the first intervention, whose command never arrives."""
    stops = (UavStop(), *map(UgvStop.of, scene.rig.formation.fleet))
    vehicles = zip(links, (told.uav, *told.ugvs), verdicts, stops, strict=True)
    after = [
        link.then((scene.scenario.trouble.cut > 0.0) & (verdict.intervened > 0.0), command, stop, TICK)
        for link, command, verdict, stop in vehicles
    ]
    uav, *ugvs = (command for _, command in after)
    return tuple(link for link, _ in after), Commands(uav, tuple(ugvs))


def _counted(
    scene: Scene, tally: Tally, near: tuple[Nearest, ...], stepped_in: Scalar, tick: Scalar
) -> Tally:
    gap, breached = near[0].gap, tally.breached
    radii = (scene.rig.uav.radius, *(model.radius for model in scene.rig.formation.fleet))
    for nearest, radius in zip(near, radii, strict=True):
        gap = minimum(gap, nearest.gap)
        breached = where(nearest.gap + radius < BREACH, 1.0, breached)
    return tally._replace(
        least=tuple(minimum(a, b.gap) for a, b in zip(tally.least, near, strict=True)),
        first=where((tally.first < 0.0) & (gap <= 0.0), tick, tally.first),
        breached=breached,
        interventions=tally.interventions + stepped_in,
    )


def _follow(scene: Scene, flying: Flying, chance: tuple[Chance, ...], tick: Scalar) -> Flying:
    """The shadow one tick later, and what it tells of the alarm."""
    shadow = flying.shadow
    mind, told = drive(scene, shadow.bodies, chance, tick)
    bodies = move(scene, shadow.bodies._replace(mind=mind), obeyed(scene.rig, told), tick)
    hit = shadow.hit
    for nearest in bodies.near:
        hit = where(nearest.gap <= 0.0, 1.0, hit)
    over, tally = shadow.left == 1.0, flying.tally
    tally = tally._replace(
        alarms=tally.alarms + where(over, 1.0, 0.0),
        false_alarms=tally.false_alarms + where(over & (hit <= 0.0), 1.0, 0.0),
    )
    return flying._replace(shadow=Shadow(bodies, maximum(shadow.left - 1.0, 0.0), hit), tally=tally)


def _retreat(trial: Trial, scene: Scene, flying: Flying) -> tuple[Flying, Any, Any, Any]:
    """(the flight after it, whether the vehicle in focus got away, whether there was a way, the track)."""
    terms, focus = trial.terms, scene.scenario.focus
    look = partial(way_out, scene.rig, scene.scenario.arena)
    start = place(flying.bodies.world, focus)
    way, exists = look(flying.bodies.world, focus, start * 0.0)

    def step(carry: tuple[Flying, Vec3, Vec3, Any], tick: Any) -> tuple[Any, Any]:
        flying, way, since, gone = carry
        world = flying.bodies.world
        here, due = place(world, focus), (tick > 0.0) & (tick % PATIENCE == 0.0)
        stuck = due & ~_apart(here, since, STUCK)
        way = jax.lax.cond(stuck, lambda: look(world, focus, way)[0], lambda: way)
        told = lead(scene.rig, world, focus, way)
        flying, row, _ = _tick(trial, scene, flying, told, tick + terms.attack_ticks)
        gone = gone | _apart(place(flying.bodies.world, focus), start, LEFT)
        return (flying, way, where(due, here, since), gone), row

    ticks = jnp.arange(terms.retreat_ticks, dtype=float)
    (flying, _, _, gone), led = scan(step, (flying, way, start, False), ticks)
    return flying, gone, exists, led


def _apart(a: Vec3, b: Vec3, far: float) -> Any:
    """Whether two places are farther apart than that [m]."""
    by = a - b
    return by.x * by.x + by.y * by.y + by.z * by.z > far**2
