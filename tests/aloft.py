"""Flights behind a net in plain Python, late and pushed as the contract allows."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import inf

from fledge.clearance import clearances
from fledge.dynamics import UGV_FLEET, Quadrotor
from fledge.engines import PLAIN
from fledge.geometry import Box, Quat, Vec3
from fledge.safety import AbstractNet
from fledge.simulation import TICK, Rig, fly_tick
from fledge.world import Arena, Commands, UavState, UgvState, VelocityCommand, Verdict, WorldState

HOVER = VelocityCommand.hover()
STILL = Commands(HOVER, (HOVER,) * 3)
HALL = Arena(Box(-5.0, 5.0, -5.0, 5.0), 6.0)
SPREAD = ((-2.0, -2.0, 0.0), (2.0, -2.0, 0.0), (0.0, 2.5, 0.0))
"""x, y, heading of UGVs far from everything."""
RIG = Rig()

Policy = Callable[[WorldState], Commands]


def world(
    uav: tuple[float, float, float] = (0.0, 0.0, 3.0),
    ugvs: tuple[tuple[float, float, float], ...] = SPREAD,
    t: float = 0.0,
    velocity: Vec3 = Vec3(0.0, 0.0, 0.0),
) -> WorldState:
    """Everybody at rest, but perhaps for the UAV."""
    none = Vec3(0.0, 0.0, 0.0)
    return WorldState(
        t,
        UavState(Vec3(*uav), velocity, Quat(1.0, 0.0, 0.0, 0.0), none, t),
        tuple(UgvState(x, y, heading, 0.0, 0.0, t) for x, y, heading in ugvs),
    )


@dataclass
class Log:
    """What a flight was like."""

    worlds: list[WorldState] = field(default_factory=list)
    verdicts: list[tuple[Verdict, ...]] = field(default_factory=list)
    least: list[float] = field(default_factory=lambda: [inf] * 4)
    """Smallest gap of every vehicle [m]."""

    @property
    def last(self) -> WorldState:
        return self.worlds[-1]

    @property
    def anew(self) -> WorldState:
        """The last world as the beginning of another flight."""
        w = self.last
        ugvs = tuple(replace(ugv, stamp=0.0) for ugv in w.ugvs)
        return WorldState(0.0, replace(w.uav, stamp=0.0), ugvs)

    @property
    def reasons(self) -> set[float]:
        """Why the UAV was not sent what was proposed, in the last second."""
        return {verdicts[0].reason for verdicts in self.verdicts[-100:]} - {0.0}


def fly(
    net: AbstractNet,
    start: WorldState,
    policy: Policy,
    seconds: float,
    arena: Arena = HALL,
    push: Vec3 = Vec3(0.0, 0.0, 0.0),
    late: int = 5,
) -> Log:
    """Fly; the net sees everything `late` ticks ago, its commands act as much later; `push` is in [m/s^2]."""
    log = Log([start])
    memory, uav = net.init(arena, start), RIG.uav.init(start.uav)
    sent = [STILL] * (late + 1)
    wind = push * (1.0 / Quadrotor().drag)
    for tick in range(round(seconds / TICK)):
        seen = replace(log.worlds[max(tick - late, 0)], t=tick * TICK)
        memory, verdicts = net.filter(memory, seen, policy(log.last))
        sent.append(Commands(verdicts[0].command, tuple(v.command for v in verdicts[1:])))
        uav, now = fly_tick(RIG, uav, log.last, sent[-1 - late], wind, (tick + 1) * TICK, PLAIN)
        log.worlds.append(now)
        log.verdicts.append(verdicts)
        near = clearances(arena, now, RIG.uav, UGV_FLEET)
        log.least = [min(a, b.gap) for a, b in zip(log.least, near, strict=True)]
    return log


def always(uav: VelocityCommand = HOVER, ugv: VelocityCommand = HOVER, which: int = 0) -> Policy:
    """The same command for the UAV, and for one UGV, whatever happens."""
    ugvs = tuple(ugv if i == which else HOVER for i in range(3))
    return lambda world: Commands(uav, ugvs)
