"""The simulator: everything below it, put together and flown forward in time.

Rates: physics 500 Hz; the net 100 Hz; pilot and UGV guidance decide, and a row is stored, at 20 Hz, the last
commands held between. One scene is a `Case`, who flies it is a `Crew`, in what vehicles is a `Rig`. `rollout`
is a pure function of these and of the chance drawn beforehand, written once and run twice: on plain floats
(`fly_plain`: any pilot, any Python) and compiled by JAX over many scenes at once (`fly`).

This is the one file where records become JAX pytrees; the lab never imports it.
"""

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cache
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.experimental.xla_metadata import set_xla_metadata

from fledge.camera import Lens
from fledge.conditions import (
    NORMALS,
    SIGHT_ROWS,
    UNIFORMS,
    Conditions,
    RowNoise,
    next_drift,
    next_gust,
    row_noise,
    sense,
)
from fledge.dynamics import Quadrotor, UavMemory
from fledge.episode import Episode, over
from fledge.formation import FormationControl
from fledge.geometry import Quat, Vec3
from fledge.manoeuvres.base import AbstractManoeuvre, FormationTrack, Plan
from fledge.observation import (
    IDEAL_RADIUS_PX,
    ROW_RATE,
    Action,
    Axes,
    Observation,
    StickScale,
    observe,
)
from fledge.pilots.base import AbstractPilot
from fledge.safety import AbstractNet, NoNet
from fledge.scalars import Scalar
from fledge.world import (
    Commands,
    UavState,
    UgvState,
    VelocityCommand,
    Verdict,
    WorldState,
)

TICKS_PER_ROW = 5
"""The net runs at 100 Hz."""
STEPS_PER_TICK = 5
"""Physics runs at 500 Hz."""
TICK = 1.0 / (ROW_RATE * TICKS_PER_ROW)
"""[s]."""
STEP = TICK / STEPS_PER_TICK
"""[s]."""


@dataclass(frozen=True, slots=True)
class Rig:
    """What flies and what it looks through; fixed within a study."""

    uav: Quadrotor = Quadrotor()
    formation: FormationControl = FormationControl()
    lens: Lens = Lens()
    sticks: StickScale = StickScale()
    ideal_radius: float = IDEAL_RADIUS_PX


@dataclass(frozen=True, slots=True)
class Case:
    """Everything that is drawn before a flight but the noise."""

    plan: Plan
    conditions: Conditions

    @classmethod
    def draw(cls, manoeuvre: AbstractManoeuvre, key: Sequence[int], rows: int) -> "Case":
        """The case that a key stands for: same manoeuvre, key and rows, same case."""
        rng = np.random.default_rng(list(key))
        return cls(manoeuvre.plan(rng, rows), Conditions.draw(rng))

    def lasting(self, rows: int) -> "Case":
        """The same cut to `rows` rows, or with its last row repeated up to them."""
        pick = np.minimum(np.arange(rows), len(self.plan.track.x) - 1)
        track = FormationTrack(*(getattr(self.plan.track, f.name)[pick] for f in fields(FormationTrack)))
        return replace(self, plan=replace(self.plan, track=track))


def flight_key(seed: int, purpose: str, manoeuvre: str, number: int) -> tuple[int, ...]:
    """The key of one flight; flights for different purposes never share chance."""
    return (seed, zlib.crc32(purpose.encode()), zlib.crc32(manoeuvre.encode()), number)


@dataclass(frozen=True, slots=True)
class Crew:
    """Who decides: the pilot, on which axes, behind which net."""

    pilot: AbstractPilot
    axes: Axes = Axes()
    net: AbstractNet = NoNet()


@dataclass(frozen=True, slots=True)
class FlightState:
    """All that changes during a flight."""

    row: Scalar
    world: WorldState
    uav: UavMemory
    gust: Vec3
    drift: VelocityCommand
    views: tuple[Observation, ...]
    """Exact observations of the last rows, newest first."""
    pilot: Any
    net: Any


class Engine(NamedTuple):
    """What a flight runs on: `COMPILED` or `PLAIN`."""

    scan: Callable[[Callable[[Any, Any], tuple[Any, Any]], Any, Any], tuple[Any, Any]]
    """`jax.lax.scan`, or a loop that does the same."""
    apart: Callable[..., Any]
    """Calls a function with arguments, as a piece of its own if anything is compiled."""


def start(case: Case, crew: Crew, rig: Rig) -> FlightState:
    """UGVs on their corners, the UAV hovering above them, everybody rested."""
    register((case, crew))
    track, c = _row(case.plan.track, 0), case.conditions
    zero = 0.0 * track.x
    ugvs = tuple(
        UgvState(x, y, case.plan.orientation + zero, zero, zero, zero)
        for x, y, _, _ in rig.formation.corners(track, case.plan.orientation)
    )
    still = Vec3(zero, zero, zero)
    above = Vec3(track.x, track.y, rig.lens.focal_px * track.spread / rig.ideal_radius)
    uav = UavState(above + c.offset, still, Quat.from_yaw(c.yaw + zero), still, zero)
    world = WorldState(zero, uav, ugvs)
    begin = FlightState(
        row=zero,
        world=world,
        uav=rig.uav.init(uav),
        gust=still,
        drift=VelocityCommand(zero, zero, zero, zero),
        views=(observe(world, rig.lens, rig.ideal_radius),) * SIGHT_ROWS,
        pilot=crew.pilot.init(),
        net=crew.net.init(case.plan.arena, world),
    )
    register(begin)
    return begin


def fly_tick(
    rig: Rig, memory: UavMemory, world: WorldState, sent: Commands, wind: Vec3, t: Scalar, engine: Engine
) -> tuple[UavMemory, WorldState]:
    """The vehicles one tick later, at time `t` [s], as they obey what they were sent."""

    def step(carry: tuple[UavMemory, UavState, tuple[UgvState, ...]], _: Any) -> Any:
        memory, uav, ugvs = carry
        memory, uav = rig.uav.step(memory, uav, sent.uav, wind, STEP)
        ugvs = tuple(
            model.step(ugv, command, STEP)
            for model, ugv, command in zip(rig.formation.fleet, ugvs, sent.ugvs, strict=True)
        )
        return (memory, uav, ugvs), ()

    (memory, uav, ugvs), _ = engine.scan(step, (memory, world.uav, world.ugvs), np.zeros(STEPS_PER_TICK))
    return memory, WorldState(t, replace(uav, stamp=t), tuple(replace(ugv, stamp=t) for ugv in ugvs))


def fly_row(
    state: FlightState,
    target: FormationTrack,
    noise: RowNoise,
    scene: tuple[Case, Crew, Rig],
    engine: Engine,
) -> tuple[FlightState, Episode]:
    """One decision, and the five ticks for which it is held: (state, the row)."""
    case, crew, rig = scene
    views = (observe(state.world, rig.lens, rig.ideal_radius), *state.views[:-1])
    seen = sense(views, noise, case.conditions)
    pilot, action = crew.pilot.act(state.pilot, seen, noise.pilot)
    action = action.only(crew.axes)
    proposed = rig.sticks.command(action)
    gust = next_gust(state.gust, noise, case.conditions)
    drift = next_drift(state.drift, state.row, noise, case.conditions)
    error = noise.command.scaled(case.conditions.command_noise) + drift
    wind = case.conditions.wind + gust
    told = rig.formation.commands(state.world.ugvs, target, case.plan.orientation, case.plan.arena)
    commands = Commands(proposed, told)

    def tick(carry: tuple[WorldState, UavMemory, Any], since: Scalar) -> tuple[Any, Any]:
        world, memory, net = carry
        net, verdicts = engine.apart(crew.net.filter, net, world, commands)
        uav_sent, *ugvs_sent = (verdict.command for verdict in verdicts)

        t = state.row / ROW_RATE + since + TICK
        sent = Commands(uav_sent + error, tuple(ugvs_sent))
        memory, stamped = fly_tick(rig, memory, world, sent, wind, t, engine)
        return (stamped, memory, net), verdicts

    ticks = np.arange(TICKS_PER_ROW) * TICK
    (world, memory, net), history = engine.scan(tick, (state.world, state.uav, state.net), ticks)
    verdicts = tuple(map(over, zip(*(_row(history, i) for i in range(TICKS_PER_ROW)), strict=True)))
    row = Episode(state.world, seen, action, commands, verdicts, target.spread)
    return FlightState(state.row + 1.0, world, memory, gust, drift, views, pilot, net), row


def rollout(
    scene: tuple[Case, Crew, Rig], chance: Any, noise_of: Callable[[Any], RowNoise], engine: Engine
) -> Episode:
    """Fly a scene from start to end; `noise_of` makes one row of `chance` into its noise."""

    def step(state: FlightState, inputs: tuple[FormationTrack, Any]) -> tuple[FlightState, Episode]:
        target, drawn = inputs
        return fly_row(state, target, noise_of(drawn), scene, engine)

    case, crew, rig = scene
    begin = start(case, crew, rig)
    _, episode = engine.scan(step, begin, (case.plan.track, chance))
    return episode


Rollout = Callable[[tuple[Case, Crew, Rig], Any, Callable[[Any], RowNoise], Engine], Any]
"""`rollout`, or something else to do with a scene."""


def apart(piece: Callable[..., Any], *inputs: Any) -> Any:
    """`piece(*inputs)` inside a compiled program, as a function of its own.

    Left to itself XLA fuses a tick into a few kernels that compute the same things many times over; with a net kept
    apart a program compiles in a tenth of the time and runs three times faster.
    """
    register(inputs)
    with set_xla_metadata(inlineable="false"):
        return jax.jit(piece)(*inputs)


def _plain_scan(step: Callable[[Any, Any], tuple[Any, Any]], carry: Any, inputs: Any) -> tuple[Any, Any]:
    """`jax.lax.scan` without JAX's arrays: a loop over plain floats, its outputs stacked by NumPy."""
    leaves, shape = jax.tree.flatten(inputs)
    outputs = []
    for row in zip(*(np.asarray(leaf).tolist() for leaf in leaves), strict=True):
        carry, output = step(carry, jax.tree.unflatten(shape, row))
        outputs.append(output)
    return carry, jax.tree.map(lambda *values: np.array(values), *outputs)


COMPILED = Engine(jax.lax.scan, apart)
PLAIN = Engine(_plain_scan, lambda piece, *inputs: piece(*inputs))


def _row(tree: Any, i: int) -> Any:
    """Row `i` of a record of arrays; of NumPy arrays, in plain floats."""

    def pick(leaf: Any) -> Scalar:
        return leaf[i].item() if isinstance(leaf, np.ndarray) else leaf[i]

    return jax.tree.map(pick, tree)


def fly_plain(case: Case, crew: Crew, key: Sequence[int], rig: Rig = Rig(), roll: Rollout = rollout) -> Any:
    """Fly one case in plain Python, with the chance of `key`; leaves of shape (rows,). Any pilot will do."""
    register((case, crew))
    case = jax.tree.map(lambda leaf: leaf if np.ndim(leaf) else float(leaf), case)
    keys = jax.random.split(jax.random.wrap_key_data(_seeds([key])[0]), len(case.plan.track.x))
    chance = jax.vmap(_draw)(keys)
    return roll((case, crew, rig), chance, _deal, PLAIN)


def fly(
    cases: Sequence[Case],
    crew: Crew | Sequence[Crew],
    keys: Sequence[Sequence[int]],
    rig: Rig = Rig(),
    reduce: Callable[[Any], Any] | None = None,
    roll: Rollout = rollout,
) -> Any:
    """Fly many cases in one compiled program; leaves of shape (flights, rows).

    Args:
        cases: one per flight, all with the same number of rows.
        crew: who flies them all, or one crew of the same kind per flight.
        keys: the chance of each flight.
        rig: vehicles and lens.
        reduce: makes something smaller of the episodes, leaves (flights, rows), inside the program: scores,
            say. Keep one function for one purpose, since each is compiled anew.
        roll: what is done with each scene.
    """
    each = not isinstance(crew, Crew)
    crews = stack(crew) if each else crew
    register(crews)
    flown = _compiled(rig, reduce, each, roll)
    return jax.tree.map(np.asarray, flown(stack_cases(cases), crews, _seeds(keys)))


def fly_team(
    cases: Sequence[Case],
    crew: Crew,
    keys: Sequence[Sequence[int]],
    rig: Rig = Rig(),
    reduce: Callable[[Episode], Any] | None = None,
) -> Any:
    """The same with a crew whose pilot's arrays have a leading axis of seeds: leaves (seeds, flights, ...)."""
    register(crew)
    flown = _compiled_team(rig, reduce)
    return jax.tree.map(np.asarray, flown(stack_cases(cases), crew, _seeds(keys)))


def take(episodes: Episode, flight: int, rows: int) -> Episode:
    """One flight of many, its first `rows` rows."""
    return jax.tree.map(lambda leaf: leaf[flight, :rows], episodes)


# Half the compile time for the same speed: LLVM's costlier passes find nothing to do in small kernels.
_QUICKLY = {"xla_backend_optimization_level": 1}


def compiled(program: Callable[..., Any]) -> Any:
    """A program of many scenes, compiled."""
    return jax.jit(program, compiler_options=_QUICKLY)


@cache
def _compiled(rig: Rig, reduce: Callable[[Any], Any] | None, each: bool, roll: Rollout) -> Any:
    return compiled(_many_flights(rig, reduce, each, roll))


@cache
def _compiled_team(rig: Rig, reduce: Callable[[Episode], Any] | None) -> Any:
    flown = _many_flights(rig, reduce, each=False)

    def team(cases: Case, crew: Crew, seeds: jax.Array) -> Any:
        # One seed after the other bounds the memory; the flights of a seed run side by side.
        return jax.lax.map(lambda pilot: flown(cases, replace(crew, pilot=pilot), seeds), crew.pilot)

    return compiled(team)


def _many_flights(
    rig: Rig, reduce: Callable[[Any], Any] | None, each: bool, roll: Rollout = rollout
) -> Callable[..., Any]:
    def one(case: Case, crew: Crew, seed: jax.Array) -> Any:
        keys = jax.random.split(jax.random.wrap_key_data(seed), len(case.plan.track.x))
        return roll((case, crew, rig), keys, lambda key: _deal(_draw(key)), COMPILED)

    def many(cases: Case, crews: Crew, seeds: jax.Array) -> Any:
        episodes = jax.vmap(one, in_axes=(0, 0 if each else None, 0))(cases, crews, seeds)
        return episodes if reduce is None else reduce(episodes)

    return many


def _draw(key: jax.Array) -> tuple[jax.Array, jax.Array]:
    """The chance of one row: standard normal numbers, and uniform ones in [-1, 1]."""
    one, two = jax.random.split(key)
    normal = jax.random.normal(one, (NORMALS,))
    return normal, jax.random.uniform(two, (UNIFORMS,), minval=-1.0, maxval=1.0)


def _deal(chance: tuple[Any, Any]) -> RowNoise:
    normal, uniform = chance
    return row_noise([normal[i] for i in range(NORMALS)], [uniform[i] for i in range(UNIFORMS)])


def traceable(pilot: AbstractPilot) -> bool:
    """Whether JAX can compile a pilot; one that cannot be compiled is flown by `fly_plain`."""
    number = jax.ShapeDtypeStruct((), jnp.float32)
    seen = Observation(*(number for _ in fields(Observation)))
    memory = pilot.init()
    register((pilot, seen, memory))
    noise = (number, number, number, number)
    try:
        # As in a flight: the memory goes through a scan, so it is traced, too, and must keep its kind.
        jax.eval_shape(
            lambda m, o, n: jax.lax.scan(lambda m, _: (pilot.act(m, o, n)[0], ()), m, length=1),
            memory,
            seen,
            noise,
        )
    except (TypeError, ValueError):  # JAX's own errors are TypeErrors
        return False
    return True


def stack_cases(cases: Sequence[Case]) -> Case:
    """One Case with a leading axis of flights, arenas padded to the same number of obstacles."""
    most = max(len(case.plan.arena.obstacles) for case in cases)
    padded = [replace(case, plan=replace(case.plan, arena=case.plan.arena.padded(most))) for case in cases]
    return stack(padded)


def stack(records: Sequence[Any]) -> Any:
    """One record whose leaves have a leading axis, of many alike."""
    for record in records:
        register(record)
    return jax.tree.map(lambda *leaves: jnp.asarray(np.array(leaves, dtype=float)), *records)


def _seeds(keys: Sequence[Sequence[int]]) -> jax.Array:
    words = [np.random.SeedSequence(list(key)).generate_state(2) for key in keys]
    return jnp.asarray(np.array(words, dtype=np.uint32))


_registered: set[type] = set()


def pytree(kind: type) -> type:
    """Make a dataclass a pytree; a field with `metadata={"static": True}` is no leaf."""
    if kind not in _registered:
        jax.tree_util.register_dataclass(kind)
        _registered.add(kind)
    return kind


def register(value: Any) -> None:
    """Make every record in `value` a pytree; a net becomes a constant, and a stranger's pilot that is no record."""
    if isinstance(value, tuple):
        for item in value:
            register(item)
    elif isinstance(value, AbstractNet) or (isinstance(value, AbstractPilot) and not is_dataclass(value)):
        if type(value) not in _registered:
            jax.tree_util.register_static(type(value))
            _registered.add(type(value))
    elif is_dataclass(value):
        pytree(type(value))
        for field in fields(value):
            if not field.metadata.get("static"):
                register(getattr(value, field.name))


for _record in (Episode, Action, Commands, Verdict, FlightState):
    pytree(_record)
