"""What a net relies on, found out: in flights of a vehicle whose answer is known, and in flights of the twin."""

from dataclasses import replace

import numpy as np
import pytest
from surveyed import flight

from fledge.errors import FledgeError
from fledge.lab.control.outfit import Outfit
from fledge.lab.control.tilt import Tilt
from fledge.lab.lockstep import fly_lockstep
from fledge.lab.survey.identify import CLIMBS, FAST_STOPS, STOPS, identify
from fledge.lab.survey.stops import flown, overruns
from fledge.lab.survey.traces import trace
from fledge.lab.twin.twin import Options, Twin
from fledge.pilots import Exciter
from fledge.safety import StopTube
from fledge.safety.terms import Terms
from fledge.world import Arena

LAG = Tilt().lag
SIMULATED = Terms()


@pytest.fixture(scope="module")
def identified():
    return identify([flight(120.0, delay=3, ours=True), flight(60.0, delay=3, seed=1, ours=True)], LAG)


@pytest.mark.slow
def test_the_terms_are_the_vehicles(identified):
    (contract, stop, ugvs), found = _parts(identified.terms), identified.findings
    assert found.delay == pytest.approx(0.03, abs=0.01)
    assert found.delay < contract.latency <= found.delay + 2.5 * contract.period
    assert 0.2 < stop.speed < 0.5 and stop.speed_up == pytest.approx(0.3, abs=0.05)
    assert stop.error >= found.most_missed
    assert stop.most == SIMULATED.uav.most, "full stick was flown"
    for one, simulated in zip(ugvs, SIMULATED.ugvs, strict=True):
        assert 0.6 * simulated.acceleration < one.acceleration <= simulated.acceleration


@pytest.mark.slow
def test_noise_that_is_seen_only_raises_a_bound(identified):
    contract = identified.terms.contract
    assert contract.position_error == SIMULATED.contract.position_error
    assert contract.disturbance >= SIMULATED.contract.disturbance
    noisy = identify([flight(130.0, noise=0.01)], LAG).terms.contract
    assert noisy.position_error > 0.03


@pytest.mark.slow
def test_larger_commands_than_were_flown_are_not_let_through():
    assert identify([flight(180.0, strength=0.6)], LAG).terms.uav.most == pytest.approx(
        0.6 * 2**0.5, abs=0.05
    )


def test_too_few_stops_are_refused_with_what_it_takes():
    with pytest.raises(FledgeError) as error:
        identify([flight(10.0)], LAG)
    said = str(error.value)
    assert said.startswith("1 flights with ") and f"valid are {STOPS}, {FAST_STOPS} and {CLIMBS}" in said
    assert "--pilot exciter" in said and "\n" not in said


@pytest.mark.slow
def test_slow_stops_are_refused():
    with pytest.raises(FledgeError, match=r" 0 of them from 0.3 m/s or more"):
        identify([flight(150.0, strength=0.2)], LAG)


@pytest.mark.slow
def test_a_vehicle_that_answers_too_late_is_refused():
    with pytest.raises(FledgeError, match="look to the link"):
        identify([flight(150.0, delay=25)], LAG)


def _parts(terms):
    return terms.contract, terms.uav, terms.ugvs


# The twin.


def excited(seed, seconds):
    """A flight of the exciter's in the twin."""
    arena = Arena.lab()
    outfit = Outfit(
        arena, "exciter", "stop-tube", axes=(0, 1, 2), duration=seconds, unattended=True, seed=seed
    )
    flying = fly_lockstep(
        outfit.controller(Exciter(), StopTube()), Twin(arena, seed, Options()), seconds + 20.0
    )
    return trace(((tick.heard.t, tick.said) for tick in flying), ours=False)


@pytest.mark.slow
def test_of_the_twin_it_finds_what_is_true_and_fresh_stops_stay_within():
    found = identify([excited(11, 110.0)], LAG)
    true_delay = Options().link_delay + 0.001  # a frame is 6 ms old, and the clock takes it for 5
    assert found.findings.delay == pytest.approx(true_delay, abs=0.01)
    assert found.findings.pose_age == pytest.approx(0.005, abs=0.002)
    contract, stop, _ = _parts(found.terms)
    beside, above, _ = overruns([flown(excited(12, 40.0))], contract, stop)
    assert len(beside) >= 12
    assert np.mean(np.append(beside <= stop.error, above <= stop.error_up)) == 1.0
    assert found.findings.drift < 0.1
    assert stop != replace(SIMULATED.uav), "it is not the simulator's vehicle"
