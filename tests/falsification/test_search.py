"""A searching adversary finds what a guessing one does not."""

import numpy as np

from fledge.falsification.attacks import SEGMENTS
from fledge.falsification.scenarios import Terms
from fledge.falsification.search import LEAST_SPREAD, Hunt, Search

WORST = np.random.default_rng(7).uniform(-1.0, 1.0, (SEGMENTS, 3))


def gap(scripts: np.ndarray) -> np.ndarray:
    """As if the worst script touched, and others missed by their distance from it."""
    return np.sqrt(((scripts - WORST) ** 2).sum(axis=(1, 2)))


def test_it_comes_nearer_than_as_many_guesses():
    rng, search, least = np.random.default_rng(0), Search.begin(), []
    for _ in range(12):
        scripts = search.write(rng, 30)
        search = search.learn(scripts, gap(scripts))
        least.append(gap(scripts).min())
    guesses = gap(np.clip(rng.normal(0.0, 1.5, (360, SEGMENTS, 3)), -1.0, 1.0)).min()
    assert least[-1] < 0.6 * guesses
    assert least[-1] < least[0]


def test_scripts_are_shares_of_full_speed_and_never_all_alike():
    search = Search.begin()
    for _ in range(50):
        scripts = search.write(np.random.default_rng(1), 10)
        assert np.abs(scripts).max() <= 1.0
        search = search.learn(scripts, gap(scripts))
    assert search.spread.min() >= LEAST_SPREAD


def test_a_hunt_gives_every_scene_its_scripts_and_its_vehicle():
    hunt = Hunt.begin(Terms(), (0, 1), 3)
    assert [draw.scenario.focus for draw in hunt.draws] == [0.0, 1.0, 2.0]
    scripts = hunt.write(np.random.default_rng(0), 7)
    draws = hunt.draw(scripts)
    for i, draw in enumerate(draws):
        assert draw.scenario.world == hunt.draws[i % 3].scenario.world
        assert draw.scenario.nature.script[2].y == scripts[i, 2, 1]
        assert draw.rejected == 0
    gaps = np.full((4, 7), 9.0)
    gaps[1] = gap(scripts)
    learnt = hunt.learn(scripts, gaps)
    same = Search.begin().learn(scripts[1::3], gaps[1, 1::3])
    np.testing.assert_array_equal(learnt.searches[1].mean, same.mean)


def test_the_same_key_hunts_on_the_same_scenes():
    assert Hunt.begin(Terms(), (4, 2), 2).draws == Hunt.begin(Terms(), (4, 2), 2).draws
    assert Hunt.begin(Terms(), (4, 2), 2).draws != Hunt.begin(Terms(), (4, 3), 2).draws
