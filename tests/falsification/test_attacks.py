"""Every family attacks as it says, on plain floats."""

from math import cos, hypot, isfinite, isnan, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.clearance import Nearest
from fledge.dynamics import P3_DX, UGV_FLEET
from fledge.falsification.attacks import FAMILIES, RAW, SEGMENTS, Attacker, Chance, Mood, Nature, drive
from fledge.geometry import Quat, Vec3
from fledge.observation import StickScale
from fledge.world import Arena, UavState, UgvState, WorldState

STILL = Vec3(0.0, 0.0, 0.0)
CALM = Chance(Vec3(0.3, -0.6, 0.9), Vec3(1.0, -1.0, 0.5), 0.9)
"""Nothing is drawn anew: the odds are far above the period over any pace."""
EAST = Nearest(1.0, 1.0, 0.0, 0.0)
ATTACKER = Attacker(StickScale(), UGV_FLEET, 0.01)
SANE = [name for name in FAMILIES if name != "garbage"]


def nature(family: str, **others) -> Nature:
    usual = {
        "stuck": Vec3(0.2, -0.4, 0.8),
        "trigger": 0.5,
        "pace": 1.0,
        "script": tuple(Vec3(i / SEGMENTS, 0.0, -1.0) for i in range(SEGMENTS)),
        "length": 8.0,
    }
    return Nature(float(list(FAMILIES).index(family)), **(usual | others))


def world(t: float = 0.0, at: tuple[float, float] = (1.0, 2.0), yaw: float = 0.0) -> WorldState:
    """The UGVs stand about the origin."""
    uav = UavState(Vec3(*at, 2.0), STILL, Quat.from_yaw(yaw), STILL, t)
    ugvs = tuple(UgvState(x, 0.0, 0.0, 0.0, 0.0, t) for x in (-1.0, 0.0, 1.0))
    return WorldState(t, uav, ugvs)


def told(what: Nature, now: WorldState, near: Nearest = EAST, chance: Chance = CALM, moods=None):
    moods = moods or ATTACKER.init(0.0)
    return ATTACKER.act(moods, what, Arena.square(), now, (near,) * 4, (chance,) * 4)


numbers = st.floats(-1.0, 1.0)


@given(
    family=st.sampled_from(SANE),
    numbers=st.tuples(*[numbers] * 6),
    odds=st.floats(0.0, 1.0),
    t=st.floats(0.0, 20.0),
    yaw=st.floats(-pi, pi),
)
def test_sane_families_stay_within_full_speed(family, numbers, odds, t, yaw):
    a, b, c, d, e, f = numbers
    size = hypot(a, b, c) or 1.0
    near = Nearest(0.3, a / size, b / size, c / size)
    chance = Chance(Vec3(d, e, f), Vec3(3.0 * d, 3.0 * e, 3.0 * f), odds)
    _, commands = told(nature(family, stuck=Vec3(d, e, f)), world(t, yaw=yaw), near, chance)
    uav = commands.uav
    assert max(abs(uav.forward), abs(uav.left)) <= 1.0 and abs(uav.up) <= 0.5 and abs(uav.turn) <= 1.0
    for command in commands.ugvs:
        assert all(isfinite(x) for x in (command.forward, command.turn))
        assert command.left == command.up == 0.0


def test_full_speed_goes_at_the_nearest_thing():
    _, commands = told(nature("nearest-wall"), world(yaw=pi / 2))
    assert (commands.uav.forward, commands.uav.left) == pytest.approx((0.0, -1.0), abs=1e-12)
    assert [ugv.forward for ugv in commands.ugvs] == pytest.approx([m.max_speed for m in UGV_FLEET])


def test_a_late_reverse_turns_round_at_its_trigger_and_comes_again():
    what, moods, ways = nature("late-reverse", trigger=0.5), None, []
    for gap in (1.0, 0.6, 0.4, 0.6, 1.1, 1.3, 1.0):
        moods, commands = told(what, world(), EAST._replace(gap=gap), moods=moods)
        ways.append(commands.uav.forward)
    assert ways == [1.0, 1.0, -1.0, -1.0, -1.0, 1.0, 1.0]


def test_a_flipped_policy_flees_from_the_ugvs():
    _, commands = told(nature("sign-flipped"), world(at=(0.2, -0.3)))
    assert commands.uav.forward > 0.0 > commands.uav.left


def test_bang_bang_goes_for_the_nearest_corner_from_two_sides():
    ways = [told(nature("corner"), world(t, at=(-1.0, 1.0)))[1].uav for t in (0.0, 1.0, 2.0, 3.0)]
    assert [(way.forward, way.left) for way in ways] == [(-1.0, 0.0), (0.0, 1.0), (-1.0, 1.0), (1.0, -1.0)]


def test_a_delayed_policy_goes_where_the_nearest_thing_was():
    what, draw = nature("delayed"), CALM._replace(odds=0.0)
    moods, _ = told(what, world(), EAST, draw)
    _, commands = told(what, world(), EAST._replace(x=-1.0), moods=moods)
    assert commands.uav.forward == 1.0


def test_what_is_random_is_held_for_a_while():
    what, draw = nature("random"), CALM._replace(odds=0.0)
    moods, first = told(what, world(), chance=draw)
    other = CALM._replace(uniform=Vec3(-1.0, -1.0, -1.0))
    _, second = told(what, world(), chance=other, moods=moods)
    assert first == second
    assert first.ugvs[1].forward == pytest.approx(0.3 * P3_DX.max_speed)
    assert first.ugvs[1].turn == pytest.approx(-0.6 * P3_DX.max_turn_rate)


def test_garbage_is_no_number_or_none_that_a_vehicle_knows():
    seen = [
        told(nature("garbage"), world(), chance=CALM._replace(odds=i / 20))[1].uav.forward for i in range(20)
    ]
    assert any(map(isnan, seen)) and {float("inf"), -1e30, 1e30} <= set(seen) and 1.0 in seen


def test_stuck_is_stuck():
    first, second = (
        told(nature("stuck"), world(t), EAST._replace(x=x))[1] for t, x in ((0.0, 1.0), (7.0, 0.0))
    )
    assert first == second


@pytest.mark.parametrize("i", range(SEGMENTS))
def test_a_script_is_read_segment_by_segment(i):
    _, commands = told(nature("search"), world(t=i + 0.5))
    assert commands.uav.forward == pytest.approx(i / SEGMENTS)
    assert commands.uav.up == -0.5


def test_ornstein_uhlenbeck_keeps_its_variance():
    moods = (Mood(STILL, Vec3(0.5, 0.5, 0.5), STILL, 0.0),) * 4
    after, _ = told(nature("ornstein-uhlenbeck", pace=0.1), world(), chance=CALM, moods=moods)
    keep = 0.9
    assert after[0].drift.x == pytest.approx(0.5 * keep + (1.0 - keep**2) ** 0.5)


@given(heading=st.floats(-7.0, 7.0), way=st.floats(-pi, pi))
def test_a_ugv_turns_to_a_direction_nose_or_tail_first(heading, way):
    ugv = UgvState(0.0, 0.0, heading, 0.0, 0.0, 0.0)
    command = drive(P3_DX, ugv, Vec3(cos(way), sin(way), 0.0))
    gain = command.forward * (cos(heading) * cos(way) + sin(heading) * sin(way))
    assert gain >= -1e-9, "it never drives away from where it should go"
    error = (way - heading + pi / 2.0) % pi - pi / 2.0
    assert command.turn == pytest.approx(4.0 * error, abs=1e-6) or abs(abs(error) - pi / 2.0) < 1e-6


def test_families_that_drive_ugvs_directly_exist():
    assert set(RAW) <= set(FAMILIES)
