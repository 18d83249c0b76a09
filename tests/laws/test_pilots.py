"""Laws that every pilot obeys."""

from dataclasses import astuple, fields, is_dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.conditions import Conditions
from fledge.engines import fly_plain
from fledge.manoeuvres import Combined, FixedAltitude
from fledge.observation import ACTION_NAMES, OBSERVATION_NAMES, Axes, Observation
from fledge.pilots import FOLLOWERS, PILOTS
from fledge.simulation import Case, Crew

pytestmark = pytest.mark.slow

EVERY_PILOT = pytest.mark.parametrize("pilot", PILOTS, ids=lambda pilot: pilot.name)

LOW = (320.0, 180.0, -1e4, -1e4, 0.0, 108.0, 0.0, -3.0, -3.0, -1.0, -2.0)
HIGH = (320.0, 180.0, 1e4, 1e4, 8.0, 108.0, 1e4, 3.0, 3.0, 1.0, 2.0)
observations = st.builds(
    Observation, *(st.floats(a, b, allow_subnormal=False) for a, b in zip(LOW, HIGH, strict=True))
)
noises = st.tuples(*(st.floats(-5.0, 5.0, allow_subnormal=False),) * 4)
looks = st.lists(st.tuples(observations, noises), min_size=1, max_size=12)


def flown(pilot, seen) -> list[tuple[float, ...]]:
    memory, said = pilot.init(), []
    for observation, noise in seen:
        memory, action = pilot.act(memory, observation, noise)
        said.append(astuple(action))
    return said


def numbers(memory: Any) -> list[Any]:
    """The leaves of a memory, in order."""
    if is_dataclass(memory):
        memory = tuple(getattr(memory, field.name) for field in fields(memory))
    return [leaf for item in memory for leaf in numbers(item)] if isinstance(memory, tuple) else [memory]


@EVERY_PILOT
def test_it_has_a_name_of_its_own(pilot):
    assert [other.name for other in PILOTS].count(pilot.name) == 1


@EVERY_PILOT
@given(seen=looks)
def test_what_it_says_is_finite_and_within_the_stops(pilot, seen):
    said = np.array(flown(pilot, seen))
    assert said.shape == (len(seen), len(ACTION_NAMES))
    assert np.isfinite(said).all() and (np.abs(said) <= 1.0).all()


@EVERY_PILOT
@given(seen=looks, other=looks)
def test_it_depends_on_its_inputs_only(pilot, seen, other):
    """The same flight twice, and once more with another flight of the same pilot in between its rows."""
    once = flown(pilot, seen)
    assert flown(pilot, seen) == once
    mine, theirs, said = pilot.init(), pilot.init(), []
    for i, (observation, noise) in enumerate(seen):
        mine, action = pilot.act(mine, observation, noise)
        theirs, _ = pilot.act(theirs, *other[i % len(other)])
        said.append(astuple(action))
    assert said == once


@EVERY_PILOT
@given(seen=looks)
def test_the_yaw_is_never_used(pilot, seen):
    assert {action[3] for action in flown(pilot, seen)} == {0.0}


@EVERY_PILOT
def test_plain_floats_numpy_and_jax_hear_the_same(pilot):
    """Sixteen flights of ten rows: one by one, all at once in NumPy, all at once in JAX."""
    rng = np.random.default_rng(0)
    seen = rng.uniform(LOW, HIGH, (10, 16, len(OBSERVATION_NAMES)))
    # Half of the flights near the set-point, where the sticks are not at their stops.
    seen[:, ::2, 2:4] = (320.0, 180.0) + rng.normal(0.0, 20.0, (10, 8, 2))
    seen[:, ::2, 6] = 108.0 + rng.normal(0.0, 5.0, (10, 8))
    chance = rng.normal(size=(10, 16, 4))

    plain = [
        flown(pilot, [(Observation(*seen[r, i].tolist()), tuple(chance[r, i].tolist())) for r in range(10)])
        for i in range(16)
    ]
    with jax.enable_x64(True):
        for array in (np.array, jnp.array):
            rows = [(Observation(*map(array, seen[r].T)), tuple(map(array, chance[r].T))) for r in range(10)]
            said = np.array(flown(pilot, rows))  # rows, actions, flights
            np.testing.assert_allclose(said.transpose(2, 0, 1), plain, rtol=1e-12, atol=1e-12)


@EVERY_PILOT
def test_memory_is_numbers_and_keeps_its_shape(pilot):
    memory = pilot.init()
    before = numbers(memory)
    assert all(isinstance(number, float) for number in before)
    memory, _ = pilot.act(memory, Observation(*LOW), (0.0,) * 4)
    assert len(numbers(memory)) == len(before)


@EVERY_PILOT
@pytest.mark.parametrize("axes", ((0, 1), (2,), (0, 1, 2), ()), ids=str)
def test_in_flight_the_axes_not_in_use_stay_at_zero(pilot, axes):
    case = Case.draw(Combined(), (0,), 12)
    episode = fly_plain(case, Crew(pilot.for_axes(axes), Axes.of(axes)), key=(1,))
    for i, name in enumerate(ACTION_NAMES):
        if i not in axes:
            np.testing.assert_array_equal(getattr(episode.action, name), 0.0)
            np.testing.assert_array_equal(getattr(episode.proposed.uav, name), 0.0)


@pytest.mark.parametrize("pilot", FOLLOWERS, ids=lambda pilot: pilot.name)
def test_on_a_calm_day_it_keeps_the_ugvs_in_view(pilot):
    manoeuvre = FixedAltitude()
    case = Case(manoeuvre.plan(np.random.default_rng(2), 240), Conditions())
    episode = fly_plain(case, Crew(pilot, Axes()), key=(3,))
    off = np.hypot(episode.observation.ugv_u - 320.0, episode.observation.ugv_v - 180.0)
    # The farthest UGV stands 108 px from the centroid; the picture ends 180 px from its centre.
    assert off.max() < 180.0 - 108.0
    assert np.abs(episode.observation.radius - 108.0).max() < 30.0
