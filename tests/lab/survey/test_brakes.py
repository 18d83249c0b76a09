"""How UGVs stop: found in flights of robots whose brakes are known."""

import numpy as np
import pytest
from surveyed import flight

from fledge.dynamics import UGV_FLEET
from fledge.lab.survey.brakes import FEWEST, brakes


def test_what_is_found_is_a_little_less_than_the_truth():
    for model, driven in zip(UGV_FLEET, flight(30.0, ours=True).ugvs, strict=True):
        found = brakes(driven, 0.05)
        assert 0.6 * model.acceleration < found.acceleration <= model.acceleration
        assert 0.4 * model.turn_acceleration < found.turn_acceleration <= model.turn_acceleration
        assert found.stops >= FEWEST and found.fastest == pytest.approx(0.3, abs=0.02)


def test_who_was_not_ours_to_command_says_nothing():
    found = brakes(flight(5.0).ugvs[0], 0.05)
    assert np.isnan(found.acceleration) and np.isnan(found.turn_acceleration) and found.stops == 0


def test_too_few_stops_say_nothing():
    found = brakes(flight(6.0, ours=True).ugvs[0], 0.05)
    assert 0 < found.stops < FEWEST and np.isnan(found.acceleration)
