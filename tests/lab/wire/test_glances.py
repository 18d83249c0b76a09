"""What a flight shows of itself, to bytes and back; whatever else comes is refused in one line."""

import json
from dataclasses import replace
from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.lab import UINT32, Malformed
from fledge.lab.shell import udp
from fledge.lab.wire.glances import LONGEST, Glance, Vehicle, decode, encode
from fledge.supervision.modes import Mode
from fledge.world import MOST_OBSTACLES, Reason

pytestmark = pytest.mark.slow

FAR = st.none() | st.floats(-1e9, 1e9)
PLACE = st.floats(-1e6, 1e6)
WORD = st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=20)
VEHICLE = st.builds(
    Vehicle,
    st.tuples(FAR, FAR, FAR),
    st.tuples(FAR, FAR, FAR, FAR),
    st.tuples(FAR, FAR, FAR),
    st.sampled_from([int(mode) for mode in Mode]),
    st.sampled_from([int(reason) for reason in Reason]),
    st.booleans(),
    FAR,
    st.tuples(FAR, FAR, FAR, FAR),
)
BOX = st.tuples(PLACE, PLACE, PLACE, PLACE, PLACE)
GLANCE = st.builds(
    Glance,
    st.integers(0, UINT32),
    st.floats(0.0, 1e9),
    *(WORD, WORD, WORD, WORD),
    st.lists(st.integers(0, 3), min_size=1, max_size=4).map(tuple),
    st.lists(WORD, min_size=1, max_size=4).map(tuple),
    BOX,
    st.lists(BOX, max_size=3).map(tuple),
    st.lists(VEHICLE, max_size=4).map(tuple),
)

UAV = Vehicle(
    *((0.5, -0.25, 2.5), (1.0, 0.0, 0.0, 0.0), (0.1, 0.0, 0.0)),
    *(int(Mode.AUTO), int(Reason.NONE), False, None, (0.2, 0.0, 0.0, 0.0)),
)
SHOWN = Glance(
    *(42, 1.25, "fly", "", "servo", "stop-tube", (0, 1), ("ardrone",)),
    *((-3.3, 3.3, -2.5, 2.5, 4.0), ((1.0, 2.0, 1.0, 2.5, 0.5),), (UAV,)),
)
GOLDEN = (
    b'{"sequence":42,"t":1.25,"phase":"fly","complaint":"","pilot":"servo","net":"stop-tube","axes":[0,1],'
    b'"subjects":["ardrone"],"room":[-3.3,3.3,-2.5,2.5,4.0],"boxes":[[1.0,2.0,1.0,2.5,0.5]],"vehicles":['
    b'{"position":[0.5,-0.25,2.5],"attitude":[1.0,0.0,0.0,0.0],"velocity":[0.1,0.0,0.0],"mode":2,"reason":0,'
    b'"intervened":false,"clearance":null,"sent":[0.2,0.0,0.0,0.0]}]}'
)


def test_a_golden_datagram():
    assert encode(SHOWN) == GOLDEN
    assert decode(GOLDEN) == SHOWN


@given(GLANCE)
def test_there_and_back(glance):
    assert decode(encode(glance)) == glance


@given(st.binary(max_size=300))
def test_bytes_that_are_no_glance_say_why(data):
    found = decode(data)
    assert isinstance(found, Malformed) and "\n" not in found.why and len(found.why) <= 200


@given(GLANCE, st.integers(0, 2000), st.binary(max_size=3))
def test_a_glance_with_something_garbled_is_a_whole_one_or_none(glance, at, garbage):
    data = encode(glance)
    found = decode(data[:at] + garbage + data[at + len(garbage) :])
    assert isinstance(found, Malformed) or decode(encode(found)) == found


def test_what_is_not_finite_has_no_place_in_it():
    for broken in (nan, inf):
        with pytest.raises(ValueError):
            encode(replace(SHOWN, t=broken))
        assert isinstance(decode(GOLDEN.replace(b"1.25", json.dumps(broken).encode())), Malformed)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"sequence": -1}, "sequence is -1"),
        ({"t": None}, "t is None"),
        ({"axes": []}, "axes is []: valid is a list of 1 to 4"),
        ({"subjects": "ardrone"}, "subjects is 'ardrone'"),
        ({"room": [0, 1, 0, 1]}, "room is"),
        ({"boxes": [[0, 1, 0, 1]]}, "boxes is"),
        ({"vehicles": [{}]}, "vehicles lacks position"),
        ({"vehicles": None}, "vehicles is None"),
        ({"weather": "fine"}, "a glance has 'weather': valid are sequence"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(change, why):
    found = decode(json.dumps(json.loads(GOLDEN) | change).encode())
    assert isinstance(found, Malformed) and why in found.why and "\n" not in found.why


@pytest.mark.parametrize(("name", "values"), (("mode", set(Mode)), ("reason", set(Reason))))
def test_a_number_that_means_nothing_is_no_glance(name, values):
    """Of a fledge of another day, say: who shows it would not know what to call it."""
    for value in range(-1, 101):
        (uav,) = json.loads(GOLDEN)["vehicles"]
        found = decode(json.dumps(json.loads(GOLDEN) | {"vehicles": [uav | {name: value}]}).encode())
        assert isinstance(found, Glance if value in values else Malformed)


def test_what_is_too_long_is_not_read():
    whole = GOLDEN + b" " * (LONGEST - len(GOLDEN))
    assert decode(whole) == SHOWN
    assert decode(whole + b" ") == Malformed("32,769 bytes: valid is at most 32,768")
    assert isinstance(decode(b"[" * 5000), Malformed) and isinstance(decode(b"9" * 6000), Malformed)


def test_the_fullest_room_with_all_its_obstacles_fits():
    box, number = (-123.45678901234567,) * 5, (-123.45678901234567,) * 4
    crowded = Vehicle(number[:3], number, number[:3], 9, 35, True, number[0], number)
    full = replace(SHOWN, boxes=(box,) * MOST_OBSTACLES, vehicles=(crowded,) * 4, complaint="why " * 100)
    assert len(encode(full)) <= LONGEST <= udp.LONGEST and decode(encode(full)) == full
