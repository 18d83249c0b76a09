"""The composite task: lateral motion, climbs and descents in random order, boxes in the way."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from fledge.dynamics import UGV_FLEET
from fledge.formation import FormationControl
from fledge.manoeuvres import Combined, FormationTrack
from fledge.manoeuvres.base import MAX_SPREAD_RATE, SPREADS
from fledge.manoeuvres.combined import OBSTACLES, PASSAGE, place_obstacles, spread_sequence
from fledge.manoeuvres.paths import HELD_OUT_FAMILIES
from fledge.observation import ROW_RATE
from fledge.world import Arena, check_arena

SEEDS = range(20)
ROWS = 1200


@pytest.fixture(scope="module")
def plans():
    return [Combined().plan(np.random.default_rng(seed), ROWS) for seed in SEEDS]


def test_all_but_the_yaw_stick_are_needed():
    assert Combined().axes == (0, 1, 2)


def test_it_moves_it_climbs_it_descends_and_it_holds(plans):
    """In a minute, with segments of 4 to 10 s, every flight changes its spread; all of them together do everything."""
    climbs = [(plan.track.spread_rate > 0.01).mean() for plan in plans]
    descents = [(plan.track.spread_rate < -0.01).mean() for plan in plans]
    holds = [(plan.track.spread_rate == 0.0).mean() for plan in plans]
    assert min(np.add(climbs, descents)) > 0.0
    assert min(np.mean(climbs), np.mean(descents), np.mean(holds)) > 0.1
    for plan in plans:
        assert np.hypot(np.ptp(plan.track.x), np.ptp(plan.track.y)) > 1.0


@pytest.mark.parametrize("seed", SEEDS)
def test_the_spread_keeps_to_its_bounds_and_to_its_rate(seed):
    spread = spread_sequence(np.random.default_rng(seed), ROWS)
    assert spread.shape == (ROWS,)
    assert SPREADS[0] - 1e-9 <= spread.min() <= spread.max() <= SPREADS[1] + 1e-9
    assert np.abs(np.diff(spread)).max() * ROW_RATE <= MAX_SPREAD_RATE + 1e-9


def test_the_first_two_seconds_hold_the_spread(plans):
    for plan in plans:
        np.testing.assert_array_equal(plan.track.spread[:40], plan.track.spread[0])


def test_every_arena_is_furnished_within_its_walls(plans):
    for plan in plans:
        arena = check_arena(plan.arena)
        assert len(arena.obstacles) == OBSTACLES
        for obstacle in arena.obstacles:
            box = obstacle.footprint
            assert arena.bounds.x_min <= box.x_min and box.x_max <= arena.bounds.x_max
            assert arena.bounds.y_min <= box.y_min and box.y_max <= arena.bounds.y_max
            assert obstacle.height < arena.ceiling


def test_no_ugv_starts_against_a_box(plans):
    for plan in plans:
        track = plan.track
        first = FormationTrack(*(getattr(track, name)[0] for name in FormationTrack.__slots__))
        corners = FormationControl().corners(first, plan.orientation)
        for (x, y, _, _), model in zip(corners, UGV_FLEET, strict=True):
            for obstacle in plan.arena.obstacles:
                assert obstacle.footprint.distance(x, y) > model.radius


def test_boxes_stand_where_they_matter(plans):
    """Most of them force at least one UGV off its way."""
    in_the_way = 0
    for plan in plans:
        corners = FormationControl().corners(plan.track, plan.orientation)
        for obstacle in plan.arena.obstacles:
            nearest = min(obstacle.footprint.distance(x, y).min() for x, y, _, _ in corners)
            in_the_way += nearest < min(model.radius for model in UGV_FLEET)
    assert in_the_way > 0.5 * OBSTACLES * len(plans)


def gap_between(a, b) -> float:
    across = max(a.x_min - b.x_max, b.x_min - a.x_max, 0.0)
    along = max(a.y_min - b.y_max, b.y_min - a.y_max, 0.0)
    return float(np.hypot(across, along))


def test_a_ugv_gets_through_between_any_two_boxes(plans):
    widest = 2.0 * (max(model.radius for model in UGV_FLEET) + FormationControl().clearance)
    assert widest <= PASSAGE
    for plan in plans:
        for one, other in combinations([obstacle.footprint for obstacle in plan.arena.obstacles], 2):
            assert gap_between(one, other) > PASSAGE


def test_on_a_path_that_never_leaves_its_start_the_boxes_stand_out_of_the_way():
    still = FormationTrack.through(*(np.full(10, value) for value in (0.0, 0.0, 0.8)))
    boxes = place_obstacles(np.random.default_rng(0), still)
    assert len(boxes) == OBSTACLES
    check_arena(replace(Arena.square(), obstacles=boxes))
    for box in boxes:
        assert box.footprint.distance(0.0, 0.0) > 4.0


def test_held_out_families_can_be_asked_for():
    tested = Combined(families=HELD_OUT_FAMILIES).plan(np.random.default_rng(0), ROWS)
    trained = Combined().plan(np.random.default_rng(0), ROWS)
    assert not np.array_equal(tested.track.x, trained.track.x)
