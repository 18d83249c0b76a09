"""How a day begins: everybody has room, wherever obstacles stand; else one clear line."""

from math import hypot

import numpy as np
import pytest

from fledge.dynamics import REAL_AR_DRONE, UGV_FLEET
from fledge.errors import FledgeError
from fledge.formation import FormationControl
from fledge.geometry import Box
from fledge.lab import opening
from fledge.lab.opening import SPREADS, draw, pad
from fledge.world import Arena, Obstacle

ROWS = 400
FORMATION = FormationControl()
LAB = Arena.lab()


def places(plan):
    track = plan.track
    first = type(track)(
        *(getattr(track, name)[0] for name in ("x", "y", "vx", "vy", "spread", "spread_rate"))
    )
    return [(x, y) for x, y, _, _ in FORMATION.corners(first, plan.orientation)]


def free(arena, x, y, radius):
    return (
        min([-arena.bounds.distance(x, y), *(one.footprint.distance(x, y) for one in arena.obstacles)])
        - radius
    )


@pytest.mark.parametrize("seed", range(20))
def test_a_plan_is_lateral_motion_in_the_middle_of_the_room(seed):
    plan = draw(np.random.default_rng(seed), LAB, ROWS, FORMATION)
    track = plan.track
    assert len(track.x) == ROWS and type(track.x[0]) is float
    assert set(track.spread) <= set(SPREADS) and not any(track.spread_rate)
    assert max(map(hypot, track.x, track.y)) < 1.2
    assert max(map(hypot, track.vx, track.vy)) < 0.35
    # Every corner of it, all the way, leaves its robot room within the walls.
    reach = max(abs(y) for y in track.y) + track.spread[0] + UGV_FLEET[0].radius
    assert reach < LAB.bounds.y_max


def test_the_room_may_be_anywhere():
    away = Arena(Box(10.0, 16.6, -30.0, -25.0), 4.0)
    plan = draw(np.random.default_rng(0), away, ROWS, FORMATION)
    assert np.mean(plan.track.x) == pytest.approx(13.3, abs=1.0)
    assert np.mean(plan.track.y) == pytest.approx(-27.5, abs=1.0)


@pytest.mark.parametrize("seed", range(10))
def test_the_formation_begins_clear_of_obstacles(seed):
    box = Obstacle(Box(-0.3, 0.3, 0.5, 1.1), 0.5)
    arena = Arena(LAB.bounds, LAB.ceiling, (box,))
    plan = draw(np.random.default_rng(seed), arena, ROWS, FORMATION)
    for (x, y), model in zip(places(plan), UGV_FLEET, strict=True):
        assert free(arena, x, y, model.radius) > opening.FREE


def test_an_arena_that_is_too_small_is_refused():
    with pytest.raises(FledgeError, match="found no place to begin"):
        draw(np.random.default_rng(0), Arena(Box(-1.0, 1.0, -1.0, 1.0), 4.0), ROWS, FORMATION)


def test_the_pad_is_clear_of_everything():
    ugvs = [(0.8, 0.0), (-0.4, 0.7), (-0.4, -0.7)]
    box = Obstacle(Box(2.0, 3.0, 1.0, 2.0), 0.5)
    arena = Arena(LAB.bounds, LAB.ceiling, (box,))
    x, y = pad(arena, ugvs)
    assert free(arena, x, y, REAL_AR_DRONE.radius) >= opening.FREE
    assert min(hypot(x - a, y - b) for a, b in ugvs) > 1.0
    assert -arena.bounds.distance(x, y) == pytest.approx(opening.INSET)


def test_a_room_with_full_corners_has_no_pad():
    corners = [(x, y) for x in (-3.3, 1.8) for y in (-2.5, 1.0)]
    boxes = tuple(Obstacle(Box(x, x + 1.5, y, y + 1.5), 1.0) for x, y in corners)
    with pytest.raises(FledgeError, match="no corner of the safe area has room"):
        pad(Arena(LAB.bounds, LAB.ceiling, boxes), [])
