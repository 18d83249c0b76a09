"""A tape is kept whole, thrown away whole, and survives its writer."""

import errno
import os
import signal
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import jax
import numpy as np
import pytest

from fledge.cockpit.tape import FLUSH, Tape, recover
from fledge.engines import fly_plain
from fledge.episode import Flight
from fledge.errors import BadFile
from fledge.learning.demonstrations import of_flights
from fledge.manoeuvres import Climb
from fledge.observation import Axes
from fledge.pilots import Servo
from fledge.runs import logbook
from fledge.simulation import Case, Crew
from fledge.storage import read_flight, sweep, write_flight

pytestmark = pytest.mark.slow

ROWS = 50


@cache
def flight() -> Flight:
    case = Case.draw(Climb(), (1,), ROWS)
    episode = fly_plain(case, Crew(Servo(), Axes.of((2,))), (1,))
    return Flight(episode, "climb", "person", "stop-tube", 0, 4, (2,), case.plan.arena)


def rows(count=ROWS):
    return [jax.tree.map(lambda leaf, i=i: float(leaf[i]), flight().episode) for i in range(count)]


def recorded(folder, count=ROWS, about=None) -> Tape:
    tape = Tape(folder, about or flight())
    for row in rows(count):
        tape.add(row)
    return tape


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def hidden(folder: Path) -> Path:
    (tape,) = folder.glob(".*.tape")
    return tape


def test_what_is_kept_is_the_flight_as_any_other_is_stored(tmp_path):
    path = recorded(tmp_path / "mine").keep()
    write_flight(tmp_path / "a.mcap", flight())
    assert names(tmp_path / "mine") == ["climb-000.mcap"] == [path.name]
    for (one, x), (other, y) in zip(
        *(
            jax.tree_util.tree_flatten_with_path(read_flight(file).episode)[0]
            for file in (path, tmp_path / "a.mcap")
        ),
        strict=True,
    ):
        assert one == other
        np.testing.assert_array_equal(x, y)
    (stored,) = logbook.read(tmp_path / "mine")
    assert (stored.pilot, stored.case) == ("person", 4)
    assert of_flights([stored]).rows == ROWS


def test_nothing_is_written_over(tmp_path):
    (tmp_path / "climb-000.mcap").write_text("somebody's")
    assert recorded(tmp_path).keep().name == "climb-001.mcap"
    assert (tmp_path / "climb-000.mcap").read_text() == "somebody's"
    assert recorded(tmp_path).keep().name == "climb-002.mcap"


def test_what_is_discarded_is_gone(tmp_path):
    recorded(tmp_path).discard()
    assert names(tmp_path) == []


def test_an_empty_tape_is_no_flight(tmp_path):
    with pytest.raises(BadFile, match="nothing was recorded"):
        recorded(tmp_path, 0).keep()
    assert names(tmp_path) == []


@pytest.mark.parametrize("name", ("../../etc/passwd", "my.package:Spiral", "..", "a" * 500, "x\0y"))
def test_a_name_leads_nowhere_else(tmp_path, name):
    path = recorded(tmp_path / "here", 1, replace(flight(), manoeuvre=name)).keep()
    assert path.parent == tmp_path / "here" and not path.name.startswith(".")
    assert names(tmp_path) == ["here"] and read_flight(path).manoeuvre == name


def test_a_tape_that_is_being_recorded_is_left_alone(tmp_path):
    tape = recorded(tmp_path)
    assert recover(tmp_path) == [] and sweep(tmp_path) == []
    assert tape.keep().exists()


KILLED = """
import os, signal, sys
import jax
from fledge.cockpit.tape import Tape
from fledge.pytrees import register
from fledge.storage import read_flight
flight = read_flight(sys.argv[1])
register(flight.episode)
tape = Tape(sys.argv[2], flight)
for i in range(int(sys.argv[3])):
    tape.add(jax.tree.map(lambda leaf: float(leaf[i]), flight.episode))
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.parametrize("count", (ROWS, FLUSH - 1))
def test_of_a_killed_server_all_but_the_last_second_is_recovered(tmp_path, count):
    source, tmp_path = tmp_path / "a.mcap", tmp_path / "tapes"
    write_flight(source, flight())
    died = subprocess.run([sys.executable, "-c", KILLED, source, tmp_path, str(count)])
    assert died.returncode == -signal.SIGKILL
    found = recover(tmp_path)
    if count < FLUSH:
        assert found == [] and names(tmp_path) == []
        return
    (path,) = found
    assert names(tmp_path) == ["climb-000.mcap"]
    back = read_flight(path)
    assert count - 20 < back.rows <= count
    np.testing.assert_array_equal(
        back.episode.world.uav.position.z, flight().episode.world.uav.position.z[: back.rows]
    )
    assert replace(back, episode=None) == replace(flight(), episode=None)


def test_a_tape_cut_anywhere_is_recovered_or_removed(tmp_path):
    tape = recorded(tmp_path)
    data = hidden(tmp_path).read_bytes()
    tape.discard()
    longest = 0
    for cut in range(0, len(data), max(len(data) // 40, 1)):
        folder = tmp_path / str(cut)
        folder.mkdir()
        (folder / ".climb.00000000.tape").write_bytes(data[:cut])
        found = recover(folder)
        assert names(folder) == [path.name for path in found]
        for path in found:
            assert read_flight(path).rows >= longest
            longest = read_flight(path).rows
    assert longest >= ROWS - 20


class Full:
    """A disk that is full from now on."""

    def __init__(self, stream):
        self.stream, self.full = stream, False

    def write(self, data):
        if self.full:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return self.stream.write(data)

    def __getattr__(self, name):
        return getattr(self.stream, name)


def test_a_full_disk_ends_the_tape_and_not_the_flight(tmp_path, monkeypatch):
    monkeypatch.setattr("fledge.cockpit.tape.open", lambda *a: Full(open(*a)), raising=False)
    tape = Tape(tmp_path, flight())
    first, *others = rows()
    for row in (first, *others[:29]):
        tape.add(row)
    tape._stream.full = True
    for row in others[29:]:
        tape.add(row)
    assert tape.problem == "cannot be written any more: No space left on device"
    monkeypatch.undo()
    assert read_flight(tape.keep()).rows == 30
    assert names(tmp_path) == ["climb-000.mcap"]


def test_a_folder_that_cannot_be_written_is_said_to_be_one(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(BadFile, match="cannot be written"):
        Tape(tmp_path / "file" / "folder", flight())
