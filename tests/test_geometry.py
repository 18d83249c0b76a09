"""Vectors, rotations and distances, against SciPy, against brute force and against their own laws."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from fledge.geometry import Box, Heading, Quat, Vec3

number = st.floats(-10.0, 10.0, allow_subnormal=False)
angle = st.floats(-math.pi, math.pi, allow_subnormal=False)
vectors = st.builds(Vec3, number, number, number)


@st.composite
def unit_quaternions(draw) -> Quat:
    parts = np.array([draw(st.floats(-1.0, 1.0, allow_subnormal=False)) for _ in range(4)])
    length = np.linalg.norm(parts)
    assume(length > 0.1)
    return Quat(*(parts / length).tolist())


def array(v: Vec3 | Quat) -> np.ndarray:
    return np.array([getattr(v, axis) for axis in ("w", "x", "y", "z") if hasattr(v, axis)])


def scipy_rotation(q: Quat) -> Rotation:
    return Rotation.from_quat([q.x, q.y, q.z, q.w])


@given(vectors, vectors, number)
def test_vectors_add_subtract_and_scale_like_arrays(a, b, factor):
    np.testing.assert_array_equal(array(a + b), array(a) + array(b))
    np.testing.assert_array_equal(array(a - b), array(a) - array(b))
    np.testing.assert_array_equal(array(a * factor), array(a) * factor)
    np.testing.assert_allclose(array(a.cross(b)), np.cross(array(a), array(b)), atol=1e-12)


@given(angle, number, number)
def test_a_heading_turns_the_plane_and_back(yaw, forward, left):
    heading = Heading.of(yaw)
    east, north = heading.to_world(forward, left)
    assert math.hypot(east, north) == pytest.approx(math.hypot(forward, left), abs=1e-12)
    assert heading.from_world(east, north) == pytest.approx((forward, left), abs=1e-12)


def test_a_heading_of_north_sends_forward_north_and_left_west():
    north = Heading.of(math.pi / 2)
    assert north.to_world(1.0, 0.0) == pytest.approx((0.0, 1.0))
    assert north.to_world(0.0, 1.0) == pytest.approx((-1.0, 0.0))


@given(unit_quaternions(), vectors)
def test_rotation_is_scipys_and_preserves_length(q, v):
    turned = array(q.rotate(v))
    np.testing.assert_allclose(turned, scipy_rotation(q).apply(array(v)), atol=1e-12)
    assert np.linalg.norm(turned) == pytest.approx(np.linalg.norm(array(v)), abs=1e-12)


@given(unit_quaternions(), vectors)
def test_the_conjugate_is_the_inverse(q, v):
    np.testing.assert_allclose(array(q.conjugate().rotate(q.rotate(v))), array(v), atol=1e-12)


@given(angle, vectors)
def test_a_yaw_turns_as_its_heading_does(yaw, v):
    q, heading = Quat.from_yaw(yaw), Heading.of(yaw)
    turned = q.rotate(v)
    assert (turned.x, turned.y) == pytest.approx(heading.to_world(v.x, v.y), abs=1e-12)
    assert turned.z == v.z
    assert (q.heading().cos, q.heading().sin) == pytest.approx((heading.cos, heading.sin), abs=1e-12)


@given(unit_quaternions())
def test_heading_and_tilt_are_scipys_euler_angles(q):
    assume(abs(q.rotate(Vec3(1.0, 0.0, 0.0)).z) < 0.99)  # else the nose points up or down: gimbal lock
    yaw, pitch, roll = scipy_rotation(q).as_euler("ZYX")
    assume(abs(roll) < 1.5)
    heading = q.heading()
    assert (heading.cos, heading.sin) == pytest.approx((math.cos(yaw), math.sin(yaw)), abs=1e-9)
    got_roll, got_pitch, upright = q.tilt()
    assert (got_roll, got_pitch) == pytest.approx((roll, pitch), abs=1e-9)
    assert upright == pytest.approx(math.cos(pitch) * math.cos(roll), abs=1e-12)


def test_straight_up_and_straight_down_are_still_numbers():
    for pitch in (math.pi / 2, -math.pi / 2):
        nose_up = Quat(math.cos(pitch / 2), 0.0, math.sin(pitch / 2), 0.0)
        assert all(math.isfinite(part) for part in (nose_up.heading().cos, *nose_up.tilt()))


@given(unit_quaternions(), vectors)
def test_an_integrated_attitude_is_a_unit_quaternion(q, rates):
    assert np.linalg.norm(array(q.integrate(rates, 0.002))) == pytest.approx(1.0, abs=1e-14)


def spin(q: Quat, rates: Vec3, dt: float, steps: int) -> Quat:
    for _ in range(steps):
        q = q.integrate(rates, dt)
    return q


@given(unit_quaternions(), vectors)
def test_a_constant_rate_turns_about_its_own_axis_by_twice_an_arc_tangent_a_step(q, rates):
    """(1 + w dt / 2), normalised, is exactly a rotation by 2 atan(|w| dt / 2)."""
    speed = np.linalg.norm(array(rates))
    assume(speed > 1e-3)
    dt, steps = 0.01, 20
    by = Rotation.from_rotvec(array(rates) / speed * steps * 2.0 * math.atan(0.5 * speed * dt))
    wanted = (scipy_rotation(q) * by).as_matrix()
    np.testing.assert_allclose(scipy_rotation(spin(q, rates, dt, steps)).as_matrix(), wanted, atol=1e-12)


def test_integration_of_a_constant_rate_converges():
    """2 atan(h) = 2 h - 2 h^3 / 3: the angle's error shrinks with the square of the step."""
    start, rates = Quat(1.0, 0.0, 0.0, 0.0), Vec3(1.0, -2.0, 0.5)
    exact = Rotation.from_rotvec(array(rates))
    errors = [
        (exact.inv() * scipy_rotation(spin(start, rates, 1.0 / steps, steps))).magnitude()
        for steps in (50, 100, 200)
    ]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.01)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.01)


def test_integration_of_a_changing_rate_converges_at_first_order():
    """Halving the step halves the error."""

    def tumble(steps: int) -> Rotation:
        q, dt = Quat(1.0, 0.0, 0.0, 0.0), 1.0 / steps
        for i in range(steps):
            q = q.integrate(Vec3(3.0 * i * dt, 2.0 - 3.0 * i * dt, 1.0), dt)
        return scipy_rotation(q)

    exact = tumble(20_000)
    errors = [(exact.inv() * tumble(steps)).magnitude() for steps in (50, 100, 200)]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(2.0, rel=0.1)


@st.composite
def boxes(draw) -> Box:
    x, y = draw(number), draw(number)
    size = st.floats(0.1, 5.0)
    return Box(x, x + draw(size), y, y + draw(size))


def edge_points(box: Box, per_side: int = 401) -> np.ndarray:
    s = np.linspace(0.0, 1.0, per_side)
    x, y = box.x_min + s * (box.x_max - box.x_min), box.y_min + s * (box.y_max - box.y_min)
    sides = [(x, 0 * s + box.y_min), (x, 0 * s + box.y_max), (0 * s + box.x_min, y), (0 * s + box.x_max, y)]
    return np.concatenate([np.stack(side, axis=1) for side in sides])


def contains(box: Box, x: float, y: float) -> bool:
    return box.x_min <= x <= box.x_max and box.y_min <= y <= box.y_max


@given(boxes(), number, number)
def test_the_distance_to_a_box_is_that_to_the_nearest_of_many_points_on_its_edge(box, x, y):
    nearest = np.linalg.norm(edge_points(box) - [x, y], axis=1).min()
    half_spacing = 0.5 * max(box.x_max - box.x_min, box.y_max - box.y_min) / 400
    distance = box.distance(x, y)
    assert nearest - half_spacing - 1e-9 <= abs(distance) <= nearest + 1e-9
    if abs(distance) > 1e-9:
        assert (distance < 0.0) == contains(box, x, y)


@given(boxes(), number, number)
def test_the_gap_leads_out_of_the_box_and_is_as_long_as_the_distance(box, x, y):
    dx, dy = box.gap(x, y)
    if contains(box, x, y):
        assert (dx, dy) == (0.0, 0.0)
    else:
        assert math.hypot(dx, dy) == pytest.approx(box.distance(x, y), abs=1e-12)
        assert box.distance(x - dx, y - dy) == pytest.approx(0.0, abs=1e-12)


@given(boxes(), boxes())
def test_boxes_overlap_as_long_as_the_middle_of_what_they_share_lies_inside_both(a, b):
    x = (max(a.x_min, b.x_min) + min(a.x_max, b.x_max)) / 2
    y = (max(a.y_min, b.y_min) + min(a.y_max, b.y_max)) / 2
    assert a.overlaps(b) == b.overlaps(a) == (a.distance(x, y) < 0 and b.distance(x, y) < 0)


def test_boxes_that_touch_do_not_overlap():
    box = Box(0.0, 1.0, 0.0, 1.0)
    assert not box.overlaps(Box(1.0, 2.0, 0.0, 1.0)) and not box.overlaps(Box(0.0, 1.0, -1.0, 0.0))
    assert box.overlaps(box)


def test_nan_is_nowhere():
    box = Box(0.0, 1.0, 0.0, 1.0)
    assert math.isnan(box.distance(math.nan, 0.5))
    assert math.isnan(Box(math.nan, 1.0, 0.0, 1.0).distance(2.0, 2.0))


def test_records_of_arrays_are_many_records_of_numbers():
    rng = np.random.default_rng(0)
    w, x, y, z = (rng.normal(size=(4, 9)) / 2.0).tolist()
    many = Quat(*(np.array(part) for part in (w, x, y, z))).integrate(Vec3(0.1, 0.2, 0.3), 0.01)
    for i in range(9):
        one = Quat(w[i], x[i], y[i], z[i]).integrate(Vec3(0.1, 0.2, 0.3), 0.01)
        np.testing.assert_allclose([part[i] for part in (many.w, many.x, many.y, many.z)], array(one))
        np.testing.assert_allclose(many.tilt()[0][i], one.tilt()[0])
