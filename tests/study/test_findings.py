"""What is made of scores: adjusted within a family, honest about what did not fly."""

import json

import numpy as np
import pytest

from fledge.study.evaluation import Score
from fledge.study.findings import PRIMARY, compare_pairs, summarise_scores, to_json
from fledge.study.metrics import ERRORS, METRICS
from fledge.study.statistics import holm


def scores(mean: float, seeds: int = 1, cases: int = 12) -> Score:
    rng = np.random.default_rng(int(10 * mean))
    return Score(*(mean + rng.normal(0.0, 1.0, (seeds, cases)) for _ in Score.names()))


def test_a_summary_is_json_and_counts_flights():
    summary = json.loads(json.dumps(summarise_scores(scores(10.0, seeds=3), rows=1200)))
    assert summary["flights"] == 36
    assert summary["distance_integral_px_s"] == pytest.approx(60.0 * summary["distance"]["mean"])
    assert summary["radius"]["sd"] > 0.0


def test_p_values_are_adjusted_over_the_whole_family():
    flown = {"a": scores(10.0), "b": scores(11.0), "c": scores(10.2)}
    found = compare_pairs([("a", "b"), ("a", "c")], ERRORS, flown, seed=0)
    assert [c.p_holm for c in found] == list(holm([c.p for c in found]))
    assert [(c.a, c.b, c.metric) for c in found] == [
        ("a", "b", ERRORS[0]),
        ("a", "b", ERRORS[1]),
        ("a", "c", ERRORS[0]),
        ("a", "c", ERRORS[1]),
    ]


@pytest.mark.parametrize("name", METRICS)
def test_who_is_better_is_said_whichever_way_the_metric_goes(name):
    lower, higher = scores(10.0), scores(20.0)
    better, worse = (lower, higher) if METRICS[name].lower_is_better else (higher, lower)
    (found,) = compare_pairs([("better", "worse")], [name], {"better": better, "worse": worse}, seed=0)
    assert found.probability_of_improvement == 1.0
    assert found.effect_size < 0.0
    difference = float(np.mean(getattr(better, name) - getattr(worse, name)))
    assert found.difference == pytest.approx(difference)
    assert found.interval[0] < difference < found.interval[1]


def test_what_did_not_fly_is_not_compared():
    assert compare_pairs(PRIMARY, ERRORS, {"primitive": scores(10.0)}, seed=0) == ()


def test_the_primary_family_is_the_one_fixed_in_advance():
    assert PRIMARY == (("primitive", "dnn-combined"), ("primitive", "human-combined"))
    assert ERRORS == ("distance_rmse", "radius_rmse")


def test_what_json_cannot_say_is_none():
    (same,) = compare_pairs([("a", "b")], ERRORS[:1], {"a": flat(1.0), "b": flat(2.0)}, seed=0)
    assert not np.isfinite(same.effect_size)
    assert to_json(same)["effect_size"] is None
    json.dumps(to_json(same), allow_nan=False)


def flat(value: float) -> Score:
    return Score(*(np.full((1, 5), value) for _ in Score.names()))
