"""What may be claimed of two methods: paired differences, intervals, tests, effect sizes, power.

**Design.** Every method flies the same test cases (same path, wind and noise) with each of its trained
networks, and leaves scores of shape (seeds, cases), in any unit, lower being better. A method without
training has shape (1, cases) and is repeated over the other's seeds; so is a single trained network, and
then nothing is said of its other trainings. The unit of inference is the flight (seed x case), never the
time step: steps of one flight are correlated and would make any difference significant.

**Intervals.** Flights of one network, or of one case, are not independent, so networks and cases are
resampled each on their own (the "pigeonhole" bootstrap: Owen, Annals of Applied Statistics 1, 2007).
Percentile bootstraps are too narrow with few units; the tail is therefore expanded as in Hesterberg (The
American Statistician 69, 2015), with degrees of freedom after Satterthwaite (1946). In simulated studies a
95 % interval then covers 93 to 97 % from six seeds on where seeds or cases matter (86 % at six without the
expansion), and more where neither does. With three seeds that matter it covers 75 %: a percentile never
leaves the values seen.

**Tests.** Signs of whole cases, of whole seeds and of both together are flipped, and the largest p counts.
The first speaks of these networks on new cases, the second of new networks on these cases; only the third
speaks of both at once: without it a test at 5 % rejects 13 % of true nulls where seeds and cases matter
alike. S seeds cannot give less than p = 2 / 2^S, so below six (0.031) no test over seeds could reject at
5 %, and it flips cases alone. Such a p is void for the method at large: with three seeds that matter it
rejects nearly every true null. `Comparison.units` says which it is. Sign flips assume differences symmetric
about zero under the null.

What is not here: the choice of primary hypotheses (see experiments) and of scores (see evaluation).
"""

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from fledge.errors import FledgeError, OutOfRange

SEEDS_NEEDED = 6  # the smallest S with 2 / 2^S < 0.05
ENUMERATED = 12  # units; up to here all 2^n sign patterns are tried
RESAMPLES = 10_000  # a p of 0.05 to within 0.004 (95 %)
MANY_CASES = 100_000  # beyond them the t quantile is the normal one plus a first-order term
MOST_NONCENTRAL = 1e6  # beyond it the power is 1 in double precision


@dataclass(frozen=True, slots=True)
class NonInferiority:
    """Whether a method is at most a stated share worse than another."""

    ratio: float
    """Mean of a over mean of b."""
    upper: float
    """One-sided 95 % upper bound of the ratio; infinite if b may be 0."""
    margin: float
    """The share by which a may be worse, 0.1 for 10 %."""
    holds: bool
    """Whether `upper` is at most 1 + `margin`."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """Method a against method b in one metric."""

    a: str
    b: str
    metric: str
    difference: float
    """Mean of a - b, in the metric's unit."""
    interval: tuple[float, float]
    """95 % interval of `difference`."""
    p: float
    """Two-sided, not adjusted."""
    effect_size: float
    """d_z over cases, negative where a is better; infinite where all cases differ by exactly the same."""
    probability_of_improvement: float
    """How often a is better than b on a flight."""
    needed_cases: int | None
    """Cases for 80 % power at 5 %; None where the difference is zero."""
    units: str
    """What the inference covers."""
    p_holm: float | None = None
    """`p` adjusted for its family by `with_holm`."""


def paired_difference(a: np.ndarray, b: np.ndarray) -> float:
    """Mean of a - b, scores of shape (seeds, cases)."""
    return float(_differences(a, b).mean())


def interval(
    a: np.ndarray, b: np.ndarray, seed: int, level: float = 0.95, resamples: int = RESAMPLES
) -> tuple[float, float]:
    """Bootstrap interval of the mean of a - b over seeds and cases.

    With one seed it resamples cases alone, and then covers new cases for this network, not new trainings.
    """
    _require(0.0 < level < 1.0, "level", level, "between 0 and 1, 0.95 for 95 %")
    differences = _differences(a, b)
    (means,) = _resampled_means((differences,), seed, resamples)
    tail = _expanded_tail(differences, (1.0 - level) / 2.0)
    low, high = np.quantile(means, (tail, 1.0 - tail))
    return float(low), float(high)


def permutation_p(a: np.ndarray, b: np.ndarray, seed: int, resamples: int = RESAMPLES) -> float:
    """Two-sided sign-flip p of the mean of a - b; never 0.

    From `SEEDS_NEEDED` seeds on it covers new cases and new trainings, below that new cases alone, averaged
    over these seeds. Up to `ENUMERATED` units it is exact, above that (1 + count) / (1 + resamples): Phipson
    and Smyth, Statistical Applications in Genetics and Molecular Biology 9, 2010.
    """
    differences = _differences(a, b)
    seeds, cases = differences.shape
    by_seed, by_case = differences.mean(axis=1) / seeds, differences.mean(axis=0) / cases
    units = [by_case]
    if seeds >= SEEDS_NEEDED:
        units += [by_seed, np.concatenate((by_seed, by_case))]
    rng = _generator(seed, resamples)
    return max(_flip_p(shares, float(differences.mean()), rng, resamples) for shares in units)


def holm(p_values: Sequence[float]) -> tuple[float, ...]:
    """Adjusted p-values in input order: Holm, Scandinavian Journal of Statistics 6, 1979."""
    p = np.asarray(p_values, dtype=float).reshape(-1)
    for value in p:
        _require(0.0 <= value <= 1.0, "a p-value", value, "0 to 1")
    order = np.argsort(p, kind="stable")
    steps = np.minimum(p[order] * np.arange(len(p), 0, -1), 1.0)
    adjusted = np.empty_like(p)
    adjusted[order] = np.maximum.accumulate(steps)
    return tuple(adjusted.tolist())


def effect_size(a: np.ndarray, b: np.ndarray) -> float:
    """d_z: mean over standard deviation of a - b, cases being the units; negative where a is better."""
    by_case = _differences(a, b).mean(axis=0)
    mean, sd = float(by_case.mean()), float(by_case.std(ddof=1))
    if sd == 0.0:
        return math.copysign(math.inf, mean) if mean else 0.0
    return mean / sd


def probability_of_improvement(a: np.ndarray, b: np.ndarray) -> float:
    """Share of flights on which a is lower than b, ties counted half."""
    differences = _differences(a, b)
    return float(np.mean(differences < 0.0) + 0.5 * np.mean(differences == 0.0))


def non_inferior(
    a: np.ndarray, b: np.ndarray, margin: float, seed: int, resamples: int = RESAMPLES
) -> NonInferiority:
    """Is a's mean at most (1 + margin) times b's? The bound is resampled as in `interval`."""
    _require(0.0 <= margin < math.inf, "margin", margin, "0 or more, 0.1 for 10 % worse")
    a, b = _paired(a, b)
    for name, scores in (("a", a), ("b", b)):
        _require(scores.min() >= 0.0, f"a score of {name}", scores.min(), "0 or more, for a ratio of means")
    _require(b.mean() > 0.0, "the mean score of b", b.mean(), "more than 0, for a ratio of means")
    ratio = float(a.mean() / b.mean())
    above, below = _resampled_means((a, b), seed, resamples)
    ratios = np.divide(above, below, out=np.full_like(above, math.inf), where=below > 0.0)
    tail = _expanded_tail(a - ratio * b, 0.05)
    upper = float(np.quantile(ratios, 1.0 - tail, method="higher"))
    return NonInferiority(ratio, upper, float(margin), upper <= 1.0 + margin)


def needed_cases(a: np.ndarray, b: np.ndarray, power: float = 0.8, alpha: float = 0.05) -> int | None:
    """Cases with which a two-sided paired t test finds a difference as large as the observed one.

    By the noncentral t distribution, searched upwards from the normal approximation, which is lower. The
    spread is that of the cases, averaged over these seeds: more cases do not make up for few seeds. None
    where the difference is zero.
    """
    _require(0.5 <= power < 1.0, "power", power, "0.5 to below 1")
    _require(0.0 < alpha < 0.5, "alpha", alpha, "between 0 and 0.5")
    size = abs(effect_size(a, b))
    edge = stats.norm.isf(alpha / 2.0)
    start = ((edge + stats.norm.ppf(power)) / size) ** 2 if size > 1e-150 else math.inf
    if math.isinf(start):
        return None
    if start > MANY_CASES:
        return math.ceil(start + edge**2 / 2.0)
    return next(n for n in itertools.count(max(2, math.ceil(start))) if _power(n, size, alpha) >= power)


def compare(name_a: str, a: np.ndarray, name_b: str, b: np.ndarray, metric: str, seed: int) -> Comparison:
    """All that is reported of two methods in one metric; equal seeds give equal records."""
    return Comparison(
        a=name_a,
        b=name_b,
        metric=metric,
        difference=paired_difference(a, b),
        interval=interval(a, b, seed),
        p=permutation_p(a, b, seed),
        effect_size=effect_size(a, b),
        probability_of_improvement=probability_of_improvement(a, b),
        needed_cases=needed_cases(a, b),
        units=_units(*_differences(a, b).shape),
    )


def with_holm(comparisons: Iterable[Comparison]) -> tuple[Comparison, ...]:
    """The same comparisons as one family: `p_holm` filled."""
    family = tuple(comparisons)
    adjusted = holm([comparison.p for comparison in family])
    return tuple(replace(one, p_holm=p) for one, p in zip(family, adjusted, strict=True))


def welch_p(mean_a: float, sd_a: float, n_a: int, mean_b: float, sd_b: float, n_b: int) -> float:
    """Two-sided p of Welch's t test from a printed table: what means, sample sds and flights can support."""
    for n, sd in ((n_a, sd_a), (n_b, sd_b)):
        _require(n >= 2, "flights", n, "2 or more")
        _require(0.0 < sd < math.inf, "standard deviation", sd, "more than 0")
    return float(stats.ttest_ind_from_stats(mean_a, sd_a, n_a, mean_b, sd_b, n_b, equal_var=False).pvalue)


def upper_bound(events: int, trials: int, level: float = 0.95) -> float:
    """One-sided upper bound of the probability of an event that came in so many of the trials.

    Exact: Clopper and Pearson, Biometrika 26, 1934. Without events it is about 3 / trials, at 95 %.
    """
    _require(trials >= 1, "trials", trials, "1 or more")
    _require(0 <= events <= trials, "events", events, f"0 to {trials}")
    _require(0.0 < level < 1.0, "level", level, "between 0 and 1, 0.95 for 95 %")
    return 1.0 if events == trials else float(stats.beta.ppf(level, events + 1, trials - events))


def _require(holds: bool, what: str, got: object, valid: str) -> None:
    if not holds:
        raise OutOfRange(what, got, valid)


def _generator(seed: int, resamples: int) -> np.random.Generator:
    _require(seed >= 0, "seed", seed, "an integer, 0 or more")
    _require(resamples >= 1, "resamples", resamples, "1 or more")
    return np.random.default_rng(seed)


def _paired(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both as floats of one shape (seeds, cases)."""
    a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    for name, scores in (("a", a), ("b", b)):
        fits = scores.ndim == 2 and scores.shape[0] >= 1 and scores.shape[1] >= 2
        _require(fits, f"the shape of {name}", scores.shape, "(seeds, cases), 1 seed and 2 cases or more")
        odd = scores[~np.isfinite(scores)]
        _require(odd.size == 0, f"a score of {name}", odd[:1].sum(), "a finite number")
    if a.shape[1] != b.shape[1] or (a.shape[0] != b.shape[0] and 1 not in (a.shape[0], b.shape[0])):
        raise FledgeError(
            f"scores of shapes {a.shape} and {b.shape}: valid are equal cases, and equal seeds or one seed"
        )
    shape = np.broadcast_shapes(a.shape, b.shape)
    return np.broadcast_to(a, shape), np.broadcast_to(b, shape)


def _differences(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Per flight a - b, shape (seeds, cases)."""
    a, b = _paired(a, b)
    return a - b


def _resampled_means(tables: tuple[np.ndarray, ...], seed: int, resamples: int) -> tuple[np.ndarray, ...]:
    """Means of each table, shape (resamples,), over the same draws of seeds and of cases."""
    rng = _generator(seed, resamples)
    rows, columns = (rng.multinomial(n, np.full(n, 1.0 / n), resamples) / n for n in tables[0].shape)
    return tuple(np.sum((rows @ table) * columns, axis=1) for table in tables)


def _expanded_tail(differences: np.ndarray, tail: float) -> float:
    """The percentile at which a bootstrap of so few units leaves `tail` outside."""
    means = [m for m in (differences.mean(axis=1), differences.mean(axis=0)) if len(m) > 1]
    variances = np.array([m.var(ddof=1) / len(m) for m in means])
    freedoms = np.array([len(m) - 1.0 for m in means])
    if variances.sum() == 0.0:
        return tail
    freedom = 1.0 / np.sum((variances / variances.sum()) ** 2 / freedoms)
    return float(stats.norm.sf(math.sqrt((freedom + 1.0) / freedom) * stats.t.isf(tail, freedom)))


def _flip_p(shares: np.ndarray, observed: float, rng: np.random.Generator, resamples: int) -> float:
    """How often the sum of the shares (what each unit adds to the mean), signs flipped, is as far from 0."""
    exact = len(shares) <= ENUMERATED
    if exact:
        signs = np.array(list(itertools.product((-1.0, 1.0), repeat=len(shares))))
    else:
        signs = rng.choice((-1.0, 1.0), (resamples, len(shares)))
    rounding = 1e-12 * np.abs(shares).sum()
    count = int(np.sum(np.abs(signs @ shares) >= abs(observed) - rounding))
    return count / len(signs) if exact else (1 + count) / (1 + resamples)


def _power(cases: int, size: float, alpha: float) -> float:
    """Power of a two-sided paired t test at the effect size `size` > 0."""
    freedom, shift = cases - 1, min(math.sqrt(cases) * size, MOST_NONCENTRAL)
    edge = stats.t.isf(alpha / 2.0, freedom)
    return float(
        stats.ncf.sf(edge**2, 1, freedom, shift**2)
    )  # of t squared: SciPy's t is NaN far out on one side


def _units(seeds: int, cases: int) -> str:
    if seeds == 1:
        return f"{cases} cases; 1 seed, so new trainings are not covered"
    if seeds < SEEDS_NEEDED:
        return f"interval: {seeds} seeds x {cases} cases; p: {cases} cases alone, of these {seeds} seeds"
    return f"{seeds} seeds x {cases} cases"
