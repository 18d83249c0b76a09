"""The formation moves about and keeps its size."""

import numpy as np
import pytest

from fledge.manoeuvres import FixedAltitude
from fledge.manoeuvres.paths import FAMILIES
from fledge.world import Arena


@pytest.mark.parametrize("family", FAMILIES)
def test_the_centre_moves_and_the_spread_stays(family):
    plan = FixedAltitude(families=(family,), spread=0.7).plan(np.random.default_rng(0), 600)
    np.testing.assert_array_equal(plan.track.spread, 0.7)
    np.testing.assert_array_equal(plan.track.spread_rate, 0.0)
    assert np.hypot(plan.track.x - plan.track.x[0], plan.track.y - plan.track.y[0]).max() > 0.5
    assert plan.arena.obstacles == ()


def test_only_the_lateral_sticks_are_needed():
    assert FixedAltitude().axes == (0, 1)


def test_the_families_it_is_given_are_the_ones_it_flies():
    circle = FixedAltitude(families=("circle",)).plan(np.random.default_rng(1), 400).track
    from_middle = np.hypot(circle.x, circle.y)
    # A polyline's chords run a little inside its circle.
    np.testing.assert_allclose(from_middle, from_middle.max(), rtol=1e-4)


def test_it_flies_in_the_arena_it_is_given():
    plan = FixedAltitude(arena=Arena.lab(), reach=0.7).plan(np.random.default_rng(1), 400)
    assert plan.arena == Arena.lab()
    assert np.abs([plan.track.x, plan.track.y]).max() < 1.2
