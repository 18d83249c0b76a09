"""What is drawn is fair to the net, hard on it, and the same again."""

import numpy as np
import pytest

from fledge.clearance import clearances
from fledge.errors import FledgeError
from fledge.falsification.attacks import FAMILIES
from fledge.falsification.scenarios import (
    MOST_OBSTACLES,
    NEAR,
    PASSAGE,
    ROOMY,
    Terms,
    draw_arena,
    draw_scenario,
)
from fledge.geometry import Box
from fledge.world import Arena, check_arena

TERMS = Terms()
DRAWS = [draw_scenario(np.random.default_rng(i), i % len(FAMILIES), i % 4, TERMS) for i in range(150)]


def gaps(scenario):
    return [
        near.gap
        for near in clearances(scenario.arena, scenario.world, TERMS.rig.uav, TERMS.rig.formation.fleet)
    ]


def test_arenas_are_sound_and_of_every_number_of_obstacles():
    arenas = [check_arena(draw.scenario.arena) for draw in DRAWS]
    counts = {len(arena.obstacles) for arena in arenas}
    assert counts >= set(range(6)) and max(counts) <= MOST_OBSTACLES
    assert {arena.ceiling for arena in arenas} == {4.0, 6.0}


def test_a_gap_is_closed_or_wide_enough():
    for draw in DRAWS:
        boxes = [obstacle.footprint for obstacle in draw.scenario.arena.obstacles]
        for i, a in enumerate(boxes):
            for b in boxes[:i]:
                across = max(a.x_min - b.x_max, b.x_min - a.x_max, 0.0)
                along = max(a.y_min - b.y_max, b.y_min - a.y_max, 0.0)
                assert np.hypot(across, along) == 0.0 or np.hypot(across, along) >= PASSAGE


def test_everybody_starts_with_room():
    for draw in DRAWS:
        uav, *ugvs = gaps(draw.scenario)
        assert uav > 0.0
        assert min(ugvs) > ROOMY[1]


def test_at_least_a_quarter_starts_near_a_wall_or_an_obstacle():
    near = 0
    for draw in DRAWS:
        arena, world = draw.scenario.arena, draw.scenario.world
        b, fleet = arena.bounds, TERMS.rig.formation.fleet
        places = (
            (world.uav.position, 0.26),
            *zip(world.ugvs, (model.radius for model in fleet), strict=True),
        )
        alone = 0
        for place, radius in places:
            walls = min(place.x - b.x_min, b.x_max - place.x, place.y - b.y_min, b.y_max - place.y)
            things = [o.footprint.distance(place.x, place.y) for o in arena.obstacles]
            alone += min([walls, *things]) - radius < NEAR
        assert alone >= draw.near - 1, "it may be near the top of an obstacle, or the ceiling"
        near += draw.near
    assert near >= 0.25 * len(DRAWS) * TERMS.vehicles


def test_what_is_rejected_is_counted():
    rejected = sum(draw.rejected for draw in DRAWS)
    assert rejected > 0
    counted = sum(draw_arena(np.random.default_rng(i))[1] for i in range(150))
    assert rejected >= counted, "arenas without room for the vehicles count, too"


def test_the_same_seed_draws_the_same():
    again = draw_scenario(np.random.default_rng(3), 3, 3, TERMS)
    assert again == DRAWS[3]
    assert again != DRAWS[4]


def test_half_the_flights_use_the_whole_contract_and_none_more():
    troubles = [draw.scenario.trouble for draw in DRAWS]
    most = round(TERMS.contract.age / TERMS.contract.period)
    assert 0.3 < np.mean([one.share == 1.0 and one.age == most for one in troubles]) < 0.7
    assert max(one.share for one in troubles) == 1.0
    assert max(one.age for one in troubles) == most
    assert {one.malice for one in troubles} == {one.cut for one in troubles} == {0.0, 1.0}


def test_a_factor_oversteps_the_contract():
    over = Terms(factor=2.0)
    troubles = [draw_scenario(np.random.default_rng(i), 0, 0, over).scenario.trouble for i in range(20)]
    assert max(one.share for one in troubles) == 2.0
    assert max(one.latency for one in troubles) == 2.0 * max(d.scenario.trouble.latency for d in DRAWS)


def test_a_given_arena_is_flown_in_and_one_without_room_is_refused():
    lab = Arena(Box(-3.3, 3.3, -2.5, 2.5), 4.0)
    draw = draw_scenario(np.random.default_rng(0), 0, 0, Terms(arena=lab))
    assert draw.scenario.arena == lab and draw.rejected == 0
    closet = Arena(Box(-0.6, 0.6, -0.6, 0.6), 2.0)
    with pytest.raises(FledgeError, match="no room for a UAV and 3 UGVs: valid is one where"):
        draw_scenario(np.random.default_rng(0), 0, 0, Terms(arena=closet))


def test_a_script_is_taken_as_it_is_and_all_else_is_drawn_alike():
    script = np.full((8, 3), 0.5)
    given, drawn = (draw_scenario(np.random.default_rng(5), 9, 1, TERMS, s).scenario for s in (script, None))
    assert [line.x for line in given.nature.script] == [0.5] * 8
    assert given.world == drawn.world and given.trouble == drawn.trouble
