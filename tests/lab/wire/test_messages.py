"""The stamp of a message: whole nanoseconds on the wire, seconds to us."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.errors import OutOfRange
from fledge.lab.wire.messages import Header


@given(st.floats(0.0, 4e9))
def test_a_stamp_comes_back_as_exactly_as_a_float_can_say_it(stamp):
    assert Header.at(stamp).stamp == pytest.approx(stamp, abs=6e-10, rel=2e-16)


def test_a_stamp_of_this_century_is_good_to_a_microsecond():
    assert Header(1_700_000_000_123_456_789).stamp == pytest.approx(1_700_000_000.123_456_8, abs=2.5e-7)


@pytest.mark.parametrize("bad", (math.nan, math.inf, -1.0, 1e10))
def test_a_stamp_out_of_range_is_refused(bad):
    with pytest.raises(OutOfRange, match=r"stamp \[s\] is"):
        Header.at(bad)
