"""Guidance of the three UGVs: where it leads them, and what it keeps them from."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.formation import FormationControl
from fledge.geometry import Box
from fledge.manoeuvres import Combined, FixedAltitude, FormationTrack, Plan
from fledge.manoeuvres.paths import FAMILIES, HELD_OUT_FAMILIES, TRAINING_FAMILIES
from fledge.observation import ROW_RATE
from fledge.world import Arena, Obstacle, UgvState

pytestmark = pytest.mark.slow

CONTROL = FormationControl()
OPEN = Arena(Box(-50.0, 50.0, -50.0, 50.0), 6.0)
STEPS = 5
"""Physics steps per row; the vehicles are driven at 100 Hz here, which is enough for a unicycle."""

metres = st.floats(-3.0, 3.0, allow_subnormal=False)
angles = st.floats(-math.pi, math.pi, allow_subnormal=False)


def standing(spread=0.8, x=0.0, y=0.0) -> FormationTrack:
    return FormationTrack(x, y, 0.0, 0.0, spread, 0.0)


def at(track: FormationTrack, row: int) -> FormationTrack:
    return FormationTrack(*(getattr(track, field.name)[row] for field in fields(track)))


def placed(places, heading=0.0) -> tuple[UgvState, ...]:
    return tuple(UgvState(x, y, heading + 0.0 * x, 0.0 * x, 0.0 * x, 0.0 * x) for x, y in places)


def on_corners(target, orientation) -> tuple[UgvState, ...]:
    return placed(((x, y) for x, y, _, _ in CONTROL.corners(target, orientation)), orientation)


def drive(ugvs, track, orientation, arena, rows):
    """The UGVs at the end of every row."""
    dt, history = 1.0 / ROW_RATE / STEPS, []
    for row in range(rows):
        told = CONTROL.commands(ugvs, at(track, row), orientation, arena)
        for _ in range(STEPS):
            ugvs = tuple(m.step(u, c, dt) for m, u, c in zip(CONTROL.fleet, ugvs, told, strict=True))
        history.append(ugvs)
    return history


def constant(target: FormationTrack, rows: int) -> FormationTrack:
    return FormationTrack(*(np.full(rows, getattr(target, field.name)).tolist() for field in fields(target)))


def errors(ugvs, target, orientation) -> np.ndarray:
    """Distance of each UGV from its corner [m]; the UGVs along the first axis."""
    corners = CONTROL.corners(target, orientation)
    return np.array([np.hypot(u.x - x, u.y - y) for u, (x, y, _, _) in zip(ugvs, corners, strict=True)])


def clearances(ugvs, arena) -> dict[str, np.ndarray]:
    """Smallest free distances between hulls and walls, boxes and each other [m]."""
    radii, far = [model.radius for model in CONTROL.fleet], np.inf
    walls = [-arena.bounds.distance(u.x, u.y) - r for u, r in zip(ugvs, radii, strict=True)]
    boxes = [
        obstacle.footprint.distance(u.x, u.y) - r
        for u, r in zip(ugvs, radii, strict=True)
        for obstacle in arena.obstacles
    ]
    others = [
        np.hypot(ugvs[i].x - ugvs[j].x, ugvs[i].y - ugvs[j].y) - radii[i] - radii[j]
        for i, j in ((0, 1), (0, 2), (1, 2))
    ]
    return {"walls": min_of(walls), "boxes": min_of(boxes, far), "others": min_of(others)}


def min_of(values, otherwise=None):
    return np.min(np.stack(values), axis=0) if values else otherwise


def stacked(plans) -> Plan:
    """One plan of arrays: track leaves (rows, plans), the rest (plans,)."""

    def gather(*records):
        return type(records[0])(
            *(np.array([getattr(r, f.name) for r in records]).T for f in fields(records[0]))
        )

    obstacles = tuple(
        Obstacle(gather(*(o.footprint for o in same)), np.array([o.height for o in same]))
        for same in zip(*(plan.arena.obstacles for plan in plans), strict=True)
    )
    arena = replace(plans[0].arena, obstacles=obstacles)
    return Plan(
        arena, gather(*(plan.track for plan in plans)), np.array([plan.orientation for plan in plans])
    )


def flown(plans, rows: int):
    """(smallest clearances, errors of shape (rows, UGVs, plans)) of many formations driven side by side."""
    plan = stacked(plans)
    begin = on_corners(at(plan.track, 0), plan.orientation)
    history = drive(begin, plan.track, plan.orientation, plan.arena, rows)
    seen = [clearances(ugvs, plan.arena) for ugvs in history]
    smallest = {name: np.min([row[name] for row in seen], axis=0) for name in seen[0]}
    return smallest, np.array([
        errors(u, at(plan.track, row), plan.orientation) for row, u in enumerate(history)
    ])


@given(metres, metres, st.floats(0.5, 1.5), angles)
def test_the_corners_are_an_equilateral_triangle_about_the_centre(x, y, spread, orientation):
    places = np.array(CONTROL.corners(standing(spread, x, y), orientation))[:, :2]
    np.testing.assert_allclose(places.mean(axis=0), (x, y), atol=1e-12)
    np.testing.assert_allclose(np.hypot(*(places - (x, y)).T), spread)
    sides = np.linalg.norm(places - np.roll(places, 1, axis=0), axis=1)
    np.testing.assert_allclose(sides, math.sqrt(3.0) * spread)
    first = places[0] - (x, y)
    np.testing.assert_allclose(
        first, spread * np.array([math.cos(orientation), math.sin(orientation)]), atol=1e-12
    )


def test_the_corners_velocities_are_the_derivatives_of_their_places():
    target, moment = FormationTrack(0.1, 0.2, 0.3, -0.1, 0.9, 0.05), 1e-6
    moved = FormationTrack(
        target.x + target.vx * moment,
        target.y + target.vy * moment,
        target.vx,
        target.vy,
        target.spread + target.spread_rate * moment,
        target.spread_rate,
    )
    now, later = (np.array(CONTROL.corners(t, 0.7)) for t in (target, moved))
    np.testing.assert_allclose((later - now)[:, :2] / moment, now[:, 2:], atol=1e-8)


def test_on_its_corners_a_formation_that_should_stand_stands():
    for told in CONTROL.commands(on_corners(standing(), 0.4), standing(), 0.4, OPEN):
        assert told.forward == pytest.approx(0.0, abs=1e-9)
        assert told.turn == pytest.approx(0.0, abs=1e-3)


@given(st.lists(st.tuples(metres, metres, angles), min_size=3, max_size=3, unique=True), angles)
def test_no_ugv_is_told_to_leave_the_ground_or_to_go_faster_than_it_may(scattered, orientation):
    ugvs = tuple(UgvState(x, y, heading, 0.0, 0.0, 0.0) for x, y, heading in scattered)
    for told in CONTROL.commands(ugvs, standing(), orientation, Arena.square()):
        assert (told.left, told.up) == (0.0, 0.0)
        assert abs(told.forward) <= CONTROL.max_speed
        assert abs(told.turn) <= CONTROL.max_turn


def lone(x, y, heading, **limits) -> float:
    """The speed that a UGV at (x, y) is told on its way to a far corner in the east, the others being far away."""
    ugvs = placed([(x, y), (0.0, 30.0), (0.0, -30.0)], heading)
    control = replace(CONTROL, **limits)
    target = standing(0.8, x=20.0, y=y)
    return control.commands(ugvs, target, 0.0, replace(OPEN, bounds=Box(-5.0, 5.0, -50.0, 50.0)))[0].forward


def test_nothing_is_approached_faster_than_a_stop_allows_that_a_lost_link_delays():
    """0.6 s at the command, then braking at the 0.7 m/s^2 that the nets' contract leaves: it ends before the wall."""
    for gap in (0.1, 0.2, 0.4, 0.8, 2.0):
        speed = lone(5.0 - CONTROL.fleet[0].radius - gap, 0.0, 0.0)
        assert 0.0 < speed <= CONTROL.max_speed
        assert 0.6 * speed + speed**2 / (2.0 * 0.7) <= gap


def test_a_turning_ugv_counts_on_where_its_turn_may_lead_it():
    beside = (5.0 - CONTROL.fleet[0].radius - 0.2, 0.0, -1.3)
    assert 0.0 < lone(*beside) < lone(*beside, foresight=0.0)


def test_of_two_that_approach_each_other_the_later_one_makes_allowance():
    """The first UGV comes from the west, the second from the east, each towards a corner behind the other."""
    start = placed([(-0.6, 0.0), (0.6, 0.0), (0.0, -30.0)])
    behind = replace(CONTROL, pull=2.0)
    told = behind.commands(start, standing(0.8), 0.0, OPEN)
    first, second = told[0].forward, -told[1].forward
    gap = 1.2 - CONTROL.fleet[0].radius - CONTROL.fleet[1].radius
    assert first > 0.0
    assert first + max(second, 0.0) <= CONTROL.approach * gap


@pytest.mark.parametrize("seed", range(8))
def test_displaced_ugvs_come_back_to_their_corners_whichever_way_they_face(seed):
    rng, target, orientation = np.random.default_rng(seed), standing(1.0), 0.3
    ugvs = tuple(
        UgvState(x + 0.2 * math.cos(a), y + 0.2 * math.sin(a), rng.uniform(-3.0, 3.0), 0.0, 0.0, 0.0)
        for (x, y, _, _), a in zip(
            CONTROL.corners(target, orientation), rng.uniform(-3.0, 3.0, 3), strict=True
        )
    )
    history = drive(ugvs, constant(target, 300), orientation, OPEN, 300)
    assert errors(history[-1], target, orientation).max() < 0.02
    assert max(abs(ugv.speed) for ugv in history[-1]) < 0.01


def test_a_corner_behind_is_reached_in_reverse():
    target = standing(0.8)
    behind = replace(target, x=-0.3)
    for told in CONTROL.commands(on_corners(target, 0.0), behind, 0.0, OPEN):
        assert told.forward < 0.0
        assert told.turn == pytest.approx(0.0, abs=1e-6)


def test_a_steadily_moving_formation_is_followed_closely():
    rows = 400
    t = np.arange(rows) / ROW_RATE
    track = FormationTrack.through(0.3 * t, 0.1 * t, 0.8 + 0.02 * t)
    history = drive(on_corners(at(track, 0), 1.0), track, 1.0, OPEN, rows)
    assert errors(history[-1], at(track, rows - 1), 1.0).max() < 0.05


def test_boxes_out_of_reach_change_nothing():
    plan = Combined().plan(np.random.default_rng(5), 100)
    target = at(plan.track, 50)
    ugvs = on_corners(replace(target, x=target.x + 0.3), plan.orientation)
    told = CONTROL.commands(ugvs, target, plan.orientation, plan.arena)
    assert told == CONTROL.commands(ugvs, target, plan.orientation, plan.arena.padded(7))


def test_walls_hold_a_formation_that_is_told_to_leave():
    """It comes as near as the clearance and stays there."""
    target, arena, rows = standing(0.8, x=6.0), Arena.square(), 600
    ugvs = on_corners(standing(0.8, x=2.0), 0.0)
    history = drive(ugvs, constant(target, rows), 0.0, arena, rows)
    walls = [clearances(ugvs, arena)["walls"] for ugvs in history]
    assert min(walls) > 0.0
    assert walls[-1] == pytest.approx(CONTROL.clearance, abs=0.03)


@pytest.mark.parametrize("aside", (-0.3, -0.15, 0.15, 0.3))
def test_a_box_in_the_way_squeezes_the_formation_which_then_recovers(aside):
    """The first UGV's way leads over a small box, a little off its middle; the others have room."""
    rows = 540
    x = np.clip(-2.5 + 0.25 * np.maximum(np.arange(rows) / ROW_RATE - 1.0, 0.0), -2.5, 2.5)
    track = FormationTrack.through(x, np.zeros(rows), np.full(rows, 0.8))
    place = 0.8 + aside
    arena = replace(OPEN, obstacles=(Obstacle(Box(-0.1, 0.1, place - 0.1, place + 0.1), 0.5),))
    north = math.pi / 2
    history = drive(on_corners(at(track, 0), north), track, north, arena, rows)
    off = np.array([errors(ugvs, at(track, row), north) for row, ugvs in enumerate(history)])
    assert off[:, 0].max() > 0.3
    assert off[-1].max() < 0.05
    smallest = [min(clearances(ugvs, arena).values()) for ugvs in history]
    assert min(smallest) > 0.0


def test_with_nothing_in_the_way_hulls_never_touch_and_corners_are_kept():
    manoeuvre = FixedAltitude(families=tuple(FAMILIES))
    plans = [manoeuvre.plan(np.random.default_rng(seed), 600) for seed in range(60)]
    smallest, off = flown(plans, 600)
    assert min(distance.min() for distance in smallest.values()) > 0.0
    assert np.median(off) < 0.05
    assert np.quantile(off, 0.99) < 0.3


@pytest.fixture(scope="module", params=(TRAINING_FAMILIES, HELD_OUT_FAMILIES), ids=("training", "held out"))
def among_boxes(request):
    plans = [Combined(families=request.param).plan(np.random.default_rng(seed), 1200) for seed in range(80)]
    return flown(plans, 1200)


def test_among_random_boxes_no_hull_touches_a_wall(among_boxes):
    assert among_boxes[0]["walls"].min() > 0.0


def test_among_random_boxes_no_hull_touches_a_box(among_boxes):
    assert among_boxes[0]["boxes"].min() > 0.0


def test_among_random_boxes_no_hull_touches_another(among_boxes):
    assert among_boxes[0]["others"].min() > 0.0


def test_among_random_boxes_most_ugvs_are_where_they_should_be_most_of_the_time(among_boxes):
    _, off = among_boxes
    assert np.isfinite(off).all()
    assert np.median(off) < 0.05
    assert np.quantile(off, 0.8) < 0.3
