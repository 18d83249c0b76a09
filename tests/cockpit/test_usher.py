"""Everybody is told where they sit, when that changes and only then."""

import time

from fledge.cockpit.asks import Sticks
from fledge.cockpit.tells import Seating
from fledge.cockpit.usher import Usher

ONE, TWO = 1, 2


def ushered():
    told = []
    return Usher(lambda client, one: told.append((client, one))), told


def sticks(sequence, client_time=0.0):
    return Sticks(sequence, client_time, 0, (0.0, 0.0, 0.0, 0.0))


def test_each_is_told_as_they_see_it():
    usher, told = ushered()
    usher.come(ONE)
    usher.come(TWO)
    now = time.monotonic()
    usher.ask(ONE, True, now)
    usher.ask(TWO, True, now)
    assert told[-2:] == [(ONE, Seating("mine", 1)), (TWO, Seating("waiting", 1))]
    usher.ask(ONE, False, now)
    assert told[-2:] == [(ONE, Seating("taken", 1)), (TWO, Seating("mine", 1))]
    usher.go(TWO, now)
    assert told[-1] == (ONE, Seating("free", 1))


def test_nothing_new_is_not_told():
    usher, told = ushered()
    usher.come(ONE)
    usher.ask(ONE, True, time.monotonic())
    known = len(told)
    usher.come(ONE)
    usher.hear(ONE, sticks(1), time.monotonic())
    usher.tick()
    assert len(told) == known


def test_sticks_count_once_and_only_the_holders():
    usher, _ = ushered()
    usher.come(ONE)
    assert not usher.hear(ONE, sticks(1), time.monotonic()) and usher.silent is None
    usher.ask(ONE, True, time.monotonic())
    assert usher.hear(ONE, sticks(1), time.monotonic()) and usher.silent < 1.0
    assert not usher.hear(ONE, sticks(1), time.monotonic())
    assert not usher.say().lost
