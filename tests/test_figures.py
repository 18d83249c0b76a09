import re
import subprocess
import sys
from dataclasses import replace
from itertools import combinations
from types import SimpleNamespace
from typing import Any, cast
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest
from matplotlib.collections import LineCollection

from fledge import figures
from fledge.camera import Lens, look
from fledge.episode import Episode, Flight
from fledge.figures import LOOKS, PARTS, STRANGERS
from fledge.geometry import Box, Quat, Vec3
from fledge.metrics import ERRORS, METRICS
from fledge.observation import Action
from fledge.world import Arena, Obstacle, UavState, UgvState, WorldState

ROWS = 60
ORDER = (
    *("training", "circle-horizontal", "circle-vertical", "top-view"),
    *("altitude", "distributions", "sticks", "comparisons"),
)


def still_flight(pilot: str, spread: float = 0.8, height: float = 2.0, aside: float = 0.0) -> Flight:
    """A UAV that hovers `aside` metres east of a triangle of UGVs, its nose to the east."""
    one, zero = np.ones(ROWS), np.zeros(ROWS)
    t = np.arange(ROWS) / 20.0
    still = Vec3(zero, zero, zero)
    corners = [2.0 * np.pi * i / 3.0 for i in range(3)]
    ugvs = tuple(
        UgvState(spread * np.cos(a) * one, spread * np.sin(a) * one, zero, zero, zero, t) for a in corners
    )
    uav = UavState(Vec3(aside * one, zero, height * one), still, Quat.from_yaw(zero), still, t)
    action = Action(np.sin(t), np.cos(t), zero, zero)
    unseen = cast(Any, None)
    episode = Episode(WorldState(t, uav, ugvs), unseen, action, unseen, (), spread * one)
    arena = replace(Arena.square(), obstacles=(Obstacle(Box(1.0, 1.4, 1.0, 1.3), 0.5),)).padded(3)
    return Flight(episode, "combined", pilot, "none", 0, 0, (0, 1, 2), arena)


FLIGHTS = {name: still_flight(name) for name in figures.FLOWN}


def results() -> dict[str, Any]:
    rng = np.random.default_rng(0)
    losses = {name: (0.1 / np.arange(1, 21)).tolist() for name in ("all", *PARTS)}
    curve = {"epochs": list(range(1, 21)), "training": losses, "validation": losses}
    setups = {
        name: {
            "curve": curve if name.startswith("primitive") else None,
            "scores": {
                metric: rng.uniform(5.0, 50.0, (2, 9)).tolist() for metric in ("distance_rmse", "radius_rmse")
            },
        }
        for name in (*LOOKS, "somebody's", "own")
    }
    comparisons = [
        {
            "family": family,
            "a": "primitive",
            "b": b,
            "metric": metric,
            "difference": 1.0,
            "interval": [-1.0, 3.0],
        }
        for family in ("primary", "exploratory")
        for b in ("human-combined", "own")
        for metric in ("distance_rmse", "radius_rmse", "in_view")
    ]
    return {"setups": setups, "comparisons": comparisons}


@pytest.fixture(scope="module")
def plots() -> list[figures.Plot]:
    return figures.draw(results(), FLIGHTS)


@pytest.fixture(scope="module")
def svgs(plots: list[figures.Plot]) -> dict[str, str]:
    return {plot.name: figures.to_svg(plot.figure) for plot in plots}


# Looks


def linear(colour: str) -> np.ndarray:
    srgb = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def contrast(one: str, other: str) -> float:
    """WCAG 2, equation of "contrast ratio"."""
    high, low = sorted((linear(colour) @ [0.2126, 0.7152, 0.0722] for colour in (one, other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("name", [name for name in figures.palette() if name not in ("card", "faint")])
def test_every_colour_stands_out_from_its_page(name):
    light, dark = figures.palette()[name]
    for page in (figures.PAGE["card"][0], "#f8f7f4"):
        assert contrast(light, page) >= 3.0
    for page in (figures.PAGE["card"][1], "#131619"):
        assert contrast(dark, page) >= 3.0


def test_no_two_set_ups_look_alike():
    every = [*LOOKS.values(), *STRANGERS]
    for trait in ("light", "dark", "dashes", "marker"):
        assert len({getattr(how, trait) for how in every}) == len(every), trait


# Machado, Oliveira and Fernandes 2009, severity 1, on linear RGB.
SEEN_BY = {
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}


def lab(rgb: np.ndarray) -> np.ndarray:
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    ratio = to_xyz @ np.clip(rgb, 0.0, 1.0) / [0.9505, 1.0, 1.089]
    f = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio * (29 / 6) ** 2 / 3.0 + 4.0 / 29.0)
    return np.array([116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])])


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("eye", SEEN_BY)
def test_colour_blind_readers_tell_the_main_set_ups_apart(eye, theme):
    seen = {
        name: lab(np.array(SEEN_BY[eye]) @ linear(getattr(LOOKS[name], theme))) for name in figures.COMPARED
    }
    for one, other in combinations(seen, 2):
        assert np.linalg.norm(seen[one] - seen[other]) > 10.0, (one, other)


def test_strangers_get_a_look_too():
    shown = figures.looks(["own", "primitive", "somebody's", "human-combined"])
    assert list(shown) == ["human-combined", "primitive", "own", "somebody's"]
    assert shown["own"] != shown["somebody's"]


def test_a_swatch_has_the_colour_the_dashes_and_the_marker():
    for how in (*LOOKS.values(), *STRANGERS):
        sample = figures.swatch(how)
        ElementTree.fromstring(sample)
        assert sample.count(figures.variables()[how.light]) == 2
        assert ("none" in sample) == (not how.dashes)


# Figures


def test_all_figures_are_there_in_order(plots):
    assert tuple(plot.name for plot in plots) == ORDER


def test_what_is_not_there_is_not_drawn():
    bare = results()
    for setup in bare["setups"].values():
        setup["curve"] = None
    bare["comparisons"] = []
    assert [plot.name for plot in figures.draw(bare, {})] == ["distributions"]
    one = figures.draw(bare, {"dnn-combined": FLIGHTS["dnn-combined"]})
    assert [plot.name for plot in one] == [*ORDER[1:6]]


def test_drawing_leaves_the_style_as_it_was():
    before = dict(matplotlib.rcParams)
    figures.to_svg(figures.draw(results(), FLIGHTS)[-1].figure)
    assert dict(matplotlib.rcParams) == before


def test_importing_is_light():
    code = "import fledge.figures, sys; assert not {'matplotlib', 'jax'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_ideal_altitude_is_the_one_without_radius_error():
    flight = FLIGHTS["primitive"]
    ideal = figures.ideal_altitude(flight)
    assert ideal == pytest.approx(374.7 * 0.8 / 108.0)
    there = still_flight("primitive", height=float(ideal[0]))
    assert look(Lens(), there.episode.world).radius == pytest.approx(108.0)


def test_the_circle_is_drawn_where_the_camera_sees_it():
    flight = still_flight("primitive", aside=0.3)
    picture = look(flight.lens, flight.episode.world)
    panel = figures.circles({"primitive": flight}, "vertical").axes[0]
    drawn = [float(line.get_ydata()[0]) for line in panel.lines]
    u, v, r = float(picture.u[0]), float(picture.v[0]), float(picture.radius[0])
    assert u == pytest.approx(320.0) and v > 180.0
    for expected in (v, v - r, v + r, 180.0 - 108.0, 180.0 + 108.0, 0.0, 360.0):
        assert expected == pytest.approx(min(drawn, key=lambda at: abs(at - expected)), abs=1e-6)


def test_frames_out_of_view_are_marked():
    for aside, marks in ((0.0, 0), (3.0, ROWS)):
        panel = figures.circles({"primitive": still_flight("primitive", aside=aside)}, "horizontal").axes[0]
        (rug,) = (found for found in panel.collections if isinstance(found, LineCollection))
        assert len(rug.get_segments()) == marks


def test_the_frame_of_the_top_view_holds_all_tracks_and_no_padding():
    flights = {"primitive": still_flight("primitive", aside=3.0)}
    panel = figures.top_view(flights).axes[0]
    (low, high), (bottom, top) = panel.get_xlim(), panel.get_ylim()
    assert low < -0.4 and 3.0 < high < 10.0
    assert bottom < -0.7 and 1.3 < top < 10.0


def test_the_sticks_are_those_of_the_middle():
    assert figures._middle(still_flight("primitive")) == slice(0, ROWS)
    assert figures._middle(cast(Flight, SimpleNamespace(rows=1200))) == slice(400, 800)


def test_the_arrow_points_where_the_first_is_better(plots):
    for panel, metric in zip(plots[-1].figure.axes, (*ERRORS, "in_view"), strict=True):
        lower = METRICS[metric].lower_is_better
        assert panel.get_title(loc="left").startswith("\N{LEFTWARDS ARROW}") == lower
        assert panel.get_title(loc="left").endswith("\N{RIGHTWARDS ARROW}") != lower


# Bytes


def test_svg_and_png_are_the_same_again(plots, svgs):
    again = {plot.name: plot for plot in figures.draw(results(), FLIGHTS)}
    for plot in plots:
        assert figures.to_svg(again[plot.name].figure) == svgs[plot.name]
    assert figures.to_png(again["sticks"].figure) == figures.to_png(
        figures.draw(results(), FLIGHTS)[6].figure
    )


def test_png_is_png(plots):
    assert figures.to_png(plots[-1].figure).startswith(b"\x89PNG\r\n\x1a\n")


@pytest.mark.parametrize("name", ORDER)
def test_svg_is_a_document_without_a_date(svgs, name):
    ElementTree.fromstring(svgs[name])
    assert "metadata" not in svgs[name]
    assert "sans-serif" in svgs[name]


@pytest.mark.parametrize("name", ORDER)
def test_inline_takes_every_colour_from_the_page(svgs, name):
    element = figures.inline(svgs[name], name, "title")
    ElementTree.fromstring(element)
    assert not re.findall(r"#[0-9a-fA-F]{3,8}\b(?!\))", re.sub(r'href="#[^"]*"', "", element))
    assert set(re.findall(r"var\((--[a-z0-9-]+)\)", element)) <= set(figures.variables().values())
    assert "http" not in element and "<style" not in element


@pytest.mark.parametrize("name", ORDER)
def test_inline_keeps_every_word_and_number(svgs, name):
    def words(svg: str) -> list[str]:
        nodes = ElementTree.fromstring(svg).iter()
        return ["".join(node.itertext()).strip() for node in nodes if node.tag.endswith("text")]

    assert words(figures.inline(svgs[name], name, "title")) == words(svgs[name]) != []


def test_inline_figures_share_a_page(svgs):
    page = "".join(figures.inline(svg, name, "title") for name, svg in svgs.items())
    ids = re.findall(r'\bid="([^"]+)"', page)
    assert len(ids) == len(set(ids))
    assert set(re.findall(r"url\(#([^)]+)\)", page)) | set(re.findall(r'href="#([^"]+)"', page)) <= set(ids)
