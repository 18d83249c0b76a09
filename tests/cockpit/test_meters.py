"""What the deck measures of itself is what a clock says."""

import time

import pytest

from fledge.cockpit.meters import LATELY, Answers, Pace


def test_half_the_ticks_are_half_the_pace():
    pace = Pace()
    began = time.monotonic()
    while time.monotonic() - began < 0.4:
        pace.step()
        time.sleep(0.02)
    # A sleep may last longer, never shorter; the first step came before any.
    assert 0.05 < pace.factor() < 0.56


def test_nothing_measured_is_real_time():
    assert Pace().factor() == 1.0
    assert Answers().lately is None and Answers().summary()["count"] == 0


def test_answers_are_counted_from_when_sticks_came():
    answers = Answers()
    for ago in (0.010, 0.020, 0.500):
        answers.add(time.monotonic() - ago)
    found = answers.summary()
    assert found["count"] == 3 and answers.lately == pytest.approx(20.0, abs=5.0)
    assert found["p50"] == pytest.approx(20.0, abs=5.0) and found["max"] >= 500.0 and found["p99"] > 400.0


def test_only_the_last_ones_are_shown():
    answers = Answers()
    answers.add(time.monotonic() - 10.0)
    for _ in range(LATELY):
        answers.add(time.monotonic())
    assert answers.lately < 50.0 and answers.summary()["max"] > 9_000.0
