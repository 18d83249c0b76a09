"""The paper's rule, mended: what no longer slips through, and what no mending of this rule can cure."""

import math

import pytest

from fledge.geometry import Box, Quat, Vec3
from fledge.safety import PaperNet, RepairedPaperNet
from fledge.world import (
    Arena,
    Commands,
    Obstacle,
    Reason,
    UavState,
    UgvState,
    VelocityCommand,
    WorldState,
)

NET = RepairedPaperNet()
BOX = Box(-0.5, 0.5, -1.0, 1.0)
ARENA = Arena(Box(-5.0, 5.0, -5.0, 5.0), 6.0, (Obstacle(BOX, 0.5),))
STILL = Vec3(0.0, 0.0, 0.0)
HOVER = VelocityCommand.hover()


def world(x=-3.0, y=-3.0, z=2.0) -> WorldState:
    uav = UavState(Vec3(x, y, z), STILL, Quat(1.0, 0.0, 0.0, 0.0), STILL, 0.0)
    return WorldState(0.0, uav, (UgvState(-3.0, 3.0, 0.0, 0.0, 0.0, 0.0),))


def moving(forward=0.0, left=0.0, up=0.0, turn=0.0) -> VelocityCommand:
    return VelocityCommand(forward, left, up, turn)


def uav_verdict(scene: WorldState, command: VelocityCommand, net=NET, arena=ARENA):
    _, verdicts = net.filter(net.init(arena, scene), scene, Commands(command, (HOVER,)))
    return verdicts[0]


def test_to_touch_the_margin_is_unsafe():
    for x, reason in ((-1.0, Reason.OBSTACLE), (-4.5, Reason.WALL)):
        assert uav_verdict(world(x, 0.0), moving(up=0.1)).reason == reason
        assert not uav_verdict(world(x, 0.0), moving(up=0.1), PaperNet()).intervened


def test_a_step_may_not_jump_over_anything():
    sheet = Arena(ARENA.bounds, 6.0, (Obstacle(Box(0.0, 0.004, -1.0, 1.0), 2.0),))
    thin = RepairedPaperNet(margin=0.0)
    assert uav_verdict(world(-0.003, 0.0), moving(forward=1.0), thin, sheet).command == HOVER
    assert uav_verdict(world(-1.5, 0.0), moving(forward=300.0)).command == HOVER


@pytest.mark.parametrize("lost", (math.nan, math.inf, -math.inf))
@pytest.mark.parametrize("field", VelocityCommand.__slots__)
def test_a_command_that_is_no_number_is_no_command(lost, field):
    verdict = uav_verdict(world(), moving(**{field: lost}))
    assert verdict.command == HOVER and verdict.reason == Reason.NOT_FINITE


def test_a_place_that_is_no_number_is_never_safe():
    verdict = uav_verdict(world(x=math.nan), moving(forward=1.0))
    assert verdict.command == HOVER and verdict.reason == Reason.NOT_FINITE


@pytest.mark.parametrize("box", (Box(-0.5, 0.5, 1.0, -1.0), Box(0.5, -0.5, -1.0, 1.0)))
def test_upside_down_rectangles_are_turned_upright(box):
    upside_down = Arena(Box(5.0, -5.0, 5.0, -5.0), 6.0, (Obstacle(box, 0.5),))
    for x, y in ((0.0, 0.0), (-0.9, 0.0), (-1.1, 0.0), (4.6, 0.0), (0.0, -1.45)):
        got, right = (uav_verdict(world(x, y), moving(up=0.1), arena=arena) for arena in (upside_down, ARENA))
        assert got == right


@pytest.mark.parametrize("x, y", ((-0.9, 0.3), (0.0, 1.4), (4.6, 0.0), (-0.6, 1.2)))
def test_it_stops_whatever_the_verbatim_rule_stops(x, y):
    for command in (moving(1.0), moving(-1.0), moving(0.0, 1.0), moving(0.0, 0.0, -0.5)):
        if uav_verdict(world(x, y), command, PaperNet()).intervened:
            assert uav_verdict(world(x, y), command).intervened


def test_the_margin_absorbs_as_before():
    """One period of full speed out of it still ends in it."""
    inside = world(-0.9, 0.0)
    assert uav_verdict(inside, moving(forward=-1.0)).command == HOVER


def test_altitude_and_other_vehicles_are_as_unseen_as_before():
    assert uav_verdict(world(0.0, 0.0, z=3.0), moving(up=0.1)).intervened
    assert not uav_verdict(world(z=0.01), moving(up=-0.5)).intervened
    scene = world(-3.0, 2.5, 0.2)
    assert not uav_verdict(scene, moving(left=1.0)).intervened
