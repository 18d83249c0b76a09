import copy
import os
import re
import shutil
import subprocess
from dataclasses import asdict
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import charged
import numpy as np
import pytest

from fledge.engines import fly_plain
from fledge.episode import Flight
from fledge.errors import BadFile
from fledge.manoeuvres import Combined
from fledge.observation import OBSERVATION_NAMES
from fledge.pilots import HumanModel, Servo
from fledge.report.claims import claims
from fledge.report.figures import FLOWN, LOOKS
from fledge.report.study import MAIN, render, write_report
from fledge.report.wording import flat, number, p_value, percent, signed
from fledge.simulation import Case, Crew
from fledge.storage import read_json, write_flight, write_json
from fledge.study import statistics

pytestmark = pytest.mark.slow

SEEDS, CASES = 6, 9
LEVELS = {
    "human-combined": 28.0,
    "dnn-combined": 27.0,
    "primitive-paper": 50.0,
    "primitive": 26.0,
    "servo": 24.0,
}
INPUTS = list(OBSERVATION_NAMES)
FIGURES = (
    *("training", "circle-horizontal", "circle-vertical", "top-view"),
    *("altitude", "distributions", "sticks", "comparisons"),
    *("pareto", "stand-off"),
)


def scores(name: str, level: float, seeds: int) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(len(name))
    hardness = np.random.default_rng(7).normal(0.0, 3.0, CASES)
    distance_rmse = level + hardness + rng.normal(0.0, 0.5, (seeds, CASES))
    radius_rmse = level / 3.0 + rng.normal(0.0, 0.3, (seeds, CASES))
    return {
        "distance": 0.9 * distance_rmse,
        "distance_rmse": distance_rmse,
        "radius": 1234.5 + radius_rmse**2,
        "radius_rmse": radius_rmse,
        "in_view": np.minimum(1.0, 1.02 - level / 1000.0 + rng.normal(0.0, 0.004, (seeds, CASES))),
        "smoothness": rng.uniform(0.5, 1.5, (seeds, CASES)),
        "effort": rng.uniform(0.2, 0.4, (seeds, CASES)),
    }


def summary(of: dict[str, np.ndarray], factor: float = 1.0) -> dict[str, Any]:
    mean = {
        name: float(values.mean()) * (1.0 if name == "in_view" else factor) for name, values in of.items()
    }
    return {
        "flights": of["distance"].size,
        "distance": {"mean": mean["distance"], "sd": float(of["distance"].std())},
        "radius": {"mean": mean["radius"], "sd": float(of["radius"].std())},
        "distance_rmse_px": mean["distance_rmse"],
        "radius_rmse_px": mean["radius_rmse"],
        **{name: mean[name] for name in ("in_view", "smoothness", "effort")},
        "distance_integral_px_s": 60.0 * mean["distance"],
        "radius_integral_px2_s": 60.0 * mean["radius"],
    }


def setup(name: str) -> dict[str, Any]:
    trained_on = (
        "combined" if name.startswith("dnn") else "sub-tasks" if name.startswith("primitive") else None
    )
    seeds = 1 if trained_on is None or name.endswith("10000") else SEEDS
    of = scores(name, LEVELS.get(name, 30.0), seeds)
    parts = ("combined",) if trained_on == "combined" else ("fixed-altitude", "climb", "descend")
    losses = {part: (0.1 / np.arange(1, 11) + 0.01 * i).tolist() for i, part in enumerate(("all", *parts))}
    ours = name in ("primitive", "primitive-matched")
    return summary(of) | {
        "title": f"What <{name}> & others do",
        "trained_on": trained_on,
        "seeds": seeds,
        "manoeuvres": {
            part: summary(of, factor)
            for part, factor in (("fixed-altitude", 0.9), ("climb", 0.2), ("descend", 0.3), ("combined", 1.0))
        },
        "scores": {metric: values.tolist() for metric, values in of.items()},
        "curve": trained_on and {"epochs": list(range(1, 11)), "training": losses, "validation": losses},
        "learning": trained_on
        and {
            "fill": "mask" if ours else "zero",
            "inputs": ["ugv_u", "ugv_v", "radius"] if ours else INPUTS,
            "delay_rows": 4 if ours else 0,
            "rows": 14891,
            "recipe": "paper" if name.endswith("10000") else "fast",
        },
    }


def study(names: tuple[str, ...] = tuple(LOOKS)) -> dict[str, Any]:
    setups = {name: setup(name) for name in names}

    def compared(family: str, pairs: list[tuple[str, str]], metrics: tuple[str, ...]) -> list[dict[str, Any]]:
        found = [
            statistics.compare(a, setups[a]["scores"][m], b, setups[b]["scores"][m], m, 0)
            for a, b in pairs
            if {a, b} <= set(setups)
            for m in metrics
        ]
        return [asdict(one) | {"family": family} for one in statistics.with_holm(found)]

    primary = [("primitive", "dnn-combined"), ("primitive", "human-combined")]
    exploratory = [
        ("primitive", "primitive-paper"),
        ("primitive-paper", "human-combined"),
        ("primitive", "servo"),
    ]
    paper = {
        "human-combined": {"distance": [14.2, 9.0], "radius": [12.9, 21.9]},
        "dnn-combined": {"distance": [12.6, 8.1], "radius": [26.2, 19.1]},
        "primitive": {"distance": [12.9, 8.2], "radius": [10.9, 9.9]},
    }
    welch = [
        {"a": a, "b": b, "metric": metric, "p": p, "p_holm": min(1.0, 6 * p)}
        for metric in ("distance", "radius")
        for a, b, p in (("human-combined", "dnn-combined", 0.681), ("dnn-combined", "primitive", 0.042))
    ]
    ratio = {"ratio": 0.93, "upper": 0.987, "margin": 0.1, "holds": True}
    return {
        "version": "0.1.0",
        "seed": 3,
        "settings": {
            "mode": "full",
            "command": "fledge reproduce --full --seed 3",
            "cases": CASES,
            "training_seeds": SEEDS,
            "manoeuvre_cases": 5,
            "flight_seconds": 60.0,
            "row_rate_hz": 20.0,
            "families": {"training": ["line"], "development": ["zigzag", "eight"], "test": ["ell", "spline"]},
            "lens": {"focal_px": 374.7, "levelled": True},
            "ideal_radius_px": 108.0,
            "recipes": {"fast": {"epochs": 20, "batch": 256}, "paper": {"epochs": 10000, "batch": None}},
            "operator": {"crossover": 1.5, "sticks": {"horizontal": 1.25}},
            "demonstrations": {
                "fixed-altitude": {"episodes": 5, "rows": 5296},
                "climb": {"episodes": 10, "rows": 4691},
                "descend": {"episodes": 10, "rows": 4904},
            },
            "versions": {"python": "3.11.2", "jax": "0.10.2"},
        },
        "operator": {
            "sentence": "No person flew: the operator is a synthetic one.",
            "axes": [{"axis": "up", "crossover": 1.353, "delay": 0.727, "remnant": 0.257, "inside": True}],
            "bands": {"crossover": [1.0, 2.5], "delay": [0.35, 0.8], "remnant": [0.1, 0.3]},
        },
        "setups": setups,
        "comparisons": compared("primary", primary, ("distance_rmse", "radius_rmse"))
        + compared("exploratory", exploratory, ("distance_rmse", "radius_rmse", "in_view")),
        "non_inferiority": [
            {"a": "primitive", "b": "human-combined", "metric": metric, **ratio}
            for metric in ("distance_rmse", "radius_rmse")
        ],
        "paper": {"table": paper, "welch": welch},
        "development": [
            {"name": "mask, delay", "fill": "mask", "inputs": INPUTS[:3], "delay_rows": 5, "distance_rmse_px": 31.25,
             "radius_rmse_px": 8.75, "in_view": 0.9925},
        ],
        "nets": charged.nets(),
        "times": {"demonstrations": 3.25, "training": 61.5},
    }  # fmt: skip


@pytest.fixture(scope="module")
def flights(tmp_path_factory) -> Path:
    """Two short flights of one case, under the names of four set-ups."""
    folder = tmp_path_factory.mktemp("flights")
    case = Case.draw(Combined(), (0,), rows=60)
    crews = {"human-combined": HumanModel(), "primitive": Servo()}
    flown = {name: fly_plain(case, Crew(pilot), (0, 1)) for name, pilot in crews.items()}
    for name in FLOWN:
        episode = flown.get(name, flown["primitive"])
        flight = Flight(episode, "combined", name, "none", 0, 0, (0, 1, 2), case.plan.arena.padded(5))
        write_flight(folder / f"{name}.mcap", flight)
    return folder


@pytest.fixture(scope="module")
def results() -> dict[str, Any]:
    return study()


@pytest.fixture(scope="module")
def report(results, flights, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    return publish(folder, results, flights)


def publish(folder: Path, results: dict[str, Any], flights: Path) -> Path:
    write_json(folder / "results.json", results)
    shutil.copytree(flights, folder / "flights")
    return write_report(folder)


class Page(HTMLParser):
    """What stands in a page: its text, its table rows as lists of cells, its tags with their attributes."""

    def __init__(self, html: str):
        super().__init__()
        self.rows: list[list[str]] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self._cell, self._hidden = False, False
        self.feed(html)
        self.text = re.sub(r"\s+", " ", self.text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self._hidden = self._hidden or tag == "style"
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")
            self._cell = True

    def handle_endtag(self, tag):
        self._hidden = self._hidden and tag != "style"
        self._cell = self._cell and tag not in ("td", "th")

    def handle_data(self, data):
        if not self._hidden:
            self.text += data
            if self._cell:
                self.rows[-1][-1] += data

    def row(self, start: str, cells: int) -> list[str]:
        (found,) = (row for row in self.rows if len(row) >= cells and row[0].startswith(start))
        return found


@pytest.fixture(scope="module")
def page(report) -> Page:
    return Page(report.read_text(encoding="utf-8"))


# The page


def test_the_page_is_where_it_says(report):
    assert report.name == "index.html"
    assert report.read_text(encoding="utf-8").startswith("<!doctype html>")


def test_all_figures_are_there_twice_and_in_the_page(report):
    html = report.read_text(encoding="utf-8")
    for name in FIGURES:
        assert (report.parent / "figures" / f"{name}.svg").read_bytes().startswith(b"<?xml")
        assert (report.parent / "figures" / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert f'<figure id="{name}">' in html
    assert html.count("<svg viewBox") == len(FIGURES)
    for i in range(len(FIGURES)):
        assert f"Figure {i + 1}. " in html


@pytest.mark.parametrize("name", LOOKS)
def test_every_number_of_the_results_table_is_in_the_page(page, results, name):
    s = results["setups"][name]
    expected = [
        *(str(s["flights"]), number(s["distance"]["mean"]), f"± {number(s['distance']['sd'])}"),
        *(number(s["radius"]["mean"]), f"± {number(s['radius']['sd'])}"),
        *(number(s["distance_rmse_px"]), number(s["radius_rmse_px"]), percent(s["in_view"])),
        *(number(s["smoothness"], 2), number(s["effort"], 3)),
    ]
    assert page.row(name + "What", len(expected) + 1)[-len(expected) :] == expected


def test_every_number_of_the_paper_is_beside_ours(page, results):
    for name, printed in (("human-combined", "human-combined"), ("primitive-paper", "primitive")):
        of = results["paper"]["table"][printed]
        cells = [cell for m, sd in (of["distance"], of["radius"]) for cell in (number(m), f"± {number(sd)}")]
        assert page.row(name + "What", 10)[1:5] == cells
    assert len(page.row("primitiveWhat", 10)) == 11, "the paper's line spans both readings of ABS-DL"
    assert page.row("servoWhat", 10)[1:3] == ["–", "–"]


@pytest.mark.parametrize("name", LOOKS)
def test_every_manoeuvre_of_every_set_up_is_in_the_page(page, results, name):
    parts = results["setups"][name]["manoeuvres"]
    expected = [
        cell
        for part in ("fixed-altitude", "climb", "descend", "combined")
        for cell in (
            percent(parts[part]["in_view"]),
            *(number(parts[part][f"{error}_rmse_px"]) for error in ("distance", "radius")),
        )
    ]
    assert [name, *expected] in page.rows


def test_every_comparison_is_in_the_page(page, results):
    for one in results["comparisons"]:
        factor = 100.0 if one["metric"] == "in_view" else 1.0
        low, high = (signed(factor * edge) for edge in one["interval"])
        expected = [
            *(
                signed(factor * one["difference"]),
                f"{low} to {high}",
                p_value(one["p"]),
                p_value(one["p_holm"]),
            ),
            *(
                signed(one["effect_size"]),
                number(one["probability_of_improvement"], 2),
                number(one["needed_cases"], 0),
            ),
        ]
        assert any(
            row[-len(expected) :] == expected or row[-len(expected) - 1 : -1] == expected for row in page.rows
        )
        assert one["units"] in page.text


def test_the_other_tables_are_in_the_page(page):
    assert ["primitive / human-combined", "distance RMSE", "0.930", "0.987", "1.10", "yes"] in page.rows
    assert ["dnn-combined – primitive", "radius", "0.042", "0.252"] in page.rows
    assert ["up", "1.35", "0.73", "25.7", "yes"] in page.rows
    assert ["people", "1.00 – 2.50", "0.35 – 0.80", "10.0 – 30.0", ""] in page.rows
    assert ["mask, delay", "mask", "centre_u, centre_v, ugv_u", "0.25", "31.2", "8.8", "99.25"] in page.rows


def test_every_net_is_in_the_page(page, results):
    for name, one in results["nets"]["flights"]["primitive"]["combined"].items():
        line = next(row for row in page.rows if row[:1] == [name])
        assert percent(one["interventions"]["any"]) in line
        if "cost" in one:
            assert number(one["cost"]["radius_rmse"]["upper"], 3) in line
    assert "74 (0.38)" in page.text and "people needed per hour" in page.text


def test_a_page_without_nets_does_not_speak_of_them(flights, tmp_path):
    page = publish(tmp_path, study() | {"nets": None}, flights).read_text(encoding="utf-8")
    assert "safety net" not in page and "#nets" not in page


def test_every_setting_is_in_the_page(page, results):
    for name, value in flat(results["settings"]):
        nested = name.split(".", 1)[1] if isinstance(results["settings"][name.split(".")[0]], dict) else name
        assert name == "command" or [nested, value] in page.rows, name
    assert results["settings"]["command"] in page.text
    assert ["training", "61.5"] in page.rows


def test_the_operator_is_said_to_be_synthetic_before_any_table(page, results):
    assert page.text.index(results["operator"]["sentence"]) < page.text.index("Table 1.")


def test_nothing_is_loaded_from_elsewhere(report, page):
    html = report.read_text(encoding="utf-8")
    assert not re.search(r"https?:|//[a-z]|@import|url\((?!#)", html)
    assert not {tag for tag, _ in page.tags} & {"script", "link", "img", "iframe", "object", "image"}
    assert "default-src 'none'" in html
    for _, attributes in page.tags:
        target = attributes.get("href") or attributes.get("src") or "#"
        assert target.startswith("#") or (report.parent / target).is_file(), target


def test_links_inside_the_page_lead_somewhere(page):
    ids = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len(ids) == len(set(ids))
    for tag, attributes in page.tags:
        if tag == "a" and (attributes["href"] or "").startswith("#"):
            assert attributes["href"][1:] in ids


def test_there_is_a_light_a_dark_and_a_printed_page(report):
    html = report.read_text(encoding="utf-8")
    assert html.index("prefers-color-scheme: dark") < html.index("@media print")
    for name, how in LOOKS.items():
        assert html.count(f"--{name}: {how.light};") == 2
        assert html.count(f"--{name}: {how.dark};") == 1


def test_the_page_says_what_the_default_read_and_where_it_was_chosen(page, results):
    assert "keys and path families of their own (zigzag and eight)" in page.text
    assert "with the default only ugv_u, ugv_v and radius" in page.text
    alike = copy.deepcopy(results)
    alike["setups"]["primitive"]["learning"]["inputs"] = INPUTS
    assert "Both methods read all 11 inputs" in Page(render(alike, {}, {})).text


def test_the_page_says_when_no_test_could_reject(page, results):
    assert "cannot give less than p = 0.031, which after Holm over the 4 primary tests is 0.125" in page.text
    more = copy.deepcopy(results)
    more["settings"]["training_seeds"] = 8  # 4 x 2 / 2^8 = 0.031
    assert "cannot reach 0.05" not in render(more, {}, {})


def test_names_and_titles_are_escaped(report, page):
    assert "<servo>" not in report.read_text(encoding="utf-8")
    assert "What <servo> & others do" in page.text


def test_the_same_results_give_the_same_bytes(report, results, flights, tmp_path):
    again = publish(tmp_path, results, flights).parent
    for path in sorted(report.parent.rglob("*")):
        if path.is_file():
            assert path.read_bytes() == (again / path.relative_to(report.parent)).read_bytes(), path.name


def test_a_quick_study_gives_a_page_as_well(flights, tmp_path):
    quick = study(("human-combined", "primitive", "own.module:Pilot"))
    quick["settings"]["training_seeds"] = 1
    quick |= {"development": None, "times": {}, "non_inferiority": []}
    for one in quick["comparisons"]:
        one |= {"p_holm": None, "effect_size": None, "needed_cases": None}
    page = Page(publish(tmp_path, quick, flights).read_text(encoding="utf-8"))
    assert "own.module:Pilot" in page.text
    assert "Every set-up trained one network" in page.text
    assert "undefined" not in page.text.lower()


@pytest.mark.skipif(
    shutil.which("chromium") is None and os.environ.get("CI") != "true", reason="no chromium here"
)
@pytest.mark.parametrize("theme", [[], ["--force-dark-mode"]], ids=["light", "dark"])
def test_a_browser_opens_the_page_without_complaint(report, tmp_path, theme):
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking"]
    options += [
        f"--user-data-dir={tmp_path}",
        "--enable-logging=stderr",
        "--log-level=0",
        "--dump-dom",
        *theme,
    ]
    shown = subprocess.run(
        ["chromium", *options, report.as_uri()], capture_output=True, text=True, timeout=120
    )
    assert shown.returncode == 0
    assert "</footer>" in shown.stdout
    assert not [line for line in shown.stderr.splitlines() if "CONSOLE" in line]


# What is missing


def test_a_missing_flight_is_named(results, flights, tmp_path):
    write_json(tmp_path / "results.json", results)
    shutil.copytree(flights, tmp_path / "flights")
    (tmp_path / "flights" / "primitive.mcap").unlink()
    with pytest.raises(BadFile, match=r"flights/primitive\.mcap: is missing.*sample flight"):
        write_report(tmp_path)
    assert not (tmp_path / "index.html").exists()


def test_missing_results_are_named(tmp_path):
    with pytest.raises(BadFile, match=r"results\.json"):
        write_report(tmp_path)


def test_a_folder_that_cannot_be_made_is_named(results, flights, tmp_path):
    (tmp_path / "figures").write_text("in the way")
    with pytest.raises(BadFile, match="cannot be written"):
        publish(tmp_path, results, flights)


def test_the_abstract_tells_every_verdict(page, results):
    abstract = page.text[: page.text.index(results["operator"]["sentence"])]
    for claim in claims(results):
        if {"primitive", "primitive-paper"} & {verdict.setup for verdict in claim.verdicts}:
            assert claim.short in abstract


def test_every_main_set_up_has_a_look():
    assert set(MAIN) <= set(LOOKS)


def test_results_may_be_read_back(report):
    assert read_json(report.parent / "results.json")["seed"] == 3
