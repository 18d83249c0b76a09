"""The twin in real time: its pace, what it misses, how it ends; over real sockets."""

import os
import signal
import socket
import time
from itertools import islice

import pytest
from loopback import own_host

from fledge.errors import OutOfRange
from fledge.lab.shell.link import Link
from fledge.lab.shell.stage import Stage, told
from fledge.lab.shell.udp import opened, twin_wires
from fledge.lab.twin.contacts import Contact, Witness
from fledge.lab.twin.twin import Options, Twin
from fledge.lab.wire import ardrone, navdata, vicon
from fledge.lab.wire.ardrone import Config, Ref
from fledge.world import Arena

pytestmark = pytest.mark.slow

FAST = Options(duration=10.0)


class Slow(Twin):
    """One whose fifth tick takes 55 ms."""

    def tick(self, heard):
        if self._ticks == 5:
            time.sleep(0.055)
        return super().tick(heard)


def stage(kind=Twin, speed=1.0, link=None):
    return Stage(kind(Arena.lab(), 0, FAST), link or Link(()), speed)


def played(one, duration):
    """How long it took [s]."""
    began = time.monotonic()
    assert list(one.run(duration)) == one.twin.contacts
    return time.monotonic() - began


@pytest.mark.parametrize(("speed", "seconds"), ((1.0, 0.5), (0.5, 1.0)))
def test_its_time_passes_as_fast_as_it_is_told(speed, seconds):
    one = stage(speed=speed)
    took = played(one, 0.5)
    assert took > seconds - 0.05
    assert took == pytest.approx((50 + one.missed) * 0.01 / speed, abs=0.3)  # a busy machine misses some
    assert one.twin.t == pytest.approx(0.5)
    assert one.summary()["ticks"] == 50


def test_what_is_missed_is_counted_and_not_made_up_for():
    one = stage(Slow)
    took = played(one, 0.3)
    assert one.missed >= 5
    assert took > 0.3 + 0.045
    assert one.summary()["missed"] == one.missed


@pytest.mark.parametrize("speed", (0.0, 51.0, float("nan"), -1.0))
def test_a_speed_that_makes_no_sense_is_refused(speed):
    with pytest.raises(OutOfRange, match="speed of the twin"):
        stage(speed=speed)


@pytest.mark.parametrize("number", (signal.SIGINT, signal.SIGTERM))
def test_signals_end_it_after_a_whole_tick_and_are_given_back(number):
    class Struck(Twin):
        """One during whose tenth tick somebody presses Ctrl-C, say."""

        def tick(self, heard):
            if self._ticks == 9:
                os.kill(os.getpid(), number)
            return super().tick(heard)

    before = signal.getsignal(number)
    one = stage(Struck)
    played(one, 60.0)
    assert one.twin.t == pytest.approx(0.1)
    assert one.summary()["ticks"] == 10
    assert signal.getsignal(number) == before


def test_contacts_are_told_as_they_begin():
    one = stage()
    one.twin.contacts.append(Contact(0.0, "p3at", "obstacle1", Witness.PHYSICS))
    first = list(islice(one.run(1.0), 1))
    assert first == one.twin.contacts
    assert told(first[0]) == {"t": 0.0, "who": "p3at", "what": "obstacle1", "witness": "physics"}


class Screen:
    """Pictures of sorts, watched from the tenth tick to the twentieth."""

    def __init__(self):
        self.asked, self.shown = 0, []

    @property
    def watched(self):
        self.asked += 1
        return 10 <= self.asked < 20

    def show(self, stamp, vehicles):
        self.shown.append((stamp, vehicles))


def test_poses_are_shown_to_those_who_watch_with_the_stamps_of_messages():
    screen = Screen()
    one = Stage(
        Twin(Arena.lab(), 0, FAST), Link(()), clock=time.time_ns() - time.monotonic_ns(), pictures=screen
    )
    began = time.time()
    list(one.run(0.3))
    assert len(screen.shown) == 10
    stamps = [stamp for stamp, _ in screen.shown]
    assert stamps == sorted(stamps)
    assert began < stamps[0] and stamps[-1] < time.time()
    for (shown, _), (now, _) in zip(screen.shown[-1][1], one.twin.poses(), strict=True):
        assert (shown.x, shown.y, shown.z) == pytest.approx((now.x, now.y, now.z), abs=1e-3)  # at rest


def test_it_speaks_and_hears_over_the_protocols_own_ports():
    host = own_host()
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as cameras,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client,
    ):
        cameras.bind((host, vicon.PORT))
        for one in (cameras, client):
            one.settimeout(2.0)
        with Link(opened(twin_wires((host, vicon.PORT), (host, ardrone.PORT)))) as link:
            client.sendto(b"\1", (host, navdata.PORT))
            commands = ardrone.encode(1, Ref(fly=False), Config("general:navdata_demo", "TRUE"))
            client.sendto(commands, (host, ardrone.PORT))
            list(stage(link=link).run(0.5))
        frame = vicon.decode(cameras.recv(2048))
        heard = []
        client.setblocking(False)
        while True:
            try:
                heard.append(navdata.decode(client.recv(4096)))
            except BlockingIOError:
                break
    assert (frame.number, len(frame.objects)) == (1, 4)
    assert heard[-1].demo is not None and heard[-1].demo.battery == 1.0


def test_the_cameras_count_on_while_the_world_stands_still():
    """Frame numbers are a clock: one that fell behind would make every later pose look old."""
    heard = Ear()
    one = Stage(Slow(Arena.lab(), 0, FAST), Link([heard]))
    list(one.run(0.3))
    numbers = heard.numbers
    assert one.missed >= 4 and numbers[-1] - numbers[0] == len(numbers) - 1 + one.missed


class Ear:
    """A port that keeps the numbers of the frames that are sent."""

    channels = frozenset(("vicon", "navdata", "at"))
    complaint = ""

    def __init__(self):
        self.numbers = []

    def receive(self):
        return []

    def send(self, datagram):
        if datagram.channel == "vicon":
            self.numbers.append(vicon.decode(datagram.data).number)
        return True

    def close(self):
        pass
