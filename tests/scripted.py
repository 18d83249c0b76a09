"""A supervisor flown by a script, one sentence per change: what the tests of layer two have in common."""

from dataclasses import dataclass, replace
from math import nan

from fledge.geometry import Quat, Vec3
from fledge.safety.base import AbstractNet
from fledge.supervision.inputs import Inputs, Operator
from fledge.supervision.modes import Mode
from fledge.supervision.posts import Decision
from fledge.supervision.supervisor import Supervisor
from fledge.world import (
    Arena,
    Commands,
    Reason,
    UavState,
    UgvState,
    VelocityCommand,
    Verdict,
    WorldState,
)

M, R = Mode, Reason
STILL = Vec3(0.0, 0.0, 0.0)
WISH = VelocityCommand(0.3, 0.0, 0.0, 0.0)
TOO_FAST = VelocityCommand(0.9, 0.0, 0.0, 0.0)
ESCAPE = VelocityCommand(-0.2, 0.0, 0.0, 0.0)
HUMAN = VelocityCommand(-0.4, 0.1, 0.0, 0.2)


@dataclass(frozen=True, slots=True)
class Limit(AbstractNet):
    """Answers everything faster than 0.5 m/s forwards with a way out."""

    def init(self, arena, world):
        return ()

    def filter(self, memory, world, commands):
        return memory, tuple(
            Verdict(ESCAPE, 1.0, float(R.WALL), 0.1) if c.forward > 0.5 else Verdict(c, 0.0, 0.0, 2.0)
            for c in (commands.uav, *commands.ugvs)
        )


NET = Limit()


@dataclass(frozen=True, slots=True)
class Says:
    """One tick's inputs in the words of a scenario; the vehicles stand still."""

    wish: VelocityCommand = WISH
    pose_age: float = 0.0
    reported: float = 0.0
    """Speed that the UAV says it has [m/s]."""
    heard: float = 0.0
    """Age of the link [s]."""
    decided: float = 0.0
    """Age of the decision [s]."""
    battery: float = 1.0
    airborne: float = 1.0
    person: Operator = Operator(arm=1.0)

    def inputs(self, t: float, ugvs: int) -> Inputs:
        stamp = t - self.pose_age
        uav = UavState(
            Vec3(0.0, 0.0, 2.0), Vec3(self.reported, 0.0, 0.0), Quat(1.0, 0.0, 0.0, 0.0), STILL, stamp
        )
        seen = WorldState(t, uav, tuple(UgvState(2.0 + i, 0.0, 0.0, 0.0, 0.0, t) for i in range(ugvs)))
        return Inputs(
            seen,
            Commands(self.wish, (WISH,) * ugvs),
            t - self.decided,
            (self.person,) * (1 + ugvs),
            t - self.heard,
            (self.battery,) * (1 + ugvs),
            self.airborne,
        )

    def but(self, **changed) -> "Says":
        """With some of it changed; what is none of its own is the person's."""
        own = {name: value for name, value in changed.items() if name in type(self).__slots__}
        theirs = {name: value for name, value in changed.items() if name not in own}
        return replace(self, **own, person=replace(self.person, **theirs))


@dataclass(frozen=True, slots=True)
class Flight:
    """A supervisor at work; a value, so that many things can happen after the same beginning."""

    supervisor: Supervisor
    memory: object
    t: float
    says: Says
    decisions: tuple[Decision, ...] = ()
    ugvs: int = 0
    dt: float = 0.02

    @classmethod
    def begin(cls, supervisor: Supervisor = Supervisor(NET), ugvs: int = 0, dt: float = 0.02, **said):
        says = Says().but(**said)
        memory = supervisor.init(Arena.square(), says.inputs(0.0, ugvs).seen)
        return cls(supervisor, memory, 0.0, says, ugvs=ugvs, dt=dt).fly(dt)

    def fly(self, seconds: float, **said) -> "Flight":
        """So much later, the inputs being changed for good."""
        return self.history(seconds, **said)[-1]

    def history(self, seconds: float, **said) -> "list[Flight]":
        """The same tick by tick."""
        flight, says, ticks = self, self.says.but(**said), []
        for _ in range(max(round(seconds / self.dt), 1)):
            t = flight.t + self.dt
            memory, decisions = self.supervisor.step(flight.memory, says.inputs(t, self.ugvs))
            flight = replace(flight, memory=memory, t=t, says=says, decisions=decisions)
            ticks.append(flight)
        return ticks

    @property
    def mode(self) -> Mode:
        return Mode(int(self.decisions[0].mode))

    @property
    def reason(self) -> Reason:
        return Reason(int(self.decisions[0].verdict.reason))

    @property
    def sent(self) -> VelocityCommand:
        return self.decisions[0].verdict.command


def ready(**how) -> Flight:
    return Flight.begin(**how, arm=0.0).fly(1.1)


def auto(**how) -> Flight:
    return ready(**how).fly(0.1, arm=1.0)


BROKEN = VelocityCommand(nan, 0.0, 0.0, 0.0)
WAYS = {
    M.INIT: lambda **how: Flight.begin(**how).fly(1.1),
    M.READY: ready,
    M.AUTO: auto,
    M.SHIELDED: lambda **how: auto(**how).fly(0.1, wish=TOO_FAST),
    M.RECOVER: lambda **how: auto(**how).fly(1.1, wish=BROKEN).fly(1.1, wish=WISH),
    M.HOLD: lambda **how: auto(**how).fly(0.1, wish=BROKEN),
    M.STOPPED: lambda **how: auto(**how).fly(1.1).fly(0.1, stop=1.0).fly(0.1, stop=0.0),
    M.MANUAL: lambda **how: auto(**how).fly(1.1).fly(0.1, switch=1.0).fly(0.1, switch=0.0),
    M.LAND: lambda **how: auto(**how).fly(0.1, land=1.0).fly(0.1, land=0.0),
    M.TERMINATED: lambda **how: auto(**how).fly(0.1, terminate=1.0).fly(0.1, terminate=0.0),
}  # fmt: skip
"""How each mode comes about; what brought it about goes on only where nothing else keeps it."""
