"""What nets make of being overruled, and of poses that are too old to hold by."""

from dataclasses import replace
from math import nan

import numpy as np
import pytest

from fledge.geometry import Box, Quat, Vec3
from fledge.safety import NETS, Barrier, StopTube
from fledge.world import Arena, Commands, UavState, UgvState, VelocityCommand, WorldState

STILL = Vec3(0.0, 0.0, 0.0)
NOTHING = VelocityCommand(nan, nan, nan, nan)
HOVER = VelocityCommand.hover()
SLOWLY = VelocityCommand(0.15, 0.0, 0.0, 0.0)
ARENA = Arena(Box(-50.0, 5.0, -50.0, 50.0), 50.0)
FAR = tuple(UgvState(-30.0 + 10.0 * i, -30.0, 0.0, 0.0, 0.0, 0.0) for i in range(3))
STEERING = pytest.mark.parametrize("net", (StopTube(), Barrier()), ids=lambda net: type(net).__name__)


def world(x: float, age: float = 0.0, z: float = 5.0) -> WorldState:
    """The UAV stands `5 - x` m from the eastern wall."""
    uav = UavState(Vec3(x, 0.0, z), STILL, Quat(1.0, 0.0, 0.0, 0.0), STILL, 0.0)
    return WorldState(age, uav, tuple(replace(ugv, stamp=age) for ugv in FAR))


def told(uav: VelocityCommand) -> Commands:
    return Commands(uav, (HOVER,) * 3)


def obeyed(net, memory, seen, instead: Commands, ticks: int = 10):
    """The memory after the net was asked for nothing and something else was sent."""
    for _ in range(ticks):
        memory, _ = net.filter(memory, seen, told(NOTHING))
        memory = net.overruled(memory, seen, instead)
    return memory


@pytest.mark.parametrize("net", NETS, ids=lambda net: type(net).__name__)
def test_who_was_obeyed_remembers_what_it_said(net):
    seen = world(4.0)
    memory, _ = net.filter(net.init(ARENA, seen), seen, told(SLOWLY))
    np.testing.assert_equal(net.overruled(memory, seen, Commands(NOTHING, (NOTHING,) * 3)), memory)


@STEERING
def test_the_next_stop_is_reckoned_from_what_was_really_sent(net):
    seen, passed = world(4.55), []
    for speed in (0.0, 1.0):
        instead = told(VelocityCommand(speed, 0.0, 0.0, 0.0))
        memory = obeyed(net, net.init(ARENA, seen), seen, instead)
        _, (verdict, *_) = net.filter(memory, seen, told(SLOWLY))
        passed.append(verdict.command.forward)
    assert passed[0] > 0.14 and passed[1] < 0.1


@STEERING
def test_so_it_is_for_ugvs(net):
    seen, passed = replace(world(0.0), ugvs=(replace(FAR[0], x=4.46, y=20.0), *FAR[1:])), []
    for speed in (0.0, 0.8):
        instead = Commands(HOVER, (VelocityCommand(speed, 0.0, 0.0, 0.0), HOVER, HOVER))
        memory = obeyed(net, net.init(ARENA, seen), seen, instead)
        _, (_, verdict, *_) = net.filter(memory, seen, Commands(HOVER, (SLOWLY, HOVER, HOVER)))
        passed.append(verdict.command.forward)
    assert passed[0] > passed[1] + 0.015


@STEERING
def test_who_was_sent_elsewhere_holds_no_point_but_who_only_came_down_does(net):
    """A steady push has driven it 0.1 m to the west since."""
    seen, pushed = world(0.0), world(-0.1)
    memory, _ = net.filter(net.init(ARENA, seen), seen, told(NOTHING))
    for instead, returns in ((NOTHING, True), (replace(NOTHING, up=-0.3), True), (HOVER, False)):
        after = net.overruled(memory, seen, Commands(instead, (NOTHING,) * 3))
        _, (verdict, *_) = net.filter(after, pushed, told(NOTHING))
        assert (verdict.command.forward > 0.1) == returns, instead


@STEERING
@pytest.mark.parametrize(
    "x, z, age, away",
    (
        (4.6, 5.0, 0.5, (-0.1, 0.0)),  # the wall is near
        (4.5, 5.0, 1.9, (-0.1, 0.0)),  # near enough for what it may have drifted
        (4.5, 5.0, 0.2, (0.0, 0.0)),
        (0.0, 5.0, 1.9, (0.0, 0.0)),  # there is nothing
        (4.6, 0.2, 0.5, (-0.1, 0.1)),  # the floor is near, too
        (4.6, 5.0, 2.1, (0.0, 0.0)),  # somebody should have landed it
    ),
)
def test_a_uav_that_sees_nothing_goes_gently_away_from_what_is_near(net, x, z, age, away):
    seen = world(x, age, z)
    for wish in (NOTHING, SLOWLY, VelocityCommand(1.0, 0.0, 0.0, 0.0)):
        _, (verdict, *_) = net.filter(net.init(ARENA, seen), seen, told(wish))
        command = verdict.command
        assert (command.forward, command.up) == pytest.approx(away)
        assert (command.left, command.turn) == (0.0, 0.0)


@STEERING
def test_between_two_things_it_stays(net):
    seen, slot = world(4.5, 0.5), Arena(Box(4.0, 5.0, -50.0, 50.0), 50.0)
    _, (verdict, *_) = net.filter(net.init(slot, seen), seen, told(NOTHING))
    assert verdict.command == HOVER
