"""The formation closes up on the spot."""

import numpy as np
import pytest

from fledge.manoeuvres import Climb, Descend
from fledge.manoeuvres.base import SPREADS


@pytest.mark.parametrize("seed", range(10))
def test_the_spread_shrinks_once_smoothly_from_large_to_small(seed):
    track = Descend().plan(np.random.default_rng(seed), 480).track
    assert (np.diff(track.spread) <= 0.0).all()
    assert SPREADS[1] - 0.1 <= track.spread[0] <= SPREADS[1]
    assert SPREADS[0] <= track.spread[-1] <= SPREADS[0] + 0.1
    assert track.spread_rate[0] == 0.0


@pytest.mark.parametrize("seed", range(10))
def test_the_centre_stands_still(seed):
    track = Descend().plan(np.random.default_rng(seed), 480).track
    for values in (np.diff(track.x), np.diff(track.y), track.vx, track.vy):
        np.testing.assert_array_equal(values, 0.0)


def test_it_needs_the_same_stick_as_a_climb():
    assert Descend().axes == Climb().axes == (2,)
