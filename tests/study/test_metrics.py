"""Every number that is shown has its row in the table, and what is said there is true of it."""

from dataclasses import fields

import pytest

from fledge.study.crossover import BANDS, Credibility
from fledge.study.evaluation import Score
from fledge.study.metrics import CREDIBILITY, ERRORS, METRICS


def test_every_number_has_its_row():
    assert tuple(METRICS) == Score.names()
    assert tuple(CREDIBILITY) == tuple(BANDS)
    assert set(CREDIBILITY) <= {field.name for field in fields(Credibility)}
    assert set(ERRORS) <= set(METRICS)


@pytest.mark.parametrize(
    "metric", [*METRICS.values(), *CREDIBILITY.values()], ids=lambda metric: metric.title
)
def test_shares_are_shown_in_per_cent_and_their_differences_in_points(metric):
    assert (metric.factor == 100.0) == (metric.unit == "%")
    assert metric.head() == (f"{metric.title} [{metric.unit}]" if metric.unit else metric.title)
    assert metric.head(difference=True) == metric.head().replace("%", "pp")
