"""A sheet measures what it says, and its axes read as numbers."""

import numpy as np
import pytest

from fledge.report.figures import sheet


@pytest.mark.parametrize(("rows", "columns"), [(1, 1), (3, 1), (2, 4)])
@pytest.mark.parametrize("keyed", [True, False])
def test_panels_are_as_high_and_as_far_apart_as_asked_for(rows, columns, keyed):
    figure, panels = sheet.panels(rows, columns, 1.5, apart=(0.2, 0.4), keyed=keyed)
    width, height = figure.get_size_inches()
    assert width == sheet.WIDTH
    assert len(panels) == rows * columns
    boxes = [panel.get_position() for panel in panels]
    assert [box.height * height for box in boxes] == pytest.approx([1.5] * len(panels))
    assert boxes[-1].x1 * width == pytest.approx(sheet.WIDTH - sheet.RIGHT)
    if columns > 1:
        assert (boxes[1].x0 - boxes[0].x1) * width == pytest.approx(0.2)
    if rows > 1:
        assert (boxes[0].y0 - boxes[columns].y1) * height == pytest.approx(0.4)


def test_a_logarithmic_axis_has_numbers_for_labels():
    _, (panel,) = sheet.panels(1, 1, 1.0)
    sheet.logarithmic(panel, "x", (1.0, 2.0, 5.0))
    panel.set_xlim(0.5, 20.0)
    labels = [label.get_text() for label in panel.get_xticklabels()]
    assert {"0.5", "1", "2", "5", "10", "20"} <= set(labels)


@pytest.mark.parametrize("decades", [0.5, 1.0, 2.0, 3.0, 3.5])
def test_the_labels_of_a_logarithmic_axis_stay_apart(decades):
    """On half a sheet; a label of four digits is 0.3 inches wide."""
    figure, (panel, _) = sheet.panels(1, 2, 1.0)
    panel.set_xlim(2.0, 2.0 * 10.0**decades)
    sheet.logarithmic(panel, "x", (1.0, 2.0, 3.0, 5.0, 7.0))
    figure.draw_without_rendering()
    low, high = panel.get_xlim()
    places = [np.log10(tick) for tick in panel.get_xticks() if low <= tick <= high]
    assert len(places) >= 2
    inches = panel.get_position().width * sheet.WIDTH / np.log10(high / low)
    assert np.diff(places).min() * inches > 0.3


def test_time_runs_to_the_end_of_the_last_row():
    assert sheet.seconds(np.arange(40) / 20.0) == pytest.approx((0.0, 2.0))


def test_a_legend_names_what_it_shows():
    figure, _ = sheet.panels(1, 1, 1.0)
    sheet.legend(figure, sheet.line("one", color="black"), sheet.patch("two", facecolor="black"))
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["one", "two"]


def test_one_panel_beside_two():
    figure, (left, above, below) = sheet.beside(3.9, 2.95)
    size = figure.get_size_inches()
    boxes = [axes.get_position() for axes in (left, above, below)]
    assert (boxes[0].width * size[0], boxes[0].height * size[1]) == pytest.approx((3.9, 2.95))
    assert boxes[1].x0 == boxes[2].x0 > boxes[0].x1 and boxes[1].y0 > boxes[2].y1
    assert (boxes[1].y1, boxes[2].y0) == pytest.approx((boxes[0].y1, boxes[0].y0))
