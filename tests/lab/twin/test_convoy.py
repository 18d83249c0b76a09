"""The UGVs by themselves: they wait for the UAV, follow the track, stop before what is in the way."""

from dataclasses import replace

import numpy as np
import pytest

from fledge.dynamics import UGV_FLEET
from fledge.formation import FormationControl
from fledge.geometry import Box, Quat, Vec3
from fledge.lab.opening import draw
from fledge.lab.twin.convoy import Convoy, Memory
from fledge.world import Arena, Obstacle, UavState, UgvState, WorldState

STILL = Vec3(0.0, 0.0, 0.0)
ROWS = 1200


def team(arena=Arena.lab(), seed=0, rows=ROWS):
    formation = FormationControl()
    return Convoy(draw(np.random.default_rng(seed), arena, rows, formation), formation)


def world(convoy, uav=None):
    """The UGVs on their corners; the UAV there, or overhead."""
    first = convoy.target(0)
    x, y, z = uav or (first.x, first.y, 2.5)
    ugvs = tuple(UgvState(a, b, convoy.plan.orientation, 0.0, 0.0, 0.0) for a, b in convoy.corners())
    return WorldState(0.0, UavState(Vec3(x, y, z), STILL, Quat(1.0, 0.0, 0.0, 0.0), STILL, 0.0), ugvs)


def drive(convoy, memory, now, rows, follow=True):
    """Robots that do as they are told at once; the UAV stays above them, or where it is."""
    for _ in range(rows):
        memory, told = convoy.step(memory, now)
        ugvs = now.ugvs
        for _ in range(5):
            pairs = zip(UGV_FLEET, ugvs, told, strict=True)
            ugvs = tuple(model.step(ugv, command, 0.01) for model, ugv, command in pairs)
        now = replace(now, ugvs=ugvs)
        if follow:
            x, y = (sum(getattr(u, name) for u in ugvs) / 3.0 for name in "xy")
            now = replace(now, uav=replace(now.uav, position=Vec3(x, y, 2.5)))
    return memory, now


def moved(a, b):
    return max(abs(u.x - v.x) + abs(u.y - v.y) for u, v in zip(a.ugvs, b.ugvs, strict=True))


@pytest.mark.parametrize("uav", ((2.5, 1.7, 0.07), (2.5, 1.7, 2.5), (0.0, 0.0, 0.5)))
def test_they_wait_while_the_uav_is_not_overhead(uav):
    convoy = team()
    before = world(convoy, uav)
    memory, after = drive(convoy, Memory(), before, 100, follow=False)
    assert memory.row == 0 and not memory.going
    assert moved(before, after) < 0.01


def test_they_go_once_it_has_been_there_for_a_second_and_follow_the_track():
    convoy = team()
    memory, now = drive(convoy, Memory(), world(convoy), convoy.rows - 1)
    assert not memory.going
    memory, now = drive(convoy, memory, now, 601)
    assert memory.row == 601
    target = convoy.target(memory.row)
    assert sum(u.x for u in now.ugvs) / 3.0 == pytest.approx(target.x, abs=0.25)
    assert sum(u.y for u in now.ugvs) / 3.0 == pytest.approx(target.y, abs=0.25)


def test_the_track_waits_for_a_uav_that_went_away():
    convoy = team()
    memory, now = drive(convoy, Memory(), world(convoy), 200)
    gone = replace(now, uav=replace(now.uav, position=Vec3(now.uav.position.x, now.uav.position.y, 0.5)))
    waiting, later = drive(convoy, memory, gone, 200, follow=False)
    assert waiting.row == memory.row and not waiting.going
    assert max(abs(u.speed) for u in later.ugvs) < 0.05
    again, _ = drive(convoy, waiting, later, 40)
    assert again.row > waiting.row


def test_after_the_last_row_they_stand():
    convoy = team(rows=60)
    memory, now = drive(convoy, Memory(), world(convoy), 200)
    assert memory.row == 59
    _, later = drive(convoy, memory, now, 100)
    assert moved(now, later) < 0.02


def test_a_robot_that_could_not_brake_stops_and_may_still_turn():
    convoy = team()
    ugv = convoy.corners()[0]
    wall = Obstacle(Box(ugv[0] + UGV_FLEET[0].radius + 0.05, ugv[0] + 2.0, ugv[1] - 1.0, ugv[1] + 1.0), 1.0)
    plan = replace(convoy.plan, arena=Arena(Box(-20.0, 20.0, -20.0, 20.0), 4.0, (wall,)))
    convoy = replace(convoy, plan=plan)
    now = world(convoy)
    fast = replace(now, ugvs=(replace(now.ugvs[0], heading=0.0, speed=0.5), *now.ugvs[1:]))
    slow = replace(now, ugvs=(replace(now.ugvs[0], heading=0.0, speed=-0.5), *now.ugvs[1:]))
    ahead = convoy.formation.commands(now.ugvs, convoy.target(0), 0.0, convoy.plan.arena)[0]
    ahead = replace(ahead, forward=0.3, turn=0.4)
    assert convoy._stopped(fast, 0, ahead) == replace(ahead, forward=0.0)
    assert convoy._stopped(slow, 0, replace(ahead, forward=-0.3)).forward == -0.3


@pytest.mark.parametrize("seed", range(4))
def test_they_touch_nothing_among_obstacles(seed):
    boxes = (Obstacle(Box(1.0, 1.3, 0.6, 0.9), 0.5), Obstacle(Box(-1.2, -0.9, -1.6, -1.2), 0.5))
    arena = Arena(Arena.lab().bounds, 4.0, boxes)
    convoy = team(arena, seed)
    memory, now = Memory(), world(convoy)
    for _ in range(20):
        memory, now = drive(convoy, memory, now, 30)
        for ugv, model in zip(now.ugvs, UGV_FLEET, strict=True):
            gaps = [box.footprint.distance(ugv.x, ugv.y) for box in boxes]
            assert min(-arena.bounds.distance(ugv.x, ugv.y), *gaps) > model.radius
