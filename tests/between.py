"""A go-between for the wires of a lab: it stands between twin and controller, and does to datagrams what networks do.

    twin --frames, navdata--> here --> controller
    twin <-- here <--commands, what wakes the navdata-- controller

What becomes of a datagram is its wire's `Fate`, a function of chance and bytes, which may change at any time. The twin
has one loopback address, and the controller is told another, at which it finds us.
"""

import heapq
import select
import socket
import struct
import time
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import count
from random import Random
from threading import Event, Thread

from fledge.geometry import Vec3
from fledge.lab.wire import ardrone, navdata, vicon
from fledge.lab.wire.datagrams import AT, NAVDATA, VICON

WAKE = "wake"
"""The wire to the drone's navdata port."""
WIRES = (VICON, NAVDATA, AT, WAKE)

Fate = Callable[[Random, bytes], Sequence[tuple[float, bytes]]]
"""What becomes of a datagram: (after which time [s], what goes on) for each one that does."""


def kept(rng, data):
    """Nothing happens to it."""
    return ((0.0, data),)


def lost(share=1.0) -> Fate:
    """Some get lost, each by itself."""
    return lambda rng, data: () if rng.random() < share else ((0.0, data),)


def late(most) -> Fate:
    """Each is up to so late [s], so that they overtake each other."""
    return lambda rng, data: ((most * rng.random(), data),)


def doubled(after) -> Fate:
    """Each comes once more [s] later."""
    return lambda rng, data: ((0.0, data), (after, data))


def corrupt(share) -> Fate:
    """Of some one byte is another, or the end is missing."""

    def spoil(rng, data):
        if rng.random() >= share:
            return ((0.0, data),)
        place, other = rng.randrange(len(data)), rng.randrange(1, 256)
        if rng.random() < 0.2:
            return ((0.0, data[:place]),)
        return ((0.0, data[:place] + bytes([data[place] ^ other]) + data[place + 1 :]),)

    return spoil


def doubled_up(name, share) -> Fate:
    """In some the bit flips that makes a subject twice as high as it is, or half as high."""

    def flip(rng, data):
        if rng.random() >= share:
            return ((0.0, data),)
        exponent = data.index(name.encode()) + vicon.OBJECT.size - 4 * 8 + 6  # of z, the third of six doubles
        return ((0.0, data[:exponent] + bytes([data[exponent] ^ 0x10]) + data[exponent + 1 :]),)

    return flip


def renumbered(frames) -> Fate:
    """The cameras' counter is ahead by so many, or behind."""

    def count_otherwise(rng, data):
        (number,) = struct.unpack_from("<I", data)
        return ((0.0, struct.pack("<I", number + frames) + data[4:]),)

    return count_otherwise


def swapped(a, b) -> Fate:
    """Two subjects are taken for each other."""
    return _redrawn(lambda one: replace(one, name={a: b, b: a}.get(one.name, one.name)))


def moved(name, dx) -> Fate:
    """A subject is seen so far to the east of where it is [m]."""
    step = Vec3(dx, 0.0, 0.0)
    return _redrawn(lambda one: replace(one, position=one.position + step) if one.name == name else one)


def _redrawn(change) -> Fate:
    def redraw(rng, data):
        frame = vicon.decode(data)
        return ((0.0, vicon.encode(vicon.Frame(frame.number, tuple(map(change, frame.objects))))),)

    return redraw


class Between:
    """The go-between: a context, at work in a thread of its own."""

    def __init__(self, lab, ours, seed=0):
        """`lab` is the twin's address, `ours` the one that the controller is told."""
        self.fates: dict[str, Fate] = dict.fromkeys(WIRES, kept)
        self.came, self.went = Counter(), Counter()
        """Datagrams, by wire."""
        self.began = None
        """When the first command came [s]."""
        self._rngs = {wire: Random(f"{seed} {wire}") for wire in WIRES}
        self._waiting, self._number = [], count()
        self._over, self._thread = Event(), Thread(target=self._run)
        self._asks, self._asker = _socket(), None
        self._asks.connect((lab, navdata.PORT))
        self._ins = {
            _socket((lab, vicon.PORT)): VICON,
            _socket((ours, ardrone.PORT)): AT,
            _socket((ours, navdata.PORT)): WAKE,
            self._asks: NAVDATA,
        }
        self._there = {VICON: (ours, vicon.PORT), AT: (lab, ardrone.PORT)}
        self._answers = next(one for one, wire in self._ins.items() if wire == WAKE)

    def during(self, seconds, **fates: Fate):
        """Wires have other fates for so long; returns (begin, end) of that, by `time.monotonic` [s]."""
        begin = time.monotonic()
        self.fates |= fates
        time.sleep(seconds)
        self.fates |= dict.fromkeys(fates, kept)
        return begin, time.monotonic()

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._over.set()
        self._thread.join()
        for one in self._ins:
            one.close()

    def _run(self):
        while not self._over.is_set():
            wait = min(max(self._waiting[0][0] - time.monotonic(), 0.0), 0.1) if self._waiting else 0.1
            for one in select.select(list(self._ins), (), (), wait)[0]:
                self._take(one)
            while self._waiting and self._waiting[0][0] <= time.monotonic():
                _, _, wire, data = heapq.heappop(self._waiting)
                self._pass_on(wire, data)

    def _take(self, one):
        wire = self._ins[one]
        with suppress(OSError):  # nobody listened where the last one went
            data, sender = one.recvfrom(65536)
            now = time.monotonic()
            self.came[wire] += 1
            if wire == AT and self.began is None:
                self.began = now
            if wire == WAKE:
                self._asker = sender
            for after, passed in self.fates[wire](self._rngs[wire], data):
                heapq.heappush(self._waiting, (now + after, next(self._number), wire, passed))

    def _pass_on(self, wire, data):
        self.went[wire] += 1
        with suppress(OSError):
            if wire == NAVDATA:
                self._answers.sendto(data, self._asker)
            elif wire == WAKE:
                self._asks.send(data)
            else:
                self._answers.sendto(data, self._there[wire])


def _socket(here=("127.0.0.1", 0)):
    opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    opened.setblocking(False)
    opened.bind(here)
    return opened
