"""The formation spreads out on the spot."""

import numpy as np
import pytest

from fledge.manoeuvres import Climb
from fledge.manoeuvres.base import SPREADS
from fledge.observation import ROW_RATE


@pytest.mark.parametrize("seed", range(10))
def test_the_spread_grows_once_smoothly_from_small_to_large(seed):
    track = Climb().plan(np.random.default_rng(seed), 480).track
    assert (np.diff(track.spread) >= 0.0).all()
    assert SPREADS[0] <= track.spread[0] <= SPREADS[0] + 0.1
    assert SPREADS[1] - 0.1 <= track.spread[-1] <= SPREADS[1]
    # Level at both ends: no jerk when it begins and when it is done.
    assert track.spread_rate[0] == 0.0
    assert abs(np.diff(track.spread_rate)).max() * ROW_RATE < 0.05


@pytest.mark.parametrize("seed", range(10))
def test_the_centre_stands_still(seed):
    track = Climb().plan(np.random.default_rng(seed), 480).track
    for values in (np.diff(track.x), np.diff(track.y), track.vx, track.vy):
        np.testing.assert_array_equal(values, 0.0)


def test_only_the_vertical_stick_is_needed_and_nothing_stands_about():
    assert Climb().axes == (2,)
    assert Climb().plan(np.random.default_rng(0), 480).arena.obstacles == ()
