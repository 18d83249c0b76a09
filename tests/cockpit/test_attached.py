"""A flight of another process: what it shows is shown, what people say arrives there, and silence is noticed."""

import time
from contextlib import contextmanager
from dataclasses import replace
from math import inf, nan
from threading import Event, Thread

import pytest
from loopback import own_host
from ticks import decision, said, world

from fledge.camera import Lens, look
from fledge.cockpit.attached import NOWHERE, STALE, Attached
from fledge.cockpit.messages import decode_told, encode
from fledge.cockpit.scene import PERSON
from fledge.cockpit.screen import frame
from fledge.cockpit.seat import HANDS_OFF, Spoken
from fledge.errors import FledgeError
from fledge.geometry import Box, Quat, Vec3
from fledge.lab.control.outfit import Outfit
from fledge.lab.control.phases import Phase
from fledge.lab.control.tick import Said
from fledge.lab.shell.runtime import Now
from fledge.lab.shell.tally import Tally
from fledge.lab.shell.udp import STICKS_PORT, UdpPort, Wire, glances_at
from fledge.lab.shell.window import Window
from fledge.lab.wire import sticks
from fledge.lab.wire.datagrams import GLANCES, STICKS
from fledge.safety import NoNet
from fledge.supervision.inputs import Operator
from fledge.supervision.modes import Mode
from fledge.supervision.watchdog import TICK
from fledge.world import Arena, Obstacle, Reason, VelocityCommand

pytestmark = pytest.mark.slow

ARENA = Arena(Box(-3.0, 3.0, -2.0, 2.0), 4.0, (Obstacle(Box(1.0, 2.0, 0.5, 1.5), 0.8),))
QUIET = Spoken((Operator(),) * 4, HANDS_OFF, inf, True)


class Elsewhere:
    """A flight behind real ports: shows what it is given to show, and keeps the sticks that it hears."""

    def __init__(self):
        self.address = own_host(), STICKS_PORT
        self.said, self.silent, self.heard = said(), False, []
        self._over = Event()

    def __enter__(self):
        self._thread = Thread(target=self._run)
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._over.set()
        self._thread.join()

    def _run(self):
        ears = UdpPort(Wire(STICKS, self.address))
        port, number = UdpPort(Wire(GLANCES, glances_at(self.address))), 0
        window, count = Window(Outfit(ARENA, "servo", "stop-tube"), port), Tally(ARENA).init()
        while not self._over.wait(TICK):
            self.heard += [sticks.decode(arrival.datagram.data) for arrival in ears.receive()]
            port.receive()
            number += 1
            if not self.silent:
                window.show(Now(number * TICK, self.said, count, 420, 0, 0, True, False))
        ears.close()
        port.close()


@contextmanager
def attached(elsewhere):
    scene = Attached.open(elsewhere.address)
    try:
        yield scene
    finally:
        scene.close()


def watched(scene, note=None, memory=None, spoken=QUIET, seconds=5.0):
    """(memory, what is shown) once it has this note, or after so long."""
    memory, shown, late = memory or scene.init(), None, time.monotonic() + seconds
    while time.monotonic() < late and (shown is None or shown.note != note):
        memory, shown = scene.tick(memory, spoken)
        time.sleep(TICK)
    return memory, shown


@pytest.fixture(scope="module")
def there():
    with Elsewhere() as elsewhere:
        yield elsewhere


@pytest.fixture
def scene(there):
    there.said, there.silent, there.heard = said(), False, []
    with attached(there) as found:
        yield found


def test_what_the_flight_is(scene):
    about = scene.about
    assert (about.manoeuvre, about.pilot, about.net, about.axes) == ("lab", "servo", "stop-tube", (0, 1))
    assert about.arena == ARENA
    assert scene.net == NoNet() and scene.halts(scene.init()) == ()


def test_what_is_flown_is_shown(there, scene):
    seen = world(x=1.25, y=-0.5, z=2.6, middle=(0.5, 0.25))
    turned = replace(seen.uav, attitude=Quat.from_yaw(0.3), velocity=Vec3(0.1, 0.2, -0.3))
    held = decision(Mode.SHIELDED, Reason.OBSTACLE, VelocityCommand(0.25, -0.5, 0.125, 1.0), clearance=0.75)
    there.said = said(uav=held, seen=replace(seen, uav=turned), phase=Phase.JOIN)
    _, shown = watched(scene, "join")
    uav = shown.world.uav
    assert (uav.position, uav.velocity, uav.attitude) == (turned.position, turned.velocity, turned.attitude)
    for ugv, one in zip(shown.world.ugvs, seen.ugvs, strict=True):
        assert (ugv.x, ugv.y) == (one.x, one.y)
        assert Quat.from_yaw(ugv.heading).rotate(Vec3(1.0, 0.0, 0.0)).x == pytest.approx(
            Quat.from_yaw(one.heading).rotate(Vec3(1.0, 0.0, 0.0)).x
        )
    assert shown.decisions[0].verdict == held.verdict and shown.decisions[0].mode == held.mode
    assert shown.commanders == ("net", "nobody", "nobody", "nobody")
    assert shown.picture == look(Lens(), shown.world)
    assert (shown.row, shown.flown, shown.over, shown.note) == (None, False, False, "join")


def test_who_flies_and_when_it_is_over(there, scene):
    by_hand = decision(Mode.MANUAL, Reason.TAKE_OVER, clearance=inf)
    there.said = said(uav=by_hand, phase=Phase.OVER)
    _, shown = watched(scene, "over")
    assert shown.commanders[0] == PERSON and shown.over
    assert shown.decisions[0].verdict.clearance == inf
    told = frame(shown, scene.about)
    assert decode_told(encode(told)) == told


def test_before_anybody_was_seen_it_says_what_is_missing(there, scene):
    missing = "no poses from motion capture yet"
    there.said = Said((), Phase.WAIT, complaint=missing)
    _, shown = watched(scene, missing)
    assert shown.note == missing
    assert shown.commanders == ("nobody",) * 4
    told = frame(shown, scene.about)
    assert decode_told(encode(told)) == told and {one.mode for one in told.vehicles} == {"INIT"}


def test_a_place_that_is_no_number_cuts_nobody_off(there, scene):
    there.said = said(seen=world(x=nan, y=inf), phase=Phase.LAND)
    _, shown = watched(scene, "land")
    told = frame(shown, scene.about)
    assert shown.note == "land" and decode_told(encode(told)) == told


def test_sticks_arrive_as_they_were_said(there, scene):
    uav = Operator(VelocityCommand(0.5, -0.25, 0.1, 0.2), deflection=0.5, switch=1.0, arm=1.0)
    said_here = (uav, Operator(arm=1.0), Operator(arm=1.0), Operator(stop=1.0))
    loud, quiet = (Spoken(said_here, HANDS_OFF, silent * TICK, False) for silent in (0.5, 2.0))
    memory, _ = watched(scene, spoken=loud, seconds=0.2)
    time.sleep(0.1)
    assert there.heard and {one.operators for one in there.heard} == {said_here}
    numbers = [one.sequence for one in there.heard]
    assert numbers == sorted(set(numbers))
    there.heard.clear()
    watched(scene, memory=memory, spoken=quiet, seconds=0.2)
    assert there.heard == [], "nothing is said for who says nothing"


def test_silence_is_noted_after_half_a_second(there, scene):
    memory, before = watched(scene, "fly")
    there.silent, notes = True, set()
    end = time.monotonic() + 2.0 * STALE
    while time.monotonic() < end:
        early = time.monotonic()
        memory, shown = scene.tick(memory, QUIET)
        if early - memory.seen > STALE:
            assert shown.note == NOWHERE
        elif time.monotonic() - memory.seen <= STALE:
            assert shown.note == "fly"
        notes.add(shown.note)
        time.sleep(TICK)
    assert notes == {"fly", NOWHERE}
    assert shown.world.uav.position == before.world.uav.position, "people still see where it was last"
    there.silent = False
    assert watched(scene, "fly", memory)[1].note == "fly"


def test_it_is_asked_again_and_again_to_show_itself(there, scene):
    """Whoever asked last is told: another who looks for a moment takes nothing away for long."""
    memory, _ = watched(scene, "fly")
    with attached(there) as other:
        assert watched(other, "fly")[1].note == "fly"
    there.said = said(phase=Phase.LAND)
    assert watched(scene, "land", memory)[1].note == "land"


def test_where_no_flight_is_it_says_where_it_looked():
    host = own_host()
    with pytest.raises(
        FledgeError, match=f"^{host}:51002: nothing is heard of the flight: valid is `fledge fly"
    ):
        Attached.open((host, STICKS_PORT), patience=0.3)
    with pytest.raises(FledgeError, match="host 'no such host' is not known"):
        Attached.open(("no such host", STICKS_PORT))
    with pytest.raises(FledgeError, match="valid are ports from 1 to 65535"):
        Attached.open((host, 65535))


def test_a_flight_that_ends_is_noticed_and_nothing_raises():
    speaking = Spoken((Operator(arm=1.0),) * 4, HANDS_OFF, 0.0, False)
    with Elsewhere() as elsewhere:
        scene = Attached.open(elsewhere.address)
        memory, _ = watched(scene, "fly", spoken=speaking)
    assert watched(scene, NOWHERE, memory, speaking)[1].note == NOWHERE
    scene.close()
