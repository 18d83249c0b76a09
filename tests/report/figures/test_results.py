"""What stands in results.json is what the figures say."""

import numpy as np
import pytest
from matplotlib import rc_context

from fledge.report.figures.looks import COMPARED, LOOKS
from fledge.report.figures.results import distributions, forest, training
from fledge.report.figures.sheet import STYLE
from fledge.study.metrics import ERRORS, METRICS


def test_every_set_up_that_learnt_has_its_panel(results):
    trained = [name for name, setup in results["setups"].items() if setup["curve"]]
    shown = [panel for panel in training(results).axes if panel.get_visible()]
    assert {panel.get_title() for panel in shown} == set(trained)
    for panel in shown:
        assert panel.get_yscale() == "log"
        assert max(np.max(line.get_xdata()) for line in panel.lines) == 20


def test_a_distribution_ends_with_all_flights_and_is_marked_at_its_median(results):
    for panel, metric in zip(distributions(results).axes, ERRORS, strict=True):
        for line, name in zip(panel.lines, COMPARED, strict=True):
            errors = np.ravel(results["setups"][name]["scores"][metric])
            assert line.get_color() == LOOKS[name].light
            error, share = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
            assert (error[-1], share[-1]) == (errors.max(), 1.0)
            assert share[line.get_markevery()] == pytest.approx(0.5, abs=1.1 / errors.size)


def test_a_difference_is_in_the_unit_of_its_axis_and_the_arrow_points_to_the_better(results):
    with rc_context(STYLE):
        panels = forest(results).axes
    for panel, name in zip(panels, (*ERRORS, "in_view"), strict=True):
        metric = METRICS[name]
        assert panel.get_xlabel() == f"difference in {metric.head(difference=True)}"
        assert np.asarray(panel.lines[0].get_xdata()) == metric.factor * 1.0
        assert panel.get_title(loc="left").startswith("\N{LEFTWARDS ARROW}") == metric.lower_is_better
        assert panel.get_title(loc="left").endswith("\N{RIGHTWARDS ARROW}") != metric.lower_is_better
