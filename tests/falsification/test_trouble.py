"""Trouble stays within the contract as long as its share does, and points where it hurts."""

from dataclasses import replace
from math import hypot

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.clearance import Nearest
from fledge.dynamics import UGV_FLEET
from fledge.falsification.trouble import WEAKEST, Line, Link, Trouble, measured, push, weakened
from fledge.geometry import Quat, Vec3
from fledge.safety import Contract, UavStop, UgvStop
from fledge.world import UavState, UgvState, VelocityCommand, WorldState

CONTRACT = Contract()
WORLD = WorldState(
    1.0,
    UavState(Vec3(1.0, 2.0, 3.0), Vec3(0.5, 0.0, 0.0), Quat(1.0, 0.0, 0.0, 0.0), Vec3(0.1, 0.2, 0.3), 1.0),
    tuple(UgvState(i, 0.0, 0.4, 0.3, 0.2, 1.0) for i in range(3)),
)
EAST = (Nearest(1.0, 1.0, 0.0, 0.0),) * 4


def trouble(share: float = 1.0, malice: float = 1.0, way=(0.0, 0.6, 0.8)) -> Trouble:
    return Trouble(5.0, 5.0, share, malice, Vec3(*way), 0.0)


def length(v: Vec3) -> float:
    return hypot(v.x, v.y, v.z)


shares = st.floats(0.0, 1.0)
ways = st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda way: hypot(*way) > 0.1)


@given(share=shares, malice=st.sampled_from((0.0, 1.0)), way=ways)
def test_what_is_seen_is_within_the_contract(share, malice, way):
    unit = tuple(x / hypot(*way) for x in way)
    seen = measured(CONTRACT, trouble(share, malice, unit), WORLD, EAST, 1.05)
    rounding = 1e-12
    assert seen.t == 1.05 and seen.uav.stamp == 1.0, "it is old, and says so"
    assert length(seen.uav.position - WORLD.uav.position) <= CONTRACT.position_error + rounding
    assert length(seen.uav.velocity - WORLD.uav.velocity) <= CONTRACT.velocity_error + rounding
    assert length(seen.uav.rates - WORLD.uav.rates) <= CONTRACT.rate_error + rounding
    roll, pitch, _ = seen.uav.attitude.tilt()
    assert hypot(roll, pitch) <= CONTRACT.angle_error * 1.001
    for ugv, true in zip(seen.ugvs, WORLD.ugvs, strict=True):
        assert hypot(ugv.x - true.x, ugv.y - true.y) <= CONTRACT.position_error + rounding
        assert abs(ugv.heading - true.heading) <= CONTRACT.angle_error + rounding
        assert abs(ugv.speed - true.speed) <= CONTRACT.velocity_error + rounding
        assert abs(ugv.turn_rate - true.turn_rate) <= CONTRACT.rate_error + rounding


def test_malice_makes_things_farther_and_vehicles_slower():
    seen = measured(CONTRACT, trouble(), WORLD, EAST, 1.0)
    assert seen.uav.position.x == pytest.approx(1.0 - CONTRACT.position_error)
    assert seen.uav.velocity.x == pytest.approx(0.5 - CONTRACT.velocity_error)
    assert [ugv.speed for ugv in seen.ugvs] == pytest.approx([0.3 - CONTRACT.velocity_error] * 3)


@given(share=shares, malice=st.sampled_from((0.0, 1.0)))
def test_a_push_is_within_the_contract_and_in_malice_towards_what_is_near(share, malice):
    pushed = push(CONTRACT, trouble(share, malice), EAST[0])
    assert length(pushed) == pytest.approx(share * CONTRACT.disturbance)
    assert (pushed.x > 0.0) == (malice > 0.0 and share * CONTRACT.disturbance > 0.0)


def test_ugvs_brake_less_but_always_brake():
    within = weakened(UGV_FLEET, CONTRACT, trouble())
    assert [model.acceleration for model in within] == pytest.approx([1.0 - CONTRACT.disturbance] * 3)
    beyond = weakened(UGV_FLEET, CONTRACT, trouble(share=10.0))
    assert [model.acceleration for model in beyond] == [WEAKEST] * 3


def test_a_line_keeps_what_was_late_ticks_ago():
    line = Line.full_of(-1.0, 4)
    for tick in range(10):
        line = line.then(float(tick))
        assert [line.late(float(late)) for late in range(4)] == [max(tick - late, -1.0) for late in range(4)]


def test_a_lost_link_holds_the_last_command_then_nothing_and_comes_back():
    stop = replace(UgvStop.of(UGV_FLEET[0]), hold_over=0.03, silence=0.06)
    told = [VelocityCommand(float(i), 0.0, 0.0, 0.0) for i in range(1, 10)]
    link, done = Link(0.0, VelocityCommand.hover()), []
    for i, command in enumerate(told):
        link, did = link.then(i == 2, command, stop, 0.01)
        done.append(did.forward)
    assert done[:4] == [1.0, 2.0, 2.0, 2.0]
    assert 0.0 in done and done[-1] == 9.0
    assert UavStop().silence > 0.0
