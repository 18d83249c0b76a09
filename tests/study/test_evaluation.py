"""Scores: against numbers worked out by hand, and the same for a flight in whatever company it is flown."""

import math
from dataclasses import replace

import jax
import numpy as np
import pytest

from fledge.camera import Lens
from fledge.engines import fly_plain, take
from fledge.episode import Episode
from fledge.geometry import Quat, Vec3
from fledge.learning.policy import HIDDEN, Policy
from fledge.learning.training import member
from fledge.manoeuvres import Combined
from fledge.observation import IDEAL_RADIUS_PX, ROW_RATE, Action, Axes, StickScale
from fledge.pilots import AbstractPilot, Servo
from fledge.pytrees import register
from fledge.simulation import Case, Crew, Rig
from fledge.study.evaluation import Score, evaluate, score
from fledge.study.metrics import METRICS
from fledge.world import UavState, UgvState, WorldState

pytestmark = pytest.mark.slow

ROWS = 60
PLAIN_ROWS = 12
"""For flights in plain Python."""
CASES = 10
KEYS = [(7, 1, 2, i) for i in range(2 * CASES)]
RIG = Rig()


def constructed(away, spread, altitude, forward, left, up):
    """A level UAV, nose to the east, over a triangle of circumradius `spread` whose centre is `away` to its left."""
    away, spread, altitude, forward, left, up = (
        np.asarray(part, float) for part in (away, spread, altitude, forward, left, up)
    )
    nothing = np.zeros(away.shape)
    still = Vec3(nothing, nothing, nothing)
    level = Quat(nothing + 1.0, nothing, nothing, nothing)
    uav = UavState(Vec3(nothing + 3.0, nothing - 2.0, altitude), still, level, still, nothing)
    ugvs = tuple(
        UgvState(3.0 + spread * math.cos(a), away - 2.0 + spread * math.sin(a), *(nothing,) * 4)
        for a in (0.3, 0.3 + 2.0 * math.pi / 3.0, 0.3 - 2.0 * math.pi / 3.0)
    )
    world = WorldState(nothing, uav, ugvs)
    # What the pilot saw and what a net made of it play no part.
    return Episode(world, None, Action(forward, left, up, nothing + 0.7), None, (), nothing)


BY_HAND = (
    [0.0, 0.3, -0.4, 2.0],  # away
    [0.6, 0.5, 0.8, 0.6],  # spread
    [2.0, 2.0, 4.0, 2.0],  # altitude
    [0.0, 0.5, 0.5, 0.0],  # forward
    [0.25, 0.25, 0.25, 0.25],  # left
    [-1.0, 1.0, -1.0, 1.0],  # up
)
FLOWN = constructed(*BY_HAND)
F = RIG.lens.focal_px
D = F * np.array([0.0, 0.15, 0.1, 1.0])
"""[px] of the centroid from the image's centre."""
E = F * np.array([0.3, 0.25, 0.2, 0.3]) - IDEAL_RADIUS_PX
"""[px] of radius too many."""


def table(scores):
    """Scores as an array: one line per score."""
    return np.array([np.asarray(getattr(scores, name)) for name in Score.names()])


# By hand


def test_the_scores_of_a_constructed_flight():
    got = score(FLOWN, RIG)
    for name, wanted in {
        "distance": D.mean(),
        "distance_rmse": math.sqrt((D**2).mean()),
        "radius": (E**2).mean(),
        "radius_rmse": math.sqrt((E**2).mean()),
        # In the last frame the centroid is 1.0 f = 375 px to the side; the picture ends at 320.
        "in_view": 3 / 4,
        # Changes: forward 0.5, 0, 0.5; left none; up 2, 2, 2. Yaw does not count.
        "smoothness": (1.0 + 0.0 + 6.0) / 9.0 * ROW_RATE,
        "effort": (0.25 + 0.25 + 1.0) / 3.0,
    }.items():
        assert float(getattr(got, name)) == pytest.approx(wanted, rel=1e-5), name
    assert Score.names() == (
        *("distance", "distance_rmse", "radius", "radius_rmse", "in_view", "smoothness", "effort"),
    )


def test_many_flights_are_scored_as_each_alone():
    other = ([0.1] * 4, [0.5] * 4, [1.5] * 4, [0.1] * 4, [0.2] * 4, [0.3, 0.3, 0.3, -0.3])
    both = constructed(*np.stack([BY_HAND, other], axis=1))
    alone = np.stack([table(score(constructed(*flight), RIG)) for flight in (BY_HAND, other)], axis=1)
    np.testing.assert_allclose(table(score(both, RIG)), alone, rtol=1e-5)


def test_a_perfect_flight_scores_nothing():
    """On the spot, at the ideal radius, sticks at rest."""
    still = constructed([0.0] * 5, [0.6] * 5, [F * 0.6 / IDEAL_RADIUS_PX] * 5, *([[0.0] * 5] * 3))
    got = score(still, RIG)
    np.testing.assert_allclose(table(got), [0, 0, 0, 0, 1, 0, 0], atol=1e-4)
    for metric, perfect, flown in zip(METRICS.values(), table(got), table(score(FLOWN, RIG)), strict=True):
        assert perfect < flown if metric.lower_is_better else perfect > flown


@pytest.mark.parametrize("stick", [-1.0, 0.3, 1.0])
def test_a_constant_action_is_perfectly_smooth(stick):
    held = constructed([0.0] * 9, [0.6] * 9, [2.0] * 9, *([[stick] * 9] * 3))
    got = score(held, RIG)
    assert float(got.smoothness) == 0.0
    assert float(got.effort) == pytest.approx(abs(stick))


@pytest.mark.parametrize("shown", [[], [0], [1, 4], [0, 1, 2, 3, 4]])
def test_in_view_counts_frames(shown):
    away = [0.0 if row in shown else 9.0 for row in range(5)]
    flown = constructed(away, [0.5] * 5, [2.0] * 5, *([[0.0] * 5] * 3))
    assert float(score(flown, RIG).in_view) == pytest.approx(len(shown) / 5)


def test_one_ugv_out_of_the_picture_is_enough():
    """The formation is centred, but too large for the short side: its nose is 194 px ahead, of 180."""
    flown = constructed([0.0] * 2, [0.3, 0.65], [1.2] * 2, *([[0.0] * 2] * 3))
    assert float(score(flown, RIG).in_view) == 0.5
    tall = replace(RIG, lens=Lens(height_px=640.0))
    assert float(score(flown, tall).in_view) == 1.0


@pytest.mark.parametrize("k", [0.5, 3.0])
def test_scores_have_the_units_they_say(k):
    """A lens with k times the pixels: distances in px grow k-fold, squares k^2-fold, shares and sticks stay."""
    fine = Rig(lens=Lens(k * F, k * 640.0, k * 360.0), ideal_radius=k * IDEAL_RADIUS_PX)
    factors = np.array([k, k, k * k, k, 1.0, 1.0, 1.0])
    np.testing.assert_allclose(table(score(FLOWN, fine)), factors * table(score(FLOWN, RIG)), rtol=1e-4)


# Flown


@pytest.fixture(scope="module")
def cases():
    return [Case.draw(Combined(), key, ROWS) for key in KEYS]


@pytest.fixture(scope="module")
def served(cases):
    """The servo on the first ten cases: (scores, first flight)."""
    return evaluate(cases[:CASES], Crew(Servo()), KEYS[:CASES])


def some_policies(seeds=2):
    """Untrained networks, stacked; weak ones, so that they stay near."""
    rng = np.random.default_rng(0)
    sizes = (11, *HIDDEN, 4)
    layers = list(zip(sizes[:-1], sizes[1:], strict=True))
    return Policy(
        weights=tuple((rng.normal(size=(seeds, *s)) / np.sqrt(s[0])).astype(np.float32) for s in layers),
        biases=tuple(rng.normal(0.0, 0.1, (seeds, n)).astype(np.float32) for _, n in layers),
        mean=np.full((seeds, 11), 100.0, np.float32),
        scale=np.full((seeds, 11), 300.0, np.float32),
        inputs=tuple(range(11)),
        states=11,
    )


def test_one_pilot_is_one_seed(cases, served):
    scores, first = served
    assert table(scores).shape == (len(Score.names()), 1, CASES)
    assert np.isfinite(table(scores)).all()
    assert {np.shape(leaf) for leaf in jax.tree.leaves(first)} == {(ROWS,)}
    np.testing.assert_allclose(table(score(first, RIG)), table(scores)[:, 0, 0], rtol=1e-4, atol=1e-5)


def test_the_first_case_is_the_first_case(cases, served):
    """The flight that comes along is that of case 0; its track says so."""
    track = cases[0].plan.track
    np.testing.assert_allclose(served[1].ideal_spread, track.spread, rtol=1e-5)


def test_scores_do_not_depend_on_the_other_cases(cases, served):
    """The last case first, among nine strangers."""
    pick = [CASES - 1, *range(CASES, 2 * CASES - 1)]
    mixed, first = evaluate([cases[i] for i in pick], Crew(Servo()), [KEYS[i] for i in pick])
    np.testing.assert_allclose(table(mixed)[:, 0, 0], table(served[0])[:, 0, -1], rtol=1e-5, atol=1e-6)
    assert not np.allclose(table(mixed)[:, 0, 1], table(served[0])[:, 0, 0])
    np.testing.assert_allclose(first.ideal_spread, cases[CASES - 1].plan.track.spread, rtol=1e-5)


def test_other_chance_gives_other_scores(cases, served):
    again, _ = evaluate(cases[:CASES], Crew(Servo()), KEYS[:CASES])
    np.testing.assert_array_equal(table(again), table(served[0]))
    other, _ = evaluate(cases[:CASES], Crew(Servo()), KEYS[CASES:])
    assert not (table(other)[0] == table(served[0])[0]).any()


def test_a_team_flies_as_each_of_its_members(cases):
    """In either order; and as each of them does alone, on the other backend."""
    team = some_policies()
    register(team)
    swapped = jax.tree.map(lambda leaf: leaf[::-1], team)
    together, first = evaluate(cases[:CASES], Crew(team), KEYS[:CASES], team=True)
    mirrored, second = evaluate(cases[:CASES], Crew(swapped), KEYS[:CASES], team=True)
    assert table(together).shape == (len(Score.names()), 2, CASES)
    np.testing.assert_array_equal(table(together)[:, ::-1], table(mirrored))
    for i, flight in enumerate((first, second)):
        np.testing.assert_allclose(table(together)[:, i, 0], table(score(flight, RIG)), rtol=1e-4, atol=1e-5)
        alone = fly_plain(cases[0].lasting(PLAIN_ROWS), Crew(member(team, i)), KEYS[0])
        for part in ("x", "y", "z"):
            together_at, alone_at = (getattr(e.world.uav.position, part) for e in (flight, alone))
            np.testing.assert_allclose(together_at[:PLAIN_ROWS], alone_at, atol=1e-3)
        np.testing.assert_allclose(flight.action.forward[:PLAIN_ROWS], alone.action.forward, atol=1e-3)
    assert not np.allclose(together.distance[0], together.distance[1])


class PlainServo(AbstractPilot):
    """What no compiler can follow: `math` and `if`."""

    name = "plain-servo"

    def act(self, memory, observation, noise):
        pixels = observation.centre_v - observation.ugv_v
        forward = math.tanh(0.01 * pixels) if abs(pixels) > 3.0 else 0.0
        return memory, Action(forward, 0.0, 0.0, 0.0)


def test_a_pilot_in_plain_python_is_evaluated_too(cases):
    short = [case.lasting(PLAIN_ROWS) for case in cases[:2]]
    scores, first = evaluate(short, Crew(PlainServo()), KEYS[:2])
    assert table(scores).shape == (len(Score.names()), 1, 2)
    for i, (case, key) in enumerate(zip(short, KEYS, strict=False)):
        flight = fly_plain(case, Crew(PlainServo()), key)
        np.testing.assert_allclose(table(scores)[:, 0, i], table(score(flight, RIG)), rtol=1e-6)
        if i == 0:
            jax.tree.map(np.testing.assert_array_equal, first, flight)


def test_a_compiled_flight_scores_as_the_same_flight_in_plain_python(cases, served):
    """The beginning of case 0, on the other backend; the scores are of exact poses on both."""
    plain = fly_plain(cases[0].lasting(PLAIN_ROWS), Crew(Servo()), KEYS[0])
    compiled = take(jax.tree.map(lambda leaf: leaf[None], served[1]), 0, PLAIN_ROWS)
    np.testing.assert_allclose(table(score(plain, RIG)), table(score(compiled, RIG)), rtol=1e-2, atol=1e-3)


def test_the_rig_that_flies_is_the_rig_that_scores(cases):
    """Another set-point, another error: evaluate scores with the rig it was given."""
    rig = Rig(ideal_radius=90.0, sticks=StickScale(horizontal=0.5))
    case = cases[0].lasting(PLAIN_ROWS)
    scores, first = evaluate([case], Crew(PlainServo(), Axes.of((0, 1))), KEYS[:1], rig)
    np.testing.assert_allclose(table(scores)[:, 0, 0], table(score(first, rig)), rtol=1e-6)
    assert (first.observation.ideal_radius == 90.0).all()
    assert abs(float(scores.radius_rmse[0, 0]) - float(score(first, RIG).radius_rmse)) > 5.0
