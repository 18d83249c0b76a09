"""The robots' computers: what they were told is what the robots do, skidding or not; and what they do in a silence."""

from math import hypot, inf

import pytest
from workbench import CALM, room

from fledge.dynamics import UGV_FLEET
from fledge.lab.twin.bodies import BASES, NAMES
from fledge.lab.twin.drivers import DRIVERS, Driver, Memory
from fledge.scalars import clip

pytestmark = pytest.mark.slow

TICK = 0.01
EVEN = (room().airframe.weight * 0.25,) * 4
GENTLE = ((0.0, 0.2), (0.0, 1.0), (0.0, -1.5), (0.3, 0.3), (0.3, 1.0), (-0.3, 0.5), (0.6, 0.5))
"""Speeds and turn rates of the guidance, but for turning its fastest while driving its fastest."""


def driven(speed, turn, seconds=3.0, silent_from=inf):
    """The three robots' states, tick by tick, told the same all the time."""
    plant, memories, found = room(), [Memory()] * len(DRIVERS), []
    for i in range(round(seconds / TICK)):
        t = i * TICK
        if t < silent_from:
            memories = [d.hear(m, t, speed, turn) for d, m in zip(DRIVERS, memories, strict=True)]
        steps = [d.step(m, t, TICK) for d, m in zip(DRIVERS, memories, strict=True)]
        memories = [memory for memory, _ in steps]
        plant.drive([wheels for _, wheels in steps])
        for _ in range(5):
            plant.step(EVEN, CALM)
        found.append(plant.world(t).ugvs)
    return found


def mean(states, robot, name):
    """Over the last second."""
    return sum(getattr(state[robot], name) for state in states[-100:]) / 100.0


@pytest.mark.parametrize("told", GENTLE)
def test_they_drive_and_turn_as_they_are_told_skidding_or_not(told):
    speed, turn = told
    states = driven(speed, turn)
    for robot in range(len(NAMES)):
        assert mean(states, robot, "speed") == pytest.approx(speed, rel=0.03, abs=2e-3)
        assert mean(states, robot, "turn_rate") == pytest.approx(turn, rel=0.03, abs=2e-3)


def test_with_the_track_of_its_wheels_the_skidding_one_would_turn_too_little():
    assert BASES[0].track > 1.4 * 2.0 * BASES[0].half_track


def test_in_a_silence_they_go_on_for_six_tenths_of_a_second_and_stop():
    states = driven(0.5, 0.0, seconds=2.4, silent_from=1.0)
    for robot in range(len(NAMES)):
        speeds = [state[robot].speed for state in states]
        assert speeds[round(1.55 / TICK)] == pytest.approx(0.5, rel=0.03)
        assert abs(speeds[-1]) < 0.01


@pytest.mark.parametrize("told", [(-0.1, -0.13), (-0.14, -0.31), (-0.18, -0.49), (0.01, -0.23), (0.03, 0.37)])
def test_who_has_stopped_stands(told):
    """A servo that rattles drives its robot, which creeps away at centimetres per second."""
    states = driven(*told, seconds=5.0, silent_from=1.0)
    for robot in range(len(NAMES)):
        begin, end = states[round(3.0 / TICK)][robot], states[-1][robot]
        assert hypot(end.x - begin.x, end.y - begin.y) < 1e-3
        assert end.heading == pytest.approx(begin.heading, abs=2e-3)


def test_they_brake_no_later_than_nets_count_on():
    told = 0.6
    states = driven(told, 0.0, seconds=2.6, silent_from=1.0)
    for robot, model in enumerate(UGV_FLEET):
        begin, end = states[round(1.62 / TICK)][robot], states[-1][robot]
        assert end.x - begin.x < told * told / (2.0 * model.acceleration)


def test_no_robot_is_told_more_than_it_can():
    for driver in DRIVERS:
        memory = driver.hear(Memory(), 0.0, 99.0, -99.0)
        hull = driver.base.hull
        assert memory.told == (hull.max_speed, -hull.max_turn_rate)


def test_a_robot_that_was_never_told_anything_stands():
    memory, wheels = DRIVERS[0].step(Memory(), 0.0, TICK)
    assert (memory.speed, memory.turn, wheels) == (0.0, 0.0, (0.0, 0.0))


def test_accelerations_are_bounded_and_braking_is_harder():
    driver = Driver(BASES[1])
    memory, speeds = driver.hear(Memory(), 0.0, 1.0, 0.0), []
    for i in range(100):
        t = i * TICK
        memory = driver.hear(memory, t, 1.0 if t < 0.5 else -1.0, 0.0)
        memory, _ = driver.step(memory, t, TICK)
        speeds.append(memory.speed)
    changes = [(b - a) / TICK for a, b in zip(speeds, speeds[1:], strict=False)]
    assert max(changes) == pytest.approx(driver.speeding_up)
    assert min(changes) == pytest.approx(-driver.braking)


def test_wheels_turn_as_the_geometry_has_it():
    driver, base = DRIVERS[1], BASES[1]
    memory = Memory(speed=0.5, turn=1.0, told=(0.5, 1.0), heard=0.0)
    _, (left, right) = driver.step(memory, 0.0, TICK)
    assert (left + right) * base.wheel_radius / 2.0 == pytest.approx(0.5)
    assert (right - left) * base.wheel_radius / base.track == pytest.approx(1.0)
    assert clip(left, 0.0, right) == left  # to the left: the right wheel is the faster one
