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
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import count
from random import Random

from processes import beside

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
    return partial(_lost, share)


def _lost(share, rng, data):
    return () if rng.random() < share else ((0.0, data),)


def late(most) -> Fate:
    """Each is up to so late [s], so that they overtake each other."""
    return partial(_late, most)


def _late(most, rng, data):
    return ((most * rng.random(), data),)


def doubled(after) -> Fate:
    """Each comes once more [s] later."""
    return partial(_doubled, after)


def _doubled(after, rng, data):
    return ((0.0, data), (after, data))


def corrupt(share) -> Fate:
    """Of some one byte is another, or the end is missing."""
    return partial(_corrupt, share)


def _corrupt(share, rng, data):
    if rng.random() >= share:
        return ((0.0, data),)
    place, other = rng.randrange(len(data)), rng.randrange(1, 256)
    if rng.random() < 0.2:
        return ((0.0, data[:place]),)
    return ((0.0, data[:place] + bytes([data[place] ^ other]) + data[place + 1 :]),)


def doubled_up(name, share) -> Fate:
    """In some the bit flips that makes a subject twice as high as it is, or half as high."""
    return partial(_doubled_up, name, share)


def _doubled_up(name, share, rng, data):
    if rng.random() >= share:
        return ((0.0, data),)
    exponent = data.index(name.encode()) + vicon.OBJECT.size - 4 * 8 + 6  # of z, the third of six doubles
    return ((0.0, data[:exponent] + bytes([data[exponent] ^ 0x10]) + data[exponent + 1 :]),)


def renumbered(frames) -> Fate:
    """The cameras' counter is ahead by so many, or behind."""
    return partial(_renumbered, frames)


def _renumbered(frames, rng, data):
    (number,) = struct.unpack_from("<I", data)
    return ((0.0, struct.pack("<I", number + frames) + data[4:]),)


def swapped(a, b) -> Fate:
    """Two subjects are taken for each other."""
    return partial(_swapped, a, b)


def _swapped(a, b, rng, data):
    frame, other = vicon.decode(data), {a: b, b: a}
    swapped = tuple(replace(one, name=other.get(one.name, one.name)) for one in frame.objects)
    return ((0.0, vicon.encode(vicon.Frame(frame.number, swapped))),)


@dataclass
class Traffic:
    """What has gone through so far."""

    came: Counter = field(default_factory=Counter)
    went: Counter = field(default_factory=Counter)
    """Datagrams, by wire."""
    began: float | None = None
    """When the first command came [s], by `time.monotonic`."""


class Between:
    """The go-between, as a test has it."""

    def __init__(self, line):
        self._line = line

    def turn(self, **fates: Fate) -> Traffic:
        """Wires have other fates from now on; returns what has gone through until now."""
        self._line.send(fates)
        assert self._line.poll(5.0), "the go-between says nothing"
        return self._line.recv()

    def during(self, seconds, **fates: Fate):
        """Wires have other fates for so long; returns (begin, end) of that, by `time.monotonic` [s]."""
        begin = time.monotonic()
        self.turn(**fates)
        time.sleep(seconds)
        end = time.monotonic()  # they are back at the earliest
        self.turn(**dict.fromkeys(fates, kept))
        return begin, end


@contextmanager
def between(lab, ours, seed=0):
    """A go-between at work; `lab` is the twin's address, `ours` the one that the controller is told."""
    with beside(_serve, lab, ours, seed) as line:
        yield Between(line)


def _serve(line, lab, ours, seed):
    wires = _Wires(lab, ours, seed)
    line.send("ready")
    while True:
        wires.pass_on(line)
        if line.poll():
            if (fates := line.recv()) is None:
                break
            wires.fates |= fates
            line.send(wires.traffic)


class _Wires:
    """The sockets, and what is on its way from one to another."""

    def __init__(self, lab, ours, seed):
        self.fates: dict[str, Fate] = dict.fromkeys(WIRES, kept)
        self.traffic = Traffic()
        self._rngs = {wire: Random(f"{seed} {wire}") for wire in WIRES}
        self._waiting, self._number = [], count()
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

    def pass_on(self, line):
        """Waits for a datagram, for one's time to go on, or for the line to speak; sees to the first two."""
        wait = max(self._waiting[0][0] - time.monotonic(), 0.0) if self._waiting else None
        for one in select.select([*self._ins, line], (), (), wait)[0]:
            if one is not line:
                self._take(one)
        while self._waiting and self._waiting[0][0] <= time.monotonic():
            _, _, wire, data = heapq.heappop(self._waiting)
            self._send(wire, data)

    def _take(self, one):
        wire, traffic = self._ins[one], self.traffic
        with suppress(OSError):  # nobody listened where the last one went
            data, sender = one.recvfrom(65536)
            now = time.monotonic()
            traffic.came[wire] += 1
            if wire == AT and traffic.began is None:
                traffic.began = now
            if wire == WAKE:
                self._asker = sender
            for after, passed in self.fates[wire](self._rngs[wire], data):
                heapq.heappush(self._waiting, (now + after, next(self._number), wire, passed))

    def _send(self, wire, data):
        self.traffic.went[wire] += 1
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
