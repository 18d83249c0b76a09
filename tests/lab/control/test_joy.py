"""A gamepad in a person's hands: each button says one thing, and the sticks go where the thumb does."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.lab import Malformed
from fledge.lab.control.joy import Gamepad, Memory
from fledge.lab.wire.messages import Header, Joy
from fledge.observation import StickScale
from fledge.supervision.inputs import Operator, said, sane
from fledge.world import VelocityCommand

PAD = Gamepad(vehicles=4)
A, B, X, Y, LB, BACK, START = 0, 1, 2, 3, 4, 6, 7
FLAGS = ("switch", "hand_back", "stop", "dead_man", "arm", "land", "terminate")


def pad(*pressed: int, axes: dict[int, float] | None = None) -> Joy:
    return Joy(
        Header(),
        tuple((axes or {}).get(i, 0.0) for i in range(8)),
        tuple(int(i in pressed) for i in range(11)),
    )


def after(*messages: Joy) -> tuple[Operator, ...]:
    memory = PAD.init()
    operators: tuple[Operator, ...] | Malformed = ()
    for message in messages:
        memory, operators = PAD.step(memory, message)
    assert not isinstance(operators, Malformed)
    return operators


def flags(operator: Operator) -> set[str]:
    return {name for name in FLAGS if said(getattr(operator, name))}


@pytest.mark.parametrize(
    ("pressed", "to_uav", "to_ugvs"),
    (
        ((), set(), set()),
        ((A,), {"land"}, {"land"}),
        ((B,), {"stop"}, {"stop"}),
        ((X,), {"hand_back"}, {"hand_back"}),
        ((Y,), {"switch"}, set()),
        ((LB,), {"dead_man"}, set()),
        ((BACK,), set(), set()),
        ((BACK, B), {"terminate", "stop"}, {"terminate", "stop"}),
        ((START,), {"arm"}, {"arm"}),
    ),
)
def test_a_button_says_what_is_written_on_it(pressed, to_uav, to_ugvs):
    uav, *ugvs = after(pad(), pad(*pressed))
    assert flags(uav) == to_uav
    assert [flags(ugv) for ugv in ugvs] == [to_ugvs] * 3


def test_what_is_let_go_is_unsaid_but_for_the_arming():
    uav, *_ = after(pad(), pad(*range(8)), pad())
    assert flags(uav) == set()
    uav, *_ = after(pad(), pad(START), pad())
    assert flags(uav) == {"arm"}


def test_landing_disarms_and_arming_takes_a_new_press():
    landed = (pad(), pad(START), pad(), pad(A))
    assert flags(after(*landed, pad())[0]) == set()
    assert flags(after(*landed, pad(), pad(START))[0]) == {"arm"}
    assert flags(after(pad(), pad(START, A), pad(START))[0]) == set()


def test_a_button_that_was_held_from_the_start_arms_nothing():
    assert flags(after(pad(START), pad(START))[0]) == set()
    assert flags(after(pad(START), pad(), pad(START))[0]) == {"arm"}


@pytest.mark.parametrize(
    ("axis", "name", "full"), ((4, "forward", 1.0), (3, "left", 1.0), (1, "up", 0.5), (0, "turn", 1.0))
)
def test_a_stick_goes_where_the_thumb_does(axis, name, full):
    uav, *ugvs = after(pad(axes={axis: 1.0}))
    hover = VelocityCommand.hover()
    expected = {field: 0.0 for field in ("forward", "left", "up", "turn")} | {name: full}
    assert uav.command == VelocityCommand(**expected)
    assert uav.deflection == 1.0
    assert all(ugv.command == hover and ugv.deflection == 0.0 for ugv in ugvs)


def test_the_farthest_stick_counts_and_triggers_do_not():
    uav, *_ = after(pad(axes={0: 0.25, 1: -0.75, 3: 0.5, 2: 1.0, 5: 1.0}))
    assert uav.deflection == 0.75


@given(st.lists(st.floats(-1.0, 1.0), min_size=8, max_size=8))
def test_no_stick_asks_for_more_than_full_speed(axes):
    full = StickScale(0.5, 0.25, 2.0)
    _, (uav, *_) = Gamepad(1, full).step(Memory(), Joy(Header(), tuple(axes), (0,) * 11))
    command = uav.command
    assert math.hypot(command.forward / 0.5, command.left / 0.5) <= math.sqrt(2.0)
    assert abs(command.up) <= 0.25 and abs(command.turn) <= 2.0
    assert 0.0 <= uav.deflection <= 1.0


@pytest.mark.parametrize("axis", (0, 1, 3, 4))
def test_a_broken_stick_is_seen_to_be_broken(axis):
    uav, *ugvs = after(pad(axes={axis: math.nan}))
    assert not sane(uav)
    assert all(sane(ugv) for ugv in ugvs)


def test_another_device_says_nothing():
    memory, found = PAD.step(Memory(armed=True), Joy(Header(), (0.0,) * 4, (1,) * 8))
    assert memory == Memory(armed=True)
    assert found == Malformed("a device of 4 axes and 8 buttons: valid is at least 5 and 8")
