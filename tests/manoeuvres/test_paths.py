"""The five families of paths, and travelling along them."""

import numpy as np
import pytest

from fledge.manoeuvres.paths import (
    ACCELERATION,
    DEVELOPMENT_FAMILIES,
    FAMILIES,
    HELD_OUT_FAMILIES,
    POINTS,
    SPEEDS,
    TRAINING_FAMILIES,
    travel,
)
from fledge.observation import ROW_RATE

REACH = 2.6
SEEDS = range(20)


def path_of(family: str, seed: int) -> np.ndarray:
    return FAMILIES[family](np.random.default_rng(seed), REACH)


def distances_to(path: np.ndarray, points: np.ndarray) -> np.ndarray:
    """From each point to the nearest segment of the polyline."""
    start, along = path[:-1], np.diff(path, axis=0)
    share = ((points[:, None] - start) * along).sum(-1) / np.maximum((along**2).sum(-1), 1e-18)
    nearest = start + np.clip(share, 0.0, 1.0)[..., None] * along
    return np.linalg.norm(points[:, None] - nearest, axis=-1).min(axis=1)


def test_every_family_serves_one_purpose_only():
    """What is learnt from, what the method is chosen on, and what it is tested on are kept apart."""
    purposes = (*TRAINING_FAMILIES, *DEVELOPMENT_FAMILIES, *HELD_OUT_FAMILIES)
    assert sorted(purposes) == sorted(FAMILIES)


@pytest.mark.parametrize("seed", SEEDS)
def test_an_eight_is_closed_and_crosses_itself_in_the_middle(seed):
    path = path_of("eight", seed)
    np.testing.assert_allclose(path[0], path[-1], atol=1e-9)
    np.testing.assert_allclose(path[0], 0.0, atol=1e-9)
    half = len(path) // 2
    np.testing.assert_allclose(path[:half].mean(axis=0), -path[-half:].mean(axis=0), atol=1e-9)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_path_is_an_unbroken_line_about_the_origin(family, seed):
    path = path_of(family, seed)
    assert path.shape == (POINTS, 2)
    # A line may be moved aside by 0.3 m, and a wave stands across the end of its leg.
    assert np.abs(path).max() <= REACH + 0.3 + 1e-9
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() < 0.2
    np.testing.assert_array_equal(path, path_of(family, seed))
    assert not np.array_equal(path, path_of(family, seed + 1))


@pytest.mark.parametrize("seed", SEEDS)
def test_a_line_is_straight(seed):
    path = path_of("line", seed)
    assert np.linalg.svd(path - path.mean(axis=0))[1][1] < 1e-9
    assert np.linalg.norm(path[-1] - path[0]) == pytest.approx(2.0 * REACH)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_circle_keeps_its_distance_from_the_middle_and_does_not_quite_close(seed):
    path = path_of("circle", seed)
    radii = np.linalg.norm(path, axis=1)
    np.testing.assert_allclose(radii, radii[0])
    assert 0.5 * REACH <= radii[0] <= REACH
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert length == pytest.approx(1.9 * np.pi * radii[0], rel=1e-3)


@pytest.mark.parametrize("seed", SEEDS)
def test_an_ell_ends_at_a_right_angle_to_its_beginning(seed):
    path = path_of("ell", seed)
    first, last = path[1] - path[0], path[-1] - path[-2]
    assert first @ last == pytest.approx(0.0, abs=1e-9)
    assert np.linalg.norm(first) > 0.0 < np.linalg.norm(last)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_sine_swings_across_its_leg(seed):
    path = path_of("sine", seed)
    turned = path @ np.linalg.svd(path - path.mean(axis=0))[2].T
    assert np.ptp(turned[:, 1]) > 0.4
    assert np.ptp(turned[:, 0]) > 2.0 * np.ptp(turned[:, 1]) / 1.8


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", range(5))
def test_travelling_keeps_to_the_path_and_to_the_speeds(family, seed):
    path = path_of(family, seed)
    xy = travel(np.random.default_rng(seed), path, 600)
    assert xy.shape == (600, 2)
    assert distances_to(path, xy).max() < 1e-9
    speeds = np.linalg.norm(np.diff(xy, axis=0), axis=1) * ROW_RATE
    assert speeds.max() <= SPEEDS[1] + 1e-9


def test_it_starts_from_rest_speeds_up_gently_and_turns_back_at_the_ends():
    path = np.stack([np.linspace(0.0, 1.5, POINTS), np.zeros(POINTS)], axis=1)
    x = travel(np.random.default_rng(3), path, 1200)[:, 0]
    velocity = np.diff(x) * ROW_RATE
    assert abs(velocity[0]) <= ACCELERATION / ROW_RATE + 1e-12
    assert 0.0 <= x.min() < 0.05 and 1.45 < x.max() <= 1.5
    assert (velocity > 0.1).any() and (velocity < -0.1).any()
    gained = np.diff(np.abs(velocity))
    assert gained.max() <= ACCELERATION / ROW_RATE + 1e-9
    # It never stands still for long: a formation that rests teaches nothing.
    assert np.abs(velocity)[20:].reshape(-1, 1)[:1160].reshape(-1, 40).mean(axis=1).min() > 0.03


def test_the_cruise_speed_changes_on_the_way():
    path = np.stack([np.linspace(0.0, 100.0, POINTS), np.zeros(POINTS)], axis=1)
    speeds = np.abs(np.diff(travel(np.random.default_rng(1), path, 1200)[:, 0])) * ROW_RATE
    cruise = speeds[40:]
    assert cruise.min() >= SPEEDS[0] - 1e-9
    held = np.isclose(np.diff(cruise), 0.0, atol=1e-9)
    changes = np.flatnonzero(held[:-1] & ~held[1:])
    assert 1200 / (10.0 * ROW_RATE) - 2 <= len(changes) <= 1200 / (5.0 * ROW_RATE) + 1
