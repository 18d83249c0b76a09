"""Statistics against theory, enumeration, SciPy and simulated studies."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import stats

from fledge.errors import FledgeError, OutOfRange
from fledge.study import statistics
from fledge.study.statistics import Comparison

pytestmark = pytest.mark.slow

SCORES = st.floats(0.0, 100.0).map(lambda score: round(score, 3))
P_VALUES = st.lists(st.floats(0.0, 1.0), min_size=1, max_size=8)


@st.composite
def paired_scores(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    """Two methods on the same cases; each has all seeds or just one."""
    seeds, cases = draw(st.integers(1, 8)), draw(st.integers(2, 9))
    shapes = [(draw(st.sampled_from((1, seeds))), cases) for _ in range(2)]
    a, b = (draw(arrays(float, shape, elements=SCORES)) for shape in shapes)
    return a, b


def crossed(
    rng: np.random.Generator, seeds: int, cases: int, by_seed: float, by_case: float, noise: float
) -> np.ndarray:
    """Differences with true mean 0 and random effects of seed, case and flight, of the given sds."""
    return (
        by_seed * rng.normal(size=(seeds, 1))
        + by_case * rng.normal(size=(1, cases))
        + noise * rng.normal(size=(seeds, cases))
    )


def zeros_for(differences: np.ndarray) -> np.ndarray:
    """A method without training that scores 0 on every case."""
    return np.zeros((1, differences.shape[1]))


@given(paired_scores())
@settings(max_examples=50, deadline=None)
def test_swapping_the_methods_mirrors_everything(pair: tuple[np.ndarray, np.ndarray]) -> None:
    """What holds of a against b holds, with the opposite sign, of b against a."""
    a, b = pair
    low, high = statistics.interval(a, b, seed=3, resamples=200)
    assert low <= high
    assert statistics.interval(b, a, seed=3, resamples=200) == pytest.approx((-high, -low), abs=1e-9)
    assert statistics.paired_difference(a, b) == pytest.approx(-statistics.paired_difference(b, a), abs=1e-12)
    assert statistics.effect_size(a, b) == -statistics.effect_size(b, a)
    assert statistics.needed_cases(a, b) == statistics.needed_cases(b, a)
    either = statistics.probability_of_improvement(a, b) + statistics.probability_of_improvement(b, a)
    assert either == pytest.approx(1.0)
    p = statistics.permutation_p(a, b, seed=3, resamples=200)
    assert 0.0 < p <= 1.0
    assert p == statistics.permutation_p(b, a, seed=3, resamples=200)


@given(paired_scores())
@settings(max_examples=30, deadline=None)
def test_one_seed_stands_for_all_of_the_others(pair: tuple[np.ndarray, np.ndarray]) -> None:
    """A (1, cases) method gives what its repetition over the other's seeds gives."""
    a, b = pair
    seeds = max(len(a), len(b))
    wide_a, wide_b = (np.repeat(x, seeds // len(x), axis=0) for x in (a, b))
    assert statistics.interval(a, b, 1, resamples=50) == statistics.interval(wide_a, wide_b, 1, resamples=50)
    assert statistics.permutation_p(a, b, 1, 50) == statistics.permutation_p(wide_a, wide_b, 1, 50)
    assert statistics.paired_difference(a, b) == pytest.approx(a.mean() - b.mean(), abs=1e-9)


def test_identical_methods_differ_in_nothing() -> None:
    """No difference: p = 1, no effect, no sample size would show it."""
    a = np.arange(12.0).reshape(2, 6)
    got = statistics.compare("a", a, "b", a.copy(), "distance", seed=0)
    assert got == Comparison(
        "a",
        "b",
        "distance",
        0.0,
        (0.0, 0.0),
        1.0,
        0.0,
        0.5,
        None,
        "interval: 2 seeds x 6 cases; p: 6 cases alone, of these 2 seeds",
    )


def test_a_constant_difference_has_no_spread() -> None:
    """Every case equally better: infinite d_z, two cases suffice, the interval is a point."""
    a = np.tile([1.0, 2.0, 3.0], (2, 1))
    assert statistics.effect_size(a, a + 4.0) == -math.inf
    assert statistics.needed_cases(a, a + 4.0) == 2
    assert statistics.interval(a, a + 4.0, 0) == (-4.0, -4.0)


def test_equal_seeds_give_equal_records() -> None:
    """Chance enters by the seed alone, and the global generator is left as it was."""
    rng = np.random.default_rng(1)
    a, b = rng.random((7, 20)), rng.random((1, 20))
    before = np.random.get_state()[1].copy()
    first = statistics.compare("a", a, "b", b, "radius", seed=5)
    assert first == statistics.compare("a", a, "b", b, "radius", seed=5)
    assert first.interval != statistics.compare("a", a, "b", b, "radius", seed=6).interval
    assert statistics.non_inferior(a, b, 0.1, 5) == statistics.non_inferior(a, b, 0.1, 5)
    assert np.array_equal(before, np.random.get_state()[1])
    assert first.units == "7 seeds x 20 cases"
    assert "1 seed" in statistics.compare("a", b, "b", 2.0 * b, "radius", seed=5).units


@given(st.lists(SCORES, min_size=2, max_size=12), st.integers(0, 99))
@settings(max_examples=30, deadline=None)
def test_few_cases_are_enumerated_as_scipy_does(differences: list[float], seed: int) -> None:
    """One seed, up to 12 cases: SciPy's exact paired permutation test, and no chance at all."""
    d = np.array([differences]) - 30.0
    wanted = stats.permutation_test((d[0],), np.mean, permutation_type="samples", n_resamples=5000).pvalue
    assert statistics.permutation_p(d, zeros_for(d), seed) == pytest.approx(wanted)


def test_many_cases_are_sampled_close_to_the_exact_p() -> None:
    """Monte-Carlo against the sum over all 2^16 sign patterns, within four standard errors."""
    d = np.random.default_rng(2).normal(0.4, 1.0, size=(1, 16))
    signs = 1.0 - 2.0 * ((np.arange(2**16)[:, None] >> np.arange(16)) & 1)
    exact = np.mean(np.abs(signs @ d[0] / 16) >= abs(d.mean()) - 1e-12)
    assert 0.01 < exact < 0.5
    error = math.sqrt(exact * (1.0 - exact) / 10_000)
    assert statistics.permutation_p(d, zeros_for(d), seed=0) == pytest.approx(exact, abs=4.0 * error)


def test_the_smallest_p_is_bounded_by_the_units() -> None:
    """A difference in every flight: 1 / (1 + resamples) by cases, 2 / 2^S from six seeds on."""
    d = np.ones((5, 200)) + 0.01 * np.random.default_rng(0).random((5, 200))
    assert statistics.permutation_p(d, zeros_for(d), 0, resamples=999) == pytest.approx(0.001)
    six = np.concatenate((d, d[:1]))
    assert statistics.permutation_p(six, zeros_for(d), 0) == pytest.approx(2 / 2**6)


def test_p_is_uniform_under_the_null() -> None:
    """One seed, no difference: the share of p <= x is x, by a Kolmogorov-Smirnov test."""
    rng = np.random.default_rng(4)
    p = [statistics.permutation_p(rng.standard_t(5, (1, 20)), np.zeros((1, 20)), k, 400) for k in range(400)]
    assert stats.kstest(p, "uniform").pvalue > 0.01
    assert np.mean(np.array(p) <= 0.05) == pytest.approx(0.05, abs=0.033)  # three standard errors


@pytest.mark.parametrize(("by_seed", "by_case"), [(1.0, 0.0), (1.0, 1.4), (0.0, 1.0)])
def test_a_true_null_is_rejected_rarely(by_seed: float, by_case: float) -> None:
    """20 seeds, 40 cases: 5 % at most whichever matters; with (1, 1.4) both matter alike."""
    rng = np.random.default_rng(6)
    studies = (crossed(rng, 20, 40, by_seed, by_case, 0.3) for _ in range(400))
    p = np.array([statistics.permutation_p(d, zeros_for(d), k, 400) for k, d in enumerate(studies)])
    assert np.mean(p <= 0.05) <= 0.05 + 0.033  # three standard errors


@pytest.mark.parametrize(
    ("seeds", "cases", "by_seed", "by_case", "noise"),
    [
        (20, 60, 1.0, 1.7, 1.0),
        (20, 60, 0.5, 0.1, 1.0),
        (6, 40, 1.0, 0.0, 0.3),
        (10, 40, 0.1, 1.0, 1.0),
        (1, 40, 0.0, 1.0, 0.0),
    ],
)
def test_the_interval_covers_the_truth(
    seeds: int, cases: int, by_seed: float, by_case: float, noise: float
) -> None:
    """95 % of 400 simulated studies, less 3.5 % for simulation error and few units; more is allowed."""
    rng = np.random.default_rng(8)
    covered = 0
    for k in range(400):
        d = crossed(rng, seeds, cases, by_seed, by_case, noise)
        low, high = statistics.interval(d, zeros_for(d), k, resamples=600)
        covered += low <= 0.0 <= high
    assert 0.915 <= covered / 400 <= 0.995


def test_the_interval_has_the_width_of_theory() -> None:
    """One seed, many cases: 1.96 standard errors on each side."""
    d = np.random.default_rng(9).normal(3.0, 2.0, (1, 2000))
    half = 1.96 * d.std(ddof=1) / math.sqrt(2000)
    low, high = statistics.interval(d, zeros_for(d), 0, resamples=4000)
    assert (low, high) == pytest.approx((d.mean() - half, d.mean() + half), abs=0.08 * half)


@given(P_VALUES)
def test_holm_is_its_definition(p_values: list[float]) -> None:
    """Each: the largest (m - rank) p of those no larger than itself, at most 1; never below p."""
    m, order = len(p_values), sorted(range(len(p_values)), key=lambda i: p_values[i])
    wanted = [0.0] * m
    for rank, i in enumerate(order):
        wanted[i] = min(1.0, max((m - k) * p_values[order[k]] for k in range(rank + 1)))
    got = statistics.holm(p_values)
    assert got == pytest.approx(wanted)
    assert all(p <= adjusted <= 1.0 for p, adjusted in zip(p_values, got, strict=True))
    ordered = [got[i] for i in order]
    assert ordered == sorted(ordered)


def test_holm_by_hand() -> None:
    """Four hypotheses: .005 x 4, .01 x 3, .03 x 2 and .04 pulled up to .06, in input order."""
    assert statistics.holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx((0.03, 0.06, 0.06, 0.02))
    assert statistics.holm([]) == ()


def test_holm_of_comparisons_fills_one_field() -> None:
    """The family is adjusted together and nothing else changes."""
    rng = np.random.default_rng(3)
    a = rng.random((1, 30))
    family = [
        statistics.compare("a", a, f"b{k}", a + rng.normal(0.1 * k, 0.3, (1, 30)), "m", 0) for k in range(3)
    ]
    adjusted = statistics.with_holm(family)
    assert [one.p_holm for one in adjusted] == list(statistics.holm([one.p for one in family]))
    assert [one.b for one in adjusted] == ["b0", "b1", "b2"]
    assert family[0].p_holm is None


def test_needed_cases_are_continuous_where_the_formula_changes() -> None:
    """At 100,000 cases the t search and the normal approximation agree."""
    for wanted in (99_990, 100_010):
        size = (stats.norm.isf(0.025) + stats.norm.ppf(0.8)) / math.sqrt(wanted)
        spread = np.array([[-1.0, 1.0]]) / math.sqrt(2.0)
        assert statistics.needed_cases(spread + size, np.zeros((1, 2))) == wanted + 2


def test_effect_sizes_by_hand() -> None:
    """Case means of a - b are -1, -3, 1, 1: mean -0.5, sd sqrt(11 / 3); 3 of 8 flights lower, 3 equal."""
    a = np.array([[0.0, -4.0, 2.0, 0.0], [-2.0, -2.0, 0.0, 2.0]])
    b = np.zeros((1, 4))
    assert statistics.effect_size(a, b) == pytest.approx(-0.5 / math.sqrt(11.0 / 3.0))
    assert statistics.probability_of_improvement(a, b) == pytest.approx((3 + 0.5 * 3) / 8)


@pytest.mark.parametrize(("share", "holds"), [(0.95, True), (1.05, True), (1.25, False)])
def test_non_inferiority_of_a_known_ratio(share: float, holds: bool) -> None:
    """Errors `share` times b's, a little noise: within a margin of 10 % or not."""
    rng = np.random.default_rng(7)
    b = rng.gamma(4.0, 3.0, (8, 50))
    a = share * b * rng.lognormal(0.0, 0.05, (8, 50))
    got = statistics.non_inferior(a, b, margin=0.1, seed=0)
    assert got.ratio == pytest.approx(a.mean() / b.mean())
    assert got.ratio < got.upper == pytest.approx(share, abs=0.03)
    assert got.holds is holds


def test_non_inferiority_errs_in_five_per_cent() -> None:
    """True ratio exactly at the margin: claimed in 5 % of studies, within three standard errors."""
    rng = np.random.default_rng(10)
    claims = 0
    for k in range(400):
        b = 10.0 + crossed(rng, 1, 50, 0.0, 2.0, 0.0)
        a = 1.1 * 10.0 + 0.5 * (b - 10.0) + crossed(rng, 1, 50, 0.0, 1.0, 0.0)
        claims += statistics.non_inferior(a, b, 0.1, k, resamples=600).holds
    assert claims / 400 == pytest.approx(0.05, abs=0.033)


def test_the_non_inferiority_bound_is_that_of_theory() -> None:
    """One seed, many cases: 1.645 standard errors above the ratio, by the delta method."""
    rng = np.random.default_rng(11)
    b = rng.uniform(5.0, 15.0, (1, 2000))
    a = b + rng.normal(1.0, 2.0, (1, 2000))
    got = statistics.non_inferior(a, b, 0.1, 0, resamples=4000)
    error = (a - got.ratio * b).std(ddof=1) / math.sqrt(2000) / b.mean()
    assert got.upper - got.ratio == pytest.approx(1.645 * error, rel=0.08)


def test_a_reference_that_may_be_zero_bounds_nothing() -> None:
    """Resamples in which b never errs make the ratio's bound infinite: no claim, no warning."""
    b = np.array([[0.0, 0.0, 0.0, 1.0]])
    got = statistics.non_inferior(np.full((1, 4), 0.2), b, 0.1, 0)
    assert (got.upper, got.holds) == (math.inf, False)


@pytest.mark.parametrize(("size", "cases"), [(0.2, 199), (0.5, 34), (0.8, 15)])
def test_needed_cases_are_the_textbook_s(size: float, cases: int) -> None:
    """G*Power's paired t test, two-sided 5 %, power 80 %; and simulated tests reject that often."""
    spread = np.linspace(-1.0, 1.0, 40)[None, :]
    d = size + spread / spread.std(ddof=1)
    assert statistics.needed_cases(d, zeros_for(d)) == cases
    simulated = np.random.default_rng(0).normal(size, 1.0, (6000, cases))
    assert np.mean(stats.ttest_1samp(simulated, 0.0, axis=1).pvalue < 0.05) == pytest.approx(0.8, abs=0.025)


@example(3.0, 0.5)  # where SciPy's noncentral t is NaN
@given(st.floats(1e-9, 1e6), st.floats(0.5, 0.99))
@settings(max_examples=50, deadline=None)
def test_needed_cases_fall_with_the_effect_and_rise_with_power(size: float, power: float) -> None:
    """Whatever the scale: finite, two or more, monotone."""
    spread = np.array([[-1.0, 1.0, -1.0, 1.0]])
    cases = statistics.needed_cases(spread + size, np.zeros((1, 4)), power)
    assert cases is not None and cases >= 2
    assert cases <= statistics.needed_cases(spread + size, np.zeros((1, 4)), 0.995)
    assert cases >= statistics.needed_cases(spread + 2.0 * size, np.zeros((1, 4)), power)


def test_the_paper_s_own_table_does_not_support_its_claim() -> None:
    """Means and sds as printed, n = 10: only one p below 0.05, and none after Holm over the six."""
    distance = {"human": (14.2, 9.0), "dnn": (12.6, 8.1), "primitive": (12.9, 8.2)}
    radius = {"human": (12.9, 21.9), "dnn": (26.2, 19.1), "primitive": (10.9, 9.9)}
    pairs = (("human", "dnn"), ("human", "primitive"), ("dnn", "primitive"))
    p = {
        (name, a, b): statistics.welch_p(*table[a], 10, *table[b], 10)
        for name, table in (("distance", distance), ("radius", radius))
        for a, b in pairs
    }
    assert p["radius", "dnn", "primitive"] == pytest.approx(0.042, abs=0.002)
    assert p["radius", "human", "dnn"] == pytest.approx(0.165, abs=0.005)
    assert min(p["distance", a, b] for a, b in pairs) > 0.6
    assert min(statistics.holm(list(p.values()))) > 0.2


GOOD = np.ones((2, 3))


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        (np.ones(3), "the shape of a is (3,): valid is (seeds, cases)"),
        (np.ones((0, 3)), "the shape of a is (0, 3)"),
        (np.ones((2, 1)), "2 cases or more"),
        (np.ones((2, 4)), "scores of shapes (2, 4) and (2, 3): valid are"),
        (np.ones((3, 3)), "equal seeds or one seed"),
        (np.array([[1.0, np.nan, 2.0]]), "a score of a is nan: valid is a finite number"),
        (np.array([[1.0, 2.0, -np.inf]]), "a score of a is -inf"),
    ],
)
def test_scores_that_do_not_fit_are_refused(bad: np.ndarray, message: str) -> None:
    """One line that says what was got and what is valid, from every function that takes scores."""
    for refuse in (
        lambda: statistics.paired_difference(bad, GOOD),
        lambda: statistics.interval(bad, GOOD, 0),
        lambda: statistics.permutation_p(bad, GOOD, 0),
        lambda: statistics.effect_size(bad, GOOD),
        lambda: statistics.probability_of_improvement(bad, GOOD),
        lambda: statistics.non_inferior(bad, GOOD, 0.1, 0),
        lambda: statistics.needed_cases(bad, GOOD),
        lambda: statistics.compare("a", bad, "b", GOOD, "m", 0),
    ):
        with pytest.raises(FledgeError) as caught:
            refuse()
        assert message in str(caught.value)
        assert "\n" not in str(caught.value)


def test_settings_out_of_range_are_refused() -> None:
    """Levels, counts, margins, probabilities and negative errors."""
    for refuse in (
        lambda: statistics.interval(GOOD, GOOD, 0, level=1.0),
        lambda: statistics.interval(GOOD, GOOD, 0, resamples=0),
        lambda: statistics.permutation_p(GOOD, GOOD, -1),
        lambda: statistics.non_inferior(GOOD, GOOD, -0.1, 0),
        lambda: statistics.non_inferior(-GOOD, GOOD, 0.1, 0),
        lambda: statistics.non_inferior(GOOD, 0.0 * GOOD, 0.1, 0),
        lambda: statistics.needed_cases(GOOD, GOOD, power=0.3),
        lambda: statistics.needed_cases(GOOD, GOOD, alpha=0.0),
        lambda: statistics.holm([0.2, math.nan]),
        lambda: statistics.holm([1.2]),
        lambda: statistics.welch_p(1.0, 1.0, 1, 1.0, 1.0, 10),
        lambda: statistics.welch_p(1.0, 0.0, 10, 1.0, 1.0, 10),
        lambda: statistics.upper_bound(0, 0),
        lambda: statistics.upper_bound(3, 2),
        lambda: statistics.upper_bound(-1, 2),
        lambda: statistics.upper_bound(1, 2, level=1.0),
    ):
        with pytest.raises(OutOfRange):
            refuse()


def test_an_upper_bound_is_three_over_the_trials_without_events() -> None:
    """The rule of three; exactly 1 - 0.05^(1/n)."""
    for trials in (1, 10, 5000):
        assert math.isclose(statistics.upper_bound(0, trials), 1.0 - 0.05 ** (1.0 / trials))
    assert statistics.upper_bound(0, 5000) == pytest.approx(3.0 / 5000, rel=0.01)
    assert statistics.upper_bound(7, 7) == 1.0


@given(trials=st.integers(1, 300), data=st.data())
def test_an_upper_bound_leaves_five_per_cent_below(trials: int, data: st.DataObject) -> None:
    """At the bound so few events, or fewer, come with a probability of 5 %: that is Clopper and Pearson's."""
    events = data.draw(st.integers(0, trials - 1))
    bound = statistics.upper_bound(events, trials)
    assert events / trials < bound <= 1.0
    assert stats.binom.cdf(events, trials, bound) == pytest.approx(0.05, rel=1e-6)
