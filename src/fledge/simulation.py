"""The simulator: everything below it, put together and flown forward in time.

Rates: physics 500 Hz; the net 100 Hz; pilot and UGV guidance decide, and a row is stored, at 20 Hz, the last
commands held between. One scene is a `Case`, who flies it is a `Crew`, in what vehicles is a `Rig`. `rollout`
is a pure function of these and of the chance drawn beforehand, written once; what runs it is an `Engine`, on plain
floats or compiled (see `engines`). The lab never imports it.
"""

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import jax
import numpy as np

from fledge.camera import Lens
from fledge.conditions import (
    SIGHT_ROWS,
    Conditions,
    RowNoise,
    next_drift,
    next_gust,
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
from fledge.pytrees import pytree, register
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
    """What a flight runs on: plain Python, or a compiled program."""

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


class Decided(NamedTuple):
    """What a row begins with; the commands and the air stand for its ticks."""

    views: tuple[Observation, ...]
    seen: Observation
    """What the pilot saw."""
    pilot: Any
    """Its memory."""
    action: Action
    commands: Commands
    """What is proposed."""
    gust: Vec3
    drift: VelocityCommand
    error: VelocityCommand
    """On what the UAV is sent."""
    wind: Vec3


def decide(
    state: FlightState, target: FormationTrack, noise: RowNoise, scene: tuple[Case, Crew, Rig]
) -> Decided:
    """What pilot and guidance make of the world as the row begins, and what the air does."""
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
    return Decided(views, seen, pilot, action, Commands(proposed, told), gust, drift, error, wind)


def fly_row(
    state: FlightState,
    target: FormationTrack,
    noise: RowNoise,
    scene: tuple[Case, Crew, Rig],
    engine: Engine,
) -> tuple[FlightState, Episode]:
    """One decision, and the five ticks for which it is held: (state, the row)."""
    _, crew, rig = scene
    d = decide(state, target, noise, scene)

    def tick(carry: tuple[WorldState, UavMemory, Any], since: Scalar) -> tuple[Any, Any]:
        world, memory, net = carry
        net, verdicts = engine.apart(crew.net.filter, net, world, d.commands)
        uav_sent, *ugvs_sent = (verdict.command for verdict in verdicts)

        t = state.row / ROW_RATE + since + TICK
        sent = Commands(uav_sent + d.error, tuple(ugvs_sent))
        memory, stamped = fly_tick(rig, memory, world, sent, d.wind, t, engine)
        return (stamped, memory, net), verdicts

    ticks = np.arange(TICKS_PER_ROW) * TICK
    (world, memory, net), history = engine.scan(tick, (state.world, state.uav, state.net), ticks)
    verdicts = tuple(map(over, zip(*(_row(history, i) for i in range(TICKS_PER_ROW)), strict=True)))
    row = Episode(state.world, d.seen, d.action, d.commands, verdicts, target.spread)
    return FlightState(state.row + 1.0, world, memory, d.gust, d.drift, d.views, d.pilot, net), row


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


def _row(tree: Any, i: int) -> Any:
    """Row `i` of a record of arrays; of NumPy arrays, in plain floats."""

    def pick(leaf: Any) -> Scalar:
        return leaf[i].item() if isinstance(leaf, np.ndarray) else leaf[i]

    return jax.tree.map(pick, tree)


for _record in (Episode, Action, Commands, Verdict, FlightState):
    pytree(_record)
