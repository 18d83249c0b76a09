"""Every reader takes what it says and nothing else, whatever comes."""

from dataclasses import dataclass, fields
from math import inf, isfinite, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.lab.wire.fields import flag, listed, made, nested, number, of, one_of, or_null, plain, text, whole


@dataclass(frozen=True, slots=True)
class Inner:
    """One number."""

    x: float = of(number(0.0, 1.0))


@dataclass(frozen=True, slots=True)
class Outer:
    """One of each."""

    count: int = of(whole(0, 9))
    on: bool = of(flag)
    name: str = of(text(5))
    side: str = of(one_of("left", "right"))
    items: tuple[Inner, ...] = of(listed(nested(Inner), 1, 2))
    gap: float | None = of(or_null(number(0.0, 9.0)), None)


WHOLE = {"count": 3, "on": True, "name": "abc", "side": "left", "items": [{"x": 0.5}], "gap": 1}
RECORD = Outer(3, True, "abc", "left", (Inner(0.5),), 1.0)
READERS = [one.metadata["read"] for kind in (Inner, Outer) for one in fields(kind)]
JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(("x", "y")), inner),
    max_leaves=6,
)


def test_there_and_back():
    assert made(Outer, "outer", WHOLE) == RECORD
    assert made(Outer, "outer", plain(RECORD)) == RECORD


def test_what_has_a_default_may_be_left_out_and_nothing_else():
    for name in WHOLE:
        less = {key: value for key, value in WHOLE.items() if key != name}
        if name == "gap":
            assert made(Outer, "outer", less).gap is None
        else:
            with pytest.raises(ValueError, match=f"outer lacks {name}"):
                made(Outer, "outer", less)


@given(st.sampled_from(READERS), JSON)
def test_a_reader_takes_it_or_says_why(read, value):
    try:
        got = read("it", value)
    except ValueError as error:
        assert "it" in str(error)
    else:
        assert plain(got) == value


@given(JSON, st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_a_number_is_finite_and_in_its_range(value, low, high):
    try:
        got = number(low, high)("it", value)
    except ValueError:
        return
    assert type(got) is float and isfinite(got) and low <= got <= high


@pytest.mark.parametrize("value", (nan, inf, -inf, 10**20, True, "0", None, [0]))
def test_what_is_no_number(value):
    with pytest.raises(ValueError, match="valid is"):
        number(-1e9, 1e9)("it", 10**400)  # too large even for a float
    with pytest.raises(ValueError, match="valid is"):
        number(-1e9, 1e9)("it", value)
