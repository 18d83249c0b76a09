"""Navdata: bytes by hand, the way there and back, the checksum, and what is no navdata."""

import math
from dataclasses import replace
from struct import pack

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.errors import OutOfRange
from fledge.geometry import Vec3
from fledge.lab import Malformed
from fledge.lab.wire.navdata import ControlState, Demo, Navdata, State, decode, encode, fresh

HEAD = "88776655 01040000 07000000 00000000"  # flying, demo navdata; number 7; no vision
DEMO = (
    "0000 9400 00000300 57000000"  # tag 0, 148 bytes; state 3, flying; 87 %
    "0000fac4 00007a44 00c8af47"  # -2000, 1000, 90000 thousandths of a degree
    "dc050000 0000fa43 00007ac3 0000fac2" + "00" * 108  # 1500 mm; 500, -250, -125 mm/s
)
GOLDEN = bytes.fromhex(HEAD + DEMO + "ffff 0800 050c0000")  # 0xc05 is what all bytes before add up to
FLYING = Navdata(
    7,
    State.FLYING | State.NAVDATA_DEMO,
    Demo(
        ControlState.FLYING,
        battery=0.87,
        roll=math.radians(1.0),
        pitch=math.radians(2.0),
        yaw=math.radians(-90.0),
        altitude=1.5,
        velocity=Vec3(0.5, 0.25, 0.125),
    ),
)
BOOTSTRAP = bytes.fromhex("88776655 00080040 01000000 00000000 ffff 0800 03020000")

uint32 = st.integers(0, 2**32 - 1)
millidegrees = st.floats(-180e3, 180e3, width=32)
millimetres_per_second = st.floats(-100e3, 100e3, width=32)


@st.composite
def on_the_wire(draw) -> bytes:
    """A datagram of a drone whose numbers are all within their range, its option packed here once more."""
    major, minor = draw(st.integers(0, 9)), draw(st.integers(0, 2**16 - 1))
    angles = [draw(millidegrees) for _ in range(3)]
    speeds = [draw(millimetres_per_second) for _ in range(3)]
    demo = pack("<HHHHI3f", 0, 148, minor, major, draw(st.integers(0, 100)), *angles)
    demo += pack("<i3f", draw(st.integers(-100_000, 100_000)), *speeds) + bytes(108)
    head = pack("<4I", 0x55667788, draw(uint32), draw(uint32), draw(st.integers(0, 1)))
    return summed(head + draw(st.sampled_from((b"", demo))))


def summed(data: bytes) -> bytes:
    return data + pack("<HHI", 0xFFFF, 8, sum(data))


def test_bytes_by_hand_are_read():
    got = decode(GOLDEN)
    assert (got.sequence, got.state, got.vision) == (FLYING.sequence, FLYING.state, False)
    assert (got.demo.control, got.demo.minor) == (ControlState.FLYING, 0)
    for name in ("battery", "roll", "pitch", "yaw", "altitude"):
        assert getattr(got.demo, name) == pytest.approx(getattr(FLYING.demo, name), rel=1e-15), name
    assert got.demo.velocity == FLYING.demo.velocity


def test_bytes_by_hand_are_written():
    assert len(GOLDEN) == 172
    assert encode(FLYING) == GOLDEN


def test_a_drone_that_was_not_configured_sends_its_state_alone():
    booting = Navdata(1, State.BOOTSTRAP | State.COM_WATCHDOG)
    assert decode(BOOTSTRAP) == booting
    assert encode(booting) == BOOTSTRAP


@given(on_the_wire())
def test_bytes_come_back_bit_for_bit(data):
    assert encode(decode(data)) == data


@given(on_the_wire(), st.data())
def test_one_changed_byte_is_noticed(data, draw):
    place = draw.draw(st.integers(0, len(data) - 1))
    byte = draw.draw(st.integers(0, 255).filter(lambda byte: byte != data[place]))
    assert isinstance(decode(data[:place] + bytes([byte]) + data[place + 1 :]), Malformed)


@given(on_the_wire(), st.data())
def test_navdata_cut_short_are_none(data, draw):
    assert isinstance(decode(data[: draw.draw(st.integers(0, len(data) - 1))]), Malformed)


@given(st.binary(max_size=300))
def test_no_bytes_make_it_raise(data):
    assert isinstance(decode(data), Navdata | Malformed)


@given(st.binary(max_size=200))
def test_no_options_make_it_raise(options):
    assert isinstance(decode(summed(bytes.fromhex(HEAD) + options)), Navdata | Malformed)


@given(st.binary(min_size=144, max_size=144))
def test_no_demo_makes_it_raise(body):
    demo = bytes.fromhex("0000 9400") + body
    assert isinstance(decode(summed(bytes.fromhex(HEAD) + demo)), Navdata | Malformed)


def test_options_nobody_reads_are_skipped():
    time = bytes.fromhex("0100 0800 efbeadde")
    data = bytes.fromhex(HEAD) + time + bytes.fromhex(DEMO) + time
    assert decode(summed(data)) == decode(GOLDEN)


def test_the_other_header_is_read_as_well():
    assert decode(summed(bytes.fromhex("89") + GOLDEN[1:-8])) == decode(GOLDEN)


@pytest.mark.parametrize(
    ("data", "why"),
    (
        (b"", "0 bytes: navdata have at least 24"),
        (b"\0" + GOLDEN[1:], "begins with 0x55667700: valid is 0x55667788"),
        (GOLDEN[:-8], "ends with option 0 of 0 bytes: valid is a checksum"),
        (GOLDEN[:-4] + bytes(4), "the bytes add up to 3077: the checksum says 0"),
        (summed(bytes.fromhex(HEAD + "0000 0800 00000000")), "a demo option of 4 bytes: valid is 144"),
        (summed(bytes.fromhex(HEAD + "0100 0300 00000000")), "option 1 of 3 bytes: valid is 4 to 8"),
        (summed(bytes.fromhex(HEAD + "0100 0900 00000000")), "option 1 of 9 bytes: valid is 4 to 8"),
        (summed(bytes.fromhex(HEAD + "01")), "option 1 of 0 bytes: valid is 4 to 1"),
        (summed(bytes.fromhex(HEAD + DEMO.replace("0300", "0a00"))), "control state 10: valid is 0 to 9"),
    ),
)
def test_what_is_no_navdata_says_why(data, why):
    got = decode(data)
    assert isinstance(got, Malformed)
    assert why in got.why


def test_a_measurement_that_is_no_number_is_for_others_to_judge():
    data = GOLDEN[:28] + pack("<f", math.nan) + GOLDEN[32:-8]
    assert math.isnan(decode(summed(data)).demo.pitch)


@pytest.mark.parametrize("bad", (math.nan, math.inf, -math.inf, 1e4))
@pytest.mark.parametrize("name", ("battery", "roll", "pitch", "yaw", "altitude"))
def test_numbers_out_of_range_are_not_sent(name, bad):
    with pytest.raises(OutOfRange, match=f"^{name}.* is {bad}: valid is "):
        encode(replace(FLYING, demo=replace(FLYING.demo, **{name: bad})))


@pytest.mark.parametrize("bad", (math.nan, math.inf, 101.0))
def test_speeds_out_of_range_are_not_sent(bad):
    for velocity in (Vec3(bad, 0.0, 0.0), Vec3(0.0, bad, 0.0), Vec3(0.0, 0.0, -bad)):
        with pytest.raises(OutOfRange, match=r"velocity \[m/s\] is"):
            encode(replace(FLYING, demo=replace(FLYING.demo, velocity=velocity)))


@pytest.mark.parametrize("bad", (-1, 2**32, 0.5))
def test_navdata_are_counted_in_whole_numbers(bad):
    with pytest.raises(OutOfRange, match="sequence number"):
        encode(replace(FLYING, sequence=bad))
    with pytest.raises(OutOfRange, match="minor control state"):
        encode(replace(FLYING, demo=replace(FLYING.demo, minor=bad)))


@given(uint32, uint32)
def test_only_what_is_newer_is_fresh(sequence, last):
    assert fresh(Navdata(sequence, State.FLYING), last) == (sequence > last)


@given(st.integers(1, 2**32 - 1), uint32)
def test_a_drone_that_reports_its_watchdog_counts_anew(sequence, last):
    assert fresh(Navdata(sequence, State.FLYING | State.COM_WATCHDOG), last)
