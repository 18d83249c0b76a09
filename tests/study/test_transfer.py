"""What flights in the lab come to, and what may be said of simulator and twin."""

from dataclasses import replace

import numpy as np
import pytest
from field import flight, numbers

from fledge.observation import IDEAL_RADIUS_PX
from fledge.study.evaluation import Score
from fledge.study.transfer import NO_ROBOT, behind, compare, needed, scored, sentences

MINUTE = 60.0


def scores(distance, **others):
    """Of as many flights as there are distances."""
    values = dict.fromkeys(Score.names(), np.ones((1, len(distance))))
    return Score(**values | {"distance_rmse": np.array([distance])} | others)


def test_a_flight_is_scored_by_its_rows():
    found = scored([flight(aside=0.0), flight(aside=0.5)])
    assert found.distance.shape == (1, 2)
    assert found.distance[0, 0] == pytest.approx(0.0, abs=1e-3)
    assert found.distance[0, 1] == pytest.approx(374.7 * 0.5 / 2.4, rel=1e-3)
    assert found.radius_rmse[0, 0] == pytest.approx(abs(374.7 * 0.7 / 2.4 - IDEAL_RADIUS_PX), rel=1e-2)


def test_interventions_are_counted_by_the_minute_and_by_the_layer():
    held = {"net": {"wall": 3}, "watchdog": {"stale": 1}, "people": {}}
    quiet = {layer: {} for layer in held}
    told = behind(
        [numbers(interventions=held, aloft_s=MINUTE), numbers(interventions=quiet, aloft_s=MINUTE)], []
    )
    assert told["interventions_per_minute"] == {"net": 1.5, "watchdog": 0.5, "people": 0.0}
    assert told["reasons"] == {"net: wall": 3, "watchdog: stale": 1}
    assert told["scores"] is None and told["minutes"] == 2.0


def test_flights_that_nobody_got_down_needed_somebody():
    assert needed(numbers(landed=False)) and needed(numbers(human_interventions_needed=1))
    assert not needed(numbers())
    told = behind([numbers(landed=False, contacts=2, touched=["ardrone, wall"]), numbers()], [])
    assert (told["people_needed"], told["contacts"], told["landed"]) == (1, 1, 1)
    assert (told["contacts_flying"], told["contacts_landing"]) == (1, 0)
    assert told["touched"] == ["ardrone, wall"]
    assert told["contacts_upper_bound_95"] == pytest.approx(0.975, abs=0.001)


def test_flights_whose_pilot_never_flew_are_told_of():
    told = behind([numbers(held=None, rows=0, least_gap_m=None)], [])
    assert (told["flights"], told["began"], told["held"], told["least_gap_m"]) == (1, 0, None, None)


def test_the_smallest_gap_is_that_of_all_flights():
    gaps = [{"uav": 0.4, "ugv": 0.1}, {"uav": 0.2, "ugv": 0.3}]
    assert behind([numbers(least_gap_m=gap) for gap in gaps], [])["least_gap_m"] == {"uav": 0.2, "ugv": 0.1}


def test_not_worse_is_claimed_only_where_a_bound_says_so():
    base = np.linspace(10.0, 20.0, 12)
    better, worse = scores(0.9 * base), scores(1.3 * base)
    same = scores(base)
    assert compare(better, same, 0, 30.0)["comparisons"]["distance_rmse"]["non_inferiority"]["holds"]
    found = compare(worse, same, 0, 30.0)["comparisons"]["distance_rmse"]
    assert not found["non_inferiority"]["holds"] and found["difference"] > 0.0 and found["p"] < 0.01


def test_noise_that_hides_a_difference_does_not_make_it_not_worse():
    rng = np.random.default_rng(1)
    base = rng.uniform(5.0, 30.0, 6)
    found = compare(scores(rng.permutation(base)), scores(base), 0, 30.0)["comparisons"]["distance_rmse"]
    assert found["p"] > 0.05 and not found["non_inferiority"]["holds"]


def test_every_flight_is_in_the_results():
    found = compare(scores([1.0, 2.0]), scores([3.0, 4.0]), 0, 30.0)
    assert found["twin"]["scores"]["distance_rmse"]["flights"] == [1.0, 2.0]
    assert found["simulator"]["scores"]["distance_rmse"]["mean"] == 3.5


def test_it_is_said_that_no_robot_flew_and_who_was_synthetic():
    assert sentences("servo")[0] == sentences("human-model")[0] == NO_ROBOT
    assert "synthetic operator" in sentences("human-model")[1]
    assert "its file does not say" in sentences("policy.onnx")[1]


def test_a_flight_out_of_view_is_out_of_view():
    away = flight(leaving=3.0)
    share = scored([replace(away)]).in_view[0, 0]
    assert 0.1 < share < 0.9
