"""The records, and the one check at the border."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.errors import FledgeError
from fledge.geometry import Box, Quat, Vec3
from fledge.lookup import ARENAS
from fledge.storage import read_arena
from fledge.world import Arena, Obstacle, UavState, VelocityCommand, check_arena, settle_on_floor

number = st.floats(-10.0, 10.0, allow_subnormal=False)
commands = st.builds(VelocityCommand, number, number, number, number)
FURNISHED = replace(Arena.square(), obstacles=(Obstacle(Box(1.0, 1.5, -2.0, -1.0), 0.5),))


def test_the_square_arena_is_the_papers_with_its_origin_in_the_middle():
    arena = check_arena(Arena.square())
    assert arena.bounds == Box(-5.0, 5.0, -5.0, 5.0)
    assert arena.obstacles == ()


def test_padding_keeps_what_stands_there_and_adds_what_nobody_can_reach():
    padded = FURNISHED.padded(3)
    assert padded.obstacles[:1] == FURNISHED.obstacles
    assert len(padded.obstacles) == 3
    for added in padded.obstacles[1:]:
        assert added.footprint.distance(0.0, 0.0) > 1000.0
    assert FURNISHED.padded(1) == FURNISHED


def furnished(box: Box, height: float = 0.5, times: int = 1) -> Arena:
    return replace(Arena.square(), obstacles=(Obstacle(box, height),) * times)


@pytest.mark.parametrize(
    "box",
    (
        Box(1.0, 0.0, 0.0, 1.0),
        Box(0.0, 1.0, 1.0, 0.0),
        Box(0.0, 0.0, 0.0, 1.0),
        Box(math.nan, 1.0, 0.0, 1.0),
        Box(0.0, 1.0, 0.0, math.nan),
        Box(0.0, math.inf, 0.0, 1.0),
        Box(0.0, 1.0, -math.inf, 1.0),
    ),
)
def test_a_rectangle_must_be_upright_and_finite(box):
    wrong = r"(x|y)_min \S+ m and \1_max \S+ m: valid is a finite \1_min below a finite \1_max"
    with pytest.raises(FledgeError, match=f"bounds has {wrong}"):
        check_arena(Arena(box, 6.0))
    with pytest.raises(FledgeError, match=f"obstacle 1 has {wrong}"):
        check_arena(furnished(box))


@pytest.mark.parametrize("height", (0.0, -1.0, math.nan, math.inf))
def test_a_height_must_be_positive_and_finite(height):
    with pytest.raises(FledgeError, match=rf"ceiling \[m\] is {height}: valid is a positive number"):
        check_arena(replace(Arena.square(), ceiling=height))
    with pytest.raises(FledgeError, match=rf"height of obstacle 1 \[m\] is {height}: valid is a positive"):
        check_arena(furnished(Box(0.0, 1.0, 0.0, 1.0), height))


@given(st.floats(-12.0, 12.0), st.floats(-12.0, 12.0))
def test_an_obstacle_may_stand_through_a_wall_but_not_behind_it(x, y):
    arena = furnished(Box(x - 1.0, x + 1.0, y - 1.0, y + 1.0))
    if abs(x) < 6.0 and abs(y) < 6.0:
        assert check_arena(arena) is arena
    else:
        with pytest.raises(FledgeError, match=r"obstacle 1 stands outside, at x .*, x -5.0\.\.5.0 m, y"):
            check_arena(arena)


def test_there_may_be_many_obstacles_but_not_any_number():
    box = Box(0.0, 1.0, 0.0, 1.0)
    assert check_arena(furnished(box, times=64))
    with pytest.raises(FledgeError, match="number of obstacles is 65: valid is at most 64"):
        check_arena(furnished(box, times=65))


@given(commands, commands, number)
def test_commands_add_and_scale_by_component(a, b, factor):
    for axis in ("forward", "left", "up", "turn"):
        assert getattr(a + b, axis) == getattr(a, axis) + getattr(b, axis)
        assert getattr(a.scaled(factor), axis) == getattr(a, axis) * factor


def test_hover_changes_nothing_that_it_is_added_to():
    command = VelocityCommand(0.1, 0.2, 0.3, 0.4)
    assert command + VelocityCommand.hover() == command
    assert command.scaled(0.0) == VelocityCommand.hover()


def uav(height, climb) -> UavState:
    zero = 0.0 * height
    return UavState(
        Vec3(1.0 + zero, 2.0 + zero, height),
        Vec3(0.3 + zero, 0.4 + zero, climb),
        Quat(1.0, 0.0, 0.0, 0.0),
        Vec3(zero, zero, zero),
        zero,
    )


@given(number, number)
def test_the_floor_is_hard_and_does_not_bounce(height, climb):
    before = uav(height, climb)
    after = settle_on_floor(before)
    if height >= 0.0:
        assert after == before
    else:
        assert (after.position.z, after.velocity.z) == (0.0, 0.0)
        assert (after.position.x, after.velocity.x) == (before.position.x, before.velocity.x)


def test_an_unknown_altitude_stays_unknown():
    after = settle_on_floor(uav(math.nan, 0.1))
    assert math.isnan(after.position.z) and after.velocity.z == 0.1


def test_the_floor_settles_many_at_once():
    after = settle_on_floor(uav(np.array([-1.0, 2.0]), np.array([-3.0, -3.0])))
    np.testing.assert_array_equal(after.position.z, [0.0, 2.0])
    np.testing.assert_array_equal(after.velocity.z, [0.0, -3.0])


def test_the_lab_is_the_one_in_the_file():
    assert Arena.lab() == read_arena(ARENAS["lab"])
