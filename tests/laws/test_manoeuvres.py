"""Laws that every manoeuvre obeys."""

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest

from fledge.dynamics import UGV_FLEET
from fledge.formation import FormationControl
from fledge.manoeuvres import MANOEUVRES, paths
from fledge.manoeuvres.base import MAX_SPREAD_RATE, SPREADS
from fledge.observation import ROW_RATE
from fledge.world import check_arena

EVERY_MANOEUVRE = pytest.mark.parametrize("manoeuvre", MANOEUVRES, ids=lambda m: m.name)
EVERY_LENGTH = pytest.mark.parametrize("rows", (480, 1200), ids=("24 s", "60 s"))
SEEDS = range(25)


def numbers(record: Any) -> np.ndarray:
    """Every number in a record, in order."""
    if is_dataclass(record):
        record = tuple(getattr(record, field.name) for field in fields(record))
    if isinstance(record, tuple):
        return np.concatenate([np.empty(0), *(numbers(item) for item in record)])
    return np.ravel(record).astype(float)


def plan(manoeuvre, seed: int, rows: int):
    return manoeuvre.plan(np.random.default_rng(seed), rows)


@EVERY_MANOEUVRE
def test_it_has_a_name_of_its_own_and_uses_real_sticks(manoeuvre):
    assert [other.name for other in MANOEUVRES].count(manoeuvre.name) == 1
    assert manoeuvre.axes and set(manoeuvre.axes) <= {0, 1, 2, 3}


@pytest.mark.slow
@EVERY_MANOEUVRE
@EVERY_LENGTH
def test_a_plan_is_a_pure_function_of_its_generator(manoeuvre, rows):
    for seed in SEEDS:
        np.testing.assert_array_equal(
            numbers(plan(manoeuvre, seed, rows)), numbers(plan(manoeuvre, seed, rows))
        )
        other = numbers(plan(manoeuvre, seed + 1000, rows))
        assert not np.array_equal(numbers(plan(manoeuvre, seed, rows)), other)


@EVERY_MANOEUVRE
@pytest.mark.parametrize("rows", (2, 100, 480, 1201))
def test_a_plan_has_a_finite_entry_for_every_row(manoeuvre, rows):
    track = plan(manoeuvre, 0, rows).track
    for field in fields(track):
        values = getattr(track, field.name)
        assert values.shape == (rows,), field.name
        assert np.isfinite(values).all(), field.name


@EVERY_MANOEUVRE
@EVERY_LENGTH
def test_every_corner_stays_inside_the_arena_clear_of_the_walls(manoeuvre, rows):
    for seed in SEEDS:
        drawn = plan(manoeuvre, seed, rows)
        bounds = check_arena(drawn.arena).bounds
        corners = FormationControl().corners(drawn.track, drawn.orientation)
        for (x, y, _, _), model in zip(corners, UGV_FLEET, strict=True):
            # `distance` is negative inside.
            assert bounds.distance(x, y).max() < -model.radius


@EVERY_MANOEUVRE
@EVERY_LENGTH
def test_speeds_spreads_and_their_rates_keep_to_what_is_declared(manoeuvre, rows):
    for seed in SEEDS:
        track = plan(manoeuvre, seed, rows).track
        assert np.hypot(track.vx, track.vy).max() <= paths.SPEEDS[1] + 1e-9
        assert SPREADS[0] - 1e-9 <= track.spread.min() <= track.spread.max() <= SPREADS[1] + 1e-9
        assert np.abs(track.spread_rate).max() <= MAX_SPREAD_RATE + 1e-9


@EVERY_MANOEUVRE
@pytest.mark.parametrize("rows", (20, 100, 200))
def test_short_flights_spread_no_faster_than_long_ones(manoeuvre, rows):
    rates = [np.abs(plan(manoeuvre, seed, rows).track.spread_rate).max() for seed in SEEDS]
    assert max(rates) <= MAX_SPREAD_RATE + 1e-9


@EVERY_MANOEUVRE
def test_the_rates_are_the_derivatives_of_the_places(manoeuvre):
    track = plan(manoeuvre, 3, 480).track
    for value, rate in ((track.x, track.vx), (track.y, track.vy), (track.spread, track.spread_rate)):
        np.testing.assert_allclose(rate[1:-1], (value[2:] - value[:-2]) * ROW_RATE / 2.0, atol=1e-12)


@EVERY_MANOEUVRE
def test_the_sticks_it_names_are_those_that_its_plan_needs(manoeuvre):
    tracks = [plan(manoeuvre, seed, 1200).track for seed in SEEDS]
    moves = any(np.hypot(track.vx, track.vy).max() > 1e-9 for track in tracks)
    spreads = any(np.abs(track.spread_rate).max() > 1e-9 for track in tracks)
    assert set(manoeuvre.axes) == ({0, 1} if moves else set()) | ({2} if spreads else set())


@pytest.mark.slow
@EVERY_MANOEUVRE
def test_only_training_families_are_flown_by_default(manoeuvre, monkeypatch):
    """What the method is chosen on, and what it is tested on, no demonstration ever shows."""

    def forbidden(rng, reach):
        raise AssertionError("a family was drawn that is not for training")

    kept_back = set(paths.FAMILIES) - set(paths.TRAINING_FAMILIES)
    assert set(paths.HELD_OUT_FAMILIES) <= kept_back
    for family in kept_back:
        monkeypatch.setitem(paths.FAMILIES, family, forbidden)
    for seed in range(100):
        plan(manoeuvre, seed, 60)
    assert not set(getattr(manoeuvre, "families", ())) & kept_back
