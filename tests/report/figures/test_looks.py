"""Whoever is shown can be told from all others, on every page and by every eye."""

from itertools import combinations
from xml.etree import ElementTree

import numpy as np
import pytest

from fledge.report.figures.looks import COMPARED, LOOKS, PAGE, STRANGERS, looks, palette, swatch, variables


def linear(colour: str) -> np.ndarray:
    srgb = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def contrast(one: str, other: str) -> float:
    """WCAG 2, equation of "contrast ratio"."""
    high, low = sorted((linear(colour) @ [0.2126, 0.7152, 0.0722] for colour in (one, other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("name", [name for name in palette() if name not in ("card", "faint")])
def test_every_colour_stands_out_from_its_page(name):
    light, dark = palette()[name]
    for page in (PAGE["card"][0], "#f8f7f4"):
        assert contrast(light, page) >= 3.0
    for page in (PAGE["card"][1], "#131619"):
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
    seen = {name: lab(np.array(SEEN_BY[eye]) @ linear(getattr(LOOKS[name], theme))) for name in COMPARED}
    for one, other in combinations(seen, 2):
        assert np.linalg.norm(seen[one] - seen[other]) > 10.0, (one, other)


def test_strangers_get_a_look_too():
    shown = looks(["own", "primitive", "somebody's", "human-combined"])
    assert list(shown) == ["human-combined", "primitive", "own", "somebody's"]
    assert shown["own"] != shown["somebody's"]


def test_a_swatch_has_the_colour_the_dashes_and_the_marker():
    for how in (*LOOKS.values(), *STRANGERS):
        sample = swatch(how)
        ElementTree.fromstring(sample)
        assert sample.count(variables()[how.light]) == 2
        assert ("none" in sample) == (not how.dashes)
