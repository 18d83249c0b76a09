"""Laws that every safety net obeys."""

from itertools import product

import numpy as np
import pytest

from fledge.geometry import Box, Heading, Quat, Vec3
from fledge.safety import NETS
from fledge.world import Arena, Commands, Obstacle, UavState, UgvState, VelocityCommand, WorldState

EVERY_NET = pytest.mark.parametrize("net", NETS, ids=lambda net: type(net).__name__)

WIDE = Arena(Box(-100.0, 100.0, -100.0, 100.0), 60.0, (Obstacle(Box(80.0, 81.0, 80.0, 81.0), 0.5),))
PLACES = ((-30.0, 0.0), (30.0, 0.0), (0.0, 30.0))
"""Everything is tens of metres from everything."""


def far_apart(forward: float, turn: float) -> WorldState:
    """All vehicles under way as they are told, at a steady speed."""
    still = Vec3(0.0, 0.0, 0.0)
    vx, vy = Heading.of(0.5).to_world(forward, 0.0)
    uav = UavState(Vec3(0.0, 0.0, 30.0), Vec3(vx, vy, 0.0), Quat.from_yaw(0.5), still, 0.0)
    return WorldState(0.0, uav, tuple(UgvState(x, y, 0.5, forward, turn, 0.0) for x, y in PLACES))


def judged(net, world: WorldState, commands: Commands):
    return net.filter(net.init(WIDE, world), world, commands)


SLOW = tuple(
    VelocityCommand(forward, 0.0, 0.0, turn) for forward, turn in product((0.0, 0.1, -0.3, 0.4), (0.0, 0.2))
)


@EVERY_NET
@pytest.mark.parametrize("command", SLOW, ids=str)
def test_far_from_everything_a_net_is_transparent(net, command):
    world = far_apart(command.forward, command.turn)
    _, verdicts = judged(net, world, Commands(command, (command,) * len(PLACES)))
    for verdict in verdicts:
        assert verdict.command == command
        assert not verdict.intervened
        assert verdict.reason == 0
        assert verdict.clearance > 10.0


@EVERY_NET
def test_there_is_one_verdict_per_vehicle_in_their_order(net):
    told = tuple(VelocityCommand(0.1 * (i + 1), 0.0, 0.0, 0.0) for i in range(len(PLACES)))
    commands = Commands(VelocityCommand(0.0, 0.0, 0.2, 0.0), told)
    _, verdicts = judged(net, far_apart(0.1, 0.0), commands)
    assert [verdict.command for verdict in verdicts] == [commands.uav, *told]


@EVERY_NET
def test_a_net_depends_on_its_inputs_only(net):
    world = far_apart(0.2, 0.1)
    commands = Commands(SLOW[2], (SLOW[3],) * len(PLACES))
    memory = net.init(WIDE, world)
    once, again = net.filter(memory, world, commands), net.filter(memory, world, commands)
    np.testing.assert_equal(once, again)


@EVERY_NET
def test_far_from_everything_a_net_stays_transparent_for_as_long_as_it_is_asked(net):
    world, commands = far_apart(0.0, 0.0), Commands(SLOW[0], (SLOW[0],) * len(PLACES))
    memory = net.init(WIDE, world)
    for _ in range(200):
        memory, verdicts = net.filter(memory, world, commands)
        assert not any(verdict.intervened for verdict in verdicts)
