"""Where the UGVs appear in the picture: pixels by hand, and how the picture must change."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.camera import NEAREST, REAL_BOTTOM_CAMERA, Lens, look
from fledge.errors import OutOfRange
from fledge.geometry import Quat, Vec3
from fledge.world import UavState, UgvState, WorldState

LENS = Lens()
FIXED = Lens(levelled=False)

metres = st.floats(-3.0, 3.0, allow_subnormal=False)
altitudes = st.floats(0.5, 6.0)
angles = st.floats(-math.pi, math.pi, allow_subnormal=False)
triples = st.lists(st.tuples(metres, metres), min_size=3, max_size=3)


def uav(x=0.0, y=0.0, z=3.0, attitude=Quat(1.0, 0.0, 0.0, 0.0)) -> UavState:
    still = Vec3(0.0, 0.0, 0.0)
    return UavState(Vec3(x, y, z), still, attitude, still, 0.0)


def scene(places, drone: UavState) -> WorldState:
    return WorldState(0.0, drone, tuple(UgvState(x, y, 0.0, 0.0, 0.0, 0.0) for x, y in places))


def test_the_default_lens_spans_81_degrees():
    half = math.degrees(math.atan(LENS.width_px / 2.0 / LENS.focal_px))
    assert 2.0 * half == pytest.approx(81.0, abs=0.01)


@pytest.mark.parametrize("lens", (LENS, FIXED), ids=("levelled", "fixed"))
@pytest.mark.parametrize(
    ("x", "y", "u", "v"),
    (
        (0.0, 0.0, 320.0, 180.0),  # straight below: the centre
        (1.0, 0.0, 320.0, 180.0 - 374.7 / 3.0),  # ahead: up the picture
        (0.0, 1.0, 320.0 - 374.7 / 3.0, 180.0),  # to the left: left in the picture
        (-0.5, -1.5, 320.0 + 374.7 / 2.0, 180.0 + 374.7 / 6.0),
    ),
)
def test_pixels_computed_by_hand_from_three_metres(lens, x, y, u, v):
    assert lens.project(uav(z=3.0), x, y) == pytest.approx((u, v))


def test_a_point_above_the_floor_appears_farther_out():
    u, _ = LENS.project(uav(z=3.0), 0.0, -1.0, 1.0)
    assert u == pytest.approx(320.0 + 374.7 / 2.0)


def test_a_nose_to_the_north_turns_the_picture():
    north = uav(z=2.0, attitude=Quat.from_yaw(math.pi / 2))
    assert LENS.project(north, 0.0, 1.0) == pytest.approx((320.0, 180.0 - 374.7 / 2.0))
    assert LENS.project(north, 1.0, 0.0) == pytest.approx((320.0 + 374.7 / 2.0, 180.0))


def test_a_body_fixed_lens_swings_with_the_airframe():
    """With the nose 0.1 rad down, what is straight below appears tan(0.1) up the picture."""
    pitched = uav(attitude=Quat(math.cos(0.05), 0.0, math.sin(0.05), 0.0))
    below = FIXED.project(pitched, 0.0, 0.0)
    assert below == pytest.approx((320.0, 180.0 - FIXED.focal_px * math.tan(0.1)))
    assert LENS.project(pitched, 0.0, 0.0) == pytest.approx((320.0, 180.0))


@given(angles, metres, metres, altitudes)
def test_a_level_body_fixed_lens_sees_what_a_levelled_one_sees(yaw, x, y, z):
    level = uav(z=z, attitude=Quat.from_yaw(yaw))
    assert FIXED.project(level, x, y) == pytest.approx(LENS.project(level, x, y), abs=1e-8)


@given(triples, metres, metres, altitudes, angles)
def test_moving_everything_along_changes_nothing(places, dx, dy, z, yaw):
    attitude = Quat.from_yaw(yaw)
    here = look(LENS, scene(places, uav(z=z, attitude=attitude)))
    moved = [(x + dx, y + dy) for x, y in places]
    there = look(LENS, scene(moved, uav(dx, dy, z, attitude)))
    assert (there.u, there.v, there.radius) == pytest.approx((here.u, here.v, here.radius), abs=1e-8)


@given(triples, metres, altitudes)
def test_a_step_aside_shifts_the_centroid_by_focal_length_over_altitude(places, step, z):
    here = look(LENS, scene(places, uav(z=z)))
    aside = look(LENS, scene(places, uav(y=step, z=z)))
    assert aside.u - here.u == pytest.approx(LENS.focal_px * step / z, abs=1e-8)
    assert aside.v == pytest.approx(here.v, abs=1e-8)
    assert aside.radius == pytest.approx(here.radius, abs=1e-8)


@given(triples, altitudes)
def test_the_order_of_the_ugvs_does_not_matter(places, z):
    seen = look(LENS, scene(places, uav(z=z)))
    for order in ((1, 2, 0), (2, 1, 0)):
        again = look(LENS, scene([places[i] for i in order], uav(z=z)))
        assert (again.u, again.v) == pytest.approx((seen.u, seen.v), abs=1e-9)
        assert again.radius == pytest.approx(seen.radius, abs=1e-9)
        assert again.all_in_view == seen.all_in_view


@given(triples, altitudes, st.floats(1.0, 4.0))
def test_the_radius_is_inversely_proportional_to_the_altitude(places, z, times):
    low, high = look(LENS, scene(places, uav(z=z))), look(LENS, scene(places, uav(z=times * z)))
    assert high.radius * times == pytest.approx(low.radius, abs=1e-8)


@given(triples, altitudes, angles)
def test_a_yaw_turns_the_picture_about_its_centre(places, z, yaw):
    before = look(LENS, scene(places, uav(z=z)))
    after = look(LENS, scene(places, uav(z=z, attitude=Quat.from_yaw(yaw))))
    right, down = before.u - 320.0, before.v - 180.0
    # A turn to the left carries what is ahead to the right.
    c, s = math.cos(yaw), math.sin(yaw)
    assert (after.u - 320.0, after.v - 180.0) == pytest.approx(
        (c * right - s * down, s * right + c * down), abs=1e-8
    )
    assert after.radius == pytest.approx(before.radius, abs=1e-8)


def test_the_radius_of_a_triangle_is_its_circumradius_in_pixels():
    corners = [
        (0.8 * math.cos(a), 0.8 * math.sin(a)) for a in (0.3, 0.3 + 2 * math.pi / 3, 0.3 - 2 * math.pi / 3)
    ]
    picture = look(LENS, scene(corners, uav(z=2.5)))
    assert (picture.u, picture.v) == pytest.approx((320.0, 180.0))
    assert picture.radius == pytest.approx(LENS.focal_px * 0.8 / 2.5)


def test_the_radius_reaches_to_the_farthest_ugv():
    picture = look(LENS, scene([(0.0, 0.0), (0.0, 0.0), (3.0, 0.0)], uav(z=3.0)))
    assert picture.v == pytest.approx(180.0 - LENS.focal_px / 3.0)
    assert picture.radius == pytest.approx(LENS.focal_px * 2.0 / 3.0)


def test_in_view_means_every_centre_within_the_picture():
    edge = 180.0 / LENS.focal_px * 3.0
    inside = [(0.0, 0.0), (0.0, 0.0), (edge - 1e-6, 0.0)]
    outside = [(0.0, 0.0), (0.0, 0.0), (edge + 1e-6, 0.0)]
    assert look(LENS, scene(inside, uav(z=3.0))).all_in_view
    assert not look(LENS, scene(outside, uav(z=3.0))).all_in_view


@pytest.mark.parametrize(
    ("u", "v", "seen"),
    (
        *((0.0, 0.0, True), (640.0, 360.0, True), (320.0, 180.0, True)),
        *((-0.1, 180.0, False), (640.1, 180.0, False), (320.0, -0.1, False), (320.0, 360.1, False)),
        *((math.nan, 180.0, False), (320.0, math.nan, False)),
    ),
)
def test_the_picture_ends_at_its_edges(u, v, seen):
    assert LENS.sees(u, v) == seen


def test_at_the_floor_the_picture_stays_finite():
    for z in (NEAREST, 0.0, -1.0):
        u, v = LENS.project(uav(z=z), 0.1, 0.0)
        assert (u, v) == pytest.approx((320.0, 180.0 - LENS.focal_px * 0.1 / NEAREST))


def test_a_longer_lens_magnifies():
    picture = look(REAL_BOTTOM_CAMERA, scene([(0.5, 0.0), (-0.5, 0.0), (0.0, 0.0)], uav()))
    default = look(LENS, scene([(0.5, 0.0), (-0.5, 0.0), (0.0, 0.0)], uav()))
    assert picture.radius / default.radius == pytest.approx(REAL_BOTTOM_CAMERA.focal_px / LENS.focal_px)


@pytest.mark.parametrize("name", ("focal_px", "width_px", "height_px"))
@pytest.mark.parametrize("value", (0.0, -1.0, math.nan, math.inf))
def test_a_lens_that_cannot_be_is_refused(name, value):
    with pytest.raises(OutOfRange, match=f"lens {name} is .* px"):
        replace(LENS, **{name: value})


def test_a_flight_of_arrays_is_looked_at_row_by_row():
    z = np.array([1.0, 2.0, 4.0])
    many = look(LENS, scene([(0.5, 0.1), (-0.5, 0.2), (0.0, 0.3)], uav(z=z)))
    for i, height in enumerate(z.tolist()):
        one = look(LENS, scene([(0.5, 0.1), (-0.5, 0.2), (0.0, 0.3)], uav(z=height)))
        assert (many.u[i], many.v[i], many.radius[i]) == pytest.approx((one.u, one.v, one.radius))
        assert many.all_in_view[i] == one.all_in_view
