"""One control tick of the lab: what was heard in, what is to be said out, 100 times a second.

    datagrams -> eyes, vehicle, hands -> estimator -> world
    the world, as far as it was believed a tick ago -> guidance, 20 times a second -> proposals
    world, proposals, operators -> `Supervisor.step` (watchdog, modes, net) -> decisions
    decisions, phase -> tilt -> orders -> vehicle -> datagrams

`Controller.step` is a pure function, so a log of what was heard replays to the same bytes. It knows neither sockets nor
clocks nor which wire is which: eyes and vehicle are records behind one protocol each (`eyes`, `vehicle`).

*Two machines of states.* Modes say who flies, and why not; phases say how far the flight has come. To take off, nothing
may be missing (`checks`), and somebody has to arm after that (`arming`).

*What the net is told* is what was really sent. While the firmware takes off or lands by itself, nothing was. UGVs that
are not ours to command count as having been told what they are seen to do.

*The pilot decides* only on poses that are fresh; if they are not, its last decision grows old, and the supervisor sees
that. It looks at poses the watchdog believed, one tick ago: a single wild pose is not flown after.
"""

from dataclasses import dataclass, replace
from math import inf, nan
from typing import Any, NamedTuple

from fledge.lab.control.arming import Arming
from fledge.lab.control.checks import Checks, Findings
from fledge.lab.control.estimator import Estimator, Seen
from fledge.lab.control.eyes import AbstractEyes, View
from fledge.lab.control.guidance import Guidance, Guided
from fledge.lab.control.hands import Hands, Holding
from fledge.lab.control.joy import Gamepad
from fledge.lab.control.phases import ALOFT, Course, Phase, Phases, Sight
from fledge.lab.control.team import Led, Team
from fledge.lab.control.tilt import Memory as Tilted
from fledge.lab.control.tilt import Tilt
from fledge.lab.control.vehicle import AbstractVehicle, Orders
from fledge.lab.wire.datagrams import Datagram, Heard
from fledge.observation import ROW_RATE, Action, Observation
from fledge.supervision.inputs import Inputs
from fledge.supervision.modes import Mode
from fledge.supervision.posts import Decision
from fledge.supervision.posts import Memory as Supervision
from fledge.supervision.supervisor import NOTHING, Supervisor
from fledge.supervision.watchdog import TICK
from fledge.world import Commands, VelocityCommand, WorldState

P = Phase
HOVER = VelocityCommand.hover()
DECIDING = 1.0 / ROW_RATE - 0.5 * TICK
"""[s] between two decisions, with room for a tick that comes a little early."""
FRESH = 0.25
"""[s] that a pose may be old for a decision; chosen: half of what ends the pilot's turn."""
IDLE = (Mode.INIT, Mode.READY)


class Memory(NamedTuple):
    """All that is remembered from one tick to the next."""

    view: View
    poses: tuple[Seen, ...]
    vehicle: Any
    holding: Holding
    course: Course
    guided: Guided
    led: Led
    tilted: Tilted
    supervision: Supervision | None = None
    """None until everybody was seen."""
    t: float = -inf
    """Of the last tick [s]."""
    asked: float = -inf
    """When there was last a decision due [s]."""
    decided: float = -inf
    """When there was one [s]."""
    height: float = nan
    """At which the formation is followed [m]."""
    cleared: bool = False
    """Whether arming counts."""
    complaint: str = ""


@dataclass(frozen=True, slots=True)
class Said:
    """What a tick comes to."""

    datagrams: tuple[Datagram, ...]
    """To be sent, by channel."""
    phase: Phase
    world: WorldState | None = None
    """As estimated, believed or not; None until everybody was seen."""
    observation: Observation | None = None
    """What was last seen, and decided on."""
    action: Action | None = None
    """What was last said."""
    decisions: tuple[Decision, ...] = ()
    """One per vehicle, the UAV first; none until everybody was seen."""
    complaint: str = ""
    """What is missing, in one line for people."""
    proposed: Commands | None = None
    """What guidance asked for, on which it was decided."""


@dataclass(frozen=True, slots=True)
class Controller:
    """Who does what; the subjects' order is the vehicles', the UAV first."""

    eyes: AbstractEyes
    vehicle: AbstractVehicle
    guidance: Guidance
    checks: Checks
    supervisor: Supervisor = Supervisor()
    estimator: Estimator = Estimator()
    tilt: Tilt = Tilt()
    phases: Phases = Phases()
    team: Team | None = None
    """Who drives the UGVs; None if they are not ours to command."""

    @property
    def hands(self) -> Hands:
        """Who listens to people."""
        return Hands(Gamepad(len(self.checks.subjects), self.guidance.sticks))

    @property
    def arming(self) -> Arming:
        """Whose word counts."""
        return Arming(self.checks.unattended, self.team is not None)

    def init(self) -> Memory:
        """Before anything was heard."""
        return Memory(
            self.eyes.init(),
            self.estimator.init(len(self.checks.subjects)),
            self.vehicle.init(),
            self.hands.init(),
            self.phases.init(),
            self.guidance.init(),
            self.team.init() if self.team else Led(told=(HOVER,) * (len(self.checks.subjects) - 1)),
            self.tilt.init(),
        )

    def step(self, memory: Memory, heard: Heard) -> tuple[Memory, Said]:
        """(memory, what to send and what it was about)."""
        memory = self._listen(memory, heard)
        world = self.estimator.world(memory.poses, heard.t)
        if world is None:
            memory = memory._replace(complaint=self._missing(memory, heard.t, None))
            return self._send(memory, heard.t, Orders(revive=True), Said((), memory.course.phase))
        supervision = memory.supervision or self.supervisor.init(self.checks.arena, world)
        believed = _believed(supervision, heard.t)
        memory = self._decide(memory, world, believed, supervision)
        inputs = self._inputs(memory, world, believed, supervision)
        supervision, decisions = self.supervisor.step(supervision, inputs)
        memory, orders = self._obey(memory._replace(supervision=supervision), heard.t, decisions)
        g = memory.guided
        said = Said(
            (), memory.course.phase, world, g.observation, g.action, decisions, proposed=inputs.proposed
        )
        return self._send(memory, heard.t, orders, said)

    def _listen(self, memory: Memory, heard: Heard) -> Memory:
        view, vehicle, holding = memory.view, memory.vehicle, memory.holding
        poses, hands = self.estimator.begin(memory.poses), self.hands
        for datagram in heard.datagrams:
            view, seen = self.eyes.look(view, heard.t, datagram)
            for who, pose in seen:
                poses = self.estimator.see(poses, who, pose)
            vehicle = self.vehicle.hear(vehicle, heard.t, datagram)
            holding = hands.hear(holding, heard.t, datagram)
        return memory._replace(view=view, poses=poses, vehicle=vehicle, holding=holding)

    def _missing(self, memory: Memory, t: float, world: WorldState | None) -> str:
        height = nan if world is None else self.guidance.height(world)
        found = Findings(t, memory.view, memory.vehicle.report, memory.holding, world, height)
        return self.checks.missing(found)

    def _decide(
        self, memory: Memory, world: WorldState, believed: WorldState, supervision: Supervision
    ) -> Memory:
        """What is due 20 times a second."""
        t, phase = world.t, memory.course.phase
        if t - memory.asked < DECIDING:
            return memory
        complaint = self._complaint(memory, world)
        cleared = self.arming.cleared(memory.cleared, complaint, memory.holding)
        memory = memory._replace(asked=t, complaint=complaint, cleared=cleared)
        if max(t - state.stamp for state in (believed.uav, *believed.ugvs)) > FRESH:
            return memory
        height = memory.height if phase in (P.FLY, P.LAND, P.OVER) else self.guidance.height(believed)
        guided = self.guidance.decide(memory.guided, phase, believed)
        memory = memory._replace(decided=t, height=height, guided=guided)
        if self.team is None:
            return memory
        flown = supervision.posts[0].mode in (Mode.AUTO, Mode.SHIELDED)
        return memory._replace(led=self.team.decide(memory.led, phase, flown, believed.ugvs))

    def _complaint(self, memory: Memory, world: WorldState) -> str:
        if memory.course.phase is P.WAIT:
            return self._missing(memory, world.t, world)
        if memory.course.phase not in ALOFT:
            return ""
        return self.checks.in_flight(world.t, memory.view, memory.vehicle.report)

    def _inputs(
        self, memory: Memory, world: WorldState, believed: WorldState, supervision: Supervision
    ) -> Inputs:
        course, report = memory.course, memory.vehicle.report
        uav = self.guidance.propose(memory.guided, course, believed.uav, self.checks.within(memory.height))
        told = world.t - report.heard <= self.checks.mute
        aloft = report.aloft if told else believed.uav.position.z > self.phases.floor
        operators, heard = self.arming.operators(
            memory.holding, memory.cleared, course.phase, supervision, world.t
        )
        return Inputs(
            world,
            Commands(uav, memory.led.told),
            memory.decided,
            operators,
            heard,
            (report.battery if told else nan, *(1.0 for _ in world.ugvs)),
            1.0 if aloft else 0.0,
        )

    def _obey(self, memory: Memory, t: float, decisions: tuple[Decision, ...]) -> tuple[Memory, Orders]:
        """(memory, what becomes of the decisions in this phase)."""
        assert memory.supervision is not None
        believed = _believed(memory.supervision, t)
        mode, observation = decisions[0].mode, memory.guided.observation
        distance = inf if observation is None else self.guidance.distance(observation)
        height = self.checks.within(memory.height)
        sight = Sight(t, mode, believed.uav, memory.vehicle.report, height, distance)
        course = self.phases.step(memory.course, sight)
        trimming = course.phase is P.TAKE_OFF and t - course.since < self.phases.trimming
        flies = course.phase in (*ALOFT, P.LAND) and not course.touching
        orders = Orders(
            fly=flies or (course.phase is P.TAKE_OFF and not trimming),
            trim=trimming,
            cut=mode == Mode.TERMINATED,
            revive=course.phase is P.WAIT,
            ugvs=tuple(one.verdict.command for one in decisions[1:]) if self.team else (),
        )
        memory = memory._replace(course=course, supervision=self._told(memory.supervision, believed, flies))
        if not flies:
            return memory._replace(tilted=self.tilt.init()), orders
        command = decisions[0].verdict.command
        tilted, tilt = self.tilt.step(memory.tilted, believed.uav, command, t)
        return memory._replace(tilted=tilted), orders._replace(velocity=command, tilt=tilt)

    def _told(self, supervision: Supervision, believed: WorldState, flies: bool) -> Supervision:
        """The net knows what was really sent."""
        if flies and self.team:
            return supervision
        ugvs = [NOTHING if self.team else _as_it_goes(ugv) for ugv in believed.ugvs]
        instead = Commands(NOTHING if flies else HOVER, tuple(ugvs))
        return supervision._replace(net=self.supervisor.net.overruled(supervision.net, believed, instead))

    def _send(self, memory: Memory, t: float, orders: Orders, said: Said) -> tuple[Memory, Said]:
        vehicle, datagrams = self.vehicle.say(memory.vehicle, t, orders)
        said = replace(said, datagrams=datagrams, complaint=memory.complaint)
        return memory._replace(vehicle=vehicle, t=t), said


def _believed(supervision: Supervision, t: float) -> WorldState:
    """All vehicles as the watchdog believes them, at time `t` [s]."""
    uav, *ugvs = (track.trusted for track in supervision.watch.tracks)
    return WorldState(t, uav, tuple(ugvs))


def _as_it_goes(ugv: Any) -> VelocityCommand:
    """A command that comes to what a UGV does."""
    return VelocityCommand(ugv.speed, 0.0, 0.0, ugv.turn_rate)
