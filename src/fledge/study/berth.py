"""How wide a berth a net gives to walls, what that leaves of an arena, and whether a vehicle gets out of it again.

Both are measured from outside, by asking the net, and so hold for anybody's: the margin is the largest distance from a
wall at which a steady approach is changed; the stand-off is a UAV flown at a wall and called back.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fledge.clearance import from_things
from fledge.conditions import Conditions
from fledge.dynamics import UGV_FLEET, Quadrotor
from fledge.engines import fly_plain
from fledge.geometry import Box, Quat, Vec3
from fledge.manoeuvres import FormationTrack, Plan
from fledge.observation import ROW_RATE, Action, Observation
from fledge.pilots import AbstractPilot
from fledge.pilots.base import Noise
from fledge.room import check_room, free_share
from fledge.safety import AbstractNet
from fledge.simulation import TICK, Case, Crew, Rig
from fledge.world import Arena, Commands, UavState, UgvState, VelocityCommand, WorldState

SPEEDS = (0.0, 0.25, 0.5, 1.0)
"""[m/s]; the last is beyond a UGV."""
CREEP = 1e-3
"""[m/s] in place of none at all: a net has nothing to say of a vehicle that wants nothing."""
HALL = Arena(Box(-50.0, 50.0, -50.0, 50.0), 100.0)
"""With room for everybody to be out of everybody's way."""
FARTHEST = 5.0
"""[m]."""
APPROACH = 100
"""Ticks for which an approach has been going on: ten times as long as any net remembers."""


def margin(net: AbstractNet, vehicle: int, speed: float) -> float:
    """How far [m] from a wall a vehicle's centre must be that approaches it, head-on at `speed` [m/s]; 0 is the UAV.

    Found to a millimetre; the motion is steady, its tilt neglected.
    """
    commands = _commands(vehicle, speed)
    memory = net.init(HALL, _approach(vehicle, speed, 2.0 * FARTHEST, 0.0))
    for tick in range(APPROACH):
        memory, _ = net.filter(memory, _approach(vehicle, speed, 2.0 * FARTHEST, tick * TICK), commands)
    low, high = 0.0, FARTHEST
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        _, verdicts = net.filter(memory, _approach(vehicle, speed, middle, APPROACH * TICK), commands)
        low, high = (middle, high) if verdicts[vehicle].intervened else (low, middle)
    return high


def _commands(vehicle: int, speed: float) -> Commands:
    """One vehicle goes ahead, all others stay."""
    ahead, hover = VelocityCommand(speed, 0.0, 0.0, 0.0), VelocityCommand.hover()
    uav, *ugvs = (ahead if i == vehicle else hover for i in range(1 + len(UGV_FLEET)))
    return Commands(uav, tuple(ugvs))


def _approach(vehicle: int, speed: float, distance: float, t: float) -> WorldState:
    """One vehicle before the eastern wall, all others at rest and far away."""
    x = HALL.bounds.x_max - distance
    still, level = Vec3(0.0, 0.0, 0.0), Quat.from_yaw(0.0)
    uav = UavState(Vec3(0.0, 0.0, 50.0), still, level, still, t)
    ugvs = [UgvState(-20.0, 20.0 * i, 0.0, 0.0, 0.0, t) for i in range(len(UGV_FLEET))]
    if vehicle:
        ugvs[vehicle - 1] = replace(ugvs[vehicle - 1], x=x, speed=speed)
    else:
        uav = replace(uav, position=Vec3(x, 0.0, 50.0), velocity=Vec3(speed, 0.0, 0.0))
    return WorldState(t, uav, tuple(ugvs))


def reach(nets: Mapping[str, AbstractNet], arena: Arena) -> dict[str, Any]:
    """By net and vehicle: at each speed, the margin and the share of the arena's floor that it leaves."""
    return {
        name: {
            "uav": [_reach(net, arena, 0, Quadrotor().radius, speed) for speed in SPEEDS],
            "ugv": [_reach(net, arena, 1, UGV_FLEET[0].radius, speed) for speed in SPEEDS[:-1]],
        }
        for name, net in nets.items()
    }


def _reach(net: AbstractNet, arena: Arena, vehicle: int, radius: float, speed: float) -> dict[str, float]:
    """Where a net keeps less than the hull, the hull is what keeps the centre off."""
    kept = max(margin(net, vehicle, max(speed, CREEP)), radius)
    return {"speed": speed, "margin_m": kept, "share": float(free_share(arena, kept))}


def announced(name: str, net: AbstractNet, arena: Arena) -> str:
    """Where a net would stop whoever is flown head-on at a wall, in a sentence.

    Raises:
        FledgeError: it leaves a vehicle no room in the arena, not even at rest.
    """
    kinds = (("UAV", 0, Quadrotor().radius, SPEEDS[1:]), ("UGV", 1, UGV_FLEET[0].radius, SPEEDS[1:-1]))
    said = []
    for who, vehicle, radius, speeds in kinds:
        check_room(arena, max(margin(net, vehicle, CREEP), radius))
        stops = ((speed, margin(net, vehicle, speed) - radius) for speed in speeds)
        told = ", ".join(f"{gap:.2f} m at {speed:g} m/s" for speed, gap in stops if gap > 0.0)
        said.append(f"{who} {told or 'never'}")
    return f"{name} steps in so far before a wall, hull to wall: " + "; ".join(said)


# The stand-off.

PUSH, PULL = 5.0, 5.0
"""[s] towards the wall at full stick, and back at half of it."""


@dataclass(frozen=True, slots=True)
class ThereAndBack(AbstractPilot):
    """Flies at the wall, and then away from it."""

    name = "there-and-back"

    def init(self) -> float:
        """Rows so far."""
        return 0.0

    def act(self, memory: float, observation: Observation, noise: Noise) -> tuple[float, Action]:
        """Whatever there is to be seen."""
        return memory + 1.0, Action(1.0 if memory < PUSH * ROW_RATE else -0.5, 0.0, 0.0, 0.0)


def stand_off(nets: Mapping[str, AbstractNet], rig: Rig = Rig()) -> dict[str, Any]:
    """The gap between hull and wall over time, behind each net, on a perfect day in the lab's arena."""
    rows = round((PUSH + PULL) * ROW_RATE)
    still = np.zeros(rows)
    track = FormationTrack(still - 1.5, still, still, still, still + 0.8, still)
    case = Case(Plan(Arena.lab(), track, 0.0), Conditions())
    gaps = {}
    for name, net in nets.items():
        world = fly_plain(case, Crew(ThereAndBack(), net=net), (0,), rig).world
        gaps[name] = np.asarray(
            from_things(case.plan.arena, world, rig.uav, rig.formation.fleet)[0].gap
        ).tolist()
    return {"t_s": (np.arange(rows) / ROW_RATE).tolist(), "gap_m": gaps, "called_back_s": PUSH}
