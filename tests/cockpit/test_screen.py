"""What is shown of a tick is what a page understands, behind every net."""

from dataclasses import replace
from math import atan2, inf, isfinite, nan

import pytest

from fledge.camera import Lens, look
from fledge.cockpit.flight import Choice, Live
from fledge.cockpit.messages import decode_told, encode
from fledge.cockpit.screen import frame
from fledge.cockpit.seat import HANDS_OFF, Spoken
from fledge.cockpit.tells import FAR
from fledge.geometry import Vec3
from fledge.manoeuvres import FixedAltitude
from fledge.pilots import Servo
from fledge.safety import NETS, Halt, NoNet, StopTube
from fledge.supervision.inputs import Operator

pytestmark = pytest.mark.slow


def shown(net, ticks=200):
    """(the last tick of a flight that was armed after a second and a half, what the flight is, its halts)."""
    live = Live.draw(Choice(FixedAltitude(), Servo(), net, "some-net", 20))
    memory, last = live.init(), None
    for i in range(ticks):
        operators = (Operator(arm=float(i >= 150)),) * 4
        memory, last = live.tick(memory, Spoken(operators, HANDS_OFF, 0.0, False))
    return last, live.about, live.halts(memory)


@pytest.mark.parametrize("net", NETS, ids=lambda net: type(net).__name__)
def test_what_is_shown_can_be_said(net):
    last, about, halts = shown(net)
    told = frame(last, about, halts)
    assert decode_told(encode(told)) == told
    assert [vehicle.mode for vehicle in told.vehicles] == ["AUTO"] * 4
    assert told.vehicles[0].commander in ("pilot", "net")
    clearances = [decision.verdict.clearance for decision in last.decisions]
    for vehicle, clearance in zip(told.vehicles, clearances, strict=True):
        assert vehicle.clearance == (clearance if isfinite(clearance) else None)
    assert [vehicle.stop for vehicle in told.vehicles] == [tuple(halt) for halt in halts or ((),) * 4]


def test_places_and_picture_are_those_of_the_world():
    last, about, _ = shown(NoNet())
    told, uav = frame(last, about), last.world.uav
    assert told.t == last.world.t
    first, *others = told.vehicles
    assert (first.x, first.y, first.z) == (uav.position.x, uav.position.y, uav.position.z)
    heading = uav.attitude.heading()
    assert first.heading == atan2(heading.sin, heading.cos)
    assert [(one.x, one.y) for one in others] == [(ugv.x, ugv.y) for ugv in last.world.ugvs]
    seen = look(about.lens, last.world)
    assert (told.picture.u, told.picture.v, told.picture.radius) == (seen.u, seen.v, seen.radius)
    assert told.picture.ideal_radius == about.ideal_radius
    assert sum(u for u, _ in told.picture.marks) / 3.0 == pytest.approx(seen.u)


def test_what_is_known_of_the_flight_is_passed_on():
    last, about, _ = shown(NoNet(), ticks=1)
    assert (frame(last, about).battery, frame(last, about).note, frame(last, about).over) == (None, "", False)
    told = frame(last._replace(battery=0.3, note="no poses", over=True), about)
    assert (told.battery, told.note, told.over) == (0.3, "no poses", True)


def test_a_net_that_does_not_look_has_no_clearance():
    last, about, _ = shown(NoNet(), ticks=1)
    verdict = replace(last.decisions[0].verdict, clearance=inf)
    blind = last._replace(decisions=(last.decisions[0]._replace(verdict=verdict), *last.decisions[1:]))
    assert frame(blind, about).vehicles[0].clearance is None


def test_a_halt_that_is_nowhere_is_not_shown():
    last, about, halts = shown(StopTube(), ticks=1)
    told = frame(last, about, (Halt(nan, 0.0, 0.1), Halt(0.0, 0.0, inf), *halts[2:]))
    assert [vehicle.stop for vehicle in told.vehicles] == [(), (), *map(tuple, halts[2:])]


@pytest.mark.parametrize("wild", (nan, inf, -inf, 1e300), ids=str)
def test_what_cameras_make_up_can_still_be_said(wild):
    """A pose that nobody believes is shown to the supervisor as it came, and must not cut off who watches."""
    last, about, _ = shown(NoNet(), ticks=1)
    uav, (ugv, *others) = last.world.uav, last.world.ugvs
    nowhere = replace(uav, position=Vec3(wild, 0.0, wild))
    world = replace(last.world, uav=nowhere, ugvs=(replace(ugv, heading=wild), *others))
    told = frame(last._replace(world=world, picture=look(about.lens, world)), about)
    assert decode_told(encode(told)) == told
    assert abs(told.vehicles[0].x) == FAR and told.vehicles[2].x == last.world.ugvs[1].x


def test_pixels_beyond_all_measure_can_still_be_said():
    last, about, _ = shown(NoNet(), ticks=1)
    lens = Lens(focal_px=1e5)
    far = replace(last.world, uav=replace(last.world.uav, position=Vec3(-20.0, 0.0, 0.0)))
    told = frame(last._replace(picture=look(lens, far), world=far), replace(about, lens=lens))
    assert decode_told(encode(told)) == told
    assert FAR in map(abs, (told.picture.u, told.picture.v, told.picture.radius))
