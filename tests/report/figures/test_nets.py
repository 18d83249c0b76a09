"""Nets stand where their numbers are."""

import charged
import numpy as np
import pytest
from matplotlib import rc_context

from fledge.report.figures.looks import LOOKS, NETS, PARTS, STRANGERS
from fledge.report.figures.nets import pareto, stand_off
from fledge.report.figures.sheet import STYLE
from fledge.study.setups import NETS as STUDIED


def test_every_net_of_a_study_has_a_look_of_its_own():
    assert set(NETS) == set(STUDIED)
    for trait in ("light", "dark", "dashes", "marker"):
        assert len({getattr(how, trait) for how in NETS.values()}) == len(NETS), trait
    others = [*LOOKS.values(), *PARTS.values(), *STRANGERS]
    assert not {how.light for how in NETS.values()} & {how.light for how in others}


def test_a_net_stands_at_its_cost_and_its_contacts():
    with rc_context(STYLE):
        (panel,) = pareto(charged.nets()).axes
    assert panel.get_title(loc="left") == "primitive"
    points = {line.get_label(): np.asarray(line.get_xydata())[0] for line in panel.lines}
    for name in charged.NAMES:
        expected = (charged.COSTS.get(name, 1.0), 100.0 * charged.CONTACTS[name] / 20)
        assert tuple(points[name]) == pytest.approx(expected)


def test_the_stand_off_shows_every_net_that_flew_it():
    (panel,) = stand_off(charged.nets()).axes
    lines = {line.get_label(): line for line in panel.lines}
    for name, gap in charged.nets()["stand_off"]["gap_m"].items():
        np.testing.assert_array_equal(lines[name].get_ydata(), gap)
        assert lines[name].get_color() == NETS[name].light
