"""The barrier net's own rule: the smallest change."""

import numpy as np
import pytest
from aloft import HALL, HOVER, SPREAD, always, fly, world
from hypothesis import given
from hypothesis import strategies as st

from fledge.dynamics import P3_DX
from fledge.geometry import Box
from fledge.safety import Barrier, UgvStop
from fledge.safety.barrier import HalfPlane, nearest
from fledge.safety.tube import UgvMotion, UgvSent
from fledge.world import Arena, Commands, VelocityCommand

ANGLES, BOUNDS = st.floats(0.0, 2.0 * np.pi), st.floats(-1.0, 0.2)
PLANES = st.lists(st.tuples(ANGLES, BOUNDS), min_size=1, max_size=3)


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), PLANES)
def test_up_to_three_half_planes_are_met_exactly(x, y, drawn):
    planes = [HalfPlane(float(np.cos(a)), float(np.sin(a)), b) for a, b in drawn]
    grid = np.linspace(-3.0, 3.0, 241)
    gx, gy = np.meshgrid(grid, grid)
    inside = np.all([p.lacks(gx, gy) <= 0.0 for p in planes], axis=0)
    if not inside.any():
        return
    cx, cy = nearest(x, y, planes)
    assert all(plane.lacks(cx, cy) <= 1e-5 for plane in planes)
    best = np.hypot(gx - x, gy - y)[inside].min()
    assert np.hypot(cx - x, cy - y) <= best + 1e-6


def test_along_a_wall_it_lets_slide():
    log = fly(Barrier(), world((4.0, -3.0, 3.0)), always(VelocityCommand(0.5, 0.5, 0.0, 0.0)), 8.0)
    assert log.least[0] > 0.0
    assert log.last.uav.position.y > 0.0, "the part of the command along the wall goes on"


def test_height_is_clipped_on_its_own():
    log = fly(Barrier(), world((-3.0, 0.0, 5.0)), always(VelocityCommand(0.5, 0.0, 0.5, 0.0)), 5.0)
    assert log.least[0] > 0.0
    assert log.last.uav.position.x > -1.5


def test_a_ugv_is_slowed_down_and_not_stopped_from_afar():
    ugvs = ((1.0, 0.0, 0.0), (-3.0, -3.0, 0.0), (-3.0, 3.0, 0.0))
    log = fly(Barrier(), world((0.0, 0.0, 3.0), ugvs), always(ugv=VelocityCommand(0.8, 0.0, 0.0, 0.0)), 8.0)
    speeds = [verdicts[1].command.forward for verdicts in log.verdicts if verdicts[1].intervened]
    assert 0.0 < log.least[1] < 0.15
    assert len({round(speed, 2) for speed in speeds}) > 10, "slower and slower"


def test_the_change_is_the_smallest():
    net, start = Barrier(), world((4.4, 0.0, 3.0))
    told = VelocityCommand(1.0, 0.3, 0.1, 0.0)
    _, verdicts = net.filter(net.init(HALL, start), start, Commands(told, (HOVER,) * 3))
    sent = verdicts[0].command
    assert 0.0 < sent.forward < 1.0
    assert (sent.left, sent.up) == pytest.approx((0.3, 0.1))


def test_where_the_barriers_contradict_each_other_it_brakes():
    """Between two walls 0.6 m apart each wants the UAV to leave it: nothing does, nor does the way along."""
    gap = Arena(Box(-0.3, 0.3, -5.0, 5.0), 6.0)
    start, along = world((0.0, 0.0, 3.0)), VelocityCommand(0.0, 0.5, 0.0, 0.0)
    _, verdicts = Barrier().filter(Barrier().init(gap, start), start, Commands(along, (HOVER,) * 3))
    assert verdicts[0].intervened and verdicts[0].command.left == 0.0


def test_the_speed_of_a_ugv_uses_up_the_room_but_for_a_reserve():
    net, stop = Barrier(), UgvStop.of(P3_DX)
    braking = stop.acceleration - net.contract.disturbance
    assert net._speed(net.reserve, 1.0, stop) == 0.0
    for room in (0.2, 1.0):
        for share in (1.0, 0.4):
            v = net._speed(room, share, stop)
            assert share * (v * stop.hold_over + v * v / (2.0 * braking) + net.reserve) == pytest.approx(room)


def test_the_reserve_is_kept_before_what_is_just_out_of_reach():
    net, told = Barrier(), 0.5
    stop, start = net.ugvs[0], world()
    for beyond, most in ((0.02, 0.49), (0.06, told)):
        reach = UgvMotion.of(net.contract, stop, start.ugvs[0], UgvSent.nothing(0.0), 0.0).reach(told)
        x = 5.0 - stop.radius - net.contract.position_error - reach - beyond
        seen = world(ugvs=((x, -4.8 + stop.radius, 0.0), *SPREAD[1:]))  # a wall at its side, too
        commands = Commands(HOVER, (VelocityCommand(told, 0.0, 0.0, 0.0), HOVER, HOVER))
        _, verdicts = net.filter(net.init(HALL, seen), seen, commands)
        assert 0.4 < verdicts[1].command.forward <= most
        assert verdicts[1].intervened == (most < told)


def test_a_face_that_a_ugv_does_not_go_to_does_not_slow_it_down():
    assert Barrier()._speed(0.0, 0.0, UgvStop.of(P3_DX)) >= P3_DX.max_speed
