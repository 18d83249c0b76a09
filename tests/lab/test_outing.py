"""One flight of the physical experiment: what is kept of it, from when to when, and by whose eyes."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from ticks import said, world

from fledge.geometry import Vec3
from fledge.lab import outing
from fledge.lab.control.phases import Phase
from fledge.lab.lockstep import Tick
from fledge.lab.outing import Outing, fly, track
from fledge.lab.twin.twin import Options, Twin
from fledge.lab.wire.datagrams import Heard
from fledge.pilots import Servo
from fledge.safety import StopTube
from fledge.world import Arena


def ticks(*phases):
    """One tick for each; the truth is half a metre east of what is believed."""
    for number, phase in enumerate(phases):
        t = 0.01 * number
        believed = world(t)
        p = believed.uav.position
        true = replace(believed, uav=replace(believed.uav, position=Vec3(p.x + 0.5, p.y, p.z)))
        yield Tick(Heard(t, ()), said(t, phase=phase), true)


def kept(phases, most=100):
    notes = outing.Notes()
    assert len(list(outing._kept(ticks(*phases), notes, most))) == len(phases)
    return notes


def test_rows_begin_when_the_pilot_first_flies_and_go_on_whoever_flies():
    phases = [Phase.CLIMB] * 3 + [Phase.FLY] * 5 + [Phase.JOIN] * 5 + [Phase.LAND] * 7
    notes = kept(phases)
    assert [row.world.t for row in notes.rows] == pytest.approx([0.03, 0.08, 0.13])
    assert notes.aloft == 13 and notes.landing == pytest.approx(0.13)


def test_there_are_no_more_than_asked_for():
    assert len(kept([Phase.FLY] * 100, most=4).rows) == 4


def test_no_rows_of_a_flight_that_never_was():
    notes = kept([Phase.CLIMB] * 40)
    assert notes.rows == [] and notes.landing == inf


def test_a_row_is_the_truth():
    (row,) = kept([Phase.FLY] * 5).rows
    assert row.world.uav.position.x == pytest.approx(world(0.0).uav.position.x + 0.5)


def test_the_formation_goes_the_way_that_is_foretold():
    way = track(7, Arena.lab(), 2.0)
    twin = Twin(Arena.lab(), 7, Options(duration=2.0 + outing.SPARE))
    centre = np.mean([(ugv.x, ugv.y) for ugv in twin.world().ugvs], axis=0)
    assert len(way.track.x) == 40
    assert centre == pytest.approx([way.track.x[0], way.track.y[0]], abs=1e-6)


def test_reversed_sticks_are_the_pilots_alone():
    one, other = (Outing(Servo(), StopTube(), 0, reversed=turned).controller() for turned in (False, True))
    axes = one.guidance.axes, other.guidance.axes
    assert [(a.forward, a.left, a.up, a.turn) for a in axes] == [(1.0, 1.0, 0.0, 0.0), (-1.0, -1.0, 0.0, 0.0)]
    assert other.phases.lost == inf and one.supervisor == other.supervisor


@pytest.mark.slow
def test_a_flight_leaves_its_numbers_and_its_rows():
    made = Outing(Servo(), StopTube(), 3, ("servo", "stop-tube"), seconds=2.0)
    numbers, flight = fly(made)
    assert flight is not None and (flight.rows, numbers["rows"], numbers["seed"]) == (40, 40, 3)
    assert (flight.pilot, flight.net, flight.axes) == ("servo", "stop-tube", (0, 1))
    assert np.diff(flight.episode.world.t) == pytest.approx(0.05)
    assert numbers["landed"] and numbers["contacts"] == 0 and numbers["held"] == 0.0
    assert numbers["aloft_s"] > 2.0
    again = fly(made)
    assert again.numbers == numbers and again.flight is not None
    assert np.array_equal(again.flight.episode.world.uav.position.x, flight.episode.world.uav.position.x)
