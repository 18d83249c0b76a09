"""The drone's senses: how far off they are, how that wanders, what trimming mends."""

from math import pi

import numpy as np
import pytest
from workbench import EXACT

from fledge.geometry import Quat, Vec3
from fledge.lab.twin.plant import Motion
from fledge.lab.twin.senses import BIRTH_NORMALS, NORMALS, Senses

SENSES = Senses()


def motion(attitude=Quat(1.0, 0.0, 0.0, 0.0), velocity=Vec3(0.0, 0.0, 0.0), z=1.0):
    return Motion(Vec3(0.0, 0.0, z), attitude, velocity, Vec3(0.1, 0.2, 0.3))


def test_without_errors_it_senses_the_truth_in_its_own_frame():
    sensed = SENSES.sense(EXACT, motion(Quat.from_yaw(pi / 2), Vec3(-2.0, 1.0, 0.5)))
    assert (sensed.forward, sensed.left, sensed.up) == pytest.approx((1.0, 2.0, 0.5))
    assert sensed.altitude == pytest.approx(1.0 - SENSES.half_height)
    assert (sensed.rates, sensed.upright) == (Vec3(0.1, 0.2, 0.3), 1.0)
    assert sensed.yaw == pytest.approx(pi / 2)


@pytest.mark.parametrize("tilt", [(0.2, 0.0), (0.0, -0.2)])
def test_a_tilt_is_sensed_as_one(tilt):
    roll, pitch = tilt
    attitude = Quat(1.0, 0.0, 0.0, 0.0).integrate(Vec3(roll, pitch, 0.0), 1.0)
    sensed = SENSES.sense(EXACT, motion(attitude))
    assert (sensed.roll, sensed.pitch) == pytest.approx(tilt, abs=2e-3)


def test_errors_wander_about_nothing_at_their_size():
    rng = np.random.default_rng(0)
    errors = SENSES.init(0.0, rng.standard_normal(BIRTH_NORMALS).tolist())
    seen = []
    for _ in range(20_000):
        errors = SENSES.wander(errors, rng.standard_normal(NORMALS).tolist(), 1.0)
        seen.append((errors.forward, errors.left, errors.up, errors.altitude))
    sizes = (SENSES.velocity, SENSES.velocity, SENSES.up, SENSES.altitude)
    assert np.std(seen, axis=0) == pytest.approx(sizes, rel=0.1)
    assert np.mean(seen, axis=0) == pytest.approx(np.zeros(4), abs=0.2 * SENSES.velocity)


def test_how_finely_time_is_cut_does_not_matter():
    errors = EXACT._replace(forward=1.0)
    still = [0.0] * NORMALS
    coarse, fine = SENSES.wander(errors, still, 1.0), errors
    for _ in range(100):
        fine = SENSES.wander(fine, still, 0.01)
    assert fine.forward == pytest.approx(coarse.forward)


def test_the_heading_creeps_steadily():
    errors = SENSES.init(1.0, [1.0] * BIRTH_NORMALS)
    later = SENSES.wander(errors, [0.0] * NORMALS, 10.0)
    assert errors.yaw == -1.0  # its zero is where it was switched on
    assert later.yaw - errors.yaw == pytest.approx(10.0 * SENSES.turn)


def test_trimming_takes_most_of_the_attitude_error_away():
    before = SENSES.init(0.0, [2.0] * BIRTH_NORMALS)
    after = SENSES.trim(before, [2.0] * NORMALS)
    assert abs(after.roll) < 0.3 * abs(before.roll) and abs(after.pitch) < 0.3 * abs(before.pitch)
    assert after._replace(roll=0.0, pitch=0.0) == before._replace(roll=0.0, pitch=0.0)
