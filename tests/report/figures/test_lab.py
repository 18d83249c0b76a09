"""Figures of the physical experiment."""

import pytest
from field import flight
from matplotlib.figure import Figure

from fledge.report.figures import lab
from fledge.report.figures.looks import NETS, STRANGERS

SCORES = {name: {"flights": [1.0, 2.0, 3.0]} for name in ("distance_rmse", "radius_rmse")}
RESULTS = {"transfer": {"twin": {"scores": SCORES}, "simulator": {"scores": SCORES}}}


def texts(axes):
    return [text.get_text() for text in axes.texts]


def test_there_are_only_figures_of_what_was_flown():
    whole = lab.draw(RESULTS, {"lab": {"none": flight("none")}, "reversed": {"none": flight("none")}})
    assert [plot.name for plot in whole] == ["physical", "reversed", "transfer"]
    assert lab.draw({"transfer": None}, {}) == []


def test_the_papers_last_figure_has_the_room_and_both_axes_of_the_image():
    figure = lab.physical(flight(), NETS["stop-tube"])
    room, across, down = figure.axes
    assert [axes.get_title() for axes in figure.axes] == [
        "real positions",
        "horizontal image",
        "vertical image",
    ]
    assert room.get_xlim() == pytest.approx((-3.3 - lab.TELLING, 3.3 + lab.TELLING))
    assert down.yaxis_inverted() and not across.yaxis_inverted()


def test_a_uav_that_leaves_the_room_is_said_to():
    figure = lab.rooms({"none": flight("none", leaving=5.0), "stop-tube": flight("stop-tube")})
    left, stayed = figure.axes
    (words,) = [text for text in texts(left) if text]
    assert words == "out of the room, by 6 m"
    assert not [text for text in texts(stayed) if text]


def test_every_net_has_a_panel_and_a_stranger_has_a_look():
    names = ["a", "b", "c", "d"]
    figure = lab.rooms({name: flight(name) for name in names})
    assert [axes.get_title() for axes in figure.axes if axes.get_visible()] == names
    assert lab.look_of("a") is STRANGERS[0] and lab.look_of("paper") is NETS["paper"]


def test_the_gap_is_drawn_for_both_errors():
    figure = lab.gap(RESULTS["transfer"])
    assert isinstance(figure, Figure) and len(figure.axes) == 2
    assert [line.get_label() for line in figure.axes[0].lines] == ["simulator", "twin"]
