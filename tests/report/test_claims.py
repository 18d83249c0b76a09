"""The same rules judge every study, and only what its numbers say counts."""

from typing import Any

import numpy as np
import pytest

from fledge.report.claims import FAILS, HOLDS, OPEN, PARTLY, SIGNS, UNTESTED, by_fate, claims

SEEDS, CASES = 2, 5
NAMES = ("human-combined", "dnn-combined", "primitive-paper", "primitive")


def study(names: tuple[str, ...] = NAMES) -> dict[str, Any]:
    """What claims are judged by, in a study of these set-ups in which nothing differs from anything."""
    pairs = [
        ("primitive", "dnn-combined"),
        ("primitive", "human-combined"),
        ("primitive-paper", "human-combined"),
    ]
    flown = [pair for pair in pairs if set(pair) <= set(names)]
    none = {"difference": 0.0, "interval": [-0.1, 0.1], "p": 1.0, "p_holm": 1.0}
    bound = {"ratio": 1.0, "upper": 1.01, "margin": 0.1, "holds": True}
    return {
        "setups": {
            name: {
                "distance_rmse_px": 20.0,
                "radius_rmse_px": 10.0,
                "scores": {"in_view": np.ones((SEEDS, CASES)), "smoothness": np.ones((SEEDS, CASES))},
                "manoeuvres": {part: {"in_view": 1.0} for part in ("climb", "combined")},
            }
            for name in names
        },
        "comparisons": [
            {"a": a, "b": b, "metric": metric, **none}
            for a, b in flown
            for metric in ("distance_rmse", "radius_rmse")
        ],
        "non_inferiority": [
            {"a": "primitive", "b": "human-combined", "metric": metric, **bound}
            for metric in ("distance_rmse", "radius_rmse")
        ],
        "paper": {"welch": [{"p_holm": 1.0}]},
    }


def compared(results: dict[str, Any], a: str, b: str) -> list[dict[str, Any]]:
    return [one for one in results["comparisons"] if (one["a"], one["b"]) == (a, b)]


def verdicts(results: dict[str, Any], short: str) -> dict[str | None, str]:
    (claim,) = (claim for claim in claims(results) if claim.short == short)
    return {verdict.setup: verdict.word for verdict in claim.verdicts}


@pytest.mark.parametrize(
    "uppers, expected",
    [((1.05, 1.10), HOLDS), ((1.05, 1.11), PARTLY), ((1.2, 1.3), OPEN)],
)  # fmt: skip
def test_comparable_is_what_the_bound_says(uppers, expected):
    results = study()
    for one, upper in zip(results["non_inferiority"], uppers, strict=True):
        one |= {"upper": upper, "holds": upper <= 1.1}
    assert verdicts(results, "comparable to the operator")["primitive"] == expected


@pytest.mark.parametrize(
    "interval, expected",
    [([-0.1, 0.01], HOLDS), ([0.2, 0.3], FAILS), ([0.0, 0.2], OPEN)],
)  # fmt: skip
def test_where_no_bound_was_tested_the_interval_decides(interval, expected):
    """The interval of the difference, in shares of the operator's error."""
    results = study()
    for one in compared(results, "primitive-paper", "human-combined"):
        mean = results["setups"]["human-combined"][f"{one['metric']}_px"]
        one["interval"] = [edge * mean for edge in interval]
    assert verdicts(results, "comparable to the operator")["primitive-paper"] == expected


@pytest.mark.parametrize("factor, expected", [(1.0, UNTESTED), (1.2, FAILS)])
def test_where_nothing_was_planned_means_may_refute_but_not_confirm(factor, expected):
    results = study()
    for error in ("distance_rmse_px", "radius_rmse_px"):
        results["setups"]["primitive-paper"][error] *= factor
    word = verdicts(results, "competitive with dnn-combined")["primitive-paper"]
    assert word == expected


@pytest.mark.parametrize(
    "difference, p, expected",
    [(-1.0, 0.01, HOLDS), (1.0, 0.01, FAILS), (-1.0, 0.05, OPEN)],
)
@pytest.mark.parametrize("turned", [False, True])
def test_lower_is_what_the_test_says_whichever_way_round(difference, p, expected, turned):
    results = study()
    _, radius = compared(results, "primitive", "dnn-combined")
    radius |= {"difference": difference, "interval": [difference - 0.5, difference + 0.5], "p_holm": p}
    if turned:
        radius |= {"a": "dnn-combined", "b": "primitive", "difference": -difference}
        radius["interval"] = [-difference - 0.5, -difference + 0.5]
    assert verdicts(results, "a lower radius error than dnn-combined")["primitive"] == expected


@pytest.mark.parametrize("radius, expected", [(99.0, FAILS), (0.1, UNTESTED)])
def test_without_a_test_a_radius_error_may_be_too_large_but_not_low(radius, expected):
    results = study()
    results["setups"]["primitive-paper"]["radius_rmse_px"] = radius
    assert verdicts(results, "a lower radius error than dnn-combined")["primitive-paper"] == expected


def test_always_in_view_means_always():
    claim = "all UGVs always in view"
    assert verdicts(study(), claim)["primitive"] == HOLDS
    on_a_sub_task, on_combined = study(), study()
    on_a_sub_task["setups"]["primitive"]["manoeuvres"]["climb"]["in_view"] = 0.9999
    on_combined["setups"]["primitive"]["scores"]["in_view"][0, 0] = 0.9999
    for results in (on_a_sub_task, on_combined):
        assert verdicts(results, claim)["primitive"] == FAILS
        assert verdicts(results, claim)["dnn-combined"] == HOLDS


@pytest.mark.parametrize("level, expected", [(0.9, HOLDS), (1.0, FAILS), (1.1, FAILS)])
def test_smoother_means_smoother(level, expected):
    results = study()
    results["setups"]["primitive"]["scores"]["smoothness"] *= level
    assert verdicts(results, "smoother than the operator")["primitive"] == expected


@pytest.mark.parametrize(
    "adjusted, expected", [((0.2, 1.0), FAILS), ((0.01, 1.0), PARTLY), ((0.01, 0.04), HOLDS)]
)
def test_the_papers_significance_is_what_its_numbers_say(adjusted, expected):
    results = study() | {"paper": {"welch": [{"p_holm": p} for p in adjusted]}}
    assert verdicts(results, "differences significant at 0.05") == {None: expected}


def test_set_ups_that_were_not_run_are_not_judged():
    for claim in claims(study(("human-combined", "primitive"))):
        assert {verdict.setup for verdict in claim.verdicts} <= {"primitive", None}


def test_every_verdict_on_a_set_up_is_one_of_its_fates():
    found = claims(study())
    for name in ("primitive", "primitive-paper"):
        fates = by_fate(found, name)
        assert list(fates) == [word for word in SIGNS if word in fates]
        told = sorted(short for which in fates.values() for short in which)
        assert told == sorted(c.short for c in found for verdict in c.verdicts if verdict.setup == name)
