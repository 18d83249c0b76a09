"""A lab flight as somebody types it: what is refused, what is said of one, and what a replay says of its log."""

import json
import os
from pathlib import Path

import pytest
from logged import entries, written

from fledge.cli import main
from fledge.commands import fly
from fledge.lab.shell.rerun import Comparison, is_log
from fledge.lab.shell.udp import STICKS_PORT
from fledge.runs import hangar

FOUND = {
    "phase": "over",
    "flown_s": 30.0,
    "in_view": 0.995,
    "contacts": 0,
    "interventions": {"net": {"wall": 2, "vehicle": 1}, "watchdog": {}, "people": {"take_over": 1}},
    "takeovers": 1,
    "ticks": 6000,
    "deadline_misses": 2,
    "tick_us": {"p50": 410.0, "p99": 900.0, "p999": 2100.0, "max": 11000},
    "log": "flight.mcap",
    "log_problem": "",
    "ticks_not_logged": 0,
}


@pytest.fixture
def ordered(monkeypatch):
    """The orders that reach the hangar; nothing flies."""
    orders = []
    monkeypatch.setattr(hangar, "fly", lambda order: orders.append(order) or dict(FOUND))
    return orders


def refused(capsys, *arguments):
    """The one line of a command that must fail."""
    with pytest.raises(SystemExit) as left:
        main(arguments)
    out, err = capsys.readouterr()
    assert (left.value.code, out, err.count("\n")) == (2, "", 1)
    return err.removeprefix("fledge: ").rstrip()


def test_what_is_typed_becomes_an_order(ordered, capsys):
    main("fly policy.onnx".split())
    (usual,) = ordered
    assert usual == hangar.Order(Path("policy.onnx"), mocap=("127.0.0.1", 51001), vehicle=("127.0.0.1", 5556))
    main(
        "fly --pilot servo --arena a.toml --mocap vicon://10.0.0.2:50000 --vehicle ros --velocity --net paper "
        "--contract mine.toml --axes up turn "
        "--operator udp://127.0.0.5:4000 --duration 60 --dry-run --seed 7 --log l.mcap".split()
    )
    assert ordered[1] == hangar.Order(
        None, "servo", "a.toml", ("10.0.0.2", 50000), None, True, "paper", "mine.toml", (2, 3),
        "udp", ("127.0.0.5", 4000), False, 60.0, True, 7, Path("l.mcap"),
    )  # fmt: skip
    main("fly --pilot servo --operator udp --mocap ros".split())
    assert (ordered[2].sticks, ordered[2].mocap) == (("127.0.0.1", STICKS_PORT), None)
    main("fly --pilot servo --operator udp --no-operator".split())
    assert (ordered[3].sticks, ordered[3].nobody) == (None, True)


def test_what_came_of_it_is_said(ordered, capsys):
    main("fly --pilot servo".split())
    said = capsys.readouterr().out
    assert "over: the pilot flew for 30.0 s, all in view 99.50 %; contacts: 0" in said
    assert "interventions: net 3, watchdog 0, people 1; take-overs: 1" in said
    assert "6,000 ticks, 2 deadlines missed; a tick took 0.41 ms, 99.9 % at most 2.10 ms" in said
    assert "log: flight.mcap" in said
    main("fly --pilot servo --json -".split())
    assert json.loads(capsys.readouterr().out) == FOUND


def test_a_log_that_is_not_whole_is_told_after_all_else(monkeypatch, capsys):
    full = FOUND | {
        "log_problem": "cannot be written any more: No space left on device",
        "ticks_not_logged": 1200,
    }
    monkeypatch.setattr(hangar, "fly", lambda order: full)
    with pytest.raises(SystemExit) as left:
        main("fly --pilot servo".split())
    out, err = capsys.readouterr()
    assert left.value.code == 2 and "over: the pilot flew" in out
    assert err == (
        "fledge: flight.mcap: 1,200 ticks are not in it: cannot be written any more: No space left on device\n"
    )


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (
            ("fly", "--pilot", "servo", "--operator", "cat"),
            "unknown operator 'cat': valid are joy, keyboard, udp, udp://HOST:PORT, ws",
        ),
        (
            ("fly", "--mocap", "vicon:127.0.0.1"),
            "wire is 'vicon:127.0.0.1': valid is vicon://HOST, vicon://HOST:PORT,",
        ),
        (("fly", "--vehicle", "ardrone://"), "address is '': valid is HOST or HOST:PORT"),
        (("fly", "--vehicle", "ardrone://a:0"), "address is 'a:0': valid is HOST or HOST:PORT"),
        (("fly",), "who flies? valid is a policy's file, or --pilot NAME"),
        (("fly", "nowhere.onnx"), "nowhere.onnx: cannot be read: No such file or directory"),
        (
            ("fly", "--pilot", "servo", "--mocap", "vicon://192.0.2.7"),
            "no --arena: valid is the file of the room",
        ),
        (("fly", "--pilot", "servo", "--duration", "0"), "duration is 0: valid is 0.1"),
    ],
)
def test_what_makes_no_sense_is_refused_before_anything_begins(words, line, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert line in refused(capsys, *words)
    assert os.listdir(tmp_path) == []


@pytest.fixture
def log(tmp_path, monkeypatch):
    """The log of an echo, which is flown again by one."""
    written(tmp_path / "log.mcap", entries(120))
    monkeypatch.chdir(tmp_path)
    assert is_log("log.mcap")
    return Path("log.mcap")


def flown_again(monkeypatch, flight, **found):
    monkeypatch.setattr(hangar, "rerun", lambda path, seen: (seen(1), (flight, Comparison(120, **found)))[1])


def test_a_replay_says_that_all_was_the_same(log, monkeypatch, capsys):
    flown_again(monkeypatch, None)
    main(["replay", str(log), "--json", "again.json"])
    assert "flown once more: 120 ticks, all of them the same, byte for byte\n" in capsys.readouterr().err
    assert json.loads(Path("again.json").read_text()) == {
        "again": {"identical": True, "missing": "", "ticks": 120}
    }


def test_a_replay_says_where_it_was_not(log, monkeypatch, capsys):
    flown_again(monkeypatch, None, difference="tick 7, 0.07 s: at b'a' then, at b'b' now")
    line = refused(capsys, "replay", str(log))
    assert (
        line
        == "log.mcap: not the same when it was flown once more: tick 7, 0.07 s: at b'a' then, at b'b' now"
    )


def test_a_replay_says_what_is_missing(log, monkeypatch, capsys):
    flown_again(monkeypatch, None, missing="cut short: its end is missing")
    _, found = fly.rerun(log)
    assert found["missing"] in capsys.readouterr().err


@pytest.mark.slow
def test_a_log_is_drawn_like_any_flight(log, monkeypatch, capsys):
    from fledge.storage import read_flight

    flown_again(monkeypatch, read_flight(log))
    main(["replay", str(log), "--json", "-", "--out", "log.svg"])
    found = json.loads(capsys.readouterr().out)
    assert found["again"]["identical"] and found["rows"] == 23 and Path("log.svg").exists()
