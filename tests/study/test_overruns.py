"""Flown stops: what is measured is what the stop tube predicts, and the chance is the key's."""

from dataclasses import replace

import numpy as np
import pytest

from fledge.dynamics import REAL_AR_DRONE
from fledge.geometry import Vec3
from fledge.safety import UavStop
from fledge.study.overruns import fly_stops, overrun

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    "moved, beyond",
    (
        (Vec3(0.0, 0.0, 0.0), -0.02),
        (Vec3(0.4, 0.0, 0.0), -0.02),  # on its way
        (Vec3(1.3, 0.0, 0.0), 0.2),  # past the end
        (Vec3(0.5, -0.3, 0.0), 0.2),  # beside the way
        (Vec3(-0.3, 0.0, 0.0), 0.2),  # back from where it was
        (Vec3(1.0, 0.0, 0.3), 0.08),  # above the end
        (Vec3(1.0, 0.0, -0.12), 0.1),  # below where it was
    ),
)
def test_an_overrun_is_the_distance_from_the_predicted_way_less_the_bound(moved, beyond):
    ahead = Vec3(1.0, 0.0, 0.2)
    assert overrun(0.1, 0.02, ahead, moved) == pytest.approx(beyond)


def test_from_rest_every_direction_is_beyond():
    assert overrun(0.1, 0.02, Vec3(0.0, 0.0, 0.0), Vec3(0.3, 0.4, 0.0)) == pytest.approx(0.4)


def flown(model=REAL_AR_DRONE, key=(1,), stops=1, **bound):
    return fly_stops(model, key, 40, stops, **bound)


@pytest.fixture(scope="module")
def once():
    return flown()


def test_an_episode_is_a_row_of_stops(once):
    twice = flown(stops=2)
    assert twice.shape == (40, 2)
    np.testing.assert_array_equal(twice[:, :1], once)
    assert np.isfinite(twice).all()


def test_the_key_is_the_chance(once):
    np.testing.assert_array_equal(flown(), once)
    assert not np.array_equal(flown(key=(2,)), once)


def test_a_larger_bound_is_overrun_by_less(once):
    wide = UavStop(error=UavStop().error + 0.5, error_up=UavStop().error_up + 0.5)
    np.testing.assert_allclose(flown(stop=wide), once - 0.5)


def test_a_vehicle_that_tilts_less_overruns_more(once):
    limp = replace(REAL_AR_DRONE, tilt=replace(REAL_AR_DRONE.tilt, limit=0.05))
    assert flown(limp).max() > once.max() + 0.03
