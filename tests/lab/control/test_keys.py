"""Keys: what each says and for how long, that hands off is hands off, and that a terminal's bytes are put together."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.lab.control.keys import (
    DOWN,
    GO,
    HAND_BACK,
    HELP,
    LAND,
    LEFT,
    RIGHT,
    STICKS,
    STOP,
    TAKE_OVER,
    TERMINATE,
    UP,
    Keyboard,
    split,
)
from fledge.supervision.inputs import HOVER, sane
from fledge.supervision.supervisor import Supervisor

BOARD = Keyboard(4)
EVERYTHING = st.sampled_from([*STICKS, GO, HAND_BACK, LAND, STOP, TAKE_OVER, TERMINATE, "x", "\x1b"])


def after(*keys, wait=0.0, board=BOARD):
    """What is said a while after these keys, a tenth of a second apart."""
    memory, t = board.init(), 0.0
    for key in keys:
        t += 0.1
        memory = board.press(memory, key, t)
    return board.says(memory, t + wait)


def test_who_touches_nothing_says_nothing():
    assert {operator.command for operator in after()} == {HOVER}
    assert all(vars_of(operator) == {"command"} for operator in after())


def vars_of(operator):
    """Fields that say something."""
    return {"command"} | {
        name for name in ("deflection", "switch", "hand_back", "stop", "dead_man", "arm", "land", "terminate")
        if getattr(operator, name)
    }  # fmt: skip


@pytest.mark.parametrize(
    ("keys", "axis", "sign"),
    [
        (("w", UP), "forward", 1),
        (("s", DOWN), "forward", -1),
        (("a", LEFT), "left", 1),
        (("d", RIGHT), "left", -1),
        (("r",), "up", 1),
        (("f",), "up", -1),
        (("q",), "turn", 1),
        (("e",), "turn", -1),
    ],
)
def test_stick_keys_move_the_uav_alone_and_far_enough_to_take_over(keys, axis, sign):
    for key in keys:
        uav, *ugvs = after(key)
        moved = {name: getattr(uav.command, name) for name in ("forward", "left", "up", "turn")}
        assert sign * moved.pop(axis) > 0.0 and not any(moved.values())
        assert uav.deflection > Supervisor().taking
        assert {(ugv.command, ugv.deflection) for ugv in ugvs} == {(HOVER, 0.0)}


def test_a_key_let_go_is_hands_off():
    """And it outlasts the pause before a keyboard repeats, so that a key held is held."""
    assert after("w", wait=0.66)[0].deflection > 0.0
    let_go = after("w", wait=0.8)[0]
    assert let_go.command == HOVER and let_go.deflection <= Supervisor().neutral


@pytest.mark.parametrize(
    ("key", "flag"), [(LAND, "land"), (STOP, "stop"), (HAND_BACK, "hand_back"), (TERMINATE, "terminate")]
)
def test_orders_are_said_to_all_and_for_a_while(key, flag):
    assert all(getattr(operator, flag) == 1.0 for operator in after(key, wait=0.1))
    assert not any(getattr(operator, flag) for operator in after(key, wait=1.0))


def test_go_stays_until_land():
    assert all(operator.arm == 1.0 for operator in after(GO, wait=1e4))
    assert all(operator.arm == 1.0 for operator in after(GO, "w", STOP, TAKE_OVER, HAND_BACK))
    for over in (LAND, TERMINATE):
        assert not any(operator.arm for operator in after(GO, over))


def test_the_switch_stays_until_handed_back_and_is_the_uavs():
    uav, *ugvs = after(GO, TAKE_OVER, "w", wait=1e3)
    assert uav.switch == 1.0 and not any(ugv.switch for ugv in ugvs)
    assert after(TAKE_OVER, HAND_BACK)[0].switch == 0.0


@pytest.mark.parametrize("order", [LAND, STOP, HAND_BACK, TAKE_OVER])
def test_an_order_takes_the_hands_off_the_sticks(order):
    assert after("w", order)[0].command == HOVER


@given(st.lists(EVERYTHING, max_size=30))
def test_whatever_is_typed_is_sane_and_slips_terminate_nothing(keys):
    said = after(*keys)
    assert len(said) == 4 and all(sane(operator) for operator in said)
    assert TERMINATE in keys or not any(operator.terminate for operator in said)
    assert not any(operator.dead_man for operator in said)


def test_the_help_names_every_key():
    assert len(HELP) <= 110
    assert all(word in HELP for word in ("g go", "t take", "h hand", "l land", "space stop", "K motors off"))


@given(st.lists(EVERYTHING, max_size=12), st.data())
def test_however_bytes_are_cut_the_keys_are_the_same(keys, data):
    """But an escape that is the last of all waits, for it may be the beginning of an arrow."""
    keys = [key for key in keys if key != "\x1b"]
    text, found = "".join(keys), []
    rest = ""
    while text:
        some = data.draw(st.integers(1, len(text)))
        whole, rest = split(rest + text[:some])
        found += whole
        text = text[some:]
    assert (found, rest) == (keys, "")


def test_other_escape_sequences_are_keys_that_mean_nothing():
    assert split("\x1b[15~w\x1bOAx") == (["\x1b[15~", "w", UP, "x"], "")
    assert split("\x1b") == ([], "\x1b") and split("\x1b[1") == ([], "\x1b[1")
    assert split("\x1bw") == (["\x1b", "w"], "")
