"""Logs: all that was heard and said is in them, whatever becomes of the disk and of the process, and no tick waits."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path
from threading import Event

import pytest
from logged import ABOUT, BRIEF, entries, written
from mcap.reader import make_reader
from ticks import decision, heard, said

from fledge.camera import Lens
from fledge.errors import BadFile
from fledge.lab.shell import logs
from fledge.lab.shell.logs import Entry, Log
from fledge.lab.shell.rerun import read_opening, read_ticks
from fledge.storage import read_flight
from fledge.supervision.modes import Mode
from fledge.world import Reason


def test_what_went_in_comes_out(tmp_path):
    path, ticks = tmp_path / "log.mcap", list(entries(230))
    log = written(path, ticks, files={"policy.onnx": b"\0weights"})
    assert (log.lost, log.problem) == (0, "")
    logged = list(read_ticks(path))
    assert [(tick.number, tick.heard) for tick in logged] == [(entry.number, entry.heard) for entry in ticks]
    assert [tick.said for tick in logged] == [entry.said.datagrams for entry in ticks]
    opening = read_opening(path)
    assert (opening.brief, opening.files) == (BRIEF, {"policy.onnx": b"\0weights"})


def test_a_log_is_a_flight_to_everybody_else(tmp_path):
    """Row by row, as a simulated one."""
    path = tmp_path / "log.mcap"
    written(path, entries(501))
    flight = read_flight(path)
    assert (flight.rows, flight.pilot, flight.net, flight.lens) == (100, "servo", "stop-tube", Lens())
    assert flight.episode.action.forward[:20] == pytest.approx([0.005 * i for i in range(20)])
    assert flight.episode.world.t == pytest.approx([0.05 * i for i in range(100)])


def test_other_tools_see_topics_for_every_wire_and_ticks_in_json(tmp_path):
    path = tmp_path / "log.mcap"
    held = decision(Mode.SHIELDED, Reason.WALL, clearance=float("inf"))
    (entry,) = entries(1)
    written(path, [entry, entry._replace(number=1, heard=heard(1), said=said(0.01, held))])
    with open(path, "rb") as file:
        messages = [
            (channel.topic, m.sequence, m.data) for _, channel, m in make_reader(file).iter_messages()
        ]
    assert {"/in/vicon", "/in/navdata", "/out/at", "/fledge/tick"} <= {topic for topic, _, _ in messages}
    tick = json.loads([data for topic, _, data in messages if topic == "/fledge/tick"][1])
    assert (tick["tick"], tick["t"], tick["took_us"], tick["phase"]) == (1, 0.01, 300, "fly")
    assert (tick["said"][0]["mode"], tick["said"][0]["reason"]) == ("SHIELDED", "WALL")
    assert tick["said"][0]["clearance"] == "Infinity"
    assert len(tick["seen"]) == len(tick["said"]) == 4
    assert set(tick) == set(logs.EXAMPLE) and set(tick["said"][0]) == set(logs.EXAMPLE["said"][0])


def test_a_flight_that_saw_nobody_has_a_log_all_the_same(tmp_path):
    path = tmp_path / "log.mcap"
    blind = said()
    blind = type(blind)((), blind.phase, complaint="no poses from motion capture yet")
    written(path, [Entry(0, heard(0), blind, 100)])
    (tick,) = read_ticks(path)
    assert (tick.heard, tick.said) == (heard(0), ())


def test_an_old_log_is_never_written_over(tmp_path):
    path = tmp_path / "log.mcap"
    written(path, entries(3))
    before = path.read_bytes()
    with pytest.raises(BadFile, match="log.mcap: is there already"):
        Log(path, ABOUT, BRIEF)
    assert path.read_bytes() == before
    with pytest.raises(BadFile, match="cannot be written: No such file or directory"):
        Log(tmp_path / "nowhere" / "log.mcap", ABOUT, BRIEF)


def test_an_error_in_flight_ends_the_log_as_well(tmp_path):
    path = tmp_path / "log.mcap"
    with pytest.raises(RuntimeError), Log(path, ABOUT, BRIEF) as log:
        for entry in entries(7):
            log.tick(entry)
        raise RuntimeError
    assert len(list(read_ticks(path))) == 7


# The disk.


class Stuck:
    """A disk that stands still from some byte on, until it is told to go on."""

    def __init__(self, path, after):
        self._file, self._left, self.goes_on = open(path, "wb"), after, Event()

    def write(self, data):
        self._left -= len(data)
        if self._left < 0:
            self.goes_on.wait(30.0)
        return self._file.write(data)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._file.close()

    def __getattr__(self, name):
        return getattr(self._file, name)


@pytest.fixture
def stuck(tmp_path, monkeypatch):
    """A log on such a disk, and the disk."""
    disk = Stuck(tmp_path / "log.mcap", 20_000)
    monkeypatch.setattr(logs, "open", lambda path, mode: disk, raising=False)
    yield Log(tmp_path / "log.mcap", ABOUT, BRIEF), disk
    disk.goes_on.set()


@pytest.mark.slow
def test_no_tick_waits_for_a_disk_that_stands_still(stuck, tmp_path):
    log, disk = stuck
    ticks = list(entries(logs.MOST + 500))
    with log:
        for entry in ticks[:200]:
            log.tick(entry)
        time.sleep(1.0)  # the thread is in the middle of writing these
        slowest = 0.0
        for entry in ticks[200:]:
            before = time.perf_counter()
            log.tick(entry)
            slowest = max(slowest, time.perf_counter() - before)
        assert slowest < 0.1  # a microsecond as a rule; other processes may have had their turn
        disk.goes_on.set()
    logged = [tick.number for tick in read_ticks(tmp_path / "log.mcap")]
    assert log.lost > 0 and len(logged) + log.lost == len(ticks)
    assert logged == list(range(len(logged)))  # the oldest are kept


def test_a_disk_that_never_comes_back_does_not_hold_up_the_end(stuck, monkeypatch):
    monkeypatch.setattr(logs, "PATIENCE", 0.3)
    log, _ = stuck
    with log:
        for entry in entries(200):
            log.tick(entry)
    assert "did not take the end" in log.problem


FILLING = """
import os, resource, sys, time
from fledge.lab.shell.logs import Log
from fledge.lab.wire.datagrams import Datagram, Heard
sys.path.insert(0, sys.argv[2])
from logged import ABOUT, BRIEF, entries

resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
flown = 0
with Log(sys.argv[1], ABOUT, BRIEF) as log:
    for entry in entries(400):
        frame = Datagram("vicon", os.urandom(900))
        log.tick(entry._replace(heard=Heard(entry.heard.t, (frame,))))
        time.sleep(0.005)
        flown += 1
print(flown, log.lost, log.problem, sep=";")
"""

LOGGING = """
import sys, time
from fledge.lab.shell.logs import Log
sys.path.insert(0, sys.argv[2])
from logged import ABOUT, BRIEF, entries

with Log(sys.argv[1], ABOUT, BRIEF) as log:
    for entry in entries(10**6):
        log.tick(entry)
        print(entry.number, flush=True)
        time.sleep(0.01)
"""


def started(script, path):
    tests = str(Path(__file__).parents[2])
    return subprocess.Popen([sys.executable, "-c", script, path, tests], stdout=subprocess.PIPE, text=True)


@pytest.mark.slow
def test_a_disk_that_is_full_ends_the_log_and_nothing_else(tmp_path):
    """A real process that may write no more: the flight goes on, what is written can be read, and it is said."""
    path = tmp_path / "log.mcap"
    out, _ = started(FILLING, path).communicate(timeout=60)
    flown, lost, problem = out.strip().split(";")
    assert problem == "cannot be written any more: File too large"
    logged = [tick.number for tick in read_ticks(path)]
    assert logged and logged == list(range(len(logged)))
    # Half a second more than is safe may be there; of the last tick nobody knows whether it is whole.
    assert int(flown) == 400 and -1 <= len(logged) + int(lost) - 400 <= 100


@pytest.mark.slow
def test_a_killed_process_loses_its_last_second_at_most(tmp_path):
    path = tmp_path / "log.mcap"
    process = started(LOGGING, path)
    assert process.stdout is not None
    last = next(int(line) for line in process.stdout if int(line) >= 250)
    process.send_signal(signal.SIGKILL)
    rest = process.communicate(timeout=20)[0].split()
    last = max([last, *map(int, rest)])
    logged = [tick.number for tick in read_ticks(path)]
    assert logged == list(range(len(logged)))
    assert last - 100 <= logged[-1] <= last
    with pytest.raises(BadFile, match="cut short"):
        read_flight(path)
