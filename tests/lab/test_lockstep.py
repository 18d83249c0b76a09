"""Controller and twin in lock-step: who hears what when, and a flight from the pad back to the floor."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from ticks import Echo, said, world

from fledge.lab.control.outfit import Outfit
from fledge.lab.control.phases import Phase
from fledge.lab.lockstep import fly_lockstep, judged
from fledge.lab.twin.contacts import Contact, Witness
from fledge.lab.twin.twin import Twin
from fledge.lab.wire.datagrams import VICON, Datagram
from fledge.pilots import Servo
from fledge.safety import StopTube
from fledge.world import Arena

BENCHMARK = Path(__file__).parents[2] / "benchmarks" / "lockstep.py"


class Counting:
    """A twin that numbers its frames, and keeps what it hears."""

    def __init__(self):
        self.heard, self.contacts = [], []

    def tick(self, heard):
        self.heard.append(heard)
        return (Datagram(VICON, b"%d" % (len(self.heard) - 1)),)

    def world(self):
        return world(0.01 * len(self.heard))


class Short(Echo):
    """Has enough after so many ticks."""

    def __init__(self, ticks):
        self._ticks = ticks

    def step(self, memory, heard):
        memory, spoken = super().step(memory, heard)
        if memory[0] >= self._ticks:
            spoken = said(heard.t, phase=Phase.OVER)
        return memory, spoken


def test_what_the_twin_says_is_heard_in_the_same_tick_and_the_answer_in_the_next():
    twin = Counting()
    ticks = list(fly_lockstep(Echo(), twin, 0.1))
    assert [tick.heard.datagrams[0].data for tick in ticks] == [b"%d" % n for n in range(10)]
    assert [heard.datagrams for heard in twin.heard] == [(), *(tick.said.datagrams for tick in ticks[:-1])]
    assert (
        [tick.heard.t for tick in ticks] == [heard.t for heard in twin.heard] == [0.01 * n for n in range(10)]
    )


@pytest.mark.parametrize("late", [1, 5])
def test_datagrams_can_be_late(late):
    ticks = list(fly_lockstep(Echo(), Counting(), 0.2, late))
    assert [tick.heard.datagrams for tick in ticks[:late]] == [()] * late
    assert [tick.heard.datagrams[0].data for tick in ticks[late:]] == [b"%d" % n for n in range(20 - late)]


def test_a_flight_ends_on_the_floor_or_with_its_time():
    assert len(list(fly_lockstep(Short(30), Counting(), 10.0))) == 30
    assert len(list(fly_lockstep(Echo(), Counting(), 0.5))) == 50


def test_what_came_of_it():
    twin = Counting()
    twin.contacts = [Contact(1.0, "p3at", "p3dx1", who) for who in Witness]
    found = judged(fly_lockstep(Short(100), twin), twin, Arena.lab())
    assert (found["ticks"], found["landed"], found["contacts"]) == (100, True, 2)
    assert found["touched"] == ["p3at, p3dx1"] and found["in_view"] == 1.0
    assert not judged(fly_lockstep(Echo(), twin, 1.0), twin, Arena.lab())["landed"]


def flown(seed, seconds=2.0, late=0):
    """A whole flight in the real twin."""
    outfit = Outfit(Arena.lab(), "servo", "stop-tube", duration=seconds, unattended=True)
    return fly_lockstep(outfit.controller(Servo(), StopTube()), Twin(Arena.lab(), seed), late=late)


@pytest.mark.slow
def test_a_flight_in_the_twin_goes_up_flies_and_comes_down():
    twin = Twin(Arena.lab(), 3)
    outfit = Outfit(Arena.lab(), "servo", "stop-tube", duration=3.0, unattended=True)
    found = judged(fly_lockstep(outfit.controller(Servo(), StopTube()), twin), twin, Arena.lab())
    assert found["landed"] and found["flown_s"] == pytest.approx(3.0, abs=0.05)
    assert (found["contacts"], found["human_interventions_needed"], found["takeovers"]) == (0, 0, 0)
    assert found["in_view"] == 1.0 and found["least_gap_m"]["uav"] > 0.0


@pytest.mark.slow
def test_the_same_seed_is_the_same_flight_byte_for_byte():
    """And another seed another one."""
    flights = [
        [tick.said.datagrams for _, tick in zip(range(600), flown(seed), strict=False)] for seed in (5, 5, 6)
    ]
    assert flights[0] == flights[1] != flights[2]


@pytest.mark.slow
def test_flights_by_the_thousand_in_short(tmp_path):
    """As `make lab` flies them, in processes of their own."""
    command = [
        sys.executable,
        BENCHMARK,
        "--flights",
        "2",
        "--seconds",
        "2",
        "--net",
        "stop-tube",
        "--jobs",
        "2",
    ]
    done = subprocess.run(
        [*command, "--json", tmp_path / "found.json"], capture_output=True, text=True, check=True
    )
    assert "stop-tube: 2 flights, 0 with contact, 0 people needed, in view 100.00 %" in done.stdout
    found = json.loads((tmp_path / "found.json").read_text())
    behind = found["nets"]["stop-tube"]
    assert behind["flown_s"] == pytest.approx(4.0, abs=0.2) and behind["not_finished"] == []
    assert behind["contacts"] == 0 and behind["least_gap_m"]["uav"] > 0.0 and behind["times_real_time"] > 0.0
