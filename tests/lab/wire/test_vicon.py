"""Vicon's object stream: bytes by hand, the way there and back, and what is no frame."""

import math
from dataclasses import replace
from struct import pack

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.errors import OutOfRange
from fledge.geometry import Quat, Vec3
from fledge.lab import Malformed
from fledge.lab.wire.vicon import (
    FARTHEST,
    LONGEST_NAME,
    MOST_OBJECTS,
    Frame,
    Object,
    decode,
    encode,
    rotation_of,
)

GOLDEN = bytes.fromhex(
    "2a000000 02"  # frame 42, two items
    "00 4800 6172 64726f6e65 0000000000000000000000000000000000"  # object, 72 bytes, "ardrone"
    "0000000000408f40 0000000000407fc0 0000000000008940"  # 1000, -500, 800 mm
    "0000000000000000 0000000000000000 000000000000e03f"  # 0, 0, 0.5 rad
    "00 4800 70336174 0000000000000000000000000000000000000000"  # object, 72 bytes, "p3at"
    "0000000000000000 0000000000006940 0000000000000000"  # 0, 200, 0 mm
    "000000000000d0bf 0000000000000000 000000000000f0bf"  # -0.25, 0, -1 rad
)
SEEN = Frame(
    42,
    (
        Object("ardrone", Vec3(1.0, -0.5, 0.8), Vec3(0.0, 0.0, 0.5)),
        Object("p3at", Vec3(0.0, 0.2, 0.0), Vec3(-0.25, 0.0, -1.0)),
    ),
)

numbers = st.integers(0, 2**32 - 1)
metres = st.floats(-FARTHEST, FARTHEST)
angles = st.floats(-math.pi, math.pi)
printable = st.characters(min_codepoint=32, max_codepoint=126)
names = st.text(printable, min_size=1, max_size=LONGEST_NAME)
objects = st.builds(
    Object, names, st.builds(Vec3, metres, metres, metres), st.builds(Vec3, angles, angles, angles)
)
frames = st.builds(Frame, numbers, st.lists(objects, max_size=MOST_OBJECTS).map(tuple))


def components(v) -> list[float]:
    return [v.x, v.y, v.z]


def test_bytes_by_hand_are_read():
    assert decode(GOLDEN) == SEEN


def test_bytes_by_hand_are_written_and_padded():
    assert encode(SEEN) == GOLDEN + bytes(256 - len(GOLDEN))


@pytest.mark.slow
@given(frames)
def test_a_frame_comes_back(frame):
    back = decode(encode(frame))
    assert (back.number, len(back.objects)) == (frame.number, len(frame.objects))
    for before, after in zip(frame.objects, back.objects, strict=True):
        assert (after.name, after.rotation) == (before.name, before.rotation)
        assert components(after.position) == pytest.approx(components(before.position), rel=1e-15, abs=0.0)


@given(frames)
def test_a_datagram_has_one_of_three_sizes(frame):
    assert len(encode(frame)) in (256, 512, 1024)


@given(frames, st.binary(max_size=64))
def test_padding_means_nothing_whatever_it_holds(frame, rubbish):
    used = 5 + 75 * len(frame.objects)
    assert decode(encode(frame)[:used] + rubbish) == decode(encode(frame))


@pytest.mark.slow
@given(frames, st.data())
def test_a_frame_cut_short_is_none(frame, data):
    cut = data.draw(st.integers(0, 4 + 75 * len(frame.objects)))
    assert isinstance(decode(encode(frame)[:cut]), Malformed)


@given(st.binary(max_size=300))
def test_no_bytes_make_it_raise(data):
    assert isinstance(decode(data), Frame | Malformed)


@given(st.integers(0, len(GOLDEN) - 1), st.integers(0, 255))
def test_no_broken_byte_makes_it_raise(place, byte):
    broken = GOLDEN[:place] + bytes([byte]) + GOLDEN[place + 1 :]
    got = decode(broken)
    assert isinstance(got, Malformed) or all(isinstance(one.attitude, Quat) for one in got.objects)


def test_items_of_another_kind_are_skipped():
    marker = bytes.fromhex("07 0300 aabbcc")
    data = pack("<IB", 42, 3) + GOLDEN[5:80] + marker + GOLDEN[80:]
    assert decode(data) == SEEN


@pytest.mark.parametrize(
    ("data", "why"),
    (
        (b"", "0 bytes: a frame has at least 5"),
        (GOLDEN[:-1], "154 bytes: item 2 of 2 ends at byte 155"),
        (bytes.fromhex("2a000000 01 00 0200 aabb"), "an object of 2 bytes: valid is 72"),
        (GOLDEN[:8] + bytes(24) + GOLDEN[32:], "an object called ''"),
        (GOLDEN[:8] + b"\xff\x0a" + GOLDEN[10:], "an object called 'ÿ\\ndrone'"),
    ),
)
def test_what_is_no_frame_says_why(data, why):
    got = decode(data)
    assert isinstance(got, Malformed)
    assert why in got.why


def test_a_pose_that_is_no_number_is_for_others_to_judge():
    data = GOLDEN[:32] + pack("<d", math.nan) + GOLDEN[40:72] + pack("<d", math.inf) + GOLDEN[80:]
    one = decode(data).objects[0]
    assert math.isnan(one.position.x)
    assert math.isnan(one.attitude.w)


@pytest.mark.parametrize("bad", (math.nan, math.inf, -math.inf, 1000.0))
def test_numbers_out_of_range_are_not_sent(bad):
    one = SEEN.objects[0]
    for broken in (replace(one, position=Vec3(0.0, bad, 0.0)), replace(one, rotation=Vec3(0.0, 0.0, bad))):
        with pytest.raises(OutOfRange, match=r"of ardrone \[.*\] is .*: valid is -"):
            encode(Frame(1, (broken,)))


@pytest.mark.parametrize("number", (-1, 2**32, 1.5, math.nan))
def test_a_frame_is_counted_in_whole_numbers(number):
    with pytest.raises(OutOfRange, match="frame number"):
        encode(Frame(number, ()))


@pytest.mark.parametrize("name", ("", "x" * 25, "Übung", "a\nb", "a\0b"))
def test_names_that_do_not_fit_are_not_sent(name):
    with pytest.raises(OutOfRange, match="name of an object"):
        encode(Frame(1, (replace(SEEN.objects[0], name=name),)))


def test_as_many_objects_as_fit_and_no_more():
    most = (1024 - 5) // 75
    assert len(decode(encode(Frame(1, most * SEEN.objects[:1]))).objects) == most
    with pytest.raises(OutOfRange, match=f"number of objects is {most + 1}"):
        encode(Frame(1, (most + 1) * SEEN.objects[:1]))


@pytest.mark.parametrize(
    ("rotation", "body", "world"),
    (
        (Vec3(math.pi / 2, 0.0, 0.0), Vec3(0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        (Vec3(0.0, math.pi / 2, 0.0), Vec3(0.0, 0.0, 1.0), (1.0, 0.0, 0.0)),
        (Vec3(0.0, 0.0, math.pi / 2), Vec3(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        # First about x, then about the new z, which lies along the world's -y: x turns up to the new y, up.
        (Vec3(math.pi / 2, 0.0, math.pi / 2), Vec3(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        # The new y is up, so turning about it takes x to the world's y.
        (Vec3(math.pi / 2, math.pi / 2, 0.0), Vec3(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    ),
)
def test_rotations_follow_one_another_about_the_new_axes(rotation, body, world):
    turned = Object("a", Vec3(0.0, 0.0, 0.0), rotation).attitude.rotate(body)
    assert components(turned) == pytest.approx(world, abs=1e-15)


@given(angles, st.floats(-1.5, 1.5), angles)
def test_angles_come_back_from_the_attitude(x, y, z):
    one = Object("a", Vec3(0.0, 0.0, 0.0), Vec3(x, y, z))
    again = replace(one, rotation=rotation_of(one.attitude))
    there, back = one.attitude, again.attitude
    same = there.w * back.w + there.x * back.x + there.y * back.y + there.z * back.z
    assert abs(same) == pytest.approx(1.0, abs=1e-12)  # q and -q are one rotation
    assert again.rotation.y == pytest.approx(y, abs=1e-9)
