"""The stop-tube nets in flight: what each of them must do, in plain Python."""

from dataclasses import replace
from math import hypot, inf, nan

import numpy as np
import pytest
from aloft import HALL, HOVER, SPREAD, STILL, always, fly, world

from fledge.geometry import Box, Vec3
from fledge.safety import Barrier, StopTube
from fledge.world import Commands, Obstacle, Reason, VelocityCommand

BOTH = pytest.mark.parametrize("net", (StopTube(), Barrier()), ids=lambda net: type(net).__name__)
EAST = VelocityCommand(1.0, 0.0, 0.0, 0.0)
AHEAD = VelocityCommand(1.0, 0.0, 0.0, 0.0)
BACK = VelocityCommand(-0.3, 0.0, 0.0, 0.0)
BOX = replace(HALL, obstacles=(Obstacle(Box(1.0, 2.0, -1.0, 1.0), 4.0),))

WAYS = {
    "east": (VelocityCommand(1.0, 0.0, 0.0, 0.0), (3.0, 0.0, 3.0)),
    "west": (VelocityCommand(-1.0, 0.0, 0.0, 0.0), (-3.0, 0.0, 3.0)),
    "north": (VelocityCommand(0.0, 1.0, 0.0, 0.0), (0.0, 3.0, 3.0)),
    "south": (VelocityCommand(0.0, -1.0, 0.0, 0.0), (0.0, -3.0, 3.0)),
    "up": (VelocityCommand(0.0, 0.0, 0.5, 0.0), (0.0, 0.0, 4.5)),
    "down": (VelocityCommand(0.0, 0.0, -0.5, 0.0), (4.0, 4.0, 1.5)),
    "onto a UGV": (VelocityCommand(0.0, 0.0, -0.5, 0.0), (-2.0, -2.0, 1.5)),
    "corner": (VelocityCommand(1.0, 1.0, 0.0, 0.0), (3.5, 3.0, 3.0)),
}


@BOTH
@pytest.mark.parametrize("way", WAYS)
def test_full_speed_at_anything_ends_before_it_and_not_far_before(net, way):
    told, start = WAYS[way]
    log = fly(net, world(start), always(told), 6.0)
    assert 0.0 < log.least[0] < 0.35
    v = log.last.uav.velocity
    assert hypot(v.x, v.y, v.z) < 0.05, "it stands"


@BOTH
@pytest.mark.parametrize(
    "direction", (Vec3(1.0, 0.0, 0.0), Vec3(0.0, -1.0, 0.0), Vec3(0.0, 0.0, -1.0)), ids=str
)
def test_a_steady_push_does_not_drift_it_through_the_margin(net, direction):
    start = (4.3 * direction.x, 4.3 * direction.y, 3.0 if direction.z == 0.0 else 0.7)
    log = fly(net, world(start), always(), 15.0, push=direction * net.contract.disturbance)
    assert log.least[0] > 0.0


@BOTH
@pytest.mark.parametrize("broken", (nan, inf, -inf, 1e30))
def test_garbage_at_speed_is_braked(net, broken):
    garbage = VelocityCommand(broken, 0.0, 0.0, 0.0)

    def policy(w):
        told = (AHEAD if w.t < 1.0 else garbage, HOVER, HOVER)
        return Commands(EAST if w.t < 1.5 else garbage, told)

    log = fly(net, world((0.0, 0.0, 3.0), ((1.0, -2.0, 0.0), *SPREAD[1:])), policy, 4.0)
    assert min(log.least) > 0.0
    if np.isnan(broken):
        assert log.reasons == {Reason.NOT_FINITE}
        assert abs(log.last.ugvs[0].speed) < 1e-9


@BOTH
def test_a_tall_box_is_stopped_at_and_a_low_one_flown_over(net):
    log = fly(net, world((-1.0, 0.0, 3.0)), always(EAST), 5.0, BOX)
    assert 0.0 < log.least[0] < 0.35
    assert log.reasons == {Reason.OBSTACLE}
    low = replace(BOX, obstacles=(replace(BOX.obstacles[0], height=2.0),))
    log = fly(net, world((-1.0, 0.0, 3.0)), always(EAST), 5.0, low)
    assert log.last.uav.position.x > 3.0, "beyond the box"


@BOTH
def test_the_reason_names_what_is_near(net):
    for way, reason in (("east", Reason.WALL), ("up", Reason.CEILING), ("down", Reason.FLOOR)):
        told, start = WAYS[way]
        assert fly(net, world(start), always(told), 4.0).reasons == {reason}
    told, start = WAYS["onto a UGV"]
    assert fly(net, world(start), always(told), 4.0).reasons == {Reason.VEHICLE}


@BOTH
def test_from_inside_a_margin_it_finds_its_own_way_out(net):
    log = fly(net, world((4.70, 0.0, 3.0)), always(), 6.0)
    assert log.least[0] > 0.0
    assert log.last.uav.position.x < 4.65
    quiet = fly(net, log.anew, always(), 0.5)
    assert not any(verdicts[0].intervened for verdicts in quiet.verdicts)


@BOTH
def test_what_leads_out_passes_at_once(net):
    start = world((4.70, 0.0, 3.0))
    out = VelocityCommand(-0.4, 0.0, 0.0, 0.0)
    _, verdicts = net.filter(net.init(HALL, start), start, Commands(out, STILL.ugvs))
    assert verdicts[0].command == out and not verdicts[0].intervened


@BOTH
def test_a_ugv_stops_before_walls_boxes_and_its_like(net):
    for start, arena in (
        ((3.0, 0.0, 0.0), HALL),
        ((-1.0, 0.0, 0.0), BOX),
        ((-0.5, -2.0, 0.0), HALL),
        ((3.0, 0.0, 3.14159), replace(HALL, bounds=Box(1.5, 5.0, -5.0, 5.0))),
    ):
        ugvs = (start, (2.0, -2.0, 0.0), (2.5, 3.5, 0.0))
        log = fly(net, world((3.0, 3.0, 3.0), ugvs), always(ugv=AHEAD), 6.0, arena)
        assert 0.0 < log.least[1] < 1.6
        assert abs(log.last.ugvs[0].speed) < 0.02


@BOTH
def test_two_ugvs_do_not_meet_and_both_can_part_again(net):
    ugvs = ((-1.5, 0.0, 0.0), (1.5, 0.0, 3.14159), (0.0, 3.5, 0.0))
    both = Commands(HOVER, (AHEAD, AHEAD, HOVER))
    log = fly(net, world((0.0, -3.0, 3.0), ugvs), lambda w: both, 6.0)
    assert 0.0 < log.least[1]
    apart = Commands(HOVER, (BACK, BACK, HOVER))
    after = fly(net, log.anew, lambda w: apart, 4.0)
    assert after.last.ugvs[0].x < log.last.ugvs[0].x - 0.5
    assert after.last.ugvs[1].x > log.last.ugvs[1].x + 0.5


@BOTH
def test_a_ugv_does_not_drive_under_a_uav_that_comes_down(net):
    ugvs = ((-2.0, 0.0, 0.0), (3.0, -3.0, 0.0), (3.0, 3.0, 0.0))
    down = VelocityCommand(0.0, 0.0, -0.5, 0.0)
    log = fly(net, world((0.0, 0.0, 1.0), ugvs), always(down, AHEAD), 6.0)
    assert min(log.least) > 0.0


@BOTH
def test_a_stopped_ugv_may_turn_and_then_drive_away(net):
    start = ((4.3, 0.0, 0.0), (-2.0, -2.0, 0.0), (0.0, 3.5, 0.0))
    turning = VelocityCommand(0.5, 0.0, 0.0, 1.0)
    log = fly(net, world((0.0, 0.0, 3.0), start), always(ugv=turning), 6.0)
    assert log.least[1] > 0.0
    assert log.last.ugvs[0].x < 4.0


@BOTH
def test_old_and_future_data_let_nothing_new_through(net):
    for t in (0.2, -0.2):
        start = replace(world(), t=t)
        _, verdicts = net.filter(net.init(HALL, start), start, Commands(EAST, (AHEAD,) * 3))
        assert [v.command for v in verdicts] == [HOVER] * 4
        assert {v.reason for v in verdicts} == {Reason.STALE}


@BOTH
def test_one_lost_ugv_does_not_stop_those_far_above(net):
    lost = replace(world(), ugvs=(replace(world().ugvs[0], x=nan), *world().ugvs[1:]))
    _, verdicts = net.filter(net.init(HALL, world()), lost, Commands(HOVER, (AHEAD,) * 3))
    assert verdicts[1].command.forward == 0.0
    assert all(np.isfinite(v.command.forward) for v in verdicts)


@BOTH
def test_commands_beyond_the_sticks_are_held_to_them(net):
    start = world()
    _, verdicts = net.filter(
        net.init(HALL, start), start, Commands(VelocityCommand(9.0, 0.0, 0.0, 0.0), (HOVER,) * 3)
    )
    assert verdicts[0].command.forward == net.uav.most and verdicts[0].intervened
