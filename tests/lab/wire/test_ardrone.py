"""AT commands: lines by hand, numbers bit for bit, the way there and back, and what is no command."""

import math
from struct import pack, unpack

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.errors import OutOfRange
from fledge.lab import Malformed
from fledge.lab.wire.ardrone import (
    Comwdg,
    Config,
    Ctrl,
    Flag,
    Ftrim,
    Line,
    Mode,
    Pcmd,
    Ref,
    accepts,
    decode,
    encode,
)

# 0.2 is 0x3e4ccccd and -0.8 is 0xbf4ccccd as a float32; bits 18, 20, 22, 24 and 28 make 290717696.
EIGHTHS = (0.125, -0.25, 0.5, -1.0)  # 0x3e000000, 0xbe800000, 0x3f000000, 0xbf800000
GOLDEN = (
    (Ref(fly=False), b"AT*REF=7,290717696\r"),
    (Ref(fly=True), b"AT*REF=7,290718208\r"),
    (Ref(fly=False, emergency=True), b"AT*REF=7,290717952\r"),
    (Pcmd.hover(), b"AT*PCMD=7,0,0,0,0,0\r"),
    (Pcmd(*EIGHTHS), b"AT*PCMD=7,1,1040187392,-1098907648,1056964608,-1082130432\r"),
    (Pcmd(0.0, 0.0, 0.0, 1.0, Flag.PROGRESSIVE | Flag.COMBINED_YAW), b"AT*PCMD=7,3,0,0,0,1065353216\r"),
    (Ftrim(), b"AT*FTRIM=7\r"),
    (Config("general:navdata_demo", "TRUE"), b'AT*CONFIG=7,"general:navdata_demo","TRUE"\r'),
    (Config("leds:leds_anim", "3,1073741824,2"), b'AT*CONFIG=7,"leds:leds_anim","3,1073741824,2"\r'),
    (Ctrl(Mode.CLEAR_ACKNOWLEDGEMENT), b"AT*CTRL=7,5,0\r"),
    (Ctrl(Mode.SEND_CONFIGURATION), b"AT*CTRL=7,4,0\r"),
    (Comwdg(), b"AT*COMWDG=7\r"),
)

shares = st.floats(-1.0, 1.0, width=32)
text = st.text(st.characters(min_codepoint=32, max_codepoint=126, exclude_characters='"'), max_size=40)
commands = st.one_of(
    st.builds(Ref, st.booleans(), st.booleans()),
    st.builds(Pcmd, shares, shares, shares, shares, st.integers(0, 7).map(Flag)),
    st.builds(Config, text.filter(bool), text),
    st.builds(Ctrl, st.sampled_from(Mode)),
    st.sampled_from((Ftrim(), Comwdg())),
)
firsts = st.integers(1, 2**31 - 10)
datagrams = st.tuples(firsts, st.lists(commands, max_size=8))


@pytest.mark.parametrize(("command", "line"), GOLDEN)
def test_lines_by_hand(command, line):
    assert encode(7, command) == line
    assert decode(line) == (Line(7, command),)


def test_shares_are_sent_as_the_bits_of_a_float32():
    assert encode(1, Pcmd(0.2, -0.8, 0.0, 0.0)) == b"AT*PCMD=1,1,1045220557,-1085485875,0,0\r"


@given(datagrams)
def test_commands_come_back_in_order_with_their_numbers(datagram):
    first, sent = datagram
    assert decode(encode(first, *sent)) == tuple(Line(first + i, one) for i, one in enumerate(sent))


@given(st.floats(-1.0, 1.0))
def test_a_share_is_rounded_to_its_float32_and_no_further(share):
    (line,) = decode(encode(1, Pcmd(share, 0.0, 0.0, 0.0)))
    assert line.command.roll == unpack("<f", pack("<f", share))[0]


@pytest.mark.slow
@given(datagrams, st.data())
def test_a_datagram_cut_short_loses_lines_and_changes_none(datagram, data):
    first, sent = datagram
    whole = encode(first, *sent)
    cut = data.draw(st.integers(0, len(whole)))
    ends = [i for i in range(1, cut + 1) if whole[i - 1 : i] == b"\r"]
    got = decode(whole[:cut])
    assert got[: len(ends)] == decode(whole)[: len(ends)]
    assert all(isinstance(one, Malformed) for one in got[len(ends) :])


any_bytes = st.binary(max_size=200)
almost = st.from_regex(rb"AT\*(REF|PCMD|CONFIG|CTRL|FTRIM|COMWDG)=[0-9,\"a-z-]{0,60}\r", fullmatch=True)


@given(any_bytes | almost)
def test_no_bytes_make_it_raise(data):
    assert all(isinstance(one, Line | Malformed) for one in decode(data))


@given(almost)
def test_what_is_read_can_be_sent(data):
    for one in decode(data):
        if isinstance(one, Line):
            assert decode(encode(1, one.command)) == (Line(1, one.command),)


def test_both_ends_of_a_line_are_read():
    assert decode(b"AT*FTRIM=1\nAT*COMWDG=2\r\nAT*REF=3,0\r") == (
        Line(1, Ftrim()),
        Line(2, Comwdg()),
        Line(3, Ref(fly=False)),
    )


@pytest.mark.parametrize(
    ("line", "command"),
    (
        (b"AT*REF=0,0\r", Ref(fly=False)),  # node-ar-drone counts from 0 and leaves out the constant bits
        (b"AT*REF=0,512\r", Ref(fly=True)),
        (b"AT*REF=0,256\r", Ref(fly=False, emergency=True)),
        (b"AT*FTRIM=0,\r", Ftrim()),
    ),
)
def test_habits_of_other_clients_are_understood(line, command):
    assert decode(line) == (Line(0, command),)


def test_a_bad_line_does_not_take_its_neighbours_along():
    first, bad, last = decode(b"AT*FTRIM=1\rAT*LED=2,1,0,5\rAT*COMWDG=3\r")
    assert (first, last) == (Line(1, Ftrim()), Line(3, Comwdg()))
    assert bad == Malformed(
        "'AT*LED=2,1,0,5': valid are REF, PCMD, FTRIM, CONFIG, CTRL, COMWDG, with their arguments, in range"
    )


@pytest.mark.parametrize(
    "line",
    (
        b"",
        b"AT*REF=1,290718208",  # its end may be missing
        b"AT*REF=2147483648,0\r",
        b"AT*REF=-1,0\r",
        b"AT*REF=1,2147483648\r",
        b"AT*REF=1,0,0\r",
        b"AT*REF=1,\xb2\r",  # a digit to Unicode, not to us
        b"AT*PCMD=1,1,0,0,0\r",
        b"AT*PCMD=1,8,0,0,0,0\r",
        b"AT*PCMD=1,1,1065353217,0,0,0\r",  # the float32 after 1.0
        b"AT*PCMD=1,1,2143289344,0,0,0\r",  # NaN
        b"AT*PCMD=1,1,2139095040,0,0,0\r",  # infinity
        b'AT*CONFIG=1,"key"\r',
        b'AT*CONFIG=1,"","value"\r',
        b"AT*CTRL=1,6,0\r",
        b"AT*CTRL=1,5,1\r",
        b'AT*CONFIG=1,"key","' + b"v" * 1005 + b'"\r',
    ),
)
def test_what_is_no_command_is_not_obeyed(line):
    assert not any(isinstance(one, Line) for one in decode(line))


@pytest.mark.parametrize("share", (math.nan, math.inf, -math.inf, 1.0001, -2.0))
@pytest.mark.parametrize("name", ("roll", "pitch", "gaz", "yaw"))
def test_shares_out_of_range_are_not_sent(name, share):
    still = dict.fromkeys(("roll", "pitch", "gaz", "yaw"), 0.0)
    with pytest.raises(OutOfRange, match=f"share of {name} is {share}: valid is -1 to 1"):
        encode(1, Pcmd(**still | {name: share}))


@pytest.mark.parametrize(("key", "value"), (("", "v"), ('k"', "v"), ("k", 'v"'), ("k", "v\r"), ("k", "é")))
def test_text_that_cannot_be_quoted_is_not_sent(key, value):
    with pytest.raises(OutOfRange, match="configuration is"):
        encode(1, Config(key, value))


@pytest.mark.parametrize("first", (0, -1, 2**31, 1.0, math.nan))
def test_lines_are_numbered_from_one_up(first):
    with pytest.raises(OutOfRange, match="sequence number"):
        encode(first, Comwdg())


def test_the_numbers_must_last_for_the_whole_datagram():
    assert len(decode(encode(2**31 - 2, Ftrim(), Comwdg()))) == 2
    with pytest.raises(OutOfRange, match="sequence number"):
        encode(2**31 - 1, Ftrim(), Comwdg())


def test_flags_that_nobody_knows_are_not_sent():
    with pytest.raises(OutOfRange, match="PCMD flags is 8"):
        encode(1, Pcmd(0.0, 0.0, 0.0, 0.0, Flag(8)))


def test_a_datagram_has_at_most_1024_characters():
    line = len(encode(1, Config("k", "")))
    assert len(encode(1, Config("k", "v" * (1024 - line)))) == 1024
    assert isinstance(decode(encode(1, Config("k", "v" * (1024 - line))))[0], Line)
    with pytest.raises(OutOfRange, match="1025: valid is at most 1,024"):
        encode(1, Config("k", "v" * (1025 - line)))


@given(st.integers(0, 2**31 - 1), st.integers(0, 2**31 - 1))
def test_the_drone_obeys_what_is_newer_and_a_new_start(last, sequence):
    assert accepts(last, sequence) == (sequence > last or sequence == 1)


def test_a_duplicate_and_an_overtaken_line_are_not_obeyed():
    assert [accepts(5, n) for n in (4, 5, 6)] == [False, False, True]
