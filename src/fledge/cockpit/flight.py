"""One flight in the simulator while people watch and act: `Live.tick`, 10 ms at a time, on plain floats.

What happens in a flight is `simulation`'s to say, here as there: `decide` at the start of each row, `fly_tick` for the
vehicles. Between them stands a supervisor with its net, as in the lab, so a person may stop, land or take over any
vehicle in any tick. Scene and chance are those of `fledge demonstrate` with the same seed and number: the person flies
what the synthetic operator flew, and a row is the same `Episode`.

**Who is the pilot.** A pilot of ours, or a person. A person's sticks are then the pilot's action, on the manoeuvre's
axes alone, proposed to the supervisor like any other's; they count in the next tick, and a row's action is their mean
over its ticks. It is as old as the last word heard of them, so the supervisor misses a person as it misses a policy: it
brakes and holds. To fly by hand on all axes, the person uses the take-over switch, whoever the pilot is.

What a person sees is the page, with its own delay; so nothing is simulated of a camera's, and what a row says was seen
is what there was to be seen. Else each flight's own delay, which no person saw, would stand between picture and sticks.

**Begin and end.** The flight begins in the air, above the formation, and everything stands still until somebody arms,
from a row's first tick on. The manoeuvre goes on while somebody flies the UAV, and waits while it holds; after its last
row the UGVs keep their last formation. A UAV whose motors are off stays where it is, as in the drills of `faults`.

A row counts as the pilot's (`Shown.flown`) only if the pilot flew in all of it, and a person was heard throughout.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from statistics import fmean
from typing import Any, NamedTuple, cast

import jax
import numpy as np

from fledge.camera import look
from fledge.cockpit.scene import FLOWN, PERSON, PILOTS_OWN, Shown, commander
from fledge.cockpit.seat import HANDS_OFF, Seats, Spoken
from fledge.dynamics import UavMemory
from fledge.engines import PLAIN, noises
from fledge.episode import Episode, Flight, over
from fledge.faults.injection import GROUND
from fledge.geometry import Vec3
from fledge.manoeuvres import AbstractManoeuvre, FormationTrack
from fledge.observation import ACTION_NAMES, Action, Axes, Observation
from fledge.pilots import AbstractPilot
from fledge.pilots.base import Noise
from fledge.pytrees import register
from fledge.safety import AbstractNet, Halt
from fledge.simulation import (
    TICK,
    TICKS_PER_ROW,
    Case,
    Crew,
    Decided,
    FlightState,
    Rig,
    RowNoise,
    decide,
    flight_key,
    fly_tick,
    start,
)
from fledge.supervision.inputs import Inputs, Operator
from fledge.supervision.posts import Decision
from fledge.supervision.posts import Memory as Supervision
from fledge.supervision.supervisor import IDLE, Supervisor
from fledge.world import Commands, WorldState

EYES = {"delay": 0.0, "pixel_noise": 0.0, "motion_noise": 0.0}
"""A person's conditions, where they differ from the scene's."""


@dataclass(frozen=True, slots=True)
class Person(AbstractPilot):
    """Whoever sits in the cockpit: says what the sticks say."""

    said: Action = HANDS_OFF
    name = PERSON

    def act(self, memory: tuple[()], observation: Observation, noise: Noise) -> tuple[tuple[()], Action]:
        """What was said."""
        return memory, self.said


class Choice(NamedTuple):
    """Which flight it is to be."""

    manoeuvre: AbstractManoeuvre
    pilot: AbstractPilot
    net: AbstractNet
    net_name: str
    rows: int
    seed: int = 0
    number: int = 0
    """Of the flight, among those of this seed."""


class Memory(NamedTuple):
    """All that changes."""

    ticks: int
    state: FlightState
    """As the row began."""
    decided: Decided
    """For this row."""
    armed: float
    """As the row began."""
    world: WorldState
    """Now."""
    uav: UavMemory
    supervision: Supervision
    history: tuple[tuple[Decision, ...], ...] = ()
    """The decisions of the row's ticks so far."""
    said: tuple[Action, ...] = ()
    """What a person said who is the pilot, in these ticks."""
    heard: bool = True
    """Whether a person was, in all of them."""
    way: int = 0
    """Rows of the manoeuvre that are over."""


@dataclass(frozen=True, slots=True)
class Live:
    """One flight: what stays as it is during it."""

    choice: Choice
    case: Case
    crew: Crew
    rig: Rig
    supervisor: Supervisor
    targets: tuple[FormationTrack, ...]
    """Row by row."""
    chance: tuple[RowNoise, ...]
    """Row by row; a flight that lasts longer has it again."""

    @classmethod
    def draw(cls, choice: Choice, rig: Rig = Rig()) -> "Live":
        """The flight of a choice, with the scene and the chance of `fledge demonstrate`."""
        manoeuvre = choice.manoeuvre
        key = flight_key(choice.seed, "demonstration", manoeuvre.name, choice.number)
        crew = Crew(choice.pilot.for_axes(manoeuvre.axes), Axes.of(manoeuvre.axes))
        case = Case.draw(manoeuvre, key, choice.rows)
        if isinstance(choice.pilot, Person):
            case = replace(case, conditions=replace(case.conditions, **EYES))
        register((case, crew))
        case = jax.tree.map(lambda leaf: leaf if np.ndim(leaf) else float(leaf), case)
        columns = (getattr(case.plan.track, one.name).tolist() for one in fields(FormationTrack))
        return cls(
            choice,
            case,
            crew,
            rig,
            Supervisor(choice.net, silence=Seats().silence),
            tuple(FormationTrack(*row) for row in zip(*columns, strict=True)),
            tuple(noises((*key, 1), choice.rows)),
        )

    @property
    def about(self) -> Flight:
        """What the flight is, for its file; there is no episode yet."""
        choice, rig = self.choice, self.rig
        return Flight(
            episode=cast(Any, None),
            manoeuvre=choice.manoeuvre.name,
            pilot=choice.pilot.name,
            net=choice.net_name,
            seed=choice.seed,
            case=choice.number,
            axes=choice.manoeuvre.axes,
            arena=self.case.plan.arena,
            lens=rig.lens,
            sticks=rig.sticks,
            ideal_radius=rig.ideal_radius,
        )

    def init(self) -> Memory:
        """Above the formation, nobody having said anything."""
        state = start(self.case, self.crew, self.rig)
        supervision = self.supervisor.init(self.case.plan.arena, state.world)
        return Memory(0, state, self._decided(state, 0), 0.0, state.world, state.uav, supervision)

    def tick(self, memory: Memory, spoken: Spoken) -> tuple[Memory, Shown]:
        """10 ms later, with what people said."""
        if not memory.history:
            memory = self._begun(memory, spoken)
        if self._by_person:
            memory = self._steered(memory, spoken.action)
        supervision, decisions = self.supervisor.step(memory.supervision, self._inputs(memory, spoken))
        t = (memory.ticks + 1) * TICK
        uav, world = self._flown(memory, decisions, t)
        memory = memory._replace(
            ticks=memory.ticks + 1,
            world=world,
            uav=uav,
            supervision=supervision,
            history=(*memory.history, decisions),
            heard=memory.heard and not spoken.lost,
        )
        row, flown = None, False
        if len(memory.history) == TICKS_PER_ROW:
            row, flown = self._row(memory), self._own(memory)
            memory = self._ended(memory)
        shown = Shown(
            world,
            decisions,
            tuple(commander(i, decision, self._by_person) for i, decision in enumerate(decisions)),
            look(self.rig.lens, world),
            row,
            flown,
            memory.way >= len(self.targets),
        )
        return memory, shown

    @property
    def net(self) -> AbstractNet:
        """Behind which it is flown."""
        return self.choice.net

    def halts(self, memory: Memory) -> tuple[Halt, ...]:
        """Where vehicles would come to rest; none if the net does not say."""
        return self.net.halts(memory.supervision.net, memory.world)

    def close(self) -> None:
        """There is nothing to give back."""

    @property
    def _by_person(self) -> bool:
        return isinstance(self.crew.pilot, Person)

    def _target(self, way: int) -> FormationTrack:
        return self.targets[min(way, len(self.targets) - 1)]

    def _decided(self, state: FlightState, way: int) -> Decided:
        noise = self.chance[int(state.row) % len(self.chance)]
        return decide(state, self._target(way), noise, (self.case, self.crew, self.rig))

    def _begun(self, memory: Memory, spoken: Spoken) -> Memory:
        """With the decision for a new row."""
        return memory._replace(
            decided=self._decided(memory.state, memory.way),
            armed=spoken.operators[0].arm,
            said=(),
            heard=True,
        )

    def _steered(self, memory: Memory, said: Action) -> Memory:
        """With what a person says now."""
        action = said.only(self.crew.axes)
        decided = self._asked(memory.decided, action)
        return memory._replace(decided=decided, said=(*memory.said, action))

    def _asked(self, decided: Decided, action: Action) -> Decided:
        """The same, but for what the pilot wants."""
        commands = replace(decided.commands, uav=self.rig.sticks.command(action))
        return decided._replace(action=action, commands=commands)

    def _inputs(self, memory: Memory, spoken: Spoken) -> Inputs:
        now = memory.world.t
        decided = now - spoken.silent if self._by_person else memory.state.world.t
        operators = tuple(replace(one, arm=memory.armed) for one in spoken.operators)
        if self._by_person:  # whose sticks are the pilot's: moving them takes nothing over
            operators = (without_sticks(operators[0]), *operators[1:])
        belly = memory.world.uav.position.z - self.rig.uav.half_height
        return Inputs(
            seen=memory.world,
            proposed=memory.decided.commands,
            decided=decided,
            operators=operators,
            heard=now - spoken.silent,
            batteries=(1.0,) * len(operators),
            airborne=float(belly > GROUND),
        )

    def _flown(
        self, memory: Memory, decisions: tuple[Decision, ...], t: float
    ) -> tuple[UavMemory, WorldState]:
        """The vehicles at time `t` [s], as they obey."""
        uav_sent, *ugvs_sent = (decision.verdict.command for decision in decisions)
        sent = Commands(uav_sent + memory.decided.error, tuple(ugvs_sent))
        rig, wind = self.rig, memory.decided.wind
        uav, world = fly_tick(rig, memory.uav, memory.world, sent, wind, t, PLAIN)
        if decisions[0].mode not in IDLE:
            return uav, world
        still = Vec3(0.0, 0.0, 0.0)
        rested = replace(memory.world.uav, velocity=still, rates=still, stamp=t)
        return rig.uav.init(rested), replace(world, uav=rested)

    def _row(self, memory: Memory) -> Episode:
        d, vehicles = memory.decided, zip(*memory.history, strict=True)
        if memory.said:
            d = self._asked(d, mean(memory.said))
        verdicts = tuple(over([one.verdict for one in decisions]) for decisions in vehicles)
        spread = self._target(memory.way).spread
        return Episode(memory.state.world, d.seen, d.action, d.commands, verdicts, spread)

    def _own(self, memory: Memory) -> bool:
        """Whether the row was the pilot's."""
        in_command = all(decisions[0].mode in PILOTS_OWN for decisions in memory.history)
        return in_command and (memory.heard or not self._by_person)

    def _ended(self, memory: Memory) -> Memory:
        """Ready for the next row."""
        state, d = memory.state, memory.decided
        if all(decisions[0].mode in IDLE for decisions in memory.history):  # then nothing has begun
            return memory._replace(state=replace(state, world=memory.world, uav=memory.uav), history=())
        state = FlightState(
            state.row + 1.0, memory.world, memory.uav, d.gust, d.drift, d.views, d.pilot, state.net
        )
        somebody = all(decisions[0].mode in FLOWN for decisions in memory.history)
        return memory._replace(state=state, history=(), way=memory.way + somebody)


def mean(actions: Sequence[Action]) -> Action:
    """Stick by stick."""
    return Action(*(fmean(getattr(action, name) for action in actions) for name in ACTION_NAMES))


def without_sticks(operator: Operator) -> Operator:
    """The same, of somebody whose moving them is no take-over; the switch still is."""
    return replace(operator, deflection=0.0)
