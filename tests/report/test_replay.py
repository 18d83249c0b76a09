"""A flight becomes a picture, or an animation, of the kind that its name says."""

import xml.etree.ElementTree as ET

import matplotlib
import numpy as np
import pytest
from PIL import Image

from fledge.engines import fly_plain
from fledge.episode import Flight
from fledge.errors import BadFile
from fledge.manoeuvres import Combined
from fledge.pilots import Servo
from fledge.report import replay
from fledge.simulation import Case, Crew

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def flight():
    case = Case.draw(Combined(), (0,), rows=60)
    return Flight(
        fly_plain(case, Crew(Servo()), (1,)), "combined", "servo", "none", 0, 0, (0, 1, 2), case.plan.arena
    )


@pytest.mark.parametrize(
    ("name", "magic"),
    [
        ("a.png", b"\x89PNG"),
        ("a.PNG", b"\x89PNG"),
        ("a.pdf", b"%PDF"),
        ("a.svg", b"<?xml"),
        ("a.gif", b"GIF89a"),
    ],
)
def test_the_name_says_the_kind(flight, tmp_path, name, magic):
    path = replay.draw_flight(flight, tmp_path / name)
    assert path == tmp_path / name
    assert path.read_bytes().startswith(magic)
    assert [left.name for left in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("kind", ["png", "svg", "pdf", "gif"])
def test_the_same_flight_gives_the_same_bytes(flight, tmp_path, kind):
    once, twice = (replay.draw_flight(flight, tmp_path / f"{i}.{kind}").read_bytes() for i in range(2))
    assert once == twice


def test_a_picture_says_what_it_shows(flight, tmp_path):
    tree = ET.parse(replay.draw_flight(flight, tmp_path / "a.svg"))
    texts = {text.strip() for text in tree.getroot().itertext()}
    assert {
        "combined, flown by servo",
        "from above",
        "x, east [m]",
        "z [m]",
        "u [px]",
        "v [px]",
        "time [s]",
    } <= texts


@pytest.mark.parametrize(("most", "frames"), [(150, 60), (20, 20), (7, 7), (1, 1)])
def test_an_animation_shows_the_whole_flight_in_so_many_frames_at_most(
    flight, tmp_path, monkeypatch, most, frames
):
    monkeypatch.setattr(replay, "FRAMES", most)
    with Image.open(replay.draw_flight(flight, tmp_path / "a.gif")) as film:
        assert film.n_frames == frames
        assert film.info["duration"] == replay.FRAME_MS
        first = np.asarray(film.convert("RGB"))
        film.seek(frames - 1)
        assert frames == 1 or (np.asarray(film.convert("RGB")) != first).any()


@pytest.mark.parametrize("name", ["a", "a.bmp", "a.mcap", "-"])
def test_other_kinds_are_refused_by_name(flight, tmp_path, name):
    with pytest.raises(BadFile, match="no such picture: valid are .png, .svg, .pdf and .gif"):
        replay.draw_flight(flight, tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_the_style_is_put_back(flight, tmp_path):
    before = dict(matplotlib.rcParams)
    replay.draw_flight(flight, tmp_path / "a.png")
    assert dict(matplotlib.rcParams) == before
