"""What a finite number of looks allows to say: how often it is wrong."""

import numpy as np
import pytest

from fledge.lab.survey.bounds import BEYOND, MORE, bound, most


@pytest.mark.parametrize("kind", ["exponential", "half-normal", "uniform"])
@pytest.mark.parametrize("looks", [40, 200])
def test_all_but_one_in_a_thousand_are_below_it(kind, looks):
    rng = np.random.default_rng(looks)
    draw = {
        "exponential": lambda n: rng.exponential(1.0, n),
        "half-normal": lambda n: np.abs(rng.standard_normal(n)),
        "uniform": lambda n: rng.random(n),
    }[kind]
    beyond = [(draw(20_000) > bound(draw(looks))).mean() for _ in range(40)]
    assert np.mean(np.array(beyond) <= 1.5 * BEYOND) > 0.85, "with 95 % confidence, as far as 40 trials tell"


def test_it_is_never_less_than_what_was_seen():
    seen = np.array([0.01] * 50 + [0.5])
    assert bound(seen) >= 0.5
    assert bound(np.full(20, 0.03)) == pytest.approx(0.03)


def test_more_looks_make_it_smaller():
    rng = np.random.default_rng(1)
    few = np.mean([bound(rng.exponential(1.0, 20)) for _ in range(200)])
    many = np.mean([bound(rng.exponential(1.0, 500)) for _ in range(200)])
    assert many < 0.9 * few


def test_the_most_is_a_tenth_more_than_the_largest_either_way():
    assert most(np.array([0.1, -0.3, 0.2])) == pytest.approx(0.3 * MORE)
