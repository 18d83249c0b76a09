"""The wire form of ROS 1: bytes by hand, the way there and back, and what is no message."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.lab import Malformed
from fledge.lab.wire.rosmsg import RULE, Kind, pack, unpack

pytestmark = pytest.mark.slow

POINT = Kind("lab/Point", "float64 x  float64 y")
HEADER = Kind("std_msgs/Header", "uint32 seq  time stamp  string frame_id")
SPOT = Kind("lab/Spot", "lab/Point at  int32[2] cell", (POINT,))
ALL = Kind(
    "lab/All",
    "std_msgs/Header header  lab/Spot spot  uint8 flag  float32[] shares  uint8[] raw  string end",
    (HEADER, SPOT),
)
VALUES = (7, 3, 5, "up", 0.5, -2.0, -1, 2, 255, (0.25,), b"\0\1", "é")
GOLDEN = bytes.fromhex(
    "07000000 03000000 05000000 02000000 7570"  # header
    "000000000000e03f 00000000000000c0 ffffffff 02000000"  # spot
    "ff 01000000 0000803e 02000000 0001 02000000 c3a9"
)

uint32 = st.integers(0, 2**32 - 1)
values = st.tuples(
    *(uint32, uint32, uint32, st.text()),
    *(st.floats(allow_nan=False), st.floats(allow_nan=False)),
    *(st.integers(-(2**31), 2**31 - 1), st.integers(-(2**31), 2**31 - 1), st.integers(0, 255)),
    *(st.lists(st.floats(width=32, allow_nan=False)).map(tuple), st.binary(), st.text()),
)


def test_bytes_by_hand_are_written_and_read():
    assert pack(ALL, *VALUES) == GOLDEN
    assert unpack(ALL, GOLDEN) == VALUES


def test_nothing_is_written_as_nothing():
    nothing = Kind("lab/Nothing", "")
    assert pack(nothing) == b""
    assert unpack(nothing, b"") == ()


@given(values)
def test_values_come_back(values):
    assert unpack(ALL, pack(ALL, *values)) == values


@given(values, st.data())
def test_a_message_cut_short_is_none(values, draw):
    data = pack(ALL, *values)
    cut = draw.draw(st.integers(0, len(data) - 1))
    assert isinstance(unpack(ALL, data[:cut]), Malformed)


@given(st.binary(max_size=200))
def test_no_bytes_make_it_raise(data):
    assert isinstance(unpack(ALL, data), tuple | Malformed)


@given(st.binary(max_size=64))
def test_bytes_that_are_read_are_the_message_and_nothing_else(data):
    texts = Kind("lab/Texts", "string a  float32[] b  uint8[] c")
    found = unpack(texts, data)
    if not isinstance(found, Malformed) and not any(x != x for x in found[1]):
        assert pack(texts, *found) == data


@pytest.mark.parametrize(
    ("definition", "data", "why"),
    (
        ("float64 x", b"\0" * 7, "a lab/One of 7 bytes: valid is at least 8"),
        ("float64 x", b"\0" * 9, "a lab/One of 9 bytes: valid is 8"),
        ("string x", b"\0" * 3, "a lab/One of 3 bytes: valid is at least 4"),
        ("string x", b"\2\0\0\0a", "a lab/One of 5 bytes: valid is at least 6"),
        ("string x", b"\1\0\0\0\xff", "is no text: valid is UTF-8"),
        ("float32[] x", b"\xff\xff\xff\xff", "a lab/One of 4 bytes: valid is at least 17179869184"),
    ),
)
def test_what_is_no_message_says_why(definition, data, why):
    found = unpack(Kind("lab/One", definition), data)
    assert isinstance(found, Malformed)
    assert why in found.why


def test_a_sum_depends_on_what_is_inside_and_not_on_what_it_is_called():
    renamed = Kind("lab/Place", "float64 x  float64 y")
    other = Kind("lab/Point", "float64 x  float64 z")
    assert renamed.md5 == POINT.md5 != other.md5
    assert Kind("lab/Spot", SPOT.definition, (other,)).md5 != SPOT.md5


def test_a_recorder_is_told_every_definition_once():
    both = Kind("lab/Both", "lab/Point a  lab/Spot b  lab/Point c", (POINT, SPOT))
    parts = both.full_text.split(RULE + "\n")
    assert parts[0] == "lab/Point a\nlab/Spot b\nlab/Point c\n"
    assert [part.splitlines()[0] for part in parts[1:]] == ["MSG: lab/Point", "MSG: lab/Spot"]
