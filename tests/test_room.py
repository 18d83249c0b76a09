"""How much room a margin leaves: the laws of areas, and what closes a corridor."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.errors import FledgeError
from fledge.geometry import Box
from fledge.room import CELL, check_room, free_share, widest
from fledge.world import Arena, Obstacle

pytestmark = pytest.mark.slow

LAB = Arena(Box(-3.3, 3.3, -2.5, 2.5), 4.0)
margins = st.floats(0.0, 3.0)


@st.composite
def obstacles(draw) -> Obstacle:
    x, y = draw(st.floats(-4.0, 4.0)), draw(st.floats(-3.0, 3.0))
    size = st.floats(0.1, 2.0)
    return Obstacle(Box(x, x + draw(size), y, y + draw(size)), 1.0)


def with_wall(gap: float) -> Arena:
    """The lab, a third of it behind a wall 0.2 m thick with an opening `gap` [m] wide at its southern end."""
    return replace(LAB, obstacles=(Obstacle(Box(1.0, 1.2, -2.5 + gap, 2.5), 2.0),))


@given(margins)
def test_a_margin_takes_a_border_off_an_empty_floor(margin):
    length, width = max(6.6 - 2 * margin, 0.0), max(5.0 - 2 * margin, 0.0)
    # On each side, the border may be off by half a cell.
    most = (length + CELL) * (width + CELL) / 33.0
    least = max(length - CELL, 0.0) * max(width - CELL, 0.0) / 33.0
    assert least <= free_share(LAB, margin) <= most


def test_without_a_margin_the_whole_floor_is_free():
    assert free_share(LAB, 0.0) == 1.0


@given(st.lists(obstacles(), max_size=4), margins, margins)
def test_more_margin_and_more_obstacles_never_leave_more_room(things, a, b):
    arena = replace(LAB, obstacles=tuple(things))
    assert free_share(arena, max(a, b)) <= free_share(arena, min(a, b)) <= 1.0
    assert free_share(arena, a) <= free_share(replace(arena, obstacles=tuple(things[1:])), a)


@given(st.lists(obstacles(), max_size=4), margins)
def test_there_is_room_exactly_up_to_the_widest_place(things, margin):
    arena = replace(LAB, obstacles=tuple(things))
    assert (free_share(arena, margin) > 0.0) == (margin <= widest(arena))


@given(st.lists(obstacles(), max_size=4), margins, st.floats(-20.0, 20.0))
def test_where_the_origin_lies_makes_no_difference(things, margin, east):
    def moved(box: Box) -> Box:
        return Box(box.x_min + east, box.x_max + east, box.y_min, box.y_max)

    there = Arena(
        moved(LAB.bounds), 4.0, tuple(replace(one, footprint=moved(one.footprint)) for one in things)
    )
    here = replace(LAB, obstacles=tuple(things))
    # Centres that lie on the very edge of what is free may be rounded to either side: a row of cells or so.
    assert widest(there) == pytest.approx(widest(here), abs=CELL)


def test_an_obstacle_takes_its_footprint_and_a_rounded_border():
    table = replace(LAB, obstacles=(Obstacle(Box(-0.5, 0.5, -0.5, 0.5), 1.0),))
    taken = 1.0 + 4 * 0.3 + 3.1416 * 0.3**2
    assert free_share(LAB, 0.3) - free_share(table, 0.3) == pytest.approx(taken / 33.0, abs=0.005)


def test_a_corridor_narrower_than_twice_the_margin_is_closed():
    assert free_share(with_wall(0.7), 0.3) == pytest.approx((4.3 - 0.6 + 2.1 - 0.6) * 4.4 / 33.0, abs=0.05)
    assert free_share(with_wall(0.5), 0.3) == pytest.approx((4.3 - 0.6) * 4.4 / 33.0, abs=0.01)


def test_a_closed_corridor_is_no_error():
    arena = with_wall(0.1)
    assert check_room(arena, 0.3) is arena


def test_no_room_says_how_large_the_margin_is_and_how_wide_the_arena():
    assert check_room(LAB, 2.45) is LAB
    line = (
        "a margin of 2.6 m leaves no room in an arena of 6.6 x 5 m with 0 obstacles: valid is at most 2.475 m"
    )
    with pytest.raises(FledgeError, match=line):
        check_room(LAB, 2.6)
    with pytest.raises(FledgeError, match="a margin of nan m leaves no room"):
        check_room(LAB, float("nan"))


def test_a_covered_floor_has_no_widest_place():
    covered = replace(LAB, obstacles=(Obstacle(LAB.bounds, 1.0),))
    assert widest(covered) < 0.0 and free_share(covered, 0.0) == 0.0
