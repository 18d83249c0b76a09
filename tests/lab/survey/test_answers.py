"""How late, and how, a vehicle answers: found in flights of one whose answer is known."""

import numpy as np
import pytest
from surveyed import flight

from fledge.lab.survey.answers import answer, delay
from fledge.lab.survey.stops import flown


@pytest.mark.slow
@pytest.mark.parametrize("ticks", [2, 6])
def test_the_delay_is_found_to_a_tick(ticks):
    assert delay([flight(25.0, delay=ticks, seed=ticks)]) == pytest.approx(0.01 * ticks, abs=0.008)


def test_without_tilts_nobody_knows():
    trace = flight(5.0)
    assert np.isnan(delay([trace._replace(tilt=np.full_like(trace.tilt, np.nan))]))


def test_the_ramp_is_that_of_the_velocity_loop():
    found = answer([flown(flight(30.0))], 0.02)
    assert 0.25 < found.lag < 0.7, "the loop says some 0.4 s; at full stick the tilt is at its stop"
    assert 0.0 < found.error < 0.25 and found.error < found.largest
