"""How a UAV stops: laws of flights of one whose answer is known."""

from dataclasses import replace

import numpy as np
import pytest
from surveyed import CLIMB, flight

from fledge.lab.control.tilt import Tilt
from fledge.lab.survey.stops import fit, flown, found, overruns, pushes
from fledge.safety import Contract

pytestmark = pytest.mark.slow

CONTRACT = Contract(latency=0.03)


@pytest.fixture(scope="module")
def law():
    return fit([flown(flight(90.0, seed=1))], CONTRACT, Tilt().lag)


def test_every_rest_is_a_stop():
    trace = flight(30.0)
    stops = found(flown(trace), (0, 1))
    assert len(stops) >= 8
    for one in stops:
        assert not trace.told[one.begin : one.end, :2].any() and trace.told[one.begin - 1, :2].any()


def test_in_height_a_lag_takes_its_own_time(law):
    assert law.stop.speed_up == pytest.approx(CLIMB, abs=0.04)
    assert law.stop.error_up < 0.05


def test_fresh_stops_end_within_the_bound(law):
    beside, above, _ = overruns([flown(flight(60.0, seed=2))], CONTRACT, law.stop)
    assert len(beside) > 15
    assert beside.max() <= law.stop.error and above.max() <= law.stop.error_up


def test_the_law_says_more_than_a_guess(law):
    """Without its terms the same stops are missed by far more."""
    fresh = [flown(flight(40.0, seed=3))]
    without = replace(law.stop, speed=0.0, tilt=0.0, rate=0.0, followed=0.0)
    assert overruns(fresh, CONTRACT, without)[0].max() > 3.0 * overruns(fresh, CONTRACT, law.stop)[0].max()


def test_in_still_air_nothing_drifts(law):
    drifts, pushed = pushes([flown(flight(40.0, seed=4))], CONTRACT, law.stop)
    assert np.median(drifts) < 0.06 and np.median(pushed) < 0.15
