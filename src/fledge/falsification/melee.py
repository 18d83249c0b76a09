"""The vehicles under attack, no net between: who drives each of them, and where they are a tick later.

Attackers drive all of them, knowing the truth; the UAV may be flown by a pilot instead, who decides at 20 Hz on what it
truly looks like. Vehicles are pushed as the scenario's trouble says, in the air at its worst towards what is nearest.
"""

from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import jax

from fledge.clearance import Nearest, clearances
from fledge.dynamics import UavMemory
from fledge.engines import COMPILED, apart
from fledge.falsification.attacks import Attacker, Chance
from fledge.falsification.scenarios import Scenario, Terms
from fledge.falsification.trouble import push, weakened
from fledge.geometry import Vec3
from fledge.observation import observe
from fledge.pilots import AbstractPilot
from fledge.scalars import Scalar, where
from fledge.simulation import TICK, TICKS_PER_ROW, Rig, fly_tick
from fledge.world import Commands, VelocityCommand, WorldState

TURN_LIMIT = 1.5
"""[rad/s] of the UAV, as published."""


class Scene(NamedTuple):
    """What surrounds one flight."""

    terms: Terms
    rig: Rig
    """As the disturbance leaves it."""
    scenario: Scenario
    pilot: AbstractPilot | None
    """Flies the UAV, if the attackers do not."""

    @classmethod
    def of(cls, terms: Terms, scenario: Scenario, pilot: AbstractPilot | None) -> "Scene":
        """That of a scenario drawn on these terms."""
        formation = terms.rig.formation
        fleet = weakened(formation.fleet, terms.contract, scenario.trouble)
        return cls(terms, replace(terms.rig, formation=replace(formation, fleet=fleet)), scenario, pilot)

    @property
    def attacker(self) -> Attacker:
        """Attacks every vehicle."""
        return Attacker(self.rig.sticks, self.rig.formation.fleet, TICK)


class Mind(NamedTuple):
    """What the attackers remember, and the pilot."""

    moods: Any
    memory: Any
    stick: VelocityCommand
    """What the pilot last asked for."""


class Bodies(NamedTuple):
    """The vehicles, what is nearest to each, and who drives them."""

    world: WorldState
    near: tuple[Nearest, ...]
    uav: UavMemory
    mind: Mind


def begin(scene: Scene) -> Bodies:
    """Everybody at the start."""
    world = scene.scenario.world
    zero = 0.0 * world.t
    memory = () if scene.pilot is None else scene.pilot.init()
    mind = Mind(scene.attacker.init(zero), memory, VelocityCommand(zero, zero, zero, zero))
    return Bodies(world, _near(scene, world), scene.rig.uav.init(world.uav), mind)


def draw_chance(key: Any, vehicles: int) -> tuple[Chance, ...]:
    """The attackers' chance in one tick."""
    one, two, three = jax.random.split(key, 3)
    uniform = jax.random.uniform(one, (vehicles, 3), minval=-1.0, maxval=1.0)
    normal = jax.random.normal(two, (vehicles, 3))
    odds = jax.random.uniform(three, (vehicles,))
    return tuple(
        Chance(Vec3(*(uniform[i, j] for j in range(3))), Vec3(*(normal[i, j] for j in range(3))), odds[i])
        for i in range(vehicles)
    )


def drive(scene: Scene, bodies: Bodies, chance: tuple[Chance, ...], tick: Scalar) -> tuple[Mind, Commands]:
    """(the mind afterwards, what every vehicle is told)."""
    mind, (arena, _, _, nature, _) = bodies.mind, scene.scenario
    moods, told = apart(scene.attacker.act, mind.moods, nature, arena, bodies.world, bodies.near, chance)
    if scene.pilot is None:
        return mind._replace(moods=moods), told
    memory, stick = jax.lax.cond(
        tick % TICKS_PER_ROW == 0.0, partial(_decided, scene, bodies), lambda: (mind.memory, mind.stick)
    )
    return Mind(moods, memory, stick), replace(told, uav=stick)


def _decided(scene: Scene, bodies: Bodies) -> tuple[Any, VelocityCommand]:
    """(memory, command): what the pilot makes of what there is to see."""
    assert scene.pilot is not None
    seen = observe(bodies.world, scene.rig.lens, scene.rig.ideal_radius)
    zero = 0.0 * bodies.world.t
    memory, action = scene.pilot.act(bodies.mind.memory, seen, (zero, zero, zero, zero))
    return memory, scene.rig.sticks.command(action)


def move(scene: Scene, bodies: Bodies, commands: Commands, tick: Scalar) -> Bodies:
    """The vehicles one tick later, as they obey these commands and are pushed."""
    scenario, rig = scene.scenario, scene.rig
    # Wind pushes through drag alone: this wind pushes with the disturbance.
    wind = push(scene.terms.contract, scenario.trouble, bodies.near[0]) * (1.0 / rig.uav.drag)
    uav, world = apart(
        lambda uav, world, commands, wind, t: fly_tick(rig, uav, world, commands, wind, t, COMPILED),
        *(bodies.uav, bodies.world, commands, wind, (tick + 1.0) * TICK),
    )
    return Bodies(world, apart(partial(_near, scene), world), uav, bodies.mind)


def _near(scene: Scene, world: WorldState) -> tuple[Nearest, ...]:
    return clearances(scene.scenario.arena, world, scene.rig.uav, scene.rig.formation.fleet)


def obeyed(rig: Rig, told: Commands) -> Commands:
    """What vehicles make of commands: of garbage their last limit; of NaN nothing, or nothing could be judged."""
    ugvs = zip(told.ugvs, rig.formation.fleet, strict=True)
    return Commands(
        _sane(told.uav, rig.sticks.horizontal, TURN_LIMIT),
        tuple(_sane(command, model.max_speed, model.max_turn_rate) for command, model in ugvs),
    )


def _sane(command: VelocityCommand, most: Scalar, most_turn: Scalar) -> VelocityCommand:
    def within(x: Scalar, limit: Scalar) -> Scalar:
        return where(abs(x) <= limit, x, where(x > 0.0, limit, where(x < 0.0, -limit, 0.0 * limit)))

    return VelocityCommand(
        within(command.forward, most),
        within(command.left, most),
        within(command.up, most),
        within(command.turn, most_turn),
    )
