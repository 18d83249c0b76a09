"""The retreat pilot: leads one vehicle away from where an attack has left it, while the others stand.

It shows whether a net keeps its vehicle prisoner. The pilot is no artist: it takes the direction with most room over
the next steps, keeps to it as long as that leads anywhere, and goes slowly. Of directions as roomy as each other it
takes the one that ends in more room: all are, to a UGV below a UAV, and only some lead out from under it. Where no
direction has room enough for the vehicle at a crawl, there is no way out, and nothing is held against the net.

It must not look for a better way as it goes: what was free for 0.6 m is so no more after the first of them, and a
pilot that did turned back for ever in six of 9,447 flights, behind nets that let every command pass. Nor may it insist:
a UAV that was pushed down on its way may end above a UGV that it was to pass.
"""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np

from fledge.clearance import clearances
from fledge.falsification.attacks import drive
from fledge.falsification.scenarios import ROOMY
from fledge.geometry import Vec3
from fledge.scalars import Scalar, where
from fledge.simulation import Rig
from fledge.world import Arena, Commands, UgvState, VelocityCommand, WorldState

STEPS = (0.2, 0.4, 0.6)
"""[m] at which a direction is tried."""
FARTHER = 1e-3
"""What the room at the last step counts beside the least: it decides between equals."""
SPEED, UGV_SHARE = 0.4, 0.25
"""[m/s] of the UAV, and share of a UGV's full speed: slow, as a careful person would."""

_AROUND = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
WAYS = np.concatenate([
    np.stack([np.cos(_AROUND), np.sin(_AROUND), np.zeros(16)], axis=1),
    [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]],
])
"""Unit vectors, shape (18, 3)."""


def place(world: WorldState, focus: Scalar) -> Vec3:
    """Where the vehicle in focus is [m]; a UGV on the floor."""
    found = world.uav.position
    for i, ugv in enumerate(world.ugvs, start=1):
        found = where(focus == float(i), Vec3(ugv.x, ugv.y, 0.0 * ugv.x), found)
    return found


def way_out(rig: Rig, arena: Arena, world: WorldState, focus: Scalar, tried: Vec3) -> tuple[Vec3, Scalar]:
    """(where to lead the vehicle in focus, a unit vector, but not where it was `tried`; whether there is room)."""
    steps = jnp.asarray(WAYS)[:, None] * np.array(STEPS)[:, None]
    room = jax.vmap(lambda step: _room(rig, arena, world, focus, Vec3(step[0], step[1], step[2])))
    rooms = jax.vmap(room)(steps)
    again = WAYS @ jnp.stack([tried.x, tried.y, tried.z]) > 0.99
    least = jnp.where(again, -1.0, rooms.min(axis=1))
    way = jnp.asarray(WAYS)[jnp.argmax(least + FARTHER * rooms[:, -1])]
    return Vec3(way[0], way[1], way[2]), least.max() > where(focus > 0.0, ROOMY[1], ROOMY[0])


def _room(rig: Rig, arena: Arena, world: WorldState, focus: Scalar, step: Vec3) -> Scalar:
    """Free distance [m] of the vehicle in focus after a step [m]; below 0 for a UGV that should go up or down."""
    moved = _moved(world, focus, step)
    gap, *others = (near.gap for near in clearances(arena, moved, rig.uav, rig.formation.fleet))
    for i, other in enumerate(others, start=1):
        gap = where(focus == float(i), other, gap)
    return where((focus > 0.0) & (step.z != 0.0), -1.0, gap)


def _moved(world: WorldState, focus: Scalar, by: Vec3) -> WorldState:
    """The vehicle in focus moved [m]."""

    def moved(ugv: UgvState, mine: Scalar) -> UgvState:
        return replace(ugv, x=ugv.x + where(mine, by.x, 0.0), y=ugv.y + where(mine, by.y, 0.0))

    uav = replace(world.uav, position=world.uav.position + where(focus == 0.0, by, by * 0.0))
    ugvs = tuple(moved(ugv, focus == float(i)) for i, ugv in enumerate(world.ugvs, start=1))
    return WorldState(world.t, uav, ugvs)


def lead(rig: Rig, world: WorldState, focus: Scalar, way: Vec3) -> Commands:
    """The vehicle in focus is led away; the others stand."""
    zero = 0.0 * world.t
    hover = VelocityCommand(zero, zero, zero, zero)
    forward, left = world.uav.attitude.heading().from_world(way.x, way.y)
    away = VelocityCommand(forward, left, way.z, zero).scaled(SPEED)
    ugvs = zip(rig.formation.fleet, world.ugvs, strict=True)
    return Commands(
        where(focus == 0.0, away, hover),
        tuple(
            where(focus == float(i), drive(model, ugv, way * UGV_SHARE), hover)
            for i, (model, ugv) in enumerate(ugvs, start=1)
        ),
    )
