"""The learnt margin: its coverage, what it may never do, and where its number comes from."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from fledge.dynamics import REAL_AR_DRONE
from fledge.errors import FledgeError, OutOfRange
from fledge.safety import Conformal, Overruns, StopTube
from fledge.safety.conformal import AR_DRONE
from fledge.study.overruns import fly_stops


@pytest.mark.parametrize(
    "n, alpha, rank", ((19, 0.05, 19), (99, 0.01, 99), (199, 0.05, 190), (999, 0.01, 990), (9, 0.5, 5))
)
def test_delta_is_the_score_of_that_rank(n, alpha, rank):
    scores = np.arange(1.0, n + 1.0)
    shuffled = np.random.default_rng(0).permutation(scores)
    assert Overruns.learnt(shuffled[:, None], alpha) == Overruns(float(rank), alpha, n)


def test_the_score_of_an_episode_is_its_worst_stop():
    overruns = np.full((19, 3), -1.0)
    overruns[4, 1] = 2.0
    assert Overruns.learnt(overruns, 0.05).delta == 2.0


@pytest.mark.parametrize("alpha", (0.5, 0.1, 0.05, 0.01, 0.001))
def test_it_takes_one_over_alpha_less_one_episodes(alpha):
    enough = round(1.0 / alpha) - 1
    assert Overruns.learnt(np.zeros((enough, 1)), alpha).episodes == enough
    with pytest.raises(
        OutOfRange, match=f"number of episodes is {enough - 1}: valid is at least {enough} for"
    ):
        Overruns.learnt(np.zeros((enough - 1, 1)), alpha)


@pytest.mark.parametrize("alpha", (0.0, 1.0, -0.1, 2.0, np.nan))
def test_alpha_is_a_share(alpha):
    with pytest.raises(OutOfRange, match="alpha is"):
        Overruns.learnt(np.zeros((99, 1)), alpha)


def test_an_overrun_that_is_no_number_teaches_nothing():
    with pytest.raises(FledgeError, match="no number"):
        Overruns.learnt(np.array([[0.0], [np.nan]]), 0.5)


@given(st.lists(st.floats(-1.0, 1.0), min_size=19, max_size=60), st.floats(0.0, 1.0))
def test_it_is_monotone(scores, more):
    overruns = np.array(scores)[:, None]
    known = Overruns.learnt(overruns, 0.05).delta
    assert Overruns.learnt(overruns + more, 0.05).delta >= known  # in the overruns
    assert Overruns.learnt(overruns, 0.2).delta <= known  # in the share that is let go
    assert overruns.min() <= known <= overruns.max()


@pytest.mark.parametrize("n, alpha", ((19, 0.05), (99, 0.05), (99, 0.3)))
def test_a_further_episode_is_covered_as_often_as_promised(n, alpha):
    """Of 20,000 calibrations with one more episode each, whatever the distribution: here one with a heavy tail."""
    rng = np.random.default_rng(0)
    scores = rng.standard_cauchy((20_000, n + 1))
    deltas = [Overruns.learnt(row[:n, None], alpha).delta for row in scores]
    covered = int((scores[:, n] <= deltas).sum())
    low, high = stats.binom.interval(0.999, len(scores), np.array([1.0 - alpha, 1.0 - alpha + 1.0 / (n + 1)]))
    assert low[0] <= covered <= high[1]


@given(st.floats(-0.5, 0.5))
def test_the_proven_margin_is_never_reduced(delta):
    proven = StopTube().uav
    enlarged = Conformal(overruns=Overruns(delta, 0.01, 999)).enlarged().uav
    assert enlarged.error == max(proven.error, proven.error + delta)
    assert enlarged.error_up == max(proven.error_up, proven.error_up + delta)


def test_where_nothing_was_overrun_it_is_the_stop_tube():
    assert Conformal(overruns=Overruns(-0.01, 0.01, 999)).enlarged() == StopTube()


@pytest.fixture(scope="module")
def flown():
    return fly_stops(REAL_AR_DRONE, (0,), 999)


@pytest.mark.slow
def test_the_shipped_number_is_measured(flown):
    assert Overruns.learnt(flown, AR_DRONE.alpha).delta == pytest.approx(AR_DRONE.delta, abs=5e-4)
    assert AR_DRONE.episodes == len(flown)


@pytest.mark.slow
def test_fresh_stops_are_covered(flown):
    """How many of m fresh episodes a calibration on n misses is beta-binomial."""
    alpha, m = 0.05, 400
    n = len(flown)
    delta = Overruns.learnt(flown, alpha).delta
    missed = int((fly_stops(REAL_AR_DRONE, (7,), m).max(axis=1) > delta).sum())
    rank = round((n + 1) * (1.0 - alpha))
    low, high = stats.betabinom.interval(0.999, m, n + 1 - rank, rank)
    assert low <= missed <= high
