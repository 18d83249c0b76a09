"""Every figure there is something for, the same bytes each time, and at home on a page of either theme."""

import copy
import re
import subprocess
import sys
from xml.etree import ElementTree

import matplotlib
import pytest

from fledge.report.figures.looks import variables
from fledge.report.figures.plots import Plot, draw, inline, to_png, to_svg

pytestmark = pytest.mark.slow

ORDER = (
    *("training", "circle-horizontal", "circle-vertical", "top-view"),
    *("altitude", "distributions", "sticks", "comparisons"),
    *("pareto", "stand-off"),
)


@pytest.fixture(scope="module")
def plots(results, flights) -> list[Plot]:
    return draw(results, flights)


@pytest.fixture(scope="module")
def svgs(plots) -> dict[str, str]:
    return {plot.name: to_svg(plot.figure) for plot in plots}


def test_all_figures_are_there_in_order(plots):
    assert tuple(plot.name for plot in plots) == ORDER


def test_what_is_not_there_is_not_drawn(results, flights):
    bare = copy.deepcopy(results)
    for setup in bare["setups"].values():
        setup["curve"] = None
    bare["comparisons"] = []
    bare["nets"] = None
    assert [plot.name for plot in draw(bare, {})] == ["distributions"]
    one = draw(bare, {"dnn-combined": flights["dnn-combined"]})
    assert [plot.name for plot in one] == [*ORDER[1:6]]


def test_drawing_leaves_the_style_as_it_was(results, flights):
    before = dict(matplotlib.rcParams)
    to_svg(draw(results, flights)[-1].figure)
    assert dict(matplotlib.rcParams) == before


def test_importing_is_light():
    code = "import fledge.report.figures, sys; assert not {'matplotlib', 'jax'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_svg_and_png_are_the_same_again(plots, svgs, results, flights):
    again = {plot.name: plot for plot in draw(results, flights)}
    for plot in plots:
        assert to_svg(again[plot.name].figure) == svgs[plot.name]
    assert to_png(again["sticks"].figure) == to_png(draw(results, flights)[6].figure)


def test_png_is_png(plots):
    assert to_png(plots[-1].figure).startswith(b"\x89PNG\r\n\x1a\n")


@pytest.mark.parametrize("name", ORDER)
def test_svg_is_a_document_without_a_date(svgs, name):
    ElementTree.fromstring(svgs[name])
    assert "metadata" not in svgs[name]
    assert "sans-serif" in svgs[name]


@pytest.mark.parametrize("name", ORDER)
def test_inline_takes_every_colour_from_the_page(svgs, name):
    element = inline(svgs[name], name, "title")
    ElementTree.fromstring(element)
    assert not re.findall(r"#[0-9a-fA-F]{3,8}\b(?!\))", re.sub(r'href="#[^"]*"', "", element))
    assert set(re.findall(r"var\((--[a-z0-9-]+)\)", element)) <= set(variables().values())
    assert "http" not in element and "<style" not in element


@pytest.mark.parametrize("name", ORDER)
def test_inline_keeps_every_word_and_number(svgs, name):
    def words(svg: str) -> list[str]:
        nodes = ElementTree.fromstring(svg).iter()
        return ["".join(node.itertext()).strip() for node in nodes if node.tag.endswith("text")]

    assert words(inline(svgs[name], name, "title")) == words(svgs[name]) != []


def test_inline_figures_share_a_page(svgs):
    page = "".join(inline(svg, name, "title") for name, svg in svgs.items())
    ids = re.findall(r'\bid="([^"]+)"', page)
    assert len(ids) == len(set(ids))
    assert set(re.findall(r"url\(#([^)]+)\)", page)) | set(re.findall(r'href="#([^"]+)"', page)) <= set(ids)
