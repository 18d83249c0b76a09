"""The referee, against brute force: hulls and boxes as clouds of points, and the laws of a distance."""

from dataclasses import replace
from math import hypot

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from fledge.clearance import clearance, clearances
from fledge.dynamics import UGV_FLEET, Quadrotor
from fledge.geometry import Box, Quat, Vec3
from fledge.world import Arena, Obstacle, UavState, UgvState, WorldState

UAV = Quadrotor()
STILL = Vec3(0.0, 0.0, 0.0)
HALL = Box(-5.0, 5.0, -4.0, 4.0)
FAR = ((100.0, 0.0), (200.0, 0.0), (300.0, 0.0))
"""[m] where UGVs are out of the way."""
CELL = 0.02


def scene(x: float, y: float, z: float, ugvs=FAR) -> WorldState:
    places = tuple(UgvState(a, b, 0.0, 0.0, 0.0, 0.0) for a, b in ugvs)
    return WorldState(0.0, UavState(Vec3(x, y, z), STILL, Quat.from_yaw(0.3), STILL, 0.0), places)


def grid(low: float, high: float) -> np.ndarray:
    return np.linspace(low, high, int((high - low) / CELL) + 2)


def to_cylinder(points: np.ndarray, x: float, y: float, z: float, radius: float, half: float) -> float:
    """Least distance from points, shape (..., 3), to an upright cylinder; 0 inside."""
    out = np.maximum(np.hypot(points[..., 0] - x, points[..., 1] - y) - radius, 0.0)
    up = np.maximum(np.abs(points[..., 2] - z) - half, 0.0)
    return float(np.hypot(out, up).min())


def block(box: Box, height: float) -> np.ndarray:
    """Points of an obstacle's surface and inside."""
    axes = (grid(box.x_min, box.x_max), grid(box.y_min, box.y_max), grid(0.0, height))
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


places = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(0.15, 3.0))
boxes = st.builds(
    lambda x, y, w, h: Box(x - w, x + w, y - h, y + h),
    *(st.floats(-2.0, 2.0),) * 2,
    *(st.floats(0.1, 0.5),) * 2,
)


@given(place=places, box=boxes, height=st.floats(0.2, 1.5))
def test_a_uav_is_as_far_from_an_obstacle_as_their_nearest_points(place, box, height):
    wide = Arena(Box(-99.0, 99.0, -99.0, 99.0), 99.0, (Obstacle(box, height),))
    gap = clearance(wide, scene(*place), UAV, UGV_FLEET, 0).gap
    floor = place[2] - UAV.half_height
    points = to_cylinder(block(box, height), *place, UAV.radius, UAV.half_height)
    if points > 2.0 * CELL:
        assert min(points, floor) - 2.0 * CELL <= gap <= min(points, floor) + 1e-9
    else:
        assert gap <= min(2.0 * CELL, floor)
    assert (gap <= 0.0) <= (points <= 2.0 * CELL)


@given(place=places, box=boxes, height=st.floats(0.2, 1.5))
def test_a_ugv_is_as_far_from_an_obstacle_as_their_nearest_points(place, box, height):
    x, y, _ = place
    model = UGV_FLEET[0]
    wide = Arena(Box(-99.0, 99.0, -99.0, 99.0), 99.0, (Obstacle(box, height),))
    gap = clearance(wide, scene(50.0, 50.0, 9.0, ((x, y), *FAR[1:])), UAV, UGV_FLEET, 1).gap
    points = block(box, CELL)
    nearest = np.hypot(points[..., 0] - x, points[..., 1] - y).min() - model.radius
    assert nearest - 2.0 * CELL <= gap <= nearest + 1e-9


@given(place=places, other=places)
def test_a_uav_and_a_ugv_are_equally_far_from_each_other(place, other):
    wide = Arena(Box(-99.0, 99.0, -99.0, 99.0), 99.0)
    now = scene(*place, ((other[0], other[1]), *FAR[1:]))
    gap = clearance(wide, now, UAV, UGV_FLEET, 1).gap
    model = UGV_FLEET[0]
    out = max(hypot(place[0] - other[0], place[1] - other[1]) - UAV.radius - model.radius, 0.0)
    up = max(place[2] - UAV.half_height - model.height, 0.0)
    if out > 0.0 or up > 0.0:
        assert gap == pytest.approx(hypot(out, up))
        assert clearance(wide, now, UAV, UGV_FLEET, 0).gap <= gap + 1e-9
    else:
        assert gap <= 0.0


def test_walls_floor_and_ceiling():
    arena = Arena(HALL, 3.0)
    for place, gap, way in (
        ((4.0, 0.0, 1.5), 1.0 - UAV.radius, (1.0, 0.0, 0.0)),
        ((-4.5, 0.0, 1.5), 0.5 - UAV.radius, (-1.0, 0.0, 0.0)),
        ((0.0, -3.5, 1.5), 0.5 - UAV.radius, (0.0, -1.0, 0.0)),
        ((0.0, 0.0, 0.3), 0.3 - UAV.half_height, (0.0, 0.0, -1.0)),
        ((0.0, 0.0, 2.8), 0.2 - UAV.half_height, (0.0, 0.0, 1.0)),
    ):
        found = clearance(arena, scene(*place), UAV, UGV_FLEET, 0)
        assert found.gap == pytest.approx(gap) and (found.x, found.y, found.z) == way


@given(place=places, box=boxes, step=st.tuples(*[st.floats(-0.3, 0.3)] * 3))
def test_nothing_comes_nearer_faster_than_a_vehicle_moves(place, box, step):
    arena = Arena(HALL, 6.0, (Obstacle(box, 1.0),))
    before = clearance(arena, scene(*place), UAV, UGV_FLEET, 0).gap
    after = clearance(arena, scene(*(a + b for a, b in zip(place, step, strict=True))), UAV, UGV_FLEET, 0).gap
    assume(before > 0.0 and after > 0.0)
    assert abs(after - before) <= hypot(*step) + 1e-9


@given(place=places, box=boxes)
def test_going_the_way_of_the_nearest_thing_touches_it(place, box):
    arena = Arena(HALL, 6.0, (Obstacle(box, 1.0),))
    near = clearance(arena, scene(*place), UAV, UGV_FLEET, 0)
    assume(near.gap > 1e-3)
    moved = Vec3(*place) + Vec3(near.x, near.y, near.z) * near.gap
    there = scene(moved.x, moved.y, moved.z)
    assert clearance(arena, there, UAV, UGV_FLEET, 0).gap == pytest.approx(0.0, abs=1e-6)


@given(places=st.tuples(*[st.tuples(st.floats(-4.0, 4.0), st.floats(-3.0, 3.0))] * 3))
def test_ugvs_are_as_far_from_each_other_as_discs_are(places):
    now = scene(50.0, 50.0, 9.0, places)
    arena = Arena(Box(-99.0, 99.0, -99.0, 99.0), 99.0)
    for i, found in enumerate(clearances(arena, now, UAV, UGV_FLEET)[1:]):
        others = (
            hypot(places[i][0] - places[j][0], places[i][1] - places[j][1])
            - UGV_FLEET[i].radius
            - UGV_FLEET[j].radius
            for j in range(3)
            if j != i
        )
        assert found.gap == pytest.approx(min(others))


def test_many_scenes_at_once_are_each_like_one():
    rng = np.random.default_rng(0)
    x, y, z = rng.uniform(-3.0, 3.0, (3, 50))
    arena = Arena(HALL, 6.0, (Obstacle(Box(0.0, 1.0, 0.0, 1.0), 1.0),))
    one = scene(0.0, 0.0, 1.0)
    many = replace(one, uav=replace(one.uav, position=Vec3(x, y, abs(z))))
    gaps = clearance(arena, many, UAV, UGV_FLEET, 0).gap
    each = [clearance(arena, scene(*p), UAV, UGV_FLEET, 0).gap for p in zip(x, y, abs(z), strict=True)]
    np.testing.assert_allclose(gaps, each, atol=1e-12)
