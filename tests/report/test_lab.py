"""The page of the physical experiment: whole, alone, and true to its results."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from harvested import PLAN, harvest

from fledge.errors import BadFile
from fledge.report.lab import differences, write_report
from fledge.runs.labwork import simulator_settings, store, summarise, twin_settings
from fledge.storage import read_json, write_json

pytestmark = pytest.mark.slow

VOID = {"meta", "br", "img"}


class Page(HTMLParser):
    """What a reader sees of it, and whether every element is closed."""

    def __init__(self, html):
        super().__init__()
        self.open, self.words, self.rows = [], [], []
        self.feed(html)
        self.text = " ".join(" ".join(self.words).split())

    def handle_starttag(self, tag, attributes):
        if tag not in VOID:
            self.open.append(tag)
        if tag == "tr":
            self.rows.append([])

    def handle_startendtag(self, tag, attributes):
        pass

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("style", "script"):
            self.words.append(data)
        if {"td", "th"} & set(self.open[-4:]) and self.rows:
            self.rows[-1].append(data.strip())


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("lab")
    store(made, harvest(), summarise(PLAN, harvest(), "fledge lab-study servo"), {"flights": 12.0})
    write_report(made)
    return made


def test_the_page_is_one_whole_file_that_loads_nothing(folder):
    html = (folder / "index.html").read_text(encoding="utf-8")
    assert html.startswith("<!doctype html>") and "<script" not in html
    assert not re.search(r'(?:src|href)="(?!#|figures/|results\.json)', html)
    assert Page(html).open == []


def test_figures_lie_beside_it(folder):
    names = {path.name for path in (folder / "figures").iterdir()}
    assert names == {
        f"{name}.{kind}" for name in ("physical", "reversed", "transfer") for kind in ("svg", "png")
    }


def test_it_says_that_no_robot_flew_and_how_to_make_it_again(folder):
    text = Page((folder / "index.html").read_text(encoding="utf-8")).text
    assert "No robot flew" in text and "fledge lab-study servo" in text
    assert "its file does not say" in text


def test_not_worse_is_said_as_it_was_found(folder, tmp_path):
    results = read_json(folder / "results.json")
    for holds, words in ((True, "shown"), (False, "not shown")):
        for one in results["transfer"]["comparisons"].values():
            if one.get("non_inferiority"):
                one["non_inferiority"]["holds"] = holds
        write_json(tmp_path / "results.json", results)
        (tmp_path / "flights").mkdir(exist_ok=True)
        for path in (folder / "flights").iterdir():
            (tmp_path / "flights" / path.name).write_bytes(path.read_bytes())
        text = Page(write_report(tmp_path).read_text(encoding="utf-8")).text
        assert ("not shown" in text) == (words == "not shown")


def test_too_few_flights_are_not_compared(tmp_path):
    few = replace(PLAN, flights=2)
    store(tmp_path, harvest(few), summarise(few, harvest(few), ""), {})
    html = write_report(tmp_path).read_text(encoding="utf-8")
    assert "that takes 6 flights or more" in Page(html).text and 'id="transfer"' not in html


def test_a_missing_flight_is_named(folder, tmp_path):
    (tmp_path / "results.json").write_bytes((folder / "results.json").read_bytes())
    with pytest.raises(BadFile, match=r"lab-none\.mcap|lab-stop-tube\.mcap"):
        write_report(tmp_path)


def test_every_difference_is_one():
    """But for what says so in words, no line of the table tells the same of both."""
    found = differences({"twin": twin_settings(), "simulator": simulator_settings()})
    assert len(found) >= 12 and all(one.simulator != one.twin for one in found)
    assert {one.what for one in found} >= {"mass [kg]", "drag [1/s]", "commands under way [s]"}
