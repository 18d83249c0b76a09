"""No net at all."""

import math

import numpy as np
import pytest

from fledge.geometry import Quat, Vec3
from fledge.safety import NoNet
from fledge.world import Arena, Commands, UavState, UgvState, VelocityCommand, WorldState


def world(t=1.0, ugvs: int = 3) -> WorldState:
    still = Vec3(0.0, 0.0, 0.0)
    uav = UavState(Vec3(0.0, 0.0, 2.0), still, Quat(1.0, 0.0, 0.0, 0.0), still, t)
    return WorldState(t, uav, tuple(UgvState(float(i), 0.0, 0.0, 0.0, 0.0, t) for i in range(ugvs)))


@pytest.mark.parametrize("ugvs", (1, 3, 5))
@pytest.mark.parametrize("value", (0.0, 0.3, 1e9, math.inf))
def test_everything_passes_even_what_should_not(ugvs, value):
    net, scene = NoNet(), world(ugvs=ugvs)
    told = tuple(VelocityCommand(value, float(i), 0.0, 0.0) for i in range(ugvs))
    commands = Commands(VelocityCommand(0.0, 0.0, value, 0.0), told)
    memory, verdicts = net.filter(net.init(Arena.square(), scene), scene, commands)
    assert memory == ()
    assert [verdict.command for verdict in verdicts] == [commands.uav, *commands.ugvs]
    for verdict in verdicts:
        assert not verdict.intervened and verdict.reason == 0
        assert verdict.clearance == math.inf


def test_nan_passes_as_well():
    net, scene = NoNet(), world()
    lost = VelocityCommand(*[math.nan] * 4)
    _, verdicts = net.filter((), scene, Commands(lost, (lost,) * 3))
    assert all(math.isnan(verdict.command.forward) and not verdict.intervened for verdict in verdicts)


def test_the_columns_of_many_scenes_are_as_long_as_the_scenes_are_many():
    net, scene = NoNet(), world(t=np.arange(5.0))
    hover = VelocityCommand.hover()
    _, verdicts = net.filter((), scene, Commands(hover, (hover,) * 3))
    for verdict in verdicts:
        assert verdict.intervened.shape == verdict.reason.shape == verdict.clearance.shape == (5,)
