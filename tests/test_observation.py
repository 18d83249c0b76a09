"""The paper's eleven numbers, and what a stick means."""

import math
from dataclasses import astuple, fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.camera import Lens, look
from fledge.errors import OutOfRange
from fledge.geometry import Quat, Vec3
from fledge.observation import (
    ACTION_NAMES,
    IDEAL_RADIUS_PX,
    OBSERVATION_NAMES,
    OBSERVATION_UNITS,
    VELOCITY_INPUTS,
    Action,
    Axes,
    Observation,
    StickScale,
    observe,
)
from fledge.world import UavState, UgvState, WorldState

LENS = Lens()
WORLD = WorldState(
    1.0,
    UavState(
        Vec3(0.5, -0.5, 3.0),
        Vec3(0.3, 0.4, -0.2),
        Quat.from_yaw(math.pi / 2),
        Vec3(0.01, 0.02, 0.7),
        1.0,
    ),
    tuple(UgvState(x, y, 0.0, 0.0, 0.0, 1.0) for x, y in ((1.0, 0.0), (-1.0, 0.5), (0.0, -1.0))),
)

sticks = st.floats(-1.0, 1.0, allow_subnormal=False)


def test_the_eleven_entries_stand_in_the_order_of_table_2():
    assert OBSERVATION_NAMES == (
        *("centre_u", "centre_v", "ugv_u", "ugv_v", "altitude", "ideal_radius", "radius"),
        *("forward", "left", "up", "turn"),
    )
    assert len(OBSERVATION_UNITS) == len(OBSERVATION_NAMES)


def test_the_four_actions_stand_in_their_order():
    assert ACTION_NAMES == ("forward", "left", "up", "turn")


def test_the_units_are_those_of_what_is_measured():
    units = dict(zip(OBSERVATION_NAMES, OBSERVATION_UNITS, strict=True))
    for name, unit in units.items():
        in_the_picture = any(part in name for part in ("centre", "ugv", "radius"))
        wanted = "px" if in_the_picture else {"altitude": "m", "turn": "rad/s"}.get(name, "m/s")
        assert unit == wanted, name


def test_the_velocity_inputs_are_those_named_like_the_actions():
    assert tuple(OBSERVATION_NAMES[i] for i in VELOCITY_INPUTS) == ACTION_NAMES


def test_each_entry_is_what_it_says():
    seen, picture = observe(WORLD, LENS), look(LENS, WORLD)
    assert (seen.centre_u, seen.centre_v) == LENS.centre
    assert (seen.ugv_u, seen.ugv_v, seen.radius) == (picture.u, picture.v, picture.radius)
    assert seen.altitude == 3.0
    assert seen.ideal_radius == IDEAL_RADIUS_PX
    # The nose points north: north is forward, west is left.
    assert (seen.forward, seen.left) == pytest.approx((0.4, -0.3))
    assert (seen.up, seen.turn) == (-0.2, 0.7)


def test_the_ideal_radius_is_passed_on():
    assert observe(WORLD, LENS, 90.0).ideal_radius == 90.0
    assert replace(observe(WORLD, LENS, 90.0), ideal_radius=IDEAL_RADIUS_PX) == observe(WORLD, LENS)


def test_above_a_triangle_at_the_ideal_altitude_there_is_nothing_to_correct():
    spread = 0.8
    ugvs = tuple(
        UgvState(spread * math.cos(a), spread * math.sin(a), 0.0, 0.0, 0.0, 0.0)
        for a in (0.0, 2.0 * math.pi / 3.0, 4.0 * math.pi / 3.0)
    )
    still = Vec3(0.0, 0.0, 0.0)
    z = LENS.focal_px * spread / IDEAL_RADIUS_PX
    seen = observe(
        WorldState(0.0, UavState(Vec3(0.0, 0.0, z), still, Quat.from_yaw(0.4), still, 0.0), ugvs), LENS
    )
    assert (seen.ugv_u, seen.ugv_v) == pytest.approx((seen.centre_u, seen.centre_v))
    assert seen.radius == pytest.approx(seen.ideal_radius)


@pytest.mark.parametrize("indices", ((), (2,), (0, 1), (0, 1, 2, 3)))
def test_axes_leave_what_is_in_use_and_silence_the_rest(indices):
    said = astuple(Action(0.1, -0.2, 0.3, -0.4).only(Axes.of(indices)))
    assert said == tuple(value if i in indices else 0.0 for i, value in enumerate((0.1, -0.2, 0.3, -0.4)))


def test_by_default_only_the_yaw_is_silent():
    assert Axes() == Axes.of((0, 1, 2))


@given(sticks, sticks, sticks, sticks)
def test_the_scaling_is_linear_within_the_stops(forward, left, up, turn):
    scale = StickScale(horizontal=2.0, vertical=0.7, turn=1.5)
    command = scale.command(Action(forward, left, up, turn))
    assert astuple(command) == pytest.approx((2.0 * forward, 2.0 * left, 0.7 * up, 1.5 * turn))


@given(st.floats(allow_nan=False))
def test_a_stick_beyond_its_stop_counts_as_at_the_stop(stick):
    scale = StickScale()
    command = scale.command(Action(stick, stick, stick, stick))
    limits = (scale.horizontal, scale.horizontal, scale.vertical, scale.turn)
    for got, limit in zip(astuple(command), limits, strict=True):
        assert abs(got) <= limit
        if abs(stick) >= 1.0:
            assert got == math.copysign(limit, stick)


def test_nan_is_not_taken_for_a_command():
    assert all(math.isnan(part) for part in astuple(StickScale().command(Action(*[math.nan] * 4))))


@pytest.mark.parametrize("name", [field.name for field in fields(StickScale)])
@pytest.mark.parametrize("value", (0.0, -1.0, 11.0, math.nan))
def test_a_stick_that_means_nothing_is_refused(name, value):
    with pytest.raises(OutOfRange, match=f"full-stick {name} speed"):
        StickScale(**{name: value})


def test_a_flight_of_arrays_is_observed_row_by_row():
    heights = np.array([2.0, 3.0])
    uav = replace(WORLD.uav, position=Vec3(0.5 + 0 * heights, -0.5 + 0 * heights, heights))
    many = observe(replace(WORLD, uav=uav), LENS)
    one = observe(WORLD, LENS)
    assert isinstance(many, Observation)
    for name in ("centre_u", "ugv_u", "ugv_v", "altitude", "radius", "ideal_radius"):
        assert getattr(many, name)[1] == pytest.approx(getattr(one, name)), name
