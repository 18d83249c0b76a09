"""The topics of a lab: bytes as Debian's ROS 1 makes them, there and back, units and signs, what is no message."""

import json
import math
from dataclasses import fields, is_dataclass, replace

import debian
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.errors import OutOfRange, UnknownName
from fledge.geometry import Quat, Vec3
from fledge.lab import Malformed
from fledge.lab.wire import topics
from fledge.lab.wire.messages import Empty, Header, Image, Joy, Navdata, Odometry, TransformStamped, Twist
from fledge.lab.wire.navdata import ControlState, Demo
from fledge.lab.wire.topics import decode, encode, kind

pytestmark = pytest.mark.slow

SEEN = Header(1_700_000_000_123_456_789, "/vicon/world", 7)
EXAMPLES = {
    topics.pose("ardrone"): TransformStamped(
        SEEN, "vicon/ardrone/ardrone", Vec3(1.0, -0.5, 0.8), Quat(0.5, -0.5, 0.5, -0.5)
    ),
    topics.FLY: Twist(Vec3(0.25, -0.5, 0.75), Vec3(0.0, 0.0, -1.5)),
    topics.JOY: Joy(Header(5, "joy", 1), (0.5, -1.0), (1, 0, 1)),
    topics.odometry("p3at"): Odometry(
        Header(10**9, "odom"),
        "base_link",
        Vec3(1.5, 2.5, 0.0),
        Quat(0.0, 0.0, 0.0, 1.0),
        Vec3(0.125, 0.0, 0.0),
        Vec3(0.0, 0.0, 0.375),
    ),
    topics.TAKE_OFF: Empty(),
    topics.PICTURES: Image(Header(1, "ardrone_base_bottomcam"), 2, 1, b"\1\2\3\4\5\6"),
    topics.NAVDATA: Navdata(
        Header(2 * 10**9 + 1, "ardrone_base_link", 3),
        Demo(
            ControlState.FLYING,
            battery=0.87,
            roll=math.radians(1.0),
            pitch=math.radians(2.0),
            yaw=math.radians(-90.0),
            altitude=1.5,
            velocity=Vec3(0.5, 0.25, 0.125),
        ),
    ),
}

VALUES = {
    topics.pose("ardrone"): {
        "header": {"seq": 7, "stamp": [1_700_000_000, 123_456_789], "frame_id": "/vicon/world"},
        "child_frame_id": "vicon/ardrone/ardrone",
        "transform": {
            "translation": {"x": 1.0, "y": -0.5, "z": 0.8},
            "rotation": {"w": 0.5, "x": -0.5, "y": 0.5, "z": -0.5},
        },
    },
    topics.FLY: {"linear": {"x": 0.25, "y": -0.5, "z": 0.75}, "angular": {"x": 0.0, "y": 0.0, "z": -1.5}},
    topics.JOY: {
        "header": {"seq": 1, "stamp": [0, 5], "frame_id": "joy"},
        "axes": [0.5, -1.0],
        "buttons": [1, 0, 1],
    },
    topics.odometry("p3at"): {
        "header": {"stamp": [1, 0], "frame_id": "odom"},
        "child_frame_id": "base_link",
        "pose": {
            "pose": {"position": {"x": 1.5, "y": 2.5}, "orientation": {"z": 1.0}},
        },
        "twist": {"twist": {"linear": {"x": 0.125}, "angular": {"z": 0.375}}},
    },
    topics.TAKE_OFF: {},
    topics.PICTURES: {
        "header": {"stamp": [0, 1], "frame_id": "ardrone_base_bottomcam"},
        "width": 2,
        "height": 1,
        "encoding": "rgb8",
        "step": 6,
        "data": [1, 2, 3, 4, 5, 6],
    },
    topics.NAVDATA: {
        "header": {"seq": 3, "stamp": [2, 1], "frame_id": "ardrone_base_link"},
        "state": 3,
        "batteryPercent": 87.0,
        "rotX": 1.0,
        "rotY": 2.0,
        "rotZ": -90.0,
        "altd": 1500,
        "vx": 500.0,
        "vy": 250.0,
        "vz": 125.0,
    },
}
"""The same, field by field, in ROS's own words and units."""

THEIRS = """
import json, sys
from importlib import import_module
from io import BytesIO
from genpy import Time
from genpy.dynamic import generate_dynamic

def filled(message, values):
    for name, value in values.items():
        if isinstance(value, dict):
            filled(getattr(message, name), value)
        elif name == "stamp":
            message.stamp = Time(*value)
        else:
            setattr(message, name, bytes(value) if name == "data" else value)
    return message

def class_of(name, text):
    package, kind = name.split("/")
    try:
        return getattr(import_module(package + ".msg"), kind)
    except ImportError:
        return generate_dynamic(name, text)[name]

out = {}
for topic, (name, text, values) in json.loads(sys.argv[1]).items():
    data = BytesIO()
    filled(class_of(name, text)(), values).serialize(data)
    out[topic] = data.getvalue().hex()
print(json.dumps(out))
"""
"""Debian's messages, filled with these and serialised by genpy."""

GOLDEN: dict[str, str] = {
    topics.pose("ardrone"): (
        "0700000000f1536515cd5b07"
        "0c0000002f7669636f6e2f776f726c64"
        "150000007669636f6e2f617264726f6e652f617264726f6e65"
        "000000000000f03f000000000000e0bf9a9999999999e93f"
        "000000000000e0bf000000000000e03f000000000000e0bf000000000000e03f"
    ),
    topics.FLY: "000000000000d03f000000000000e0bf000000000000e83f00000000000000000000000000000000000000000000f8bf",
    topics.JOY: (
        "010000000000000005000000030000006a6f79020000000000003f000080bf03000000010000000000000001000000"
    ),
    topics.odometry("p3at"): (
        "000000000100000000000000"
        "040000006f646f6d"
        "09000000626173655f6c696e6b"
        "000000000000f83f00000000000004400000000000000000"
        "00000000000000000000000000000000000000000000f03f0000000000000000"
        + "00"
        * 288
        + "000000000000c03f00000000000000000000000000000000"
        "00000000000000000000000000000000000000000000d83f" + "00" * 288
    ),
    topics.TAKE_OFF: "",
    topics.PICTURES: (
        "000000000000000001000000"
        "16000000617264726f6e655f626173655f626f74746f6d63616d"
        "0100000002000000"
        "0400000072676238"
        "0006000000"
        "06000000010203040506"
    ),
    topics.NAVDATA: (
        "030000000200000001000000"
        "11000000617264726f6e655f626173655f6c696e6b"
        "0000ae4203000000" + "00" * 32 + "0000803f000000400000b4c2"
        "dc050000"
        "0000fa4300007a430000fa42" + "00" * 52
    ),
}
"""What that printed."""

places = st.floats(-100.0, 100.0)
vectors = st.builds(Vec3, places, places, places)
parts = st.floats(-1.0, 1.0)
headers = st.builds(
    Header, st.integers(0, 2**32 * 10**9 - 1), st.text(max_size=20), st.integers(0, 2**32 - 1)
)
quaternions = st.builds(Quat, parts, parts, parts, parts)
texts = st.text(max_size=20)
transforms = st.builds(TransformStamped, headers, texts, vectors, quaternions)
twists = st.builds(Twist, vectors, vectors)
odometries = st.builds(Odometry, headers, texts, vectors, quaternions, vectors, vectors)
axes = st.lists(st.floats(-1.0, 1.0, width=32), max_size=10).map(tuple)
joys = st.builds(Joy, headers, axes, st.lists(st.integers(0, 1), max_size=12).map(tuple))
pictures = st.tuples(st.integers(0, 5), st.integers(0, 4)).flatmap(
    lambda size: st.builds(
        Image,
        headers,
        st.just(size[0]),
        st.just(size[1]),
        st.binary(min_size=3 * size[0] * size[1], max_size=3 * size[0] * size[1]),
    )
)
SENT = {
    "/vicon/p3dx1/p3dx1": transforms,
    "/p3at/cmd_vel": twists,
    "/p3at/odom": odometries,
    topics.JOY: joys,
    topics.PICTURES: pictures,
}
angles = st.floats(-math.pi, math.pi)
demos = st.builds(
    Demo, st.sampled_from(ControlState), st.floats(0.0, 1.0), angles, angles, angles, places, vectors
)


def numbers(record):
    """Every number in a record, one after the other."""
    for field in fields(record):
        value = getattr(record, field.name)
        if is_dataclass(value):
            yield from numbers(value)
        elif isinstance(value, float | int):
            yield value


@pytest.mark.parametrize("topic", EXAMPLES)
def test_bytes_are_those_of_ros(topic):
    assert encode(EXAMPLES[topic]).hex() == GOLDEN[topic]


@debian.needs_ros
def test_ros_still_makes_these_bytes():
    asked = {topic: (kind(topic).name, kind(topic).full_text, VALUES[topic]) for topic in EXAMPLES}
    assert json.loads(debian.run(THEIRS, json.dumps(asked))) == GOLDEN


@pytest.mark.parametrize("topic", EXAMPLES)
def test_bytes_of_ros_are_read(topic):
    got = decode(topic, bytes.fromhex(GOLDEN[topic]))
    if topic == topics.NAVDATA:
        assert got.header == EXAMPLES[topic].header
        assert list(numbers(got)) == pytest.approx(list(numbers(EXAMPLES[topic])), rel=1e-6)
    else:
        assert got == EXAMPLES[topic]


@pytest.mark.parametrize("topic", SENT)
@given(data=st.data())
def test_messages_come_back(topic, data):
    message = data.draw(SENT[topic])
    assert decode(topic, encode(message)) == message


@given(headers, demos)
def test_navdata_come_back_as_exactly_as_the_wire_can_say_it(header, demo):
    got = decode(topics.NAVDATA, encode(Navdata(header, demo)))
    assert (got.header, got.demo.control, got.demo.minor) == (header, demo.control, 0)
    assert list(numbers(got.demo)) == pytest.approx(list(numbers(demo)), rel=1e-6, abs=1e-3)
    assert got.demo.altitude == pytest.approx(demo.altitude, abs=0.00051)


@pytest.mark.parametrize("topic", EXAMPLES)
@given(data=st.binary(max_size=300))
def test_no_bytes_make_it_raise(topic, data):
    assert isinstance(decode(topic, data), type(EXAMPLES[topic]) | Malformed)


@pytest.mark.parametrize("topic", EXAMPLES)
@given(data=st.data())
def test_no_changed_byte_makes_it_raise(topic, data):
    whole = bytearray.fromhex(GOLDEN[topic])
    if whole:
        whole[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    assert isinstance(decode(topic, bytes(whole)), type(EXAMPLES[topic]) | Malformed)


def test_a_stranger_to_the_lab_is_named():
    assert decode("/tf", b"").why.startswith("unknown topic '/tf': valid are ")
    with pytest.raises(UnknownName, match="/vicon/NAME/NAME"):
        kind("/tf")


@pytest.mark.parametrize(
    "topic", ("/vicon/ardrone/p3at", "/vicon/markers", "/odom", "/p3at/odom/x", "/p3 at/odom", "joy")
)
def test_what_only_looks_like_a_topic_is_none(topic):
    assert isinstance(decode(topic, b""), Malformed)


@pytest.mark.parametrize("bad", (math.nan, math.inf, -math.inf, 1e3))
@pytest.mark.parametrize("part", range(6))
def test_nobody_obeys_a_twist_that_is_no_command(part, bad):
    six = [0.0] * 6
    six[part] = bad
    data = topics.pack(kind(topics.FLY), *six)
    assert "a twist of" in decode(topics.FLY, data).why
    with pytest.raises(OutOfRange):
        encode(Twist(Vec3(*six[:3]), Vec3(*six[3:])))


def test_a_pose_that_is_no_number_is_for_others_to_judge():
    data = encode(EXAMPLES[topics.pose("ardrone")])
    poisoned = data[:-56] + b"\xff" * 8 + data[-48:]
    assert math.isnan(decode(topics.pose("ardrone"), poisoned).translation.x)


@pytest.mark.parametrize(
    ("topic", "changed", "what"),
    (
        (topics.pose("ardrone"), {"translation": Vec3(0.0, 1e3, 0.0)}, "place"),
        (topics.pose("ardrone"), {"rotation": Quat(2.0, 0.0, 0.0, 0.0)}, "quaternion"),
        (topics.pose("ardrone"), {"header": Header(-1)}, "stamp"),
        (topics.pose("ardrone"), {"header": Header(0, "", 2**32)}, "number of a message"),
        (topics.JOY, {"axes": (1.5,)}, "axis"),
        (topics.JOY, {"buttons": (-1,)}, "button"),
        (topics.PICTURES, {"width": 3}, "length of a picture"),
    ),
)
def test_what_has_no_place_on_the_wire_is_not_sent(topic, changed, what):
    with pytest.raises(OutOfRange, match=what):
        encode(replace(EXAMPLES[topic], **changed))


@pytest.mark.parametrize("name", ("battery", "roll", "pitch", "yaw", "altitude"))
def test_navdata_out_of_range_are_not_sent(name):
    good = EXAMPLES[topics.NAVDATA]
    with pytest.raises(OutOfRange, match=f"^{name}"):
        encode(replace(good, demo=replace(good.demo, **{name: math.nan})))


@pytest.mark.parametrize(
    ("topic", "values", "why"),
    (
        (topics.JOY, (0, 0, 10**9, "", (), ()), "a stamp with 1000000000 ns"),
        (topics.PICTURES, (0, 0, 0, "", 1, 1, "mono8", 0, 1, b"\0"), "'mono8'"),
        (topics.PICTURES, (0, 0, 0, "", 1, 1, "rgb8", 0, 4, b"\0" * 4), "in rows of 4 bytes"),
        (topics.PICTURES, (0, 0, 0, "", 1, 1, "rgb8", 0, 3, b"\0" * 4), "4 in all"),
        (topics.NAVDATA, (0, 0, 0, "", 9.0, 10, *(0,) * 22, 0, *((),) * 7, 0.0), "control state 10"),
    ),
)
def test_what_cannot_be_read_says_why(topic, values, why):
    assert why in decode(topic, topics.pack(kind(topic), *values)).why
