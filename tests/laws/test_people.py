"""Taking over, handing back: what a person does to a vehicle, and what nothing does to a person."""

from dataclasses import replace
from math import inf, nan

import pytest
from scripted import BROKEN, ESCAPE, HUMAN, TOO_FAST, WAYS, WISH, Flight, auto

from fledge.supervision.inputs import HOVER
from fledge.supervision.modes import Mode as M
from fledge.world import Reason as R
from fledge.world import VelocityCommand

GRABBED = {"deflection": 0.6}


def test_who_takes_over_flies_through_the_net():
    flight = auto().fly(0.1, switch=1.0, command=HUMAN)
    assert (flight.mode, flight.sent, flight.reason) == (M.MANUAL, HUMAN, R.TAKE_OVER)
    assert flight.decisions[0].verdict.intervened
    flight = flight.fly(0.1, command=TOO_FAST)
    assert (flight.sent, flight.reason) == (ESCAPE, R.WALL)


def test_the_dead_man_switch_takes_the_net_away_but_only_by_hand():
    flight = auto().fly(0.1, switch=1.0, command=TOO_FAST, dead_man=1.0)
    assert (flight.sent, flight.reason) == (TOO_FAST, R.TAKE_OVER)
    assert flight.fly(0.1, dead_man=0.0).sent == ESCAPE
    assert flight.fly(0.1, command=replace(TOO_FAST, up=nan)).sent == HOVER
    assert auto().fly(0.1, wish=TOO_FAST, dead_man=1.0).sent == ESCAPE


def test_what_a_person_asks_for_is_what_the_net_is_asked():
    """So a person may always fly away from a wall: nothing but the net stands in between."""
    for command in (WISH, HUMAN, VelocityCommand(-2.0, 1.0, 0.5, 1.0)):
        for age in (0.0, 0.3, 5.0):
            assert auto().fly(0.1, switch=1.0).fly(0.5, command=command, pose_age=age).sent == command


def test_a_stick_that_is_no_number_is_a_hover():
    flight = auto().fly(0.1, switch=1.0, command=HUMAN)
    for bad in (
        {"command": replace(HUMAN, left=nan)},
        {"command": replace(HUMAN, up=inf)},
        {"deflection": nan},
    ):
        broken = flight.fly(0.1, **bad)
        assert (broken.mode, broken.sent, broken.reason) == (M.MANUAL, HOVER, R.NOT_FINITE)


def test_a_spike_of_the_stick_takes_nothing_over():
    flight = auto()
    for _ in range(20):
        flight = flight.fly(0.08, deflection=1.0).fly(0.04, deflection=0.0)
        assert flight.mode == M.AUTO
    assert flight.fly(1.0, deflection=0.29).mode == M.AUTO
    assert flight.fly(1.0, deflection=nan).mode == M.HOLD
    assert flight.fly(0.14, deflection=0.31).mode == M.MANUAL


def test_a_hold_is_deaf_to_sticks_for_five_seconds_never_to_the_switch():
    hold = WAYS[M.HOLD]()
    assert hold.fly(4.7, **GRABBED).mode == M.HOLD
    assert hold.fly(5.1, **GRABBED).mode == M.MANUAL
    assert hold.fly(0.02, switch=1.0).mode == M.MANUAL


def test_handing_back_needs_hands_off_a_quiet_alarm_and_a_net_with_nothing_to_say():
    manual = WAYS[M.MANUAL]().fly(1.1)
    assert manual.fly(0.02, hand_back=1.0).mode == M.RECOVER
    hindered = (
        {"deflection": 0.11},
        {"deflection": nan},
        {"switch": 1.0},
        {"switch": nan},
        {"dead_man": 1.0},
        {"command": TOO_FAST},
        {"wish": BROKEN},
        {"pose_age": 0.2},
        {"battery": nan},
    )
    for hindrance in hindered:
        held = manual.fly(0.2, **hindrance).fly(0.5, hand_back=1.0)
        assert held.mode == M.MANUAL, hindrance
    assert manual.fly(0.1, pose_age=0.2).fly(0.5, pose_age=0.0, hand_back=1.0).mode == M.MANUAL, "too early"


def test_the_command_fades_from_the_person_s_to_the_policy_s():
    before = WAYS[M.MANUAL](dt=0.01).fly(1.1, command=HUMAN)
    ticks = before.history(1.3, hand_back=1.0)
    sent = [before.sent.forward, *(flight.sent.forward for flight in ticks)]
    assert sent[0] == HUMAN.forward and sent[-1] == WISH.forward
    most = (WISH.forward - HUMAN.forward) * 0.01 / 1.0
    assert all(-1e-9 <= b - a <= most + 1e-9 for a, b in zip(sent, sent[1:], strict=False))
    fading = [flight for flight in ticks if flight.mode == M.RECOVER]
    assert fading == ticks[: len(fading)] and len(fading) == pytest.approx(100, abs=1)
    assert {flight.mode for flight in ticks[len(fading) :]} == {M.AUTO}
    assert {flight.reason for flight in fading} == {R.RECOVERING}


def test_who_flies_by_hand_and_is_not_heard_is_stopped_and_lands():
    flight, modes = auto().fly(0.1, switch=1.0, command=HUMAN), {}
    last = flight.t + 0.01
    for _ in range(520):
        flight = flight.fly(0.02, heard=flight.t + 0.02 - last)
        modes.setdefault(flight.mode, round(flight.t - last, 2))
    assert modes == {M.MANUAL: 0.01, M.STOPPED: 0.51, M.LAND: 10.01}
    assert flight.reason == R.LINK_LOST


def test_armed_too_early_is_not_armed():
    flight = Flight.begin(arm=1.0).fly(5.0)
    assert flight.mode == M.INIT and flight.sent == HOVER
    assert flight.fly(0.04, arm=nan).fly(0.1, arm=1.0).mode == M.INIT
