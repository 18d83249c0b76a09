"""What stands in a table is what was found, in the units of its head."""

import pytest

from fledge.report import tables
from fledge.study.metrics import CREDIBILITY, METRICS

ENTRY = {
    "distance": {"mean": 12.345, "sd": 6.789},
    "radius": {"mean": 101.25, "sd": 55.5},
    "distance_rmse_px": 14.0,
    "radius_rmse_px": 9.5,
    "in_view": 0.98765,
    "smoothness": 1.25,
}


def comparison(metric, **other):
    found = {"difference": -0.5, "interval": (-0.75, 0.25), "p_holm": 0.03125, "effect_size": -1.5}
    return {"a": "primitive", "b": "servo", "metric": metric, **found, **other}


def test_scores_are_in_the_units_of_their_heads():
    table = tables.scores("flights", {"servo": ENTRY})
    assert [" ".join(head.split()) for head in table.columns] == [
        *("", "distance mean [px]", "radius mean [px²]", "distance RMSE [px]", "radius RMSE [px]"),
        *("in view [%]", "sticks [1/s]"),
    ]
    assert table.rows == (("servo", "12.3 ± 6.8", "101.2 ± 55.5", "14.0", "9.5", "98.77", "1.25"),)


def test_a_table_of_scores_fits_a_terminal_where_names_are_short():
    table = tables.scores("flights", {"policy.onnx": ENTRY})
    cells = [
        max(len(line) for text in column for line in text.split("\n"))
        for column in zip(*table.rows, strict=True)
    ]
    heads = [max(map(len, head.split("\n"))) for head in table.columns]
    assert sum(max(pair) + 2 for pair in zip(cells, heads, strict=True)) <= 80


@pytest.mark.parametrize("metric", METRICS)
def test_a_comparison_is_in_the_unit_of_its_metric(metric):
    factor = 100.0 if metric == "in_view" else 1.0
    (table,) = tables.comparisons([comparison(metric)])
    assert table.title == "primitive minus servo"
    interval = f"{-0.75 * factor:+.2f} to {0.25 * factor:+.2f}"
    name = METRICS[metric].head(difference=True)
    assert table.rows == ((name, f"{-0.5 * factor:+.2f}", interval, "0.0312", "-1.50"),)


def test_a_very_small_p_is_not_called_zero():
    (table,) = tables.comparisons([comparison("in_view", p_holm=1e-7)])
    assert table.rows[0][3] == "< 0.0001"


def test_every_pair_has_its_table():
    found = [
        comparison(metric, b=b)
        for b in ("servo", "human-combined")
        for metric in ("distance_rmse", "radius_rmse", "in_view")
    ]
    assert [(table.title, len(table.rows)) for table in tables.comparisons(found)] == [
        ("primitive minus servo", 3),
        ("primitive minus human-combined", 3),
    ]
    assert tables.comparisons([]) == []


def test_a_flights_score_comes_with_units():
    scores = {"distance": 1.0, "distance_rmse": 2.0, "radius": 9.0, "radius_rmse": 3.0}
    table = tables.flight("climb", scores | {"in_view": 0.5, "smoothness": 0.25, "effort": 0.125})
    assert [value for _, value in table.rows] == [
        "1.0 px",
        "2.0 px",
        "9.0 px²",
        "3.0 px",
        "50.00 %",
        "0.25 1/s",
        "0.125",
    ]


def test_the_operator_stands_beside_the_bands_that_people_reach():
    axis = {"axis": "up", "crossover": 1.204, "delay": 0.555, "remnant": 0.2514, "inside": False}
    bands = {"crossover": (1.0, 2.5), "delay": (0.35, 0.65), "remnant": (0.1, 0.3)}
    table = tables.operator({"sentence": "Nobody.", "axes": [axis], "bands": bands})
    assert table.title == "Nobody."
    assert [" ".join(head.split()) for head in table.columns[1:-1]] == [
        metric.head() for metric in CREDIBILITY.values()
    ]
    assert table.rows == (
        ("up", "1.20", "0.56", "25.1", "no"),
        ("people", "1.00 to 2.50", "0.35 to 0.65", "10.0 to 30.0", ""),
    )


def test_attacks_are_shown_family_by_family_and_in_all():
    one = {
        **{"flights": 1200, "contacts": 3, "deadlocks": 0, "breaches": 40, "false_alarm_rate": 0.253},
        "least_gap_m": {"uav": -0.104, "ugv": 0.06},
    }
    none = one | {"false_alarm_rate": None}
    table = tables.attacks("paper under attack", none | {"families": {"random": one}})
    assert table.rows == (
        ("random", "1,200", "3", "0", "40", "25.3", "-0.10", "0.06"),
        ("all", "1,200", "3", "0", "40", "-", "-0.10", "0.06"),
    )
    assert len(table.columns) == len(table.rows[0])


def test_flights_in_the_lab_say_what_was_touched_and_who_was_needed():
    one = {
        "contacts": 4,
        "people_needed": 2,
        "interventions_per_minute": {"net": 1.25, "watchdog": 0.5, "people": 0.0},
        "scores": {"distance_rmse": {"mean": 19.26}, "radius_rmse": {"mean": 1.0}, "in_view": {"mean": 0.5}},
    }
    table = tables.lab("title", {"paper": one, "none": one | {"scores": None}})
    assert table.rows[0] == ("paper", "4", "2", "1.75", "19.3", "1.0", "50.00")
    assert table.rows[1][-3:] == ("-", "-", "-")


def test_simulator_and_twin_stand_side_by_side():
    sides = {"scores": {name: {"mean": 0.5} for name in ("distance_rmse", "in_view")}}
    found = {
        "simulator": sides,
        "twin": sides,
        "comparisons": {
            "distance_rmse": {"interval": [-1.0, 0.5], "non_inferiority": {"upper": 1.034}},
            "in_view": {"interval": [0.0, 0.01]},
        },
    }
    distance, view = tables.transfer(found).rows
    assert distance == ("distance RMSE [px]", "0.5", "0.5", "-1.00 to +0.50", "1.03")
    assert view == ("in view [%]", "50.00", "50.00", "+0.00 to +1.00", "-")
