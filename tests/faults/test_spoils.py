"""What spoilt data look like, on plain floats."""

from dataclasses import replace
from math import inf, nan, pi

import pytest

from fledge.faults.spoils import (
    CLEARLY,
    HOLD_OVERS,
    Moment,
    backwards,
    battery,
    broken_stick,
    clearly_moving,
    clock,
    deaf,
    dropped,
    exchanged,
    mirrored,
    one_field,
    placed,
    poses,
    proposing,
    silent,
    stopped_clock,
    undecided,
)
from fledge.geometry import Quat, Vec3
from fledge.supervision.inputs import HOVER, Inputs
from fledge.supervision.tracking import Motion
from fledge.world import Commands, UavState, UgvState, VelocityCommand, WorldState

WISH = VelocityCommand(0.3, 0.1, 0.0, 0.2)


def world(t: float) -> WorldState:
    """Everybody under way."""
    uav = UavState(
        Vec3(0.1 * t, 1.0, 2.0), Vec3(0.1, 0.5, 0.0), Quat.from_yaw(0.4), Vec3(0.0, 0.1, 0.2), t - 0.03
    )
    return WorldState(t, uav, tuple(UgvState(i + 0.2 * t, -1.0, 0.5, 0.2, 0.1, t - 0.02) for i in range(3)))


def given(t: float) -> Inputs:
    return Inputs.unattended(world(t), Commands(WISH, (WISH,) * 3))


NOW, LAST, PAST = given(5.0), given(4.99), world(4.5)


def at(*struck: int, since: float = 0.2, luck: float = 0.0, odds: float = 0.5) -> Moment:
    flags = tuple(i in struck for i in range(4))
    return Moment(since, flags, luck, odds, LAST, PAST, Commands(WISH, (HOVER, WISH, WISH)))


def states(inputs: Inputs) -> tuple:
    return (inputs.seen.uav, *inputs.seen.ugvs)


POSES = {
    "dropped": dropped(1.0),
    "nan": one_field(nan),
    "past": poses(lambda s: s.past),
    "moved": poses(lambda s: s.moved(s.aside(0.5))),
    "backwards": poses(backwards),
    "mirrored": poses(mirrored),
}


@pytest.mark.parametrize("spoil", POSES.values(), ids=POSES)
@pytest.mark.parametrize("struck", ((), (0,), (2,), (1, 3), (0, 1, 2, 3)), ids=str)
def test_a_pose_is_spoilt_for_those_who_are_struck_and_nothing_else_is(spoil, struck):
    spoilt = spoil(NOW, at(*struck))
    for i, (before, after) in enumerate(zip(states(NOW), states(spoilt), strict=True)):
        assert (after != before) == (i in struck)
    assert replace(spoilt, seen=NOW.seen) == NOW and spoilt.seen.t == NOW.seen.t


def test_a_sample_that_does_not_come_is_the_one_before():
    assert states(dropped(1.0)(NOW, at(0, 2))) == (
        LAST.seen.uav,
        NOW.seen.ugvs[0],
        LAST.seen.ugvs[1],
        NOW.seen.ugvs[2],
    )
    assert dropped(0.1)(NOW, at(0, odds=0.5)) == NOW
    assert dropped(0.1)(NOW, at(0, odds=0.05)).seen.uav == LAST.seen.uav


def test_every_number_of_a_pose_can_be_the_broken_one():
    for vehicle, count in ((0, 14), (1, 6)):
        seen = set()
        for i in range(count):
            broken = states(one_field(inf)(NOW, at(vehicle, luck=(i + 0.5) / count)))[vehicle]
            seen.add(repr(broken))
            assert repr(broken).count("inf") == 1
        assert len(seen) == count


def test_positions_move_one_way():
    moved = poses(lambda s: s.moved(s.aside(0.5)))
    assert moved(NOW, at(0)).seen.uav.position == Vec3(1.0, 1.0, 2.0)
    north = moved(NOW, at(1, luck=0.25)).seen.ugvs[0]
    assert (north.x, north.y) == (pytest.approx(NOW.seen.ugvs[0].x), pytest.approx(-0.5))


def test_two_change_places():
    uav, first, second, third = states(exchanged(NOW, at(1, 3)))
    assert (first.x, third.x) == (NOW.seen.ugvs[2].x, NOW.seen.ugvs[0].x)
    assert (uav, second) == (NOW.seen.uav, NOW.seen.ugvs[1])
    uav, first, _, _ = states(exchanged(NOW, at(0, 1)))
    assert uav.position == Vec3(1.0, -1.0, 0.0) and (first.x, first.y) == (0.5, 1.0)


def test_a_mirrored_world_is_a_mirror_image():
    """Its headings and velocities fit its positions."""
    uav, ugv, *_ = states(poses(mirrored)(NOW, at(0, 1)))
    assert uav.position == Vec3(0.5, -1.0, 2.0) and uav.velocity == Vec3(0.1, -0.5, 0.0)
    assert (uav.attitude.heading().cos, uav.attitude.heading().sin) == (
        pytest.approx(NOW.seen.uav.attitude.heading().cos),
        pytest.approx(-NOW.seen.uav.attitude.heading().sin),
    )
    before, after = Motion.of(NOW.seen.ugvs[0]).velocity, Motion.of(ugv).velocity
    assert (after.x, after.y) == (pytest.approx(before.x), pytest.approx(-before.y))
    twice = poses(mirrored)(poses(mirrored)(NOW, at(0, 1)), at(0, 1))
    assert twice == NOW


def test_who_stands_has_no_velocity_of_the_wrong_sign():
    assert backwards_of(NOW, 0).velocity == Vec3(-0.1, -0.5, 0.0) and backwards_of(NOW, 1).speed == -0.2
    assert clearly_moving(NOW, at(0)) and not clearly_moving(NOW, at(1, 2, 3))
    fast = replace(NOW.seen.ugvs[1], speed=-CLEARLY - 0.01)
    seen = replace(NOW.seen, ugvs=(NOW.seen.ugvs[0], fast, NOW.seen.ugvs[2]))
    assert clearly_moving(replace(NOW, seen=seen), at(2)) and not clearly_moving(NOW, at())


def backwards_of(inputs: Inputs, i: int):
    return states(poses(backwards)(inputs, at(i)))[i]


def test_a_ugv_is_placed_on_the_floor():
    assert placed(NOW.seen.ugvs[0], Vec3(7.0, 8.0, 9.0)) == replace(NOW.seen.ugvs[0], x=7.0, y=8.0)


def test_clocks():
    assert clock(-1.0)(NOW, at()).seen == replace(NOW.seen, t=4.0)
    assert stopped_clock(NOW, at()).seen == replace(NOW.seen, t=4.99)


def test_a_lost_link_and_a_late_policy_repeat_the_last_word():
    assert silent(NOW, at()) == replace(NOW, heard=4.99, operators=LAST.operators)
    assert undecided(NOW, at()) == replace(NOW, decided=4.99, proposed=LAST.proposed)


def test_garbage_on_every_axis():
    proposed = proposing(1e30)(NOW, at(0, 2)).proposed
    garbage = VelocityCommand(1e30, 1e30, 1e30, 1e30)
    assert proposed == Commands(garbage, (WISH, garbage, WISH))


def test_a_stick_and_a_battery():
    broken = broken_stick(NOW, at(0))
    assert repr(broken.operators[0]).count("nan") == 1 and broken.operators[1:] == NOW.operators[1:]
    assert battery(0.1)(NOW, at(3)).batteries == (1.0, 1.0, 1.0, 0.1)


def test_who_hears_nothing_goes_on_for_as_long_as_its_watchdog_lets_it():
    told = Commands(VelocityCommand(0.5, 0.0, 0.0, 0.0), (WISH, HOVER, HOVER))
    for since in (0.0, 0.04, 0.06, 0.5, 0.7):
        obeyed = deaf(told, at(0, 2, since=since))
        assert obeyed.uav == (WISH if since < HOLD_OVERS[0] else HOVER)
        assert obeyed.ugvs == (WISH, WISH if since < HOLD_OVERS[1] else HOVER, HOVER)


def test_one_way_is_drawn_for_a_whole_flight():
    for luck in (0.0, 0.3, 0.9):
        seen = poses(lambda s: s.moved(s.aside(1.0)))(NOW, at(0, luck=luck)).seen.uav.position
        assert (seen.x - 0.5) ** 2 + (seen.y - 1.0) ** 2 == pytest.approx(1.0), luck * 2.0 * pi
