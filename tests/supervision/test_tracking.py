"""Which poses are believed."""

from dataclasses import fields, is_dataclass, replace
from math import inf, nan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fledge.geometry import Quat, Vec3
from fledge.supervision.tracking import LEAD, Motion, Tracker
from fledge.world import Reason, UavState, UgvState, WorldState

TICK = 0.01
TRACKER = Tracker()
STILL = Vec3(0.0, 0.0, 0.0)


def uav(stamp, x=0.0, y=0.0, z=2.0, velocity=STILL) -> UavState:
    return UavState(Vec3(x, y, z), velocity, Quat(1.0, 0.0, 0.0, 0.0), STILL, stamp)


def ugv(stamp, x=2.0, y=0.0, speed=0.0) -> UgvState:
    return UgvState(x, y, 0.0, speed, 0.0, stamp)


def world(now, flyer, *drivers) -> WorldState:
    return WorldState(now, flyer, drivers)


class Stream:
    """Poses fed one by one to the tracker."""

    def __init__(self, *vehicles):
        self.tracks = TRACKER.init(world(0.0, *vehicles))

    def feed(self, now, *vehicles):
        """What came of each vehicle's sample."""
        self.tracks, sights = TRACKER.follow(self.tracks, world(now, *vehicles), now)
        return sights

    def trusted(self, i=0):
        return self.tracks[i].trusted


def test_what_is_in_good_order_is_believed():
    stream = Stream(uav(0.0), ugv(0.0))
    for i in range(1, 200):
        t = i * TICK
        moved = uav(t, x=1.5 * t, velocity=Vec3(1.5, 0.0, 0.0)), ugv(t, x=2.0 - 0.8 * t, speed=-0.8)
        for sight in stream.feed(t, *moved):
            assert (sight.dropped, sight.elsewhere, sight.contradicts) == (0, 0, False)
        assert (stream.trusted(0), stream.trusted(1)) == moved


def paths(record, *above):
    """Every number in a record, by its way there."""
    for field in fields(record):
        value = getattr(record, field.name)
        if is_dataclass(value):
            yield from paths(value, *above, field.name)
        else:
            yield (*above, field.name)


def put(record, path, value):
    name, *rest = path
    return replace(record, **{name: put(getattr(record, name), rest, value) if rest else value})


@pytest.mark.parametrize("bad", (nan, inf, -inf, 1e30))
@pytest.mark.parametrize("path", list(paths(uav(0.0))), ids=".".join)
def test_a_number_that_is_none_anywhere_in_the_uav_drops_the_sample(path, bad):
    stream = Stream(uav(0.0))
    (sight,) = stream.feed(TICK, put(uav(TICK), path, bad))
    assert sight.dropped > 0 and stream.trusted() == uav(0.0)
    if path != ("stamp",):
        assert sight.dropped == Reason.BAD_POSE
    (sight,) = stream.feed(2 * TICK, uav(2 * TICK))
    assert not sight.dropped and stream.trusted() == uav(2 * TICK)


@pytest.mark.parametrize("bad", (nan, inf, -inf))
@pytest.mark.parametrize("path", list(paths(ugv(0.0))), ids=".".join)
def test_a_number_that_is_none_anywhere_in_a_ugv_drops_the_sample(path, bad):
    stream = Stream(uav(0.0), ugv(0.0))
    _, sight = stream.feed(TICK, uav(TICK), put(ugv(TICK), path, bad))
    assert sight.dropped > 0 and stream.trusted(1) == ugv(0.0)
    _, sight = stream.feed(2 * TICK, uav(2 * TICK), ugv(2 * TICK))
    assert not sight.dropped and stream.trusted(1) == ugv(2 * TICK)


@pytest.mark.parametrize("bad", (nan, inf))
@pytest.mark.parametrize("path", list(paths(uav(0.0))), ids=".".join)
def test_a_bad_beginning_heals(path, bad):
    """Nothing of it stays in the memory."""
    stream = Stream(put(uav(0.0), path, bad))
    for i in range(1, 150):
        (sight,) = stream.feed(i * TICK, uav(i * TICK))
    assert (sight.dropped, sight.elsewhere, sight.contradicts) == (0, 0, False)
    assert stream.trusted() == uav(i * TICK)


def test_units_that_slipped_are_out_of_this_world():
    stream = Stream(uav(0.0, x=0.5))
    (sight,) = stream.feed(TICK, uav(TICK, x=500.0, z=2000.0))
    assert sight.dropped == Reason.BAD_POSE


def test_a_little_ahead_of_the_clock_is_no_future():
    stream = Stream(uav(0.0))
    assert not stream.feed(1.0, uav(1.0 + 0.9 * LEAD))[0].dropped
    assert stream.feed(1.01, uav(1.01 + 1.1 * LEAD))[0].dropped == Reason.FUTURE
    assert stream.trusted().stamp == 1.0 + 0.9 * LEAD


def test_what_was_measured_before_is_dropped():
    stream = Stream(uav(1.0))
    assert stream.feed(1.01, uav(0.5))[0].dropped == Reason.BACKWARD
    assert not stream.feed(1.02, uav(1.02))[0].dropped


def test_the_same_sample_again_is_no_news_and_no_fault():
    stream = Stream(uav(1.0))
    for i in range(100):
        assert not stream.feed(1.0 + i * TICK, uav(1.0))[0].dropped
    assert stream.trusted().stamp == 1.0


def test_one_stamp_in_two_places_is_a_fault():
    stream = Stream(uav(1.0))
    assert stream.feed(1.01, uav(1.0, x=0.01))[0].dropped == Reason.DUPLICATE
    assert stream.trusted() == uav(1.0)


@pytest.mark.parametrize("far", (0.5, 5.0, 90.0))
def test_who_jumps_and_jumps_back_is_believed_at_once(far):
    stream = Stream(uav(0.0))
    for i in range(1, 50):
        (sight,) = stream.feed(i * TICK, uav(i * TICK, y=far))
        assert sight.dropped == Reason.JUMP and stream.trusted() == uav(0.0)
    (sight,) = stream.feed(0.5, uav(0.5, y=0.01))
    assert (sight.dropped, sight.elsewhere, sight.contradicts) == (0, 0, False)
    assert stream.trusted() == uav(0.5, y=0.01)


@pytest.mark.parametrize("far", (0.5, 5.0, 90.0))
def test_who_jumps_and_stays_is_believed_in_the_end_and_reported(far):
    stream, reported = Stream(uav(0.0)), []
    for i in range(1, 300):
        t = i * TICK
        (sight,) = stream.feed(t, uav(t, y=far))
        assert bool(sight.dropped) == (t < TICK + TRACKER.patience - 1e-9)
        if sight.elsewhere:
            reported.append((t, sight.elsewhere))
    assert reported == [(pytest.approx(TICK + TRACKER.patience), Reason.JUMP)]
    assert stream.trusted() == uav(t, y=far)


def test_who_never_stays_is_never_believed_elsewhere():
    stream = Stream(uav(0.0))
    for i in range(1, 500):
        (sight,) = stream.feed(i * TICK, uav(i * TICK, y=5.0 + 3.0 * (i // 50 % 2)))
        assert sight.dropped == Reason.JUMP and not sight.elsewhere
    assert stream.trusted() == uav(0.0)


def test_after_a_gap_a_vehicle_may_be_as_far_as_it_can_go():
    reach = TRACKER.fastest * 0.4 + 3.0 * TRACKER.contract.position_error
    for far, dropped in ((0.99 * reach, 0), (1.01 * reach, Reason.JUMP)):
        stream = Stream(uav(0.0))
        assert stream.feed(0.4, uav(0.4, x=far))[0].dropped == dropped


def test_two_that_change_places_are_swapped_until_they_change_back():
    stream = Stream(uav(0.0), ugv(0.0, x=2.0), ugv(0.0, x=-2.0))
    for i in range(1, 40):
        t = i * TICK
        sights = stream.feed(t, uav(t), ugv(t, x=-2.0), ugv(t, x=2.0))
        assert [s.dropped for s in sights] == [0, Reason.SWAP, Reason.SWAP]
    sights = stream.feed(0.4, uav(0.4), ugv(0.4, x=2.0), ugv(0.4, x=-2.0))
    assert [s.dropped for s in sights] == [0, 0, 0]


def test_a_swap_that_stays_is_reported_for_both():
    stream, reported = Stream(uav(0.0, x=0.0), ugv(0.0, x=2.0)), []
    for i in range(1, 200):
        t = i * TICK
        sights = stream.feed(t, uav(t, x=2.0, z=0.0), ugv(t, x=0.0))
        reported += [(i, s.elsewhere) for s in sights if s.elsewhere]
    assert reported == [(101, Reason.SWAP)] * 2


def test_who_jumps_alone_to_where_another_stands_is_not_swapped():
    stream = Stream(uav(0.0), ugv(0.0, x=2.0), ugv(0.0, x=-2.0))
    sights = stream.feed(TICK, uav(TICK), ugv(TICK, x=-2.0), ugv(TICK, x=-2.0))
    assert [s.dropped for s in sights] == [0, Reason.JUMP, 0]


TIMES = np.arange(0.0, 8.0, TICK)


def wandering(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """(positions, velocities), (ticks, 3), of a vehicle that accelerates by up to 2 m/s^2 and goes up to 2 m/s."""
    velocity, velocities = np.zeros(3), []
    for i in range(len(TIMES)):
        if i % 30 == 0:
            push = rng.normal(size=3)
            push *= 2.0 / np.linalg.norm(push)
        velocity = velocity + push * TICK
        velocity *= min(1.0, 2.0 / np.linalg.norm(velocity))
        velocities.append(velocity)
    velocities = np.array(velocities)
    return np.cumsum(velocities, axis=0) * TICK, velocities


def of_length(rng: np.random.Generator, most: float) -> np.ndarray:
    """Vectors (ticks, 3) of that length: the worst that an error bound allows."""
    v = rng.normal(size=(len(TIMES), 3))
    return most * v / np.linalg.norm(v, axis=1, keepdims=True)


@pytest.mark.slow
@given(st.integers(0, 10_000))
def test_within_the_errors_that_are_allowed_nothing_is_dropped(seed):
    """Noisy positions, a velocity that is wrong by as much as it may be, always the same way, samples missing."""
    rng = np.random.default_rng(seed)
    places, velocities = wandering(rng)
    places = places + of_length(rng, TRACKER.contract.position_error)
    velocities = velocities + of_length(rng, TRACKER.contract.velocity_error)[0]
    kept = rng.uniform(size=len(TIMES)) < rng.uniform(0.3, 1.0)
    samples = [
        uav(t, *p, velocity=Vec3(*v))
        for t, p, v in zip(*(a[kept].tolist() for a in (TIMES, places, velocities)), strict=True)
    ]
    stream = Stream(samples[0])
    for sample in samples[1:]:
        (sight,) = stream.feed(sample.stamp, sample)
        assert not sight.dropped and not sight.contradicts


@pytest.mark.slow
@settings(max_examples=30)
@given(st.floats(0.0, 2.0 * np.pi), st.floats(0.33, 3.0), st.floats(-1.0, 1.0))
def test_a_velocity_that_is_wrong_by_more_is_found(direction, wrong, speed):
    """e_v + 5 e_p / T = 0.3 m/s, noise not counted; the sum comes within 1 % of its end in five windows."""
    error = Vec3(wrong * np.cos(direction), wrong * np.sin(direction), 0.0)
    stream, found = Stream(uav(0.0)), False
    for i in range(1, 260):
        t = i * TICK
        (sight,) = stream.feed(t, uav(t, x=speed * t, velocity=Vec3(speed, 0.0, 0.0) + error))
        assert not sight.dropped, "either may be right"
        found = found or sight.contradicts
    assert found


@pytest.mark.parametrize("speed", (-0.6, -0.2, 0.2, 0.6))
def test_a_ugv_that_drives_the_other_way_is_found(speed):
    stream = Stream(uav(0.0), ugv(0.0))
    for i in range(1, 260):
        t = i * TICK
        _, sight = stream.feed(t, uav(t), ugv(t, x=2.0 + speed * t, speed=-speed))
    assert sight.contradicts


def test_a_contradiction_passes():
    stream = Stream(uav(0.0))
    for i in range(1, 400):
        velocity = Vec3(1.0, 0.0, 0.0) if i < 100 else STILL
        (sight,) = stream.feed(i * TICK, uav(i * TICK, velocity=velocity))
        assert i != 50 or sight.contradicts
    assert not sight.contradicts


def test_a_jump_is_no_contradiction():
    stream = Stream(uav(0.0))
    assert not any(stream.feed(i * TICK, uav(i * TICK, x=5.0))[0].contradicts for i in range(1, 300))


@pytest.mark.parametrize("dt", (-1.0, -0.5, -1e-9, 0.0))
def test_no_stamp_makes_it_raise(dt):
    stream = Stream(uav(5.0))
    stream.feed(5.01, uav(5.0 + dt, x=0.3))
    assert not stream.feed(5.02, uav(5.02))[0].dropped


def test_a_ugv_moves_along_its_nose_on_the_floor():
    motion = Motion.of(UgvState(1.0, 2.0, np.pi / 2, 0.7, 0.1, 3.0))
    assert (motion.position, motion.stamp) == (Vec3(1.0, 2.0, 0.0), 3.0)
    assert motion.velocity == Vec3(pytest.approx(0.0), pytest.approx(0.7), 0.0)
