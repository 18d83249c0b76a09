"""Test flights, and those who fly meanwhile."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from fledge import engines
from fledge.pilots import Servo
from fledge.simulation import Rig
from fledge.study import proving
from fledge.study.proving import Bystanders
from fledge.study.setups import BASIC, Study

PRIMITIVE = next(setup for setup in BASIC if setup.name == "primitive")
STUDY = Study("tiny", BASIC, cases=4, manoeuvre_cases=2, training_seeds=2, rows=60)


def test_test_cases_are_a_function_of_the_seed_and_those_of_a_small_study_come_first():
    cases, keys = proving.test_cases(STUDY)
    assert len(cases) == len(keys) == STUDY.cases + 3 * STUDY.manoeuvre_cases
    again, _ = proving.test_cases(replace(STUDY, training_seeds=7, setups=()))
    larger, larger_keys = proving.test_cases(replace(STUDY, cases=6))
    other, _ = proving.test_cases(replace(STUDY, seed=1))
    assert larger_keys[:4] == keys[:4] and larger_keys[6:] == keys[4:]
    for i, case in enumerate(cases):
        np.testing.assert_array_equal(case.plan.track.x, again[i].plan.track.x)
        assert case.conditions == again[i].conditions != other[i].conditions
    np.testing.assert_array_equal(cases[3].plan.track.x, larger[3].plan.track.x)


@pytest.fixture
def slow(monkeypatch):
    """In place of flights: what was asked for, after a while."""
    asked, gate = [], threading.Event()

    def fly(setup, study, pilot, rig):
        asked.append(setup.name)
        gate.wait(10.0)
        return setup.name

    monkeypatch.setattr(proving, "credibility", lambda pilot, seed, rig: (seed, rig))
    monkeypatch.setattr(proving, "fly_tests", fly)
    monkeypatch.setattr(proving, "get_ready", lambda study, rig: None)
    return asked, gate


def test_bystanders_are_those_who_learn_nothing_and_fly_while_others_do(slow):
    asked, gate = slow
    with Bystanders(STUDY, Rig()) as others:
        assert set(others.flown) == {setup.name for setup in STUDY.setups if setup.pilot}
        assert others.operator.result() == (STUDY.seed, Rig())
        assert not any(flight.done() for flight in others.flown.values())
        gate.set()
        assert all(flight.result() == name for name, flight in others.flown.items())
    assert asked == list(others.flown)


def test_whoever_has_not_taken_off_stays_on_the_ground_if_the_study_ends_early(slow):
    asked, gate = slow
    with Bystanders(STUDY, Rig()) as others:
        while not asked:
            time.sleep(0.01)
    gate.set()
    first, *rest = others.flown.values()
    assert first.result() == asked[0]
    assert len(asked) == 1 and all(flight.cancelled() for flight in rest)


def test_an_error_in_a_flight_is_the_study_s(monkeypatch):
    def crash(*anything):
        raise ZeroDivisionError

    monkeypatch.setattr(proving, "credibility", lambda pilot, seed, rig: ())
    monkeypatch.setattr(proving, "fly_tests", crash)
    monkeypatch.setattr(proving, "get_ready", lambda study, rig: None)
    study = replace(STUDY, setups=(replace(BASIC[0], pilot=Servo()),))
    with Bystanders(study, Rig()) as others, pytest.raises(ZeroDivisionError):
        others.flown[BASIC[0].name].result()


def test_what_is_to_fly_a_network_is_ready_before_it_has_learnt(monkeypatch):
    ahead = []
    monkeypatch.setattr(proving, "compile_ahead", lambda *asked: ahead.append(asked))
    proving.get_ready(replace(STUDY, net_cases=3), Rig())
    ((policy, *rest),) = ahead
    assert policy.inputs == PRIMITIVE.method.inputs and rest == [STUDY.nets, STUDY.rows, Rig()]
    proving.get_ready(STUDY, Rig())
    assert len(ahead) == 1
    monkeypatch.setattr(engines, "compiled", None)  # nothing more is compiled
    learnt = replace(policy, biases=tuple(bias + 0.1 for bias in policy.biases))
    scores, sample = proving.fly_tests(replace(PRIMITIVE, trained_on=None), STUDY, learnt, Rig())
    assert scores.effort.min() > 0.05 and sample.pilot == "primitive"
