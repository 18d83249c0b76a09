"""The paper's rule, to the letter, and its dead ends: each is a test, so that nobody mends them here unawares."""

import math

import pytest

from fledge.engines import PLAIN
from fledge.geometry import Box, Quat, Vec3
from fledge.safety import PaperNet
from fledge.simulation import TICK, Rig, fly_tick
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

NET = PaperNet()
BOX = Box(-0.5, 0.5, -1.0, 1.0)
ARENA = Arena(Box(-5.0, 5.0, -5.0, 5.0), 6.0, (Obstacle(Box(3.0, 3.2, 3.0, 3.2), 1.0), Obstacle(BOX, 0.5)))
STILL = Vec3(0.0, 0.0, 0.0)
HOVER = VelocityCommand.hover()
TINY = 1e-6


def world(x=-3.0, y=-3.0, z=2.0, yaw=0.0, ugvs=((-3.0, 3.0, 0.0),)) -> WorldState:
    uav = UavState(Vec3(x, y, z), STILL, Quat.from_yaw(yaw), STILL, 0.0)
    return WorldState(0.0, uav, tuple(UgvState(*pose, 0.0, 0.0, 0.0) for pose in ugvs))


def moving(forward=0.0, left=0.0, up=0.0, turn=0.0) -> VelocityCommand:
    return VelocityCommand(forward, left, up, turn)


def uav_verdict(scene: WorldState, command: VelocityCommand, net=NET, arena=ARENA):
    _, verdicts = net.filter(net.init(arena, scene), scene, Commands(command, (HOVER,) * len(scene.ugvs)))
    return verdicts[0]


def ugv_verdict(pose: tuple[float, float, float], command: VelocityCommand, net=NET, arena=ARENA):
    scene = world(ugvs=(pose,))
    return net.filter(net.init(arena, scene), scene, Commands(HOVER, (command,)))[1][1]


def eta(x: float, y: float) -> bool:
    """Eq. 1 for a UAV that only climbs, so that it stays where it is."""
    verdict = uav_verdict(world(x, y), moving(up=0.1))
    assert verdict.command == (HOVER if verdict.intervened else moving(up=0.1))
    return bool(verdict.intervened)


@pytest.mark.parametrize(
    "x, y, unsafe",
    (
        (0.0, 0.0, True),
        (-1.0 + TINY, 0.0, True),
        (-1.0 - TINY, 0.0, False),
        (1.0 - TINY, 0.0, True),
        (1.0 + TINY, 0.0, False),
        (0.0, -1.5 + TINY, True),
        (0.0, -1.5 - TINY, False),
        (0.0, 1.5 - TINY, True),
        (0.0, 1.5 + TINY, False),
        (3.1, 3.1, True),  # any obstacle counts, not only one that all share
        (-4.5 - TINY, 0.0, True),
        (-4.5 + TINY, 0.0, False),
        (0.0, 4.5 + TINY, True),
        (0.0, 4.5 - TINY, False),
    ),
)
def test_a_place_is_unsafe_within_the_margin_of_a_rectangle_or_a_boundary(x, y, unsafe):
    assert eta(x, y) == unsafe


def test_what_counts_is_where_the_next_period_ends():
    margin = -1.0  # of the box, from the west
    assert uav_verdict(world(margin - 0.009, 0.0), moving(forward=1.0)).intervened
    assert not uav_verdict(world(margin - 0.011, 0.0), moving(forward=1.0)).intervened


@pytest.mark.parametrize(
    "yaw, command",
    (
        (0.0, moving(forward=1.0)),
        (math.pi / 2, moving(left=-1.0)),
        (math.pi, moving(forward=-1.0)),
        (-math.pi / 2, moving(left=1.0)),
    ),
)
def test_a_command_is_turned_into_the_world(yaw, command):
    verdict = uav_verdict(world(-1.005, 0.0, yaw=yaw), command)
    assert verdict.command == HOVER and verdict.reason == Reason.OBSTACLE


def test_a_ugv_is_predicted_along_its_nose_and_immobilised():
    near = -1.005
    assert ugv_verdict((near, 0.0, 0.0), moving(forward=1.0, turn=0.3)).command == HOVER
    for pose, command in (
        ((near, 0.0, math.pi), moving(forward=1.0)),
        ((near, 0.0, math.pi / 2), moving(forward=1.0)),
        ((near, 0.0, 0.0), moving(left=1.0)),  # no UGV obeys this
    ):
        assert not ugv_verdict(pose, command).intervened


def test_a_verdict_says_why_and_how_near_the_centre_is():
    wall, box = uav_verdict(world(-4.9, 0.0), moving(up=0.1)), uav_verdict(world(-0.8, 0.0), moving(up=0.1))
    assert (wall.reason, box.reason) == (Reason.WALL, Reason.OBSTACLE)
    assert wall.clearance == pytest.approx(0.1) and box.clearance == pytest.approx(0.3)


def test_who_stands_still_already_is_not_stopped():
    verdict = uav_verdict(world(0.0, 0.0), HOVER)
    assert not verdict.intervened and verdict.reason == Reason.NONE


# Dead ends.


def test_to_touch_the_margin_is_safe():
    assert not eta(-1.0, 0.0)
    assert not eta(-4.5, 0.0)


def test_the_margin_is_wider_at_corners():
    """A square's corner is 1.41 times as far away as its sides."""
    x, y = BOX.x_max + 0.49, BOX.y_max + 0.49
    assert BOX.distance(x, y) > 1.38 * NET.margin
    assert eta(x, y)


@pytest.mark.parametrize(
    "lost", (moving(forward=math.nan), moving(left=math.nan), moving(math.nan, math.nan))
)
def test_what_is_no_number_counts_as_safe_even_inside_an_obstacle(lost):
    assert eta(0.0, 0.0)
    verdict = uav_verdict(world(0.0, 0.0, yaw=0.3), lost)
    assert not verdict.intervened and verdict.command is lost
    assert not uav_verdict(world(math.nan, math.nan), moving(forward=1.0)).intervened


def test_it_jumps_over_what_is_thinner_than_a_step():
    """A speed of 1 m/s and no margin over a sheet of metal; at the paper's margin, numbers no vehicle obeys."""
    sheet = Arena(ARENA.bounds, 6.0, (Obstacle(Box(0.0, 0.004, -1.0, 1.0), 2.0),))
    thin = PaperNet(margin=0.0)
    assert not uav_verdict(world(-0.003, 0.0), moving(forward=1.0), thin, sheet).intervened
    assert not uav_verdict(world(-1.5, 0.0), moving(forward=300.0)).intervened


def test_a_picture_s_upper_edge_silences_it():
    """In a picture y points down: "upper" is less than "lower". Read literally where y points up, nothing is unsafe."""
    upside_down = Arena(ARENA.bounds, 6.0, (Obstacle(Box(-0.5, 0.5, 1.0, -1.0), 0.5),))
    assert eta(0.0, 0.0)
    assert not uav_verdict(world(0.0, 0.0), moving(up=0.1), arena=upside_down).intervened


def test_it_knows_no_altitude():
    assert uav_verdict(world(0.0, 0.0, z=3.0), moving(up=0.1)).intervened  # 2.5 m above a low box
    for z, up in ((0.01, -0.5), (5.99, 0.5)):
        assert not uav_verdict(world(z=z), moving(up=up)).intervened


def test_it_sees_no_other_vehicle():
    scene = world(-2.5, 0.0, 0.2, ugvs=((-2.0, 0.0, math.pi), (-2.0, 0.6, -math.pi / 2)))
    at_each_other = Commands(moving(forward=1.0), (moving(forward=0.5),) * 2)
    _, verdicts = NET.filter(NET.init(ARENA, scene), scene, at_each_other)
    assert not any(verdict.intervened for verdict in verdicts)


def test_who_overshoots_is_never_let_out_again():
    """The margin absorbs: a vehicle comes to rest inside, where one period of any command ends inside as well."""
    rig, scene, sent = Rig(), world(-3.0, 0.0), []
    uav, memory = rig.uav.init(scene.uav), NET.init(ARENA, scene)
    parked = (HOVER,) * len(rig.formation.fleet)
    scene = WorldState(0.0, scene.uav, tuple(UgvState(-3.0, 3.0, 0.0, 0.0, 0.0, 0.0) for _ in parked))
    for tick in range(800):
        # Full speed at the box, then full speed away from it.
        told = Commands(moving(forward=1.0 if tick < 300 else -1.0), parked)
        memory, verdicts = NET.filter(memory, scene, told)
        sent.append(verdicts[0].command)
        obeyed = Commands(sent[-1], parked)
        uav, scene = fly_tick(rig, uav, scene, obeyed, STILL, (tick + 1) * TICK, PLAIN)
    assert sent[100] == moving(forward=1.0)
    assert sent[300:] == [HOVER] * 500
    assert scene.uav.position.x > -1.0 + 0.1
