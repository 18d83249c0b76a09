"""Logs read back: what was flown is flown again, byte for byte, or the first difference is named."""

import random

import pytest
from logged import ABOUT, BRIEF, entries, written
from mcap.writer import Writer
from ticks import Echo, heard

from fledge.errors import BadFile
from fledge.lab.control.phases import Phase
from fledge.lab.control.tick import Said
from fledge.lab.shell import logs
from fledge.lab.shell.logs import Entry
from fledge.lab.shell.rerun import Comparison, is_log, read_opening, read_ticks, replay
from fledge.lab.wire.datagrams import AT, Datagram
from fledge.storage import read_flight, write_flight


class Drifting(Echo):
    """An echo that says something else from some tick on."""

    def __init__(self, since, extra=False):
        self._since, self._extra = since, extra

    def step(self, memory, heard):
        memory, said = super().step(memory, heard)
        if memory[0] > self._since:
            other = Datagram(AT, b"AT*REF=7\r")
            others = (*said.datagrams, other) if self._extra else (other,)
            said = type(said)(others, said.phase, said.world)
        return memory, said


@pytest.fixture
def log(tmp_path):
    """Of 200 ticks."""
    written(tmp_path / "log.mcap", entries(200))
    return tmp_path / "log.mcap"


def test_the_same_controller_says_the_same(log):
    assert replay(log, Echo()) == Comparison(200)


def test_the_first_difference_is_named(log):
    found = replay(log, Drifting(120))
    assert found.ticks == 120
    assert found.difference.startswith("tick 120, 1.20 s: at b'120 frame 12state' then, at b'AT*REF=7")
    assert replay(log, Drifting(7, extra=True)).difference.endswith("1 datagrams then, 2 now")
    assert replay(log, Drifting(200)) == Comparison(200)


@pytest.mark.slow
def test_a_log_that_was_cut_short_is_read_as_far_as_it_goes(log, tmp_path):
    whole = log.read_bytes()
    lengths = random.Random(0).sample(range(1, len(whole)), 60)
    for length in [*lengths, len(whole) - 1]:
        part = tmp_path / "part.mcap"
        part.write_bytes(whole[:length])
        if not is_log(part):
            continue
        ticks = list(read_ticks(part))
        assert [tick.number for tick in ticks] == list(range(len(ticks)))
        assert [tick.heard for tick in ticks] == [heard(tick.number) for tick in ticks]
        found = replay(part, Echo())
        assert (found.ticks, found.difference) == (len(ticks), "")
        assert found.missing == "cut short: its end is missing"


def test_the_last_tick_of_a_cut_log_is_not_taken_for_whole(tmp_path):
    """A chunk may end in the middle of a tick: here before anything was said in it."""
    path = tmp_path / "log.mcap"
    with logs.Log(path, ABOUT, BRIEF) as log:
        for entry in entries(3):
            log.tick(entry)
        mute = Entry(3, heard(3), Said((), Phase.FLY), 100)
        log.tick(mute)
    whole, end = path.read_bytes(), logs.END.encode()
    (tmp_path / "part.mcap").write_bytes(whole[: whole.index(end)])
    assert [tick.number for tick in read_ticks(path)] == [0, 1, 2, 3]
    assert [tick.number for tick in read_ticks(tmp_path / "part.mcap")] == [0, 1, 2]


def test_ticks_that_were_not_logged_are_missed(tmp_path):
    path = tmp_path / "log.mcap"
    written(path, [entry for entry in entries(50) if not 20 <= entry.number < 23])
    assert replay(path, Echo()) == Comparison(20, missing="ticks 20 to 22 were not logged")
    assert len(list(read_ticks(path))) == 47


def test_lost_ticks_are_told(tmp_path):
    path = tmp_path / "log.mcap"
    with logs.Log(path, ABOUT, BRIEF) as log:
        for entry in entries(30):
            log.tick(entry)
        log.lost = 4
    assert replay(path, Echo()).missing == "4 ticks were not logged"


def test_damage_is_no_end(log, tmp_path):
    """One bit within the ticks: told, and not taken for a log that was cut short."""
    data = bytearray(log.read_bytes())
    data[len(data) // 2] ^= 1
    (tmp_path / "bad.mcap").write_bytes(data)
    with pytest.raises(BadFile, match="bad.mcap: damaged"):
        list(read_ticks(tmp_path / "bad.mcap"))


def test_what_is_no_log_is_told(tmp_path, log, monkeypatch):
    with pytest.raises(BadFile, match="nowhere.mcap: cannot be read: No such file"):
        read_opening(tmp_path / "nowhere.mcap")
    (tmp_path / "text").write_text("hello")
    assert not is_log(tmp_path / "text") and not is_log(tmp_path / "nowhere.mcap") and is_log(log)
    with open(tmp_path / "other.mcap", "wb") as file:
        writer = Writer(file)
        writer.start()
        writer.finish()
    with pytest.raises(BadFile, match="without the record 'fledge.lab'"):
        read_opening(tmp_path / "other.mcap")
    monkeypatch.setattr("fledge.lab.shell.rerun.FORMAT", "2")
    with pytest.raises(BadFile, match="a log of format '1': this fledge reads '2'"):
        read_opening(log)


def test_a_flight_that_was_not_flown_in_the_lab_is_no_log(tmp_path, log):
    write_flight(tmp_path / "flight.mcap", read_flight(log))
    assert not is_log(tmp_path / "flight.mcap")
