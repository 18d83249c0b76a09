"""Faults on the wires between `fledge twin` and `fledge fly`: real processes, real sockets, real time.

What is done about each is what the table in docs/lab.md says, and its reason stands in the log. A process that pauses
or is killed is in tests/runs/test_hangar.py, what a port does without a ROS master in tests/lab/shell/test_ros.py.

Whatever drives the twin's UGVs over UDP does not stop when the UAV comes down blind, so flights that end like that end
over the pad.
"""

import json
import os
import signal
import time
from contextlib import contextmanager

import debian
import pytest
from between import between, corrupt, doubled, doubled_up, kept, late, lost, renumbered, swapped
from loopback import own_host
from processes import flown_to, process, ticks_of, until

from fledge.runs import hangar

GONE = lost()
LEAP = 100_000
"""Frames."""
SETTLED = 2.6
"""[s] after which a hold is over: it settles for one, and fades the policy in for another."""


class Flight:
    """A flight under way behind a go-between, and what was done to it."""

    def __init__(self, folder, go):
        self.log, self._go = folder / "log.mcap", go
        self._when, self._began = {}, None

    def fault(self, name, seconds, rest, **fates):
        """Wires have other fates for so long, and a rest."""
        before = self._go.turn()
        begin, end = self._go.during(seconds, **fates)
        time.sleep(rest)
        self._when[name] = begin, end + rest
        after = self._go.turn()
        self._began = after.began
        came, went = after.came - before.came, after.went - before.went
        for wire, fate in fates.items():
            assert came[wire] > 0 and (fate is not GONE or went[wire] < came[wire]), wire

    def until(self, phase, **fates):
        """Wires have other fates until the flight has got there."""
        self._go.turn(**fates)
        flown_to(phase, self.log, within=20.0)
        self._go.turn(**dict.fromkeys(fates, kept))

    def seen(self):
        """By the name of a fault: every tick from its beginning to the end of the rest after it."""
        ticks = ticks_of(self.log)
        offset = self._began - ticks[0]["t"]  # every tick says something to the drone
        return {
            name: [tick for tick in ticks if begin <= tick["t"] + offset < end]
            for name, (begin, end) in self._when.items()
        }


def told(ticks, what, who=0):
    """What the log names for a vehicle, each as it changes."""
    found = [tick["said"][who][what] for tick in ticks]
    return [b for a, b in zip(["", *found], found, strict=False) if a != b]


@contextmanager
def flight(folder, *arguments):
    """(Flight, `fledge fly`) with a twin at the far end, and what is left of that in twin.json."""
    lab, ours = own_host(), own_host()
    with process(
        "twin", "--drone", lab, "--mocap", lab, "--seed", "1", "--json", "twin.json", cwd=folder
    ) as twin:
        until(twin, "Ctrl-C ends")
        wires = ("--mocap", f"vicon://{ours}", "--vehicle", f"ardrone://{ours}", "--log", "log.mcap")
        with (
            between(lab, ours) as go,
            process("fly", "--pilot", "servo", *wires, *arguments, cwd=folder) as fly,
        ):
            yield Flight(folder, go), fly
            twin.send_signal(signal.SIGINT)
            twin.communicate(timeout=20)


def contacts(folder):
    return json.loads((folder / "twin.json").read_text())["contacts"]


@pytest.mark.slow
def test_what_passes_is_flown_through_and_named(tmp_path):
    """Fourteen faults in one flight, one after the other; nobody is touched, and the policy goes on after each."""
    with flight(tmp_path, "--no-operator") as (flown, _):
        flown_to("fly", flown.log)
        flown.fault("a tenth is lost", 1.5, 0.3, vicon=lost(0.1))
        flown.fault("half is lost", 1.5, 1.0, vicon=lost(0.5))
        flown.fault("out of order", 1.5, 0.6, vicon=late(0.03))
        flown.fault("twice", 0.6, 0.3, vicon=doubled(0.015), navdata=doubled(0.015), at=doubled(0.015))
        flown.fault("corrupt", 1.5, 1.0, vicon=corrupt(0.2), navdata=corrupt(0.2))
        flown.fault("a flipped bit", 1.0, 1.0, vicon=doubled_up("ardrone", 0.1))
        flown.fault("0.1 s", 0.13, 0.8, vicon=GONE)
        flown.fault("0.5 s", 0.55, SETTLED, vicon=GONE)
        flown.fault("numbers ahead", 0.6, 0.0, vicon=renumbered(LEAP))
        flown.fault("numbers back", 0.05, 0.9)
        flown.fault("swap", 0.3, 0.9, vicon=swapped("ardrone", "p3at"))
        flown.fault("no commands", 0.6, 0.6, at=GONE)
        flown.fault("no navdata", 2.4, SETTLED, navdata=GONE)
        flown.fault("long swap", 0.85, SETTLED, vicon=swapped("p3at", "p3dx1"))
        time.sleep(1.0)  # until all of that is in the log
    seen = flown.seen()
    modes, alarms = ({name: told(ticks, what) for name, ticks in seen.items()} for what in ("mode", "alarm"))
    held = ["HOLD", "RECOVER", "AUTO"]
    # Nothing is done, or the vehicle stands for as long as it lasts; the policy keeps its turn.
    for name in seen.keys() - {"0.5 s", "no navdata", "long swap"}:
        assert set(modes[name]) <= {"AUTO", "SHIELDED"}, name
    for name in ("a tenth is lost", "no commands", "numbers ahead"):
        assert set(alarms[name]) <= {"NONE", "STALE"}, name
    assert set(alarms["twice"]) <= {
        "NONE",
        "STALE",
        "BACKWARD",
    }  # the second comes after the frame that follows
    assert set(alarms["half is lost"]) == {"NONE", "STALE"}
    assert set(alarms["0.1 s"]) == {"NONE", "STALE"} and "SHIELDED" in modes["0.1 s"]
    assert "BACKWARD" in alarms["out of order"] and "BACKWARD" in alarms["numbers back"]
    assert "JUMP" in alarms["a flipped bit"]  # what is corrupt anywhere may be so where it changes nothing
    assert "SWAP" in alarms["swap"] and "SWAP" in told(seen["swap"], "alarm", 1)
    # These end its turn, for a while.
    for name, reason in {"0.5 s": "STALE", "no navdata": "BATTERY_LOW", "long swap": "POLICY_LATE"}.items():
        assert modes[name][modes[name].index("HOLD") :][:3] == held, name
        assert {tick["said"][0]["reason"] for tick in seen[name] if tick["said"][0]["mode"] == "HOLD"} == {
            reason
        }
    assert any(tick["complaint"].startswith("the vehicle has said nothing") for tick in seen["no navdata"])
    assert {"SWAP"} <= set(told(seen["long swap"], "alarm", 1)) & set(told(seen["long swap"], "alarm", 2))
    assert contacts(tmp_path) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("wire", "reason", "alarm"), [("vicon", "STALE", "STALE"), ("at", "LANDING", "NONE")]
)
def test_what_lasts_ends_in_a_landing(wire, reason, alarm, tmp_path):
    """2 s without poses: its own firmware lands it. 2 s without commands: it does so unbidden, and is landed with."""
    with flight(tmp_path, "--no-operator", "--json", "fly.json") as (flown, fly):
        flown_to("climb", flown.log)
        time.sleep(1.0)
        flown.until("land", **{wire: GONE})
        _, err = fly.communicate(timeout=60)
    assert fly.returncode == 0, err
    ticks = ticks_of(flown.log)
    landing = next(tick for tick in ticks if tick["said"] and tick["said"][0]["mode"] == "LAND")
    assert (landing["said"][0]["reason"], landing["said"][0]["alarm"]) == (reason, alarm)
    assert {tick["phase"] for tick in ticks[landing["tick"] + 2 :]} == {"land", "over"}
    found = json.loads((tmp_path / "fly.json").read_text())
    assert (found["phase"], found["contacts"], contacts(tmp_path)) == ("over", 0, [])
    assert json.loads((tmp_path / "twin.json").read_text())["phase"] == "landed"
    assert hangar.rerun(flown.log)[1].difference == ""


@debian.needs_ros
@pytest.mark.slow
def test_the_ros_master_dies_in_flight(tmp_path):
    """Who is connected stays so: it climbs on and lands as it is told, and the log names the master."""
    with debian.core(tmp_path) as core:
        with process(
            "twin", "--ros", "shares", "--seed", "3", "--json", "twin.json", cwd=tmp_path, **core.variables
        ) as twin:
            until(twin, "topics:")
            ros = (
                "--mocap",
                "ros",
                "--vehicle",
                "ros",
                "--arena",
                "lab",
                "--no-operator",
                "--log",
                "log.mcap",
            )
            with process("fly", "--pilot", "servo", *ros, cwd=tmp_path, **core.variables) as fly:
                flown_to("climb", tmp_path / "log.mcap")
                os.kill(core.master, signal.SIGKILL)
                time.sleep(3.0)
                fly.send_signal(signal.SIGINT)
                _, err = fly.communicate(timeout=60)
            twin.send_signal(signal.SIGINT)
            twin.communicate(timeout=20)
    assert fly.returncode == 0, err
    ticks = ticks_of(tmp_path / "log.mcap")
    after = [tick for tick in ticks if "the ROS master at" in tick["wires"]]
    assert {tick["phase"] for tick in after} >= {"climb", "land", "over"}
    assert {tick["said"][0]["alarm"] for tick in after} <= {"NONE", "STALE"}
    assert contacts(tmp_path) == []
    assert hangar.rerun(tmp_path / "log.mcap")[1].difference == ""
