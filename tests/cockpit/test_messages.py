"""What page and server say: strict, there and back, and nothing that arrives raises."""

import json
from dataclasses import fields
from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.cockpit import asks, tells
from fledge.cockpit.asks import Cancel, Discard, Fly, Keep, Pause, Reset, Resume, Seat, Sticks, Train
from fledge.cockpit.messages import (
    FROM_PAGE,
    LONGEST_HEARD,
    LONGEST_SAID,
    TO_PAGE,
    decode,
    decode_told,
    encode,
)
from fledge.cockpit.tells import (
    Block,
    Flight,
    Frame,
    Harvest,
    Heap,
    Lesson,
    Marks,
    Notice,
    Picture,
    Seating,
    Stored,
    Task,
    Vehicle,
    View,
    Welcome,
)
from fledge.errors import FledgeError
from fledge.lab import UINT32, Malformed
from fledge.supervision.inputs import Operator

GOLDEN = '{"kind":"sticks","sequence":7,"stamp":12.5,"vehicle":0,"axes":[0.5,0,0,-1],"arm":true}'
LEARNT = (
    '{"kind":"lesson","state":"done","setup":"primitive","policy":"p.onnx","epoch":2,"epochs":2,'
    '"points":[[1.0,0.5,0.25],[2.0,0.125,0.25]],"problem":""}'
)


def many(item, least=0, most=3):
    return st.lists(item, min_size=least, max_size=most).map(tuple)


def some(*items):
    return st.sampled_from(items)


UNIT = st.floats(-1.0, 1.0)
FAR = st.floats(-tells.FAR, tells.FAR)
COUNT = st.integers(0, UINT32)
STAMP = st.floats(-1e15, 1e15)
NAME = st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=20)
FLAG = st.booleans()
AXES = many(st.integers(0, 3), 1, 4)
WORLD, RECORD = some(*asks.WORLDS), some(*asks.RECORDS)

ASKED = {
    "sticks": st.builds(
        Sticks, COUNT, STAMP, st.integers(0, 63), st.tuples(UNIT, UNIT, UNIT, UNIT), *(FLAG,) * 7
    ),
    "seat": st.builds(Seat, FLAG),
    "fly": st.builds(
        Fly, NAME, NAME, NAME, st.floats(0.1, 4.0), st.integers(0, asks.LARGEST_SEED), RECORD, WORLD
    ),
    "pause": st.just(Pause()),
    "resume": st.just(Resume()),
    "reset": st.just(Reset()),
    "keep": st.just(Keep()),
    "discard": st.just(Discard()),
    "train": st.builds(Train, NAME, st.none() | st.integers(1, 100_000), FLAG),
    "cancel": st.just(Cancel()),
}

BLOCK = st.builds(Block, FAR, FAR, FAR, FAR, FAR)
VIEW = st.builds(View, FAR, FAR, FAR)
STOP = st.just(()) | st.tuples(FAR, FAR, FAR)
COMMAND = st.tuples(FAR, FAR, FAR, FAR)
VEHICLE = st.builds(Vehicle, FAR, FAR, FAR, FAR, NAME, NAME, NAME, COMMAND, st.none() | FAR, STOP)
PICTURE = st.builds(Picture, FAR, FAR, FAR, FAR, many(st.tuples(FAR, FAR)))
SHARE = st.floats(0.0, 1.0)
MARKS = st.builds(Marks, FAR, FAR, SHARE)

TOLD = {
    "welcome": st.builds(
        Welcome,
        many(st.builds(Task, NAME, AXES, COUNT)),
        many(NAME),
        many(NAME),
        many(WORLD, 1),
        many(NAME),
    ),
    "flight": st.builds(
        Flight,
        *(some(*tells.FLIGHTS), NAME, NAME, NAME, WORLD, FAR, COUNT, RECORD),
        BLOCK,
        many(BLOCK),
        many(FAR, 0, 1),
        VIEW,
        AXES,
        many(NAME, 1),
    ),
    "frame": st.builds(
        Frame,
        FAR,
        many(VEHICLE, 1, 4),
        PICTURE,
        COUNT,
        FLAG,
        FLAG,
        FAR,
        battery=st.none() | SHARE,
        sequence=st.integers(-1, UINT32),
        stamp=STAMP,
        silent=st.none() | FAR,
        answer=st.none() | FAR,
        note=NAME,
    ),
    "seat": st.builds(Seating, some(*tells.SEATS), COUNT),
    "harvest": st.builds(Harvest, many(st.builds(Heap, NAME, COUNT, COUNT))),
    "stored": st.builds(Stored, NAME, NAME, COUNT, MARKS, st.none() | MARKS),
    "lesson": st.builds(
        Lesson, some(*tells.LESSONS), NAME, NAME, COUNT, COUNT, many(st.tuples(FAR, FAR, FAR)), NAME
    ),
    "notice": st.builds(Notice, NAME, some(*tells.LEVELS)),
}


def test_a_golden_message():
    assert decode(GOLDEN) == Sticks(7, 12.5, 0, (0.5, 0.0, 0.0, -1.0), arm=True)
    assert decode(GOLDEN.encode()) == decode(GOLDEN)
    lesson = Lesson("done", "primitive", "p.onnx", 2, 2, ((1.0, 0.5, 0.25), (2.0, 0.125, 0.25)))
    assert encode(lesson) == LEARNT and decode_told(LEARNT) == lesson


def test_everything_an_operator_can_say_can_be_said():
    flags = {field.name for field in fields(Operator)} - {"command", "deflection"}
    assert {field.name for field in fields(Sticks)} == {"sequence", "stamp", "vehicle", "axes"} | flags


def test_no_kind_is_left_out_here():
    assert set(ASKED) == set(FROM_PAGE) and set(TOLD) == set(TO_PAGE)


@pytest.mark.parametrize("kind", FROM_PAGE)
@given(st.data())
def test_there_and_back(kind, data):
    message = data.draw(ASKED[kind])
    assert type(message) is FROM_PAGE[kind] and decode(encode(message)) == message


@pytest.mark.slow
@pytest.mark.parametrize("kind", TO_PAGE)
@given(st.data())
def test_back_and_there(kind, data):
    message = data.draw(TOLD[kind])
    assert type(message) is TO_PAGE[kind] and decode_told(encode(message)) == message


def test_nobody_understands_words_of_their_own():
    """Of the seat both sides speak, but never in the same words."""
    assert {*FROM_PAGE} & {*TO_PAGE} == {"seat"}
    assert isinstance(decode(encode(Seating("free", 0))), Malformed)
    assert isinstance(decode_told(encode(Seat(True))), Malformed)
    assert isinstance(decode_told(GOLDEN), Malformed) and isinstance(decode(LEARNT), Malformed)


@given(st.one_of(st.binary(max_size=300), st.text(max_size=300)))
def test_nothing_that_arrives_raises(data):
    for found in (decode(data), decode_told(data)):
        assert isinstance(found, Malformed)
        assert "\n" not in found.why and len(found.why) <= 200


@given(st.one_of(*ASKED.values(), *TOLD.values()), st.integers(0, 400), st.text(max_size=3))
def test_something_garbled_is_a_whole_message_or_none(message, at, garbage):
    text = encode(message)
    garbled = text[:at] + garbage + text[at + len(garbage) :]
    for hears in (decode, decode_told):
        found = hears(garbled)
        assert isinstance(found, Malformed) or hears(encode(found)) == found


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)


@pytest.mark.slow
@given(st.sampled_from(sorted({*FROM_PAGE, *TO_PAGE})), st.data())
def test_no_value_of_a_known_key_raises(kind, data):
    tables = [table for table in (FROM_PAGE, TO_PAGE) if kind in table]
    names = [field.name for table in tables for field in fields(table[kind])]
    said = {name: data.draw(JSON) for name in names}
    text = json.dumps({"kind": kind, **said})
    for found in (decode(text), decode_told(text)):
        assert isinstance(found, Malformed) or isinstance(found, (*FROM_PAGE.values(), *TO_PAGE.values()))


def with_(**changes) -> str:
    return json.dumps({**json.loads(GOLDEN), **changes})


def asking(kind, **said) -> str:
    return json.dumps({"kind": kind, **said})


CHOSEN = {"manoeuvre": "a", "pilot": "b", "net": "c"}


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (with_(kind="stick"), "kind is 'stick': valid are sticks, seat, fly"),
        (with_(kind=["sticks"]), "kind is "),
        (with_(lnad=True), "sticks has 'lnad': valid are sequence"),
        (with_(sequence=-1), "sequence is -1"),
        (with_(sequence=1.0), "sequence is 1.0"),
        (with_(sequence=True), "sequence is True"),
        (with_(stamp="now"), "stamp is 'now'"),
        (with_(vehicle=64), "vehicle is 64"),
        (with_(axes=[0, 0, 0]), "axes is "),
        (with_(axes=[0, 0, 0, 1.001]), "axes is 1.001: valid is -1 to 1"),
        (with_(axes=[nan, 0, 0, 0]), "NaN is no number"),
        (with_(axes=[0, inf, 0, 0]), "Infinity is no number"),
        (GOLDEN.replace("0.5", "1e999"), "axes is inf"),
        (with_(axes=[True, 0, 0, 0]), "axes is True"),
        (with_(arm=1), "arm is 1: valid is true or false"),
        (asking("seat"), "seat lacks want"),
        (asking("pause", now=True), "pause has 'now': valid are no keys"),
        (asking("cancel", setup="a"), "cancel has 'setup': valid are no keys"),
        (asking("fly", **CHOSEN | {"pilot": "b\n"}), "pilot is 'b"),
        (asking("fly", **CHOSEN, record="all"), "record is 'all': valid are nothing, demonstration, flight"),
        (asking("fly", **CHOSEN, world="moon"), "world is 'moon': valid are simulator, twin, attached"),
        (asking("fly", **CHOSEN, seed=asks.LARGEST_SEED + 1), "whole number from 0 to 4,294,966"),
        (asking("fly", **CHOSEN, speed=0.09), "speed is 0.09: valid is 0.1 to 4"),
        (asking("train", epochs=1), "train lacks setup"),
        (asking("train", setup="a", epochs=0), "epochs is 0: valid is a whole number from 1 to 100,000"),
        (asking("train", setup="a", takeovers="yes"), "takeovers is 'yes'"),
        ("[]", "[]: valid is an object"),
        ("[" * 2000, "brackets within brackets"),
        (" " * (LONGEST_HEARD + 1), "2,049 bytes: valid are up to 2,048"),
        (b"\xff\xfe\xff", "codec"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(text, why):
    found = decode(text)
    assert isinstance(found, Malformed) and why in found.why and "\n" not in found.why


def test_what_may_be_left_out_is():
    assert decode(asking("fly", **CHOSEN)) == Fly("a", "b", "c", 1.0, 0, "nothing", "simulator")
    assert decode(asking("train", setup="a")) == Train("a", None, False)


PARKED = Vehicle(0.0, 0.0, 1.0, 0.0, "AUTO", "NONE", "pilot", (0.0,) * 4, None)
NOWHERE = Picture(0, 0, 0, 0, ())
FRAME = Frame(0.0, (PARKED,), NOWHERE)
BOX = Block(*(-1234.5678901234567,) * 5)


@pytest.mark.parametrize("broken", (nan, inf, 1e7))
def test_a_server_says_nothing_that_is_no_number(broken):
    assert decode_told(encode(FRAME)) == FRAME
    with pytest.raises(FledgeError, match="t is "):
        encode(Frame(broken, FRAME.vehicles, FRAME.picture))
    with pytest.raises(FledgeError, match="points is "):
        encode(Lesson("running", points=((1.0, broken, 0.0),)))


def flight(**changes):
    said = {
        "state": "none",
        "manoeuvre": "",
        "pilot": "",
        "net": "",
        "world": "twin",
        "speed": 1.0,
        "seed": 0,
    }
    said |= {"record": "nothing", "arena": BOX, "obstacles": (), "margins": (), "lens": View(1.0, 1.0, 1.0)}
    return Flight(**said | {"axes": (0,), "names": ("UAV",)} | changes)


@pytest.mark.parametrize(
    ("message", "why"),
    [
        (lambda: Frame(0.0, (), NOWHERE), "vehicles is"),
        (lambda: Frame(0.0, (PARKED,), NOWHERE, battery=1.01), "battery is 1.01: valid is 0 to 1"),
        (lambda: Frame(0.0, (PARKED,), NOWHERE, note="two\nlines"), "note is"),
        (lambda: Frame(0.0, (PARKED,), Picture(0, 0, 0, 0, ((1.0,),))), "marks is"),
        (lambda: flight(margins=(0.1, 0.2)), "margins is"),
        (lambda: flight(state="lost"), "state is 'lost': valid are none, running, paused, over"),
        (lambda: flight(names=()), "names is"),
        (lambda: Welcome((), (), (), (), ()), "worlds is"),
        (lambda: Welcome((Task("a", (4,)),), (), (), ("twin",), ()), "axes is 4"),
        (lambda: Stored("a", "b", 1, Marks(0.0, 0.0, 1.5)), "in_view is 1.5"),
        (lambda: Harvest((Heap("a", -1, 0),)), "flights is -1"),
        (lambda: Lesson("over"), "state is 'over': valid are none, running, done, failed, cancelled"),
        (lambda: Notice("a", "fatal"), "level is 'fatal'"),
    ],
)
def test_what_has_no_place_in_a_message_is_not_said(message, why):
    with pytest.raises(FledgeError) as caught:
        encode(message())
    assert why in str(caught.value) and "\n" not in str(caught.value)


def test_the_fullest_room_can_be_told():
    full, most = (-123.45678901234567,) * 4, asks.MOST_VEHICLES
    crowded = Vehicle(*full, "TERMINATED", "INCONSISTENT", "guidance", full, full[0], full[:3])
    frame = Frame(full[0], (crowded,) * most, Picture(*full, (full[:2],) * most))
    assert decode_told(encode(frame)) == frame
    told = flight(obstacles=(BOX,) * most, names=("a vehicle",) * most)
    assert decode_told(encode(told)) == told


@pytest.mark.parametrize(
    ("message", "longest"),
    [
        (Fly(*("\N{HELICOPTER}" * 200,) * 3), LONGEST_HEARD),
        (Welcome((), ("a" * 200,) * 200, ("b" * 200,) * 200, ("twin",), ()), LONGEST_SAID),
    ],
    ids=("to the server", "to a page"),
)
def test_what_nobody_would_listen_to_is_not_said(message, longest):
    with pytest.raises(FledgeError, match=f"characters: valid are up to {longest:,}"):
        encode(message)
