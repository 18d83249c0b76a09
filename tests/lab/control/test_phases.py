"""The course of a flight."""

from dataclasses import replace
from itertools import pairwise
from math import inf, nan

import pytest

from fledge.geometry import Quat, Vec3
from fledge.lab.control.phases import Course, Phase, Phases, Sight
from fledge.lab.control.vehicle import Report
from fledge.lab.wire.navdata import ControlState as C
from fledge.supervision.modes import Mode
from fledge.world import UavState

P, M = Phase, Mode
PHASES = Phases(duration=20.0)
HEIGHT = 2.6


def uav(z=0.06, x=0.0, climb=0.0, yaw=0.0, stamp=0.0) -> UavState:
    still = Vec3(0.0, 0.0, 0.0)
    return UavState(Vec3(x, 0.0, z), Vec3(0.0, 0.0, climb), Quat.from_yaw(yaw), still, stamp)


class Flight:
    """A course under way; what is said stays said."""

    def __init__(self, phases=PHASES):
        self.phases, self.course, self.t = phases, phases.init(), 0.0
        self.said = {"mode": M.INIT, "control": C.LANDED, "z": 0.06, "distance": 900.0}
        self.silent = self.unseen = False
        self.heard = self.seen = 0.0

    def go(self, seconds=0.01, **said):
        """So much later."""
        self.said |= said
        for _ in range(max(round(seconds / 0.01), 1)):
            self.t += 0.01
            now = dict(self.said)
            self.heard = self.heard if self.silent else self.t
            self.seen = self.seen if self.unseen else self.t
            report = Report(self.heard, now.pop("control"), 1.0, now.pop("emergency", False), True)
            mode, distance = now.pop("mode"), now.pop("distance")
            sight = Sight(self.t, float(mode), uav(stamp=self.seen, **now), report, HEIGHT, distance)
            self.course = self.phases.step(self.course, sight)
        return self.course.phase


def up() -> Flight:
    """In the air, flown by the pilot."""
    flight = Flight()
    trail = [
        flight.go(0.1, mode=M.READY),
        flight.go(0.5, mode=M.AUTO),
        flight.go(1.0, control=C.TAKING_OFF),
        flight.go(0.1, control=C.HOVERING, z=1.0),
        flight.go(0.1, z=HEIGHT, climb=0.0),
        flight.go(0.1, distance=30.0),
    ]
    assert trail == [P.WAIT, P.TAKE_OFF, P.TAKE_OFF, P.CLIMB, P.JOIN, P.FLY]
    return flight


def test_from_the_pad_to_the_floor():
    flight = up()
    assert flight.go(19.8) is P.FLY
    assert flight.go(0.5) is P.LAND
    assert not flight.course.touching
    assert flight.go(5.0, mode=M.LAND, z=0.5) is P.LAND and not flight.course.touching
    assert flight.go(0.1, z=0.29) is P.LAND and flight.course.touching
    assert flight.go(1.0, control=C.LANDING, z=0.06) is P.LAND and flight.course.touching
    assert flight.go(0.1, control=C.LANDED, mode=M.INIT) is P.OVER
    assert flight.go(9.0, mode=M.AUTO) is P.OVER


@pytest.mark.parametrize("mode", [M.INIT, M.READY])
def test_without_leave_to_fly_it_waits_and_who_disarms_on_the_pad_waits_again(mode):
    flight = Flight()
    assert flight.go(10.0, mode=mode) is P.WAIT
    assert flight.go(0.5, mode=M.AUTO) is P.TAKE_OFF
    assert flight.go(0.01, mode=mode) is P.WAIT


def test_it_climbs_until_it_is_there_and_calm():
    flight = Flight()
    flight.go(mode=M.AUTO)
    assert flight.go(0.1, control=C.FLYING, z=1.0, climb=0.3) is P.CLIMB
    assert flight.go(0.1, z=HEIGHT) is P.CLIMB
    assert flight.go(0.1, climb=0.0, z=HEIGHT - 0.2) is P.CLIMB
    assert flight.go(0.1, z=HEIGHT - 0.05) is P.JOIN


def test_a_formation_out_of_sight_is_joined_anew():
    flight = up()
    assert flight.go(0.1, distance=200.0) is P.FLY
    assert flight.go(0.1, distance=300.0) is P.JOIN
    assert flight.go(0.1, distance=100.0) is P.JOIN
    assert flight.go(0.1, distance=39.0) is P.FLY


@pytest.mark.parametrize("phase", [P.TAKE_OFF, P.CLIMB, P.JOIN, P.FLY, P.LAND])
def test_a_person_s_hand_leads_back_to_the_climb_from_wherever_it_took_over(phase):
    flight = up()
    flight.course = flight.course._replace(phase=phase)
    assert flight.go(1.0, mode=M.MANUAL, x=0.7, z=1.4, yaw=0.3) is P.CLIMB
    flight.go(1.0, x=1.1, yaw=0.9)
    assert flight.go(0.1, mode=M.RECOVER, x=1.2) is P.CLIMB
    assert flight.course.place.x == 1.1  # where the hand let go
    assert flight.course.heading == uav(yaw=0.9).attitude.heading()


@pytest.mark.parametrize("mode", [M.HOLD, M.STOPPED, M.SHIELDED, M.RECOVER])
@pytest.mark.parametrize("phase", [P.CLIMB, P.JOIN, P.FLY])
def test_other_modes_interrupt_a_phase_and_do_not_end_it(mode, phase):
    flight = up()
    flight.course = flight.course._replace(phase=phase, since=flight.t)
    flight.said |= {"z": 1.5, "distance": 100.0}
    place = flight.course.place
    assert flight.go(3.0, mode=mode) is phase
    assert flight.course.place == place


@pytest.mark.parametrize("phase", [P.TAKE_OFF, P.CLIMB, P.JOIN, P.FLY])
def test_an_order_to_land_lands_from_anywhere_and_to_terminate_ends(phase):
    flight = up()
    flight.course = flight.course._replace(phase=phase)
    assert flight.go(mode=M.LAND) is P.LAND
    assert flight.go(mode=M.TERMINATED) is P.OVER


@pytest.mark.parametrize("phase", [P.CLIMB, P.JOIN, P.FLY])
@pytest.mark.parametrize("mode", [M.AUTO, M.MANUAL, M.HOLD])
@pytest.mark.parametrize(
    "how", [{"control": C.LANDING}, {"control": C.LANDED}, {"control": C.DEFAULT, "emergency": True}]
)
def test_a_vehicle_that_comes_down_by_itself_is_not_sent_up_again(phase, mode, how):
    flight = up()
    flight.course = flight.course._replace(phase=phase)
    assert flight.go(mode=mode, **how) is P.LAND


def test_one_that_has_fallen_silent_is_not_taken_for_landed():
    flight = up()
    flight.silent = True
    flight.said["control"] = C.LANDED  # an old word
    flight.heard -= 2.0
    assert flight.go(3.0) is P.FLY


def test_one_that_does_not_take_off_is_given_up():
    flight = Flight()
    flight.go(mode=M.AUTO)
    assert flight.go(PHASES.patience - 0.1) is P.TAKE_OFF
    assert flight.go(0.2) is P.LAND


def test_blind_it_lands_from_where_it_is_and_a_landing_begun_goes_on():
    flight = up()
    flight.go(0.5, mode=M.LAND)
    flight.unseen = True
    flight.go(0.9)
    assert not flight.course.touching
    flight.go(0.2)
    assert flight.course.touching
    flight.unseen = False
    flight.go(1.0)
    assert flight.course.touching
    assert flight.go(1.0, mode=M.MANUAL) is P.LAND and flight.course.touching


def test_the_place_is_the_pad_s_until_it_is_left_and_then_where_it_took_off_to():
    flight = Flight()
    flight.go(1.0, mode=M.READY, x=-2.0)
    assert flight.course.place.x == -2.0
    flight.go(1.0, mode=M.AUTO, x=-1.9)
    assert flight.course.place.x == -1.9
    flight.go(1.0, x=-1.8)
    assert flight.course.place.x == -1.9
    flight.go(0.01, control=C.HOVERING, x=-1.7, z=1.0)
    assert flight.course.place.x == -1.7


def test_no_time_is_up_by_default_and_numbers_that_are_none_end_nothing():
    flight = up()
    flight.phases = Phases()
    assert Phases().duration == inf
    flight.t += 1000.0
    assert flight.go(1.0) is P.FLY
    flight.course = flight.course._replace(phase=P.JOIN)
    assert flight.go(1.0, distance=nan) is P.JOIN
    flight.course = flight.course._replace(phase=P.CLIMB)
    assert flight.go(1.0, z=nan) is P.CLIMB


def test_the_phases_are_in_the_order_of_a_flight():
    order = list(Phase)
    assert order[0] is Course().phase
    flight, seen = up(), [P.WAIT, P.TAKE_OFF, P.CLIMB, P.JOIN]
    seen += [flight.go(0.1), flight.go(20.1), flight.go(0.1, mode=M.INIT)]
    assert seen == order
    assert all(a is not b for a, b in pairwise(seen))
    assert replace(PHASES) == PHASES
