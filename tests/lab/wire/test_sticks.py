"""What people say, to bytes and back."""

import json
from dataclasses import fields, replace
from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.errors import OutOfRange
from fledge.lab import UINT32, Malformed
from fledge.lab.wire.sticks import FLAGS, LONGEST, MOST, Sticks, decode, encode
from fledge.supervision.inputs import Operator, sane
from fledge.world import VelocityCommand

NUMBER = st.floats(-MOST, MOST)
COMMAND = st.builds(VelocityCommand, NUMBER, NUMBER, NUMBER, NUMBER)
OPERATOR = st.builds(Operator, COMMAND, **{name: NUMBER for name in FLAGS})
SAID = st.builds(
    Sticks, st.integers(0, UINT32), st.floats(-1e12, 1e12), st.lists(OPERATOR, max_size=6).map(tuple)
)

GOLDEN = (
    b'{"sequence":12,"stamp":3.25,"operators":'
    b'[{"deflection":0.3,"arm":1.0,"command":[0.3,0.0,0.0,-0.1]},{"arm":1.0},{}]}'
)


def test_a_golden_datagram():
    uav = Operator(VelocityCommand(0.3, 0.0, 0.0, -0.1), deflection=0.3, arm=1.0)
    said = Sticks(12, 3.25, (uav, Operator(arm=1.0), Operator()))
    assert encode(said) == GOLDEN
    assert decode(GOLDEN) == said


def test_everything_an_operator_can_say_can_be_said():
    assert {"command", *FLAGS} == {field.name for field in fields(Operator)}


@given(SAID)
def test_there_and_back(said):
    assert decode(encode(said)) == said


@given(st.binary(max_size=300))
def test_bytes_that_are_no_frame_say_why(data):
    assert isinstance(decode(data), (Malformed, Sticks))


@given(SAID, st.integers(0, 4000), st.binary(max_size=3))
def test_a_frame_with_something_garbled_is_one_of_sane_numbers_or_none(said, at, garbage):
    data = encode(said)
    found = decode(data[:at] + garbage + data[at + len(garbage) :])
    assert isinstance(found, Malformed) or all(sane(operator) for operator in found.operators)


def without(name):
    frame = json.loads(GOLDEN)
    del frame[name]
    return frame


def with_uav(**said):
    frame = json.loads(GOLDEN)
    frame["operators"][0] |= said
    return frame


NONSENSE = {
    "no sequence": without("sequence"),
    "no operators": without("operators"),
    "a list": [GOLDEN.decode()],
    "nobody": None,
    "a negative sequence": without("sequence") | {"sequence": -1},
    "a sequence that is too large": without("sequence") | {"sequence": UINT32 + 1},
    "a sequence that is no whole number": without("sequence") | {"sequence": 1.5},
    "a sequence that is a flag": without("sequence") | {"sequence": True},
    "more than is known": without("stamp") | {"time": 1.0},
    "a misspelt flag": with_uav(stpo=1),
    "a flag in words": with_uav(stop="yes"),
    "no flag": with_uav(stop=None),
    "a flag in a list": with_uav(stop=[1]),
    "NaN": with_uav(stop=nan),
    "infinity": with_uav(deflection=inf),
    "NaN in a command": with_uav(command=[0.0, nan, 0.0, 0.0]),
    "too few axes": with_uav(command=[0.0, 0.0, 0.0]),
    "axes by name": with_uav(command={"forward": 1.0}),
    "a number beyond all measure": with_uav(command=[10**400, 0, 0, 0]),
    "a speed beyond all measure": with_uav(command=[1e7, 0, 0, 0]),
    "a stamp beyond all measure": without("stamp") | {"stamp": 1e300},
}


@pytest.mark.parametrize("what", NONSENSE)
def test_nonsense_is_refused_in_one_line_that_says_what_would_be_valid(what):
    found = decode(json.dumps(NONSENSE[what]).encode())
    assert isinstance(found, Malformed)
    assert "\n" not in found.why and "valid is" in found.why


@pytest.mark.parametrize(
    "data", [b"[" * 5000, b'{"a":' * 1500, GOLDEN + b" " * LONGEST, b"9" * 6000, b"\xff\xfe"]
)
def test_no_datagram_is_too_odd_to_be_refused(data):
    assert isinstance(decode(data), Malformed)


def test_flags_may_be_said_as_true_and_what_is_0_may_be_left_out():
    found = decode(b'{"sequence":0,"operators":[{"stop":true,"land":false}]}')
    assert found == Sticks(0, 0.0, (Operator(stop=1.0),))
    assert all(type(getattr(found.operators[0], name)) is float for name in FLAGS)


@pytest.mark.parametrize(
    "said",
    [
        Sticks(-1, 0.0, ()),
        Sticks(0, nan, ()),
        Sticks(0, 0.0, (Operator(stop=nan),)),
        Sticks(0, 0.0, (Operator(VelocityCommand(inf, 0.0, 0.0, 0.0)),)),
        Sticks(0, 0.0, (replace(Operator(), deflection=2.0 * MOST),)),
        Sticks(0, 0.0, (Operator(stop=1.0, land=1.0),) * 400),
    ],
)
def test_what_has_no_place_on_the_wire_is_not_sent(said):
    with pytest.raises(OutOfRange, match="valid is"):
        encode(said)
