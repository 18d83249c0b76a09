"""Stored flights as a page is shown them: the newest first, every number the flight's own, no way out of the folder."""

import json
import os
import shutil
from dataclasses import astuple, replace
from functools import cache
from pathlib import Path

import jax
import numpy as np
import pytest

from fledge.camera import REAL_BOTTOM_CAMERA, look
from fledge.cockpit.shelf import Shelf, hall, lens, marks, names
from fledge.cockpit.tells import Block, View
from fledge.engines import fly_plain
from fledge.episode import Flight
from fledge.errors import BadFile, UnknownName
from fledge.geometry import Box
from fledge.manoeuvres import Climb, Combined
from fledge.observation import Axes
from fledge.pilots import Servo
from fledge.safety import NoNet, StopTube
from fledge.simulation import Case, Crew, Rig
from fledge.storage import read_flight, write_flight
from fledge.study.evaluation import score
from fledge.world import Arena, Obstacle, Reason

pytestmark = pytest.mark.slow

ROWS = 30


@cache
def flown(manoeuvre=Climb(), net=NoNet(), name="none", number=0) -> Flight:
    key = (number, 1)
    case = Case.draw(manoeuvre, key, ROWS)
    episode = fly_plain(case, Crew(Servo(), Axes.of(manoeuvre.axes), net), key)
    return Flight(episode, manoeuvre.name, "servo", name, 3, number, manoeuvre.axes, case.plan.arena)


def stored(path: Path, flight: Flight, modified: float) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    write_flight(path, flight)
    os.utime(path, (modified, modified))
    return path


@pytest.fixture
def demos(tmp_path) -> Path:
    return tmp_path / "demos"


@pytest.fixture
def shelf(demos) -> Shelf:
    return Shelf(demos, demos / "flights")


def listed(shelf) -> list[str]:
    return [one["name"] for one in shelf.listing()]


def strict(value):
    """As it arrives in a page: JSON has no NaN and no infinity."""
    return json.loads(json.dumps(value, allow_nan=False))


# Which there are


def test_the_newest_come_first_wherever_they_lie(demos, shelf):
    assert shelf.listing() == [], "there is not even a folder"
    stored(demos / "climb-000.mcap", flown(), 100.0)
    stored(demos / "climb-001.mcap", flown(number=1), 300.0)
    stored(demos / "flights" / "combined-000.mcap", flown(Combined(), StopTube(), "stop-tube"), 200.0)
    stored(demos / "a.mcap", flown(), 100.0)
    first, *_ = found = shelf.listing()
    assert [one["name"] for one in found] == ["climb-001", "flights/combined-000", "a", "climb-000"]
    assert first == {
        "name": "climb-001", "manoeuvre": "climb", "pilot": "servo", "net": "none", "seed": 3, "case": 1,
        "rows": ROWS, "seconds": ROWS / 20.0, "modified": 300.0,
    }  # fmt: skip
    assert strict(found) == found


def test_what_is_no_flight_is_passed_over(demos, shelf):
    path = stored(demos / "climb-000.mcap", flown(), 100.0)
    (demos / "rubbish.mcap").write_bytes(b"rubbish")
    (demos / "cut.mcap").write_bytes(path.read_bytes()[:-1])
    (demos / "empty.mcap").touch()
    (demos / "folder.mcap").mkdir()
    (demos / "gone.mcap").symlink_to(demos / "nowhere")
    for other in (".climb.1234.tape", ".hidden.mcap", "climb-000.json"):
        shutil.copy(path, demos / other)
    assert listed(shelf) == ["climb-000"]
    assert listed(shelf) == ["climb-000"], "nor the second time"


def test_what_changes_is_looked_at_anew(demos, shelf):
    path = stored(demos / "climb-000.mcap", flown(), 100.0)
    assert shelf.listing()[0]["rows"] == ROWS
    short = replace(flown(), episode=jax.tree.map(lambda leaf: leaf[:7], flown().episode))
    stored(path, short, 200.0)
    assert shelf.listing()[0]["rows"] == 7
    path.write_bytes(b"rubbish")
    assert shelf.listing() == []
    path.unlink()
    assert shelf.listing() == []


# One of them


@pytest.fixture
def combined(demos, shelf) -> Flight:
    """One that its net held back, in a room with an obstacle."""
    flight = flown(Combined(), StopTube(), "stop-tube")
    arena = replace(flight.arena, obstacles=(Obstacle(Box(1.0, 2.0, 1.0, 2.5), 0.3),))
    uav, *ugvs = flight.episode.verdicts
    held = np.arange(ROWS) % 3 == 0
    uav = replace(uav, intervened=1.0 * held, reason=np.where(held, float(Reason.WALL), 0.0))
    free = replace(ugvs[0], clearance=np.full(ROWS, np.inf))
    episode = replace(flight.episode, verdicts=(uav, free, *ugvs[1:]))
    flight = replace(flight, arena=arena, lens=REAL_BOTTOM_CAMERA, ideal_radius=90.0, episode=episode)
    stored(demos / "flights" / "combined-000.mcap", flight, 100.0)
    return flight


def test_the_columns_are_the_flights(shelf, combined):
    whole = strict(shelf.whole("flights/combined-000"))
    world, columns = combined.episode.world, whole["columns"]

    def same(column, wanted):
        np.testing.assert_allclose(np.array(column, float), wanted, atol=0.51e-5)

    same(columns["t"], world.t)
    uav, *ugvs = columns["vehicles"]
    for name in ("x", "y", "z"):
        same(uav[name], getattr(world.uav.position, name))
    heading = world.uav.attitude.heading()
    same(uav["heading"], np.arctan2(heading.sin, heading.cos))
    for shown, ugv in zip(ugvs, world.ugvs, strict=True):
        for name in ("x", "y", "heading"):
            same(shown[name], getattr(ugv, name))
        same(shown["z"], np.zeros(ROWS))
    for shown, verdict in zip(columns["vehicles"], combined.episode.verdicts, strict=True):
        same(shown["sent"], np.stack(astuple(verdict.command), axis=1))
        same(shown["intervened"], verdict.intervened)
        assert [Reason[name] for name in shown["reason"]] == verdict.reason.tolist()
    same(uav["clearance"], combined.episode.verdicts[0].clearance)
    assert ugvs[0]["clearance"] == [None] * ROWS
    same(columns["action"], np.stack(astuple(combined.episode.action), axis=1))


def test_the_picture_is_what_its_own_lens_saw(shelf, combined):
    picture = shelf.whole("flights/combined-000")["columns"]["picture"]
    world, eye = combined.episode.world, combined.lens
    seen = look(eye, world)
    for name in ("u", "v", "radius"):
        np.testing.assert_allclose(picture[name], getattr(seen, name), atol=0.51e-5)
    for i, ugv in enumerate(world.ugvs):
        u, v = eye.project(world.uav, ugv.x, ugv.y)
        np.testing.assert_allclose(np.array(picture["marks"])[:, i], np.stack([u, v], axis=1), atol=0.51e-5)


def test_what_it_was_and_how_well_it_was_flown(shelf, combined):
    whole = strict(shelf.whole("flights/combined-000"))
    some = {"name": "flights/combined-000", "manoeuvre": "combined", "pilot": "servo", "net": "stop-tube"}
    some |= {"seed": 3, "case": 0, "rows": ROWS, "axes": list(Combined.axes), "ideal_radius": 90.0}
    assert {name: whole[name] for name in some} == some
    assert whole["names"] == ["UAV", "UGV 1", "UGV 2", "UGV 3"] == names(combined.episode.world)
    found = score(combined.episode, replace(Rig(), lens=combined.lens, ideal_radius=90.0))
    wanted = float(found.distance_rmse), float(found.radius_rmse), float(found.in_view)
    assert astuple(marks(combined)) == wanted
    assert tuple(whole["marks"].values()) == pytest.approx(wanted, abs=0.51e-5)
    assert tuple(whole["marks"]) == ("distance", "radius", "in_view")
    assert Block(**whole["arena"]) == Block(-5.0, 5.0, -5.0, 5.0, 6.0)
    assert [Block(**box) for box in whole["obstacles"]] == [Block(1.0, 2.0, 1.0, 2.5, 0.3)]
    assert View(**whole["lens"]) == View(700.5, 640.0, 360.0) == View(**lens(combined))
    assert hall(Arena.square()) == {"arena": whole["arena"], "obstacles": []}


def test_a_vehicle_that_was_lost_is_nowhere(demos, shelf):
    flight = flown()
    x = flight.episode.world.uav.position.x.copy()
    x[5:8] = np.nan, np.inf, -np.inf
    uav = flight.episode.world.uav
    lost = replace(uav, position=replace(uav.position, x=x))
    episode = replace(flight.episode, world=replace(flight.episode.world, uav=lost))
    stored(demos / "climb-000.mcap", replace(flight, episode=episode), 100.0)
    whole = strict(shelf.whole("climb-000"))
    assert whole["marks"]["distance"] is None
    assert whole["columns"]["vehicles"][0]["x"][4:9].count(None) == 3
    assert whole["columns"]["picture"]["u"][5] is None


@pytest.mark.parametrize(
    "name",
    [
        *("climb-001", "", ".", "..", "/", "CLIMB-000", "climb-000.mcap", "climb-000\0", "flights"),
        *("../secret", "flights/../climb-000", "flights//climb-000", "./climb-000", "..\\secret", ".hidden"),
        *("/etc/passwd", "*", "climb-00?", "flights/climb-000"),
    ],
)
def test_only_what_is_listed_can_be_had(demos, shelf, name):
    path = stored(demos / "climb-000.mcap", flown(), 100.0)
    for other in (demos.parent / "secret.mcap", demos / ".hidden.mcap"):
        shutil.copy(path, other)
    with pytest.raises(UnknownName, match="valid are climb-000"):
        shelf.whole(name)
    with pytest.raises(UnknownName):
        shelf.whole(str(path.with_suffix("")))


def test_one_that_cannot_be_read_says_why(demos, shelf):
    path = stored(demos / "climb-000.mcap", flown(), 100.0)
    assert shelf.whole("climb-000")["rows"] == read_flight(path).rows
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(BadFile, match="climb-000.mcap: cut short"):
        shelf.whole("climb-000")
