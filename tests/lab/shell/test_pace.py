"""Slots: one tick to each, no drift, no burst, and poses in their middle."""

from collections import deque

from hypothesis import given
from hypothesis import strategies as st

from fledge.lab.shell.pace import PERIOD, Pacer, Slot

PACER = Pacer()
times = st.integers(0, 10**12)


@given(times, st.lists(st.integers(0, PERIOD - 1), max_size=200))
def test_the_grid_does_not_drift(start, late):
    """However late ticks end within their slots, the thousandth slot begins a thousand periods after the first."""
    slot = PACER.first(start)
    for number, delay in enumerate(late, start=1):
        slot, missed = PACER.next(slot, slot.begins + delay)
        assert (slot, missed) == (Slot(start + number * PERIOD, start + (number + 1) * PERIOD), 0)


@given(times, st.integers(0, 10**11))
def test_what_is_missed_is_counted_and_not_made_up_for(start, late):
    """After any delay the next slot is one in which it is now, or which is still to come, and on the same grid."""
    slot = PACER.first(start)
    now = start + late
    after, missed = PACER.next(slot, now)
    assert now < after.ends and after.begins > slot.begins
    assert after.begins == start + (1 + missed) * PERIOD
    assert missed == max(late // PERIOD - 1, 0)


def flown(poses, ticks):
    """Ticks of a stream of poses: (how many poses each saw, how far each one's last was from its slot's middle)."""
    slot, seen, off = PACER.first(0), [], []
    waiting = deque(poses)
    for _ in range(ticks):
        due = waiting and waiting[0] <= slot.ends
        now, heard = max(waiting[0], slot.begins) if due else slot.ends, []
        while waiting and waiting[0] <= now:
            heard.append(waiting.popleft())
        seen.append(len(heard))
        off.append(heard[-1] - (slot.begins + slot.ends) // 2 if heard else 0)
        slot, _ = PACER.next(slot, now, heard[-1] if heard else None)
    return seen, off


@given(st.integers(0, PERIOD), st.sampled_from([-200, -50, 0, 50, 200]))
def test_poses_of_another_clock_come_in_the_middle_of_their_slots(phase, ppm):
    """Wherever they come at first, and though cameras and controller count time differently."""
    period = PERIOD * (1_000_000 + ppm) // 1_000_000
    seen, off = flown([phase + i * period for i in range(700)], 600)
    assert max(map(abs, off[300:])) < 0.1 * PERIOD
    assert set(seen[300:]) == {1}


def test_without_poses_every_slot_has_its_tick():
    seen, _ = flown([], 100)
    assert seen == [0] * 100


def test_poses_that_stop_and_come_back_cost_no_tick():
    poses = [i * PERIOD for i in range(600) if not 200 <= i < 300]
    seen, _ = flown(poses, 590)
    assert sum(seen[:320]) <= 220 and set(seen[320:]) == {1}
