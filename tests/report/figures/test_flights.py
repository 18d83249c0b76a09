"""What is drawn of a flight stands where the camera saw it, and where it was flown."""

from types import SimpleNamespace
from typing import cast

import pytest
from matplotlib.collections import LineCollection

from fledge.camera import Lens, look
from fledge.episode import Flight
from fledge.report.figures.flights import _middle, circles, ideal_altitude, top_view


def test_the_ideal_altitude_is_the_one_without_radius_error(still_flight):
    flight = still_flight("primitive")
    ideal = ideal_altitude(flight)
    assert ideal == pytest.approx(374.7 * 0.8 / 108.0)
    there = still_flight("primitive", height=float(ideal[0]))
    assert look(Lens(), there.episode.world).radius == pytest.approx(108.0)


def test_the_circle_is_drawn_where_the_camera_sees_it(still_flight):
    flight = still_flight("primitive", aside=0.3)
    picture = look(flight.lens, flight.episode.world)
    panel = circles({"primitive": flight}, "vertical").axes[0]
    drawn = [float(line.get_ydata()[0]) for line in panel.lines]
    u, v, r = float(picture.u[0]), float(picture.v[0]), float(picture.radius[0])
    assert u == pytest.approx(320.0) and v > 180.0
    for expected in (v, v - r, v + r, 180.0 - 108.0, 180.0 + 108.0, 0.0, 360.0):
        assert expected == pytest.approx(min(drawn, key=lambda at: abs(at - expected)), abs=1e-6)


def test_frames_out_of_view_are_marked(still_flight):
    for aside, marks in ((0.0, 0), (3.0, 60)):
        panel = circles({"primitive": still_flight("primitive", aside=aside)}, "horizontal").axes[0]
        (rug,) = (found for found in panel.collections if isinstance(found, LineCollection))
        assert len(rug.get_segments()) == marks


def test_the_frame_of_the_top_view_holds_all_tracks_and_no_padding(still_flight):
    flights = {"primitive": still_flight("primitive", aside=3.0)}
    panel = top_view(flights).axes[0]
    (low, high), (bottom, top) = panel.get_xlim(), panel.get_ylim()
    assert low < -0.4 and 3.0 < high < 10.0
    assert bottom < -0.7 and 1.3 < top < 10.0


def test_the_sticks_are_those_of_the_middle(still_flight):
    assert _middle(still_flight("primitive")) == slice(0, 60)
    assert _middle(cast(Flight, SimpleNamespace(rows=1200))) == slice(400, 800)
