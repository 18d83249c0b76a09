"""What a flight shows of itself: to who asked last, every third tick, and to nobody else; what was said, as it was."""

import select
from dataclasses import replace
from math import cos, inf, nan, pi, sin

import pytest
from ticks import SPREAD, decision, said, world

from fledge.geometry import Box, Quat, Vec3
from fledge.lab.control.outfit import SUBJECTS, Outfit
from fledge.lab.control.phases import Phase
from fledge.lab.control.tick import Said
from fledge.lab.shell.runtime import Now
from fledge.lab.shell.tally import Tally
from fledge.lab.shell.udp import UdpPort, Wire
from fledge.lab.shell.window import EVERY, Window
from fledge.lab.wire import glances
from fledge.lab.wire.datagrams import GLANCES, Datagram
from fledge.lab.wire.glances import Glance
from fledge.supervision.modes import Mode
from fledge.world import Arena, Obstacle, Reason, VelocityCommand

ARENA = Arena(Box(-3.0, 3.0, -2.0, 2.0), 4.0, (Obstacle(Box(1.0, 2.0, 0.5, 1.5), 0.8),))
OUTFIT = Outfit(ARENA, "servo", "stop-tube")
ASK = Datagram(GLANCES, b"\1")


@pytest.fixture
def opened():
    """Opens ports, and closes them after the test."""
    ports = []

    def port(*args, **more):
        ports.append(UdpPort(Wire(GLANCES, *args, **more)))
        return ports[-1]

    yield port
    for one in ports:
        one.close()


def now(tick, t=12.5, **more):
    return Now(t, tick, Tally(ARENA).init(), 420, 0, 0, True, False)._replace(**more)


def come(port, within=2.0):
    """The glances that are there, once one is."""
    select.select([port], (), (), within)
    found = [glances.decode(arrival.datagram.data) for arrival in port.receive()]
    assert all(isinstance(one, Glance) for one in found)
    return found


def asked(window, port, by):
    """Somebody asks, and the flight hears it as it hears everything: by receiving."""
    by.send(ASK)
    select.select([port], (), (), 2.0)
    port.receive()


def shown(opened, tick, **more):
    """The one glance of a tick."""
    port = opened(("127.0.0.1", 0))
    window, eye = Window(OUTFIT, port), opened(there=port.address)
    asked(window, port, eye)
    for _ in range(EVERY):
        window.show(now(tick, **more))
    (glance,) = come(eye)
    return glance


def test_every_third_tick_is_shown_to_who_asked_last(opened):
    port = opened(("127.0.0.1", 0))
    window, one, other = Window(OUTFIT, port), *(opened(there=port.address) for _ in range(2))
    for eye in (one, other):
        asked(window, port, eye)
        for tick in range(30):
            window.show(now(said(), t=0.01 * tick))
    assert [glance.sequence for glance in come(one)] == list(range(EVERY, 31, EVERY))
    assert [glance.sequence for glance in come(other)] == list(range(30 + EVERY, 61, EVERY))


def test_where_nobody_asked_nothing_is_said(opened):
    port = opened(("127.0.0.1", 0))
    window, eye = Window(OUTFIT, port), opened(there=port.address)
    for _ in range(30):
        window.show(now(said()))
        Window(OUTFIT, None).show(now(said()))
    assert come(eye, within=0.05) == []


def test_who_has_gone_away_holds_nobody_up(opened):
    port = opened(("127.0.0.1", 0))
    window, eye = Window(OUTFIT, port), opened(there=port.address)
    asked(window, port, eye)
    eye.close()
    for _ in range(30):
        window.show(now(said()))
        port.receive()


def test_what_the_flight_is(opened):
    glance = shown(opened, said(phase=Phase.JOIN), t=7.25, wires="the master does not answer")
    assert (glance.t, glance.phase, glance.complaint) == (7.25, "join", "the master does not answer")
    assert (glance.pilot, glance.net, glance.axes, glance.subjects) == (
        "servo",
        "stop-tube",
        (0, 1),
        SUBJECTS,
    )
    assert glance.room == (-3.0, 3.0, -2.0, 2.0, 4.0) and glance.boxes == ((1.0, 2.0, 0.5, 1.5, 0.8),)


def test_everybody_is_where_they_were_said_to_be(opened):
    seen = world(x=1.25, y=-0.5, z=2.6, middle=(0.5, 0.25))
    tilted = replace(seen.uav, attitude=Quat.from_yaw(0.3), velocity=Vec3(0.1, 0.2, -0.3))
    seen = replace(seen, uav=tilted, ugvs=tuple(replace(ugv, speed=-0.5) for ugv in seen.ugvs))
    uav, *ugvs = shown(opened, said(seen=seen)).vehicles
    q = tilted.attitude
    assert (uav.position, uav.velocity) == ((1.25, -0.5, 2.6), (0.1, 0.2, -0.3))
    assert uav.attitude == (q.w, q.x, q.y, q.z)
    for i, ugv in enumerate(ugvs):
        a = 2.0 * pi * i / 3.0
        assert ugv.position == pytest.approx((0.5 + SPREAD * cos(a), 0.25 + SPREAD * sin(a), 0.0))
        assert ugv.attitude == pytest.approx((cos(0.5 * a), 0.0, 0.0, sin(0.5 * a)))
        assert ugv.velocity == pytest.approx((-0.5 * cos(a), -0.5 * sin(a), 0.0))


def test_what_was_decided_is_shown_with_its_reason(opened):
    held = decision(Mode.SHIELDED, Reason.OBSTACLE, VelocityCommand(0.25, -0.5, 0.125, 1.0), clearance=0.75)
    uav, *ugvs = shown(opened, said(uav=held)).vehicles
    assert (uav.mode, uav.reason, uav.intervened) == (Mode.SHIELDED, Reason.OBSTACLE, True)
    assert (uav.clearance, uav.sent) == (0.75, (0.25, -0.5, 0.125, 1.0))
    assert [(one.mode, one.reason) for one in ugvs] == [(Mode.READY, Reason.NOT_READY)] * 3
    (free, *_) = shown(opened, said(uav=decision(clearance=inf))).vehicles
    assert (free.intervened, free.clearance) == (False, None)


def test_a_place_that_is_no_number_is_said_to_be_none(opened):
    uav, *_ = shown(opened, said(seen=world(x=nan, y=inf))).vehicles
    assert uav.position[:2] == (None, None) and uav.position[2] is not None


def test_before_anybody_was_seen_it_says_what_is_missing(opened):
    glance = shown(opened, Said((), Phase.WAIT, complaint="no poses " * 100))
    assert glance.vehicles == () and glance.phase == "wait"
    assert len(glance.complaint) == 500 and glance.complaint.startswith("no poses")
