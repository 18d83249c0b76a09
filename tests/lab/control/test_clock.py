"""When a frame was measured, by its number and its receipt."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.lab.control.clock import Clock

CLOCK = Clock()
BOOT = 812.3
"""[s] at which the cameras counted zero."""


def stamps(arrivals, clock=CLOCK):
    """Of (number, received) one by one."""
    memory, found = clock.init(), []
    for number, received in arrivals:
        memory, stamp = clock.step(memory, number, received)
        found.append(stamp)
    return np.array(found)


def stream(seconds, rng, least=CLOCK.least, jitter=0.008, drift=0.0, first=500):
    """(numbers, true times of measurement, receipts) of a stream whose cameras' quartz is off by `drift`."""
    numbers = first + np.arange(round(seconds * CLOCK.rate))
    true = BOOT + numbers / CLOCK.rate * (1.0 + drift)
    return numbers, true, true + least + jitter * rng.random(len(numbers)) ** 2


def of(numbers, received):
    return zip(numbers.tolist(), received.tolist(), strict=True)


def test_stamps_are_true_to_the_luck_of_the_fastest_datagram_so_far():
    numbers, true, received = stream(10.0, np.random.default_rng(0))
    error = stamps(of(numbers, received)) - true
    assert np.all(
        error >= -1e-9
    )  # never older than they are, the least latency being the one that is taken for it
    assert np.all(error <= 0.008)
    assert np.all(error[50:] <= 1e-4)  # which is soon known


def test_a_latency_that_all_share_beyond_the_least_shows_nowhere():
    numbers, true, received = stream(2.0, np.random.default_rng(1), least=CLOCK.least + 0.03, jitter=0.0)
    assert stamps(of(numbers, received)) - true == pytest.approx(0.03)


@pytest.mark.parametrize("drift", [-5e-5, 5e-5])
def test_two_quartzes_that_disagree_are_followed(drift):
    numbers, true, received = stream(600.0, np.random.default_rng(2), drift=drift)
    error = stamps(of(numbers, received)) - true
    assert np.abs(error[100:]).max() < 1e-3
    # And from frame to frame nothing jumps: velocities are differences of stamps.
    assert np.abs(np.diff(error[100:])).max() < 5e-4


def test_what_is_late_lost_twice_or_out_of_order_is_stamped_as_what_it_is():
    rng = np.random.default_rng(3)
    numbers, true, received = stream(5.0, rng)
    received = received + np.where(rng.random(len(numbers)) < 0.2, rng.uniform(0.0, 1.5, len(numbers)), 0.0)
    kept = np.concatenate([np.flatnonzero(rng.random(len(numbers)) < 0.7), np.arange(200, 210)])
    order = kept[np.argsort(received[kept], kind="stable")]
    late = stamps(of(numbers[order], received[order])) - true[order]
    assert np.abs(late[30:]).max() < 1e-3


@pytest.mark.parametrize("first", [0, 5_000_000])
def test_a_counter_that_starts_anew_is_believed_after_a_tenth_of_a_second(first):
    rng = np.random.default_rng(4)
    numbers, true, received = stream(3.0, rng)
    anew = first + np.arange(300)
    later = true[-1] + 0.01 * (1 + np.arange(300))
    arrivals = [*of(numbers, received), *of(anew, later + CLOCK.least + 0.003 * rng.random(300))]
    error = stamps(arrivals)[len(numbers) :] - later
    assert np.all(error[CLOCK.agreeing :] < 0.004) and np.all(error[CLOCK.agreeing :] > -1e-3)
    # Until then, poses are too old to be believed, or stamped by their receipt; never as newer than they are.
    assert np.all(error[: CLOCK.agreeing] < 0.004)


def test_cameras_that_stood_still_are_believed_again():
    numbers, true, received = stream(2.0, np.random.default_rng(5))
    again = numbers[-1] + 1 + np.arange(100)
    later = true[-1] + 30.0 + 0.01 * np.arange(100)
    error = stamps([*of(numbers, received), *of(again, later + 0.006)])[len(numbers) :] - later
    assert np.all(error[: CLOCK.agreeing - 1] < -20.0)
    assert np.abs(error[CLOCK.agreeing :]).max() < 2e-3


def test_what_waited_in_a_buffer_stays_old():
    """A process that was stopped for three seconds reads them all at once, and then goes on."""
    numbers, true, received = stream(10.0, np.random.default_rng(6))
    stopped = (true > true[400]) & (true < true[700])
    received = np.where(stopped, true[700] + CLOCK.least, received)
    error = stamps(of(numbers, received)) - true
    assert np.abs(error[50:]).max() < 1e-3


def test_a_number_that_is_garbled_once_does_no_harm():
    numbers, true, received = stream(4.0, np.random.default_rng(7))
    for wrong in (0, 900, 4_000_000_000):
        garbled = numbers.copy()
        garbled[200] = wrong
        error = stamps(of(garbled, received)) - true
        assert error[200] < 0.01
        assert np.abs(np.delete(error, 200)[50:]).max() < 1e-3


def test_a_clock_of_the_sender_s_own_is_read_alike():
    rng = np.random.default_rng(8)
    numbers, true, received = stream(5.0, rng)
    wall = true + 1.7e9
    error = stamps(of(wall, received), Clock(rate=1.0)) - true
    assert np.abs(error[50:]).max() < 1e-3


@given(st.lists(st.tuples(st.integers(0, 2**32 - 1), st.floats(0.0, 0.2)), min_size=1, max_size=40))
def test_nothing_is_ever_stamped_with_the_future(arrivals):
    received, memory = 0.0, CLOCK.init()
    for number, gap in arrivals:
        received += gap
        memory, stamp = CLOCK.step(memory, number, received)
        assert stamp <= received - CLOCK.least
