"""The study of nets: same flights for all, and numbers that say what was flown."""

import json

import numpy as np
import pytest

from fledge import engines
from fledge.dynamics import UGV_FLEET
from fledge.pilots import Servo
from fledge.safety import NETS
from fledge.simulation import Case, flight_key
from fledge.study.bill import Bill
from fledge.study.evaluation import Score
from fledge.study.restraint import (
    LAB,
    NAMED,
    NEAR,
    Entry,
    Trials,
    compile_ahead,
    cost,
    examine,
    summarise,
    trials,
)
from fledge.study.setups import NETS as STUDIED
from fledge.world import Arena

pytestmark = pytest.mark.slow

ROWS = 120


def made_up(distance, gap, interventions=0.0, held=0.0) -> Bill:
    """A bill of some flights of 100 rows."""
    flights = len(distance)
    errors = {name: np.asarray(distance, dtype=float) for name in Score.names()}
    return Bill(
        Score(**errors),
        np.full((flights, 5), interventions),
        np.full((flights, 5), 0.5 * interventions),
        np.tile(np.asarray(gap, dtype=float)[:, None], 4),
        np.full((flights, 4), 0.9 * NEAR),
        np.full((flights, 4), held),
    )


def test_every_shipped_net_is_studied_by_the_name_of_its_module():
    assert set(STUDIED) == set(NAMED) and len(NAMED) == len(NETS)
    assert type(NAMED["paper-repaired"]).__name__ == "RepairedPaperNet"


def test_flights_are_the_test_flights_and_shapes_are_alike():
    found = trials(3, 4, seed=5, rows=ROWS)
    assert set(found) == {"combined", "reversed", "lab"} and found["combined"] is found["reversed"]
    key = flight_key(5, "test", "combined", 1)
    assert found["combined"].keys[1] == (*key, 1)
    assert set(trials(2, 0, 0, ROWS)) == {"combined", "reversed"}


def test_in_the_lab_every_corner_stays_clear_of_the_walls():
    """By what the default net asks of a UGV at 0.3 m/s, and more."""
    flights = Trials.draw(LAB, "lab", 30, 0, 1200)
    assert {float(case.plan.track.spread[0]) for case in flights.cases} == {0.7, 0.75, 0.8}
    for case in flights.cases:
        track, bounds = case.plan.track, Arena.lab().bounds
        assert case.plan.arena.bounds == bounds
        room = -bounds.distance(track.x, track.y) - track.spread - UGV_FLEET[0].radius
        assert room.min() > 0.5


def test_a_net_flies_the_same_flights_as_no_net_and_is_charged_for_them(monkeypatch):
    nets = {name: NAMED[name] for name in ("none", "paper")}
    compile_ahead(Servo(p=0.1), list(nets), ROWS)
    monkeypatch.setattr(engines, "compiled", None)  # all that will be needed is there, whoever flies
    flights = trials(2, 2, seed=0, rows=ROWS)
    entries = list(examine("servo", Servo(), nets, flights))
    assert [(one.pilot, one.net) for one in entries] == [("servo", "none"), ("servo", "paper")]
    found = summarise(entries, ROWS, seed=0)
    assert json.loads(json.dumps(found)) == found
    for kind in flights:
        none = found["flights"]["servo"][kind]["none"]
        assert none["flights"] == 2 and none["interventions"] == {"uav": 0.0, "ugv": 0.0, "any": 0.0}
    assert found["flights"]["servo"]["combined"]["paper"]["cost"]["flights"] == 2
    assert list(found["stand_off"]["gap_m"]) == ["paper"]
    # Reversed sticks lead elsewhere.
    ways = found["flights"]["servo"]
    assert ways["reversed"]["none"]["distance_rmse_px"] > 3.0 * ways["combined"]["none"]["distance_rmse_px"]


def test_cost_is_a_ratio_over_flights_that_go_well_without_a_net():
    free = made_up([10.0, 20.0, 30.0, 1000.0], [1.0, 0.2, 0.1, -0.1])
    behind = made_up([11.0, 22.0, 33.0, 5.0], [1.0] * 4)
    found = cost(behind, free, seed=0)
    assert found is not None and found["flights"] == 3
    assert found["distance_rmse"]["ratio"] == pytest.approx(1.1)
    same = cost(free, free, 0)
    assert same is not None and same["distance_rmse"]["holds"] and not found["distance_rmse"]["holds"]
    assert cost(behind, made_up([1.0, 1.0], [0.0, -1.0]), 0) is None


def test_shares_are_of_steps_and_people_come_by_the_hour():
    entry = Entry("me", "paper", {"lab": made_up([1.0] * 6, [0.3] * 5 + [-0.1], 25.0, 1.0)})
    found = summarise([entry], 100, 0)["flights"]["me"]["lab"]["paper"]
    assert found["interventions"] == {"uav": 0.25, "ugv": 0.25, "any": 0.25}
    assert found["false_alarms"]["any"] == 0.125
    assert found["contacts"] == 1 and 1 / 6 < found["upper_bound_95"] < 1.0
    assert found["near"] == {"uav": 1.0, "ugv": 1.0}
    assert found["human_interventions"] == 24
    assert found["human_interventions_per_hour"] == pytest.approx(24 / (6 * 5.0 / 3600.0))


def test_a_case_of_the_lab_is_a_function_of_its_key():
    one, other = (Trials.draw(LAB, "lab", 1, seed, 50).cases[0] for seed in (0, 0))
    assert isinstance(one, Case)
    np.testing.assert_array_equal(one.plan.track.x, other.plan.track.x)
