"""Flights of the lab's controller against a lab of point masses: what the tests of its tick have in common."""

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass, field, replace
from functools import cache
from math import hypot

from standin import SUBJECTS, TICK, Lab, RosLab, lateral

from fledge.lab.control.ardrone_ros import ArDroneRos
from fledge.lab.control.ardrone_udp import ArDroneUdp, entries
from fledge.lab.control.checks import Checks
from fledge.lab.control.eyes import TopicEyes, ViconEyes
from fledge.lab.control.guidance import Guidance
from fledge.lab.control.phases import Phase
from fledge.lab.control.team import Team
from fledge.lab.control.tick import Controller, Said
from fledge.lab.control.tilt import Tilt
from fledge.lab.wire import sticks
from fledge.lab.wire.datagrams import STICKS, Datagram, Heard
from fledge.lab.wire.sticks import Sticks
from fledge.pilots import AbstractPilot, Servo
from fledge.supervision.inputs import Operator
from fledge.supervision.modes import Mode
from fledge.world import Arena, Reason

P, M = Phase, Mode
ARENA = Arena.lab()


def over_udp(pilot: AbstractPilot, unattended=False, **how) -> Controller:
    return Controller(
        ViconEyes(SUBJECTS),
        ArDroneUdp(entries(Tilt(), ARENA.ceiling)),
        Guidance(pilot),
        Checks(ARENA, SUBJECTS, unattended),
        **how,
    )


def over_ros(pilot: AbstractPilot, seed=3) -> tuple[Controller, RosLab]:
    team = Team(lateral(seed))
    corners = team.formation.corners(team._target(0, False), team.plan.orientation)
    lab = RosLab(places=tuple((x, y, team.plan.orientation) for x, y, _, _ in corners))
    controller = Controller(
        TopicEyes(SUBJECTS), ArDroneRos(SUBJECTS[1:]), Guidance(pilot), Checks(ARENA, SUBJECTS), team=team
    )
    return controller, lab


Spoil = Callable[[float, tuple[Datagram, ...]], tuple[Datagram, ...]]


@dataclass
class Flight:
    """A controller, a lab, and somebody at the sticks."""

    controller: Controller = field(default_factory=lambda: over_udp(Servo()))
    lab: Lab = field(default_factory=Lab)
    says: Operator | None = Operator()
    """Of the UAV; None says nothing at all. UGVs are armed with it."""
    spoil: Spoil = lambda t, datagrams: datagrams

    def __post_init__(self) -> None:
        self.memory = self.controller.init()
        self.ticks = 0
        self.heards: list[Heard] = []
        self.saids: list[Said] = []
        self.out: tuple[Datagram, ...] = ()

    def tick(self) -> Said:
        """10 ms."""
        came = [*self.lab.tick(self.out), *self._sticks()]
        heard = Heard(self.lab.t, self.spoil(self.lab.t, tuple(came)))
        self.memory, said = self.controller.step(self.memory, heard)
        self.out = said.datagrams
        self.heards.append(heard)
        self.saids.append(said)
        return said

    def _sticks(self) -> list[Datagram]:
        self.ticks += 1
        if self.says is None or self.ticks % 5:
            return []
        others = (Operator(arm=self.says.arm, land=self.says.land),) * 3
        said = Sticks(self.ticks, self.lab.t, (self.says, *others))
        return [Datagram(STICKS, sticks.encode(said))]

    def go(self, seconds: float, **says) -> "Flight":
        """So much later, the person saying that from now on."""
        if self.says is not None:
            self.says = replace(self.says, **says)
        for _ in range(round(seconds / TICK)):
            self.tick()
        return self

    def until(self, phase: Phase, within=30.0, **says) -> "Flight":
        """Until a phase begins."""
        if self.says is not None:
            self.says = replace(self.says, **says)
        for _ in range(round(within / TICK)):
            if self.tick().phase is phase:
                return self
        raise AssertionError(
            f"{phase} did not begin within {within} s: {self.last.phase}, {self.last.complaint!r}"
        )

    @property
    def last(self) -> Said:
        return self.saids[-1]

    @property
    def mode(self) -> Mode:
        return Mode(int(self.last.decisions[0].mode))

    @property
    def complaints(self) -> set[str]:
        return {said.complaint for said in self.saids}

    def reasons(self, seconds: float) -> set[Reason]:
        """Of the UAV's alarms in the last so many seconds."""
        ticks = self.saids[-round(seconds / TICK) :]
        return {Reason(int(said.decisions[0].alarm.reason)) for said in ticks} - {Reason.NONE}

    @property
    def off(self) -> float:
        """How far the UAV is from above the UGVs' middle [m]."""
        x, y = (sum(place) / 3.0 for place in zip(*self.lab.ugvs, strict=True))
        return hypot(self.lab.air.position.x - x, self.lab.air.position.y - y)


def ready(**how) -> Flight:
    """Nothing is missing, and nobody has armed."""
    flight = Flight(**how)
    flight.go(2.5)
    assert (flight.last.phase, flight.mode, flight.last.complaint) == (P.WAIT, M.READY, "")
    return flight


@cache
def _half_way(phase: Phase) -> Flight:
    """Half a second into a phase; flown once for all tests."""
    if phase is P.TAKE_OFF:
        flight = ready()
    else:
        flight = into(list(Phase)[list(Phase).index(phase) - 1])
    flight.until(phase, arm=1.0).go(0.5)
    return flight


def into(phase: Phase) -> Flight:
    """Half a second into a phase, with a servo for a pilot, on its own from there."""
    flight = _half_way(phase)
    heards, saids = flight.heards, flight.saids
    flight.heards, flight.saids = heards[-5:], saids[-5:]
    own = deepcopy(flight)
    flight.heards, flight.saids = heards, saids
    return own


def flying() -> Flight:
    """Half a second into the pilot's part."""
    return into(P.FLY)
