"""What people are told before take-off."""

from dataclasses import replace
from math import inf, nan

import pytest

from fledge.geometry import Box, Quat, Vec3
from fledge.lab.control.checks import Checks, Findings
from fledge.lab.control.eyes import View
from fledge.lab.control.hands import Holding
from fledge.lab.control.vehicle import Report
from fledge.lab.wire.navdata import ControlState as C
from fledge.supervision.inputs import Operator
from fledge.world import Arena, Obstacle, UavState, UgvState, WorldState

NAMES = ("ardrone", "p3at", "p3dx1", "p3dx2")
CHECKS = Checks(Arena.lab(), NAMES)
T = 100.0
STILL = Vec3(0.0, 0.0, 0.0)
UAV = UavState(Vec3(-2.5, -1.7, 0.06), STILL, Quat(1.0, 0.0, 0.0, 0.0), STILL, T)
UGVS = tuple(UgvState(x, y, 0.0, 0.0, 0.0, T) for x, y in ((0.75, 0.0), (-0.4, 0.6), (-0.4, -0.6)))
VIEW = View(None, T, tuple((name, T) for name in NAMES))
REPORT = Report(T, C.LANDED, 0.9, emergency=False, configured=True)
READY = Findings(T, VIEW, REPORT, Holding((Operator(),) * 4, T), WorldState(T, UAV, UGVS), 2.6)


def uav(**but) -> Findings:
    return READY._replace(world=WorldState(T, replace(UAV, **but), UGVS))


def ugv(**but) -> Findings:
    return READY._replace(world=WorldState(T, UAV, (UGVS[0], replace(UGVS[1], **but), UGVS[2])))


def report(**but) -> Findings:
    return READY._replace(report=REPORT._replace(**but))


def scaled(factor) -> Findings:
    p = UAV.position * factor
    ugvs = tuple(replace(one, x=one.x * factor, y=one.y * factor) for one in UGVS)
    return READY._replace(world=WorldState(T, replace(UAV, position=p), ugvs))


WRONG = {
    "no poses from motion capture yet": READY._replace(view=View(), world=None),
    "no poses from motion capture for 2.0 s": READY._replace(view=VIEW._replace(heard=T - 2.0)),
    "no frame, 3 bytes": READY._replace(view=View(trouble="3 bytes"), world=None),
    "does not see p3dx2: it names ardrone, p3at, p3dx1, wand": READY._replace(
        view=VIEW._replace(names=(*VIEW.names[:3], ("wand", T))), world=None
    ),
    "does not see ardrone, p3at, p3dx1, p3dx2: it names nobody": READY._replace(
        view=VIEW._replace(names=()), world=None
    ),
    "not yet for long enough": READY._replace(world=None),
    "millimetres?": scaled(1e3),
    "read as millimetres": scaled(1e-3),
    "p3dx1 is at (nan": ugv(x=nan),
    "ardrone and p3dx1 are 0.100 m apart": uav(position=Vec3(-0.5, 0.6, 0.06)),
    "ardrone is outside the safe area, at (-3.40": uav(position=Vec3(-3.4, 0.0, 0.06)),
    "p3dx1 is outside the safe area": ugv(y=2.6),
    "ardrone is at a height of 1.20 m": uav(position=Vec3(-2.5, -1.7, 1.2)),
    "do the axes agree?": uav(attitude=Quat(0.7, 0.7, 0.0, 0.0)),
    "followed at 5.20 m: valid is 1 to 3.5 m": READY._replace(height=5.2),
    "followed at nan m": READY._replace(height=nan),
    "followed at 0.50 m": READY._replace(height=0.5),
    "does not answer": report(heard=-inf),
    "no navdata": report(heard=T - 1.0),
    "emergency": report(emergency=True),
    "configuration": report(configured=False),
    "does not say what it is doing": report(control=None),
    "says that it is hovering": report(control=C.HOVERING),
    "battery is at 12 %: valid is 25 % or more": report(battery=0.12),
    "battery is at nan %": report(battery=nan),
    "no operator": READY._replace(holding=Holding((Operator(),) * 4)),
    "nobody is heard from: what comes from the sticks is wrong, 2 operators": READY._replace(
        holding=Holding((Operator(),) * 4, trouble="2 operators")
    ),
}


def test_where_nothing_is_missing_nothing_is_said():
    assert CHECKS.missing(READY) == ""


@pytest.mark.parametrize("says", WRONG)
def test_what_is_missing_is_said_in_one_line(says):
    complaint = CHECKS.missing(WRONG[says])
    assert says in complaint
    assert "\n" not in complaint


def test_an_arena_that_is_none_is_said_first():
    stray = Obstacle(Box(9.0, 9.5, 0.0, 0.5), 1.0)
    checks = replace(CHECKS, arena=replace(Arena.lab(), obstacles=(stray,)))
    assert "obstacle 1 stands outside" in checks.missing(READY)
    assert "obstacle 1 stands outside" in checks.missing(READY._replace(view=View(), world=None))


def test_who_flies_unattended_needs_no_operator():
    assert replace(CHECKS, unattended=True).missing(READY._replace(holding=Holding(()))) == ""


def test_in_flight_only_who_is_silent_or_not_seen_is_spoken_of():
    assert CHECKS.in_flight(T, VIEW, REPORT) == ""
    assert CHECKS.in_flight(T + 0.9, VIEW, REPORT) == ""
    view = VIEW._replace(names=tuple((name, T + 3.0) for name in NAMES))
    assert CHECKS.in_flight(T + 3.0, view, REPORT) == "the vehicle has said nothing for over 2 s"
    view = VIEW._replace(names=tuple((name, T + 3.0) for name in NAMES[:2]))
    report = REPORT._replace(heard=T + 3.0)
    assert CHECKS.in_flight(T + 3.0, view, report) == "motion capture does not see p3dx1, p3dx2"


@pytest.mark.parametrize(("height", "within"), [(2.6, 2.6), (9.0, 3.5), (0.1, 1.0)])
def test_the_room_bounds_the_height(height, within):
    assert CHECKS.within(height) == within
