"""What the paper says of its method, in its own words, each held against a study's numbers.

Judged is the method as the paper has it (`primitive-paper`) and as fledge would have it (`primitive`). The same rules
judge every study:

* *comparable*, *competitive*: both errors at most `MARGIN` worse, by the one-sided 95 % bound of the ratio where the
  study tested it, else by the two-sided 95 % interval of the difference, which asks for more;
* *lower*: the adjusted p below `ALPHA`, and the difference on the right side;
* *always in view*: every frame of every flight;
* *smoother*: on average, and on more than half of the paired flights; a description, not a test.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fledge.report.figures import Results
from fledge.report.wording import number, p_value, percent, signed
from fledge.study.metrics import ERRORS, METRICS

ALPHA, MARGIN = 0.05, 0.10
"""The paper's level, and ours for "comparable" (D12)."""

HOLDS, PARTLY, FAILS, OPEN, UNTESTED = "holds", "holds in part", "does not hold", "undecided", "not tested"
SIGNS = {HOLDS: "●", PARTLY: "◐", FAILS: "○", OPEN: "◌", UNTESTED: "–"}


@dataclass(frozen=True, slots=True)
class Verdict:
    """Of one claim for one set-up."""

    setup: str | None
    """None for the paper itself."""
    word: str
    evidence: str

    @property
    def sign(self) -> str:
        """The word as one character."""
        return SIGNS[self.word]


@dataclass(frozen=True, slots=True)
class Claim:
    """What the paper says, and how it fares here."""

    short: str
    """In the abstract's words."""
    quote: str
    """In the paper's words."""
    verdicts: tuple[Verdict, ...]


def claims(results: Results) -> list[Claim]:
    """What can be said of the paper's claims, in the order of the page."""
    found = [
        Claim(
            "comparable to the operator",
            "performance of the proposed approach is comparable to that of a human",
            _each(results, ("primitive-paper", "primitive"), "human-combined", _within_margin),
        ),
        Claim(
            "competitive with dnn-combined",
            "competitive to the traditional approach using expert demonstrations performed on the composite task",
            _each(results, ("primitive-paper", "primitive"), "dnn-combined", _within_margin),
        ),
        Claim(
            "a lower radius error than dnn-combined",
            "[Primitive] performs much better than [DNN-combined] regarding the radius error",
            _each(results, ("primitive-paper", "primitive"), "dnn-combined", _lower_radius),
        ),
        Claim(
            "all UGVs always in view",
            "the DNN always retains the UGVs within the range of the camera in all manoeuvres and all test cases",
            _each(results, ("dnn-combined", "primitive-paper", "primitive"), None, _always_in_view),
        ),
        Claim(
            "smoother than the operator",
            "when tracking UGVs, the DNN seems to do this in a smoother manner",
            _each(results, ("dnn-combined", "primitive-paper", "primitive"), "human-combined", _smoother),
        ),
        Claim(
            "smoother than dnn-combined",
            "the primitive DNN tracks more smoothly than the combined DNN",
            _each(results, ("primitive-paper", "primitive"), "dnn-combined", _smoother),
        ),
        Claim(
            "differences significant at 0.05",
            "the differences are statistically significant at α = 0.05",
            (_printed_significance(results["paper"]["welch"]),),
        ),
    ]
    return [claim for claim in found if claim.verdicts]


def by_fate(found: list[Claim], setup: str) -> dict[str, list[str]]:
    """The claims on one set-up, in short, by their verdicts."""
    fates: dict[str, list[str]] = {sign: [] for sign in SIGNS}
    for claim in found:
        for verdict in claim.verdicts:
            if verdict.setup == setup:
                fates[verdict.word].append(claim.short)
    return {fate: which for fate, which in fates.items() if which}


def _each(results: Results, names: tuple[str, ...], other: str | None, judge: Any) -> tuple[Verdict, ...]:
    """The verdict on every one of these set-ups that was run, against another that was."""
    setups = results["setups"]
    there = [name for name in names if name in setups and (other is None or other in setups)]
    return tuple(Verdict(name, *judge(results, name, other)) for name in there)


def _within_margin(results: Results, name: str, other: str) -> tuple[str, str]:
    parts, words = [], []
    for metric in ERRORS:
        word, text = _ratio(results, name, other, metric)
        words.append(word)
        parts.append(f"{METRICS[metric].title} {text}")
    word = next(iter(set(words))) if len(set(words)) == 1 else PARTLY if HOLDS in words else OPEN
    return word, f"{'; '.join(parts)}; allowed {1.0 + MARGIN:.2f}"


def _ratio(results: Results, name: str, other: str, metric: str) -> tuple[str, str]:
    """Whether one error is at most the margin worse, and the ratio of means that says so."""
    for one in results["non_inferiority"]:
        if (one["a"], one["b"], one["metric"]) == (name, other, metric):
            word = HOLDS if one["holds"] else FAILS if one["ratio"] > 1.0 + one["margin"] else OPEN
            bound = f" (at most {number(one['upper'], 2)}, one-sided)" if one["upper"] is not None else ""
            return word, f"{number(one['ratio'], 2)} times{bound}"
    of, to = (results["setups"][setup][f"{metric}_px"] for setup in (name, other))
    compared = _difference(results, name, other, metric)
    if compared is None:
        return FAILS if of > (
            1.0 + MARGIN
        ) * to else UNTESTED, f"{number(of / to, 2)} times (no test planned)"
    low, high = (1.0 + edge / to for edge in compared[1])
    word = HOLDS if high <= 1.0 + MARGIN else FAILS if low > 1.0 + MARGIN else OPEN
    return word, f"{number(of / to, 2)} times ({number(low, 2)} to {number(high, 2)})"


def _difference(
    results: Results, a: str, b: str, metric: str
) -> tuple[float, tuple[float, float], float] | None:
    """(mean of a - b, its interval, adjusted p), whichever way round the study compared them."""
    for one in results["comparisons"]:
        if one["metric"] == metric and {one["a"], one["b"]} == {a, b}:
            sign = 1.0 if one["a"] == a else -1.0
            low, high = sorted(sign * edge for edge in one["interval"])
            p = one["p"] if one["p_holm"] is None else one["p_holm"]
            return sign * one["difference"], (low, high), p
    return None


def _lower_radius(results: Results, name: str, other: str) -> tuple[str, str]:
    compared = _difference(results, name, other, "radius_rmse")
    if compared is None:
        of, to = (results["setups"][setup]["radius_rmse_px"] for setup in (name, other))
        means = f"radius RMSE {number(of)} against {number(to)} px (no test planned)"
        return FAILS if of >= to else UNTESTED, means
    difference, (low, high), p = compared
    word = OPEN if p >= ALPHA else HOLDS if difference < 0.0 else FAILS
    interval = f"95 %: {signed(low, 2)} to {signed(high, 2)}"
    return word, f"radius RMSE {signed(difference, 2)} px ({interval}), adjusted p {p_value(p)}"


def _always_in_view(results: Results, name: str, _: object) -> tuple[str, str]:
    setup = results["setups"][name]
    shares = np.ravel(setup["scores"]["in_view"])
    whole = int(np.sum(shares >= 1.0))
    least = min(
        (part["in_view"] for name, part in setup["manoeuvres"].items() if name != "combined"), default=1.0
    )
    rest = "always on the sub-tasks" if least >= 1.0 else f"{percent(least)} % or more on every sub-task"
    word = HOLDS if whole == len(shares) and least >= 1.0 else FAILS
    frames = f"{percent(float(shares.mean()))} % of frames on Combined"
    return word, f"{frames}, every frame in {whole} of {len(shares)} flights; {rest}"


def _smoother(results: Results, name: str, other: str) -> tuple[str, str]:
    of, to = (np.asarray(results["setups"][setup]["scores"]["smoothness"]) for setup in (name, other))
    share = float(np.mean(of < to) + 0.5 * np.mean(of == to))
    word = HOLDS if of.mean() < to.mean() and share > 0.5 else FAILS
    means = f"{number(of.mean(), 2)} against {number(to.mean(), 2)} /s"
    return word, f"{means}; smoother on {percent(share, 0)} % of paired flights"


def _printed_significance(welch: list[Mapping[str, Any]]) -> Verdict:
    below = [one for one in welch if one["p_holm"] < ALPHA]
    word = HOLDS if len(below) == len(welch) else PARTLY if below else FAILS
    least = min(one["p_holm"] for one in welch)
    evidence = (
        f"{len(below)} of {len(welch)} Welch tests on its printed means, standard deviations and n = 10 "
    )
    return Verdict(
        None, word, evidence + f"reach 0.05 after Holm; the smallest adjusted p is {p_value(least)}"
    )
