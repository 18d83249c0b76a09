"""The exciter: what it shows of a vehicle, and where it stays meanwhile."""

from dataclasses import astuple, replace

import numpy as np
import pytest

from fledge.conditions import Conditions
from fledge.engines import fly_plain
from fledge.manoeuvres import FixedAltitude
from fledge.observation import Axes, Observation
from fledge.pilots import Exciter
from fledge.simulation import Case, Crew

NO_NOISE = (0.0, 0.0, 0.0, 0.0)
MIDDLE = Observation(320.0, 180.0, 320.0, 180.0, 2.6, 108.0, 108.0, 0.0, 0.0, 0.0, 0.0)
MINUTES = 5
ROWS = MINUTES * 1200


def sticks(rows, observation=MIDDLE, pilot=Exciter()):
    """What it says, row by row; shape (rows, 4)."""
    memory, said = pilot.init(), []
    for _ in range(rows):
        memory, action = pilot.act(memory, observation, NO_NOISE)
        said.append(astuple(action))
    return np.array(said)


@pytest.fixture(scope="module")
def pattern():
    return sticks(ROWS)


def test_it_lets_go_often_and_for_long_enough(pattern):
    still = (np.abs(pattern).max(axis=1) == 0.0).astype(int)
    rests = np.diff(np.flatnonzero(np.diff(still)))[::2]
    assert still[0] == 0, "it begins with a drive"
    assert len(rests) >= 22 * MINUTES
    assert rests.min() >= Exciter().rest


def test_it_uses_all_of_the_stick_and_all_between(pattern):
    driving = pattern[np.abs(pattern).max(axis=1) > 0.0][:, :3]
    for axis in driving.T:
        shares, _ = np.histogram(axis, np.linspace(-1.0, 1.0, 9))
        assert shares.min() > 0.04 * len(axis), "no eighth of the stick is left out"
        assert (np.abs(axis) == 1.0).mean() > 0.02


def test_the_axes_do_not_follow_each_other(pattern):
    driving = pattern[np.abs(pattern).max(axis=1) > 0.0][:, :3]
    assert np.abs(np.corrcoef(driving.T) - np.eye(3)).max() < 0.15


def test_where_it_begins_another_flight_begins():
    elsewhere = sticks(100, replace(MIDDLE, ugv_u=333.3, ugv_v=171.0))
    assert np.abs(elsewhere - sticks(100)).max() > 0.5


@pytest.mark.parametrize(
    ("change", "axis", "sign"),
    [
        ({"ugv_v": 60.0}, 0, 1.0),
        ({"ugv_v": 300.0}, 0, -1.0),
        ({"ugv_u": 200.0}, 1, 1.0),
        ({"ugv_u": 440.0}, 1, -1.0),
        ({"radius": 140.0}, 2, 1.0),
        ({"radius": 80.0}, 2, -1.0),
    ],
)
def test_far_from_the_ugvs_it_does_not_lead_on(change, axis, sign):
    said = sticks(400, replace(MIDDLE, **change))[:, axis]
    assert (said * sign >= 0.0).all() and (said != 0.0).any()


@pytest.mark.slow
def test_it_stays_over_the_ugvs():
    case = Case(FixedAltitude().plan(np.random.default_rng(2), 1200), Conditions())
    seen = fly_plain(case, Crew(Exciter(), Axes()), key=(3,)).observation
    metres = np.asarray(seen.altitude) / 374.7
    off = np.hypot((seen.ugv_u - 320.0) * metres, (seen.ugv_v - 180.0) * metres)
    assert off.max() < 2.0, "within the reach of a lab's room"
    assert off.max() > 0.6, "or it shows nothing"
