"""The ROS 1 topics of a lab: what they are called, what goes over them, and its bytes.

    /vicon/<subject>/<subject>      TransformStamped   poses, by vicon_bridge; subject and segment have one name
    /ardrone/navdata                Navdata            of the AR.Drone, by ardrone_autonomy or tum_simulator
    /ardrone/bottom/image_raw       Image              of its bottom camera
    /cmd_vel                        Twist              to the AR.Drone
    /ardrone/takeoff, land, reset   Empty              likewise
    /<ugv>/odom                     Odometry           a UGV's
    /<ugv>/cmd_vel                  Twist              to a UGV
    /joy                            Joy                a person's

A channel (`datagrams`) that begins with "/" is one of these. What is under way there is a message as ROS 1 serialises
it.

Quaternions have their scalar part last on the wire, first in our records. Covariances are zeros, for "unknown", and
nobody reads them. Pictures are rgb8.

ardrone_autonomy turns the drone's numbers before it sends them: `rotX` right side down, `rotY` nose down, `rotZ`
counter-clockwise [degrees], `vx` forward, `vy` left, `vz` up [mm/s], which is our body frame; tum_simulator's are the
same. `altd` is in mm: the comment in its .msg says cm, but the driver passes on the drone's own number. `state` is the
major control state. Of the other fields the lab reads none; zeros here.

References: src/vicon_bridge.cpp of github.com/ethz-asl/vicon_bridge; src/ardrone_driver.cpp of
github.com/AutonomyLab/ardrone_autonomy; src/quadrotor_state_controller.cpp of github.com/tum-vision/tum_simulator.
"""

import re
from collections.abc import Callable, Mapping
from functools import lru_cache
from math import degrees, pi, radians

from fledge.errors import OutOfRange, UnknownName
from fledge.geometry import Quat, Vec3
from fledge.lab import UINT32, Malformed, whole, within
from fledge.lab.wire import definitions as d
from fledge.lab.wire.messages import (
    LATEST,
    NS,
    Empty,
    Header,
    Image,
    Joy,
    Message,
    Navdata,
    Odometry,
    TransformStamped,
    Twist,
)
from fledge.lab.wire.navdata import FARTHEST, FASTEST, ControlState, Demo
from fledge.lab.wire.rosmsg import Kind, Values, pack, unpack

NAVDATA = "/ardrone/navdata"
PICTURES = "/ardrone/bottom/image_raw"
FLY = "/cmd_vel"
TAKE_OFF = "/ardrone/takeoff"
LAND = "/ardrone/land"
RESET = "/ardrone/reset"
JOY = "/joy"

KINDS: Mapping[str, Kind] = {
    r"/vicon/(\w+)/\1": d.TRANSFORM_STAMPED,
    NAVDATA: d.NAVDATA,
    PICTURES: d.IMAGE,
    FLY: d.TWIST,
    f"{TAKE_OFF}|{LAND}|{RESET}": d.EMPTY,
    JOY: d.JOY,
    r"/\w+/odom": d.ODOMETRY,
    r"/\w+/cmd_vel": d.TWIST,
}
"""What goes over the topics with such names."""

INT32 = 2**31 - 1
FASTEST_TURN = 100.0
"""[rad/s] that a message may speak of; chosen: the nimblest drones turn at a third of it."""
UNIT = 1.000001
"""What a component of a unit quaternion may come to, rounding included."""
MOST_PIXELS = 2**14
"""Of a side, chosen: beyond any camera."""
ENCODING = "rgb8"


def pose(subject: str) -> str:
    """Where motion capture says where a subject is."""
    return f"/vicon/{subject}/{subject}"


def odometry(ugv: str) -> str:
    """Where a UGV says where it thinks it is."""
    return f"/{ugv}/odom"


def drive(ugv: str) -> str:
    """Where a UGV is told how to move."""
    return f"/{ugv}/cmd_vel"


@lru_cache
def kind(topic: str) -> Kind:
    """What goes over a topic.

    Raises:
        UnknownName: it is none of a lab's.
    """
    for pattern, found in KINDS.items():
        if re.fullmatch(pattern, topic, re.ASCII):
            return found
    names = (pattern.replace(r"(\w+)/\1", "NAME/NAME").replace(r"\w+", "NAME") for pattern in KINDS)
    raise UnknownName("topic", topic, "|".join(names).split("|"))


def encode(message: Message) -> bytes:
    """The bytes of a message.

    Raises:
        OutOfRange: a number that is not finite, not in these units, or too large for the wire.
    """
    match message:
        case Empty():
            return b""
        case TransformStamped(header, child, place, rotation):
            return pack(d.TRANSFORM_STAMPED, *_head(header), child, *_place(place), *_rotation(rotation))
        case Twist(linear, angular):
            return pack(d.TWIST, *_motion(linear, angular))
        case Odometry(header, child, place, rotation, linear, angular):
            pose, unknown = (*_place(place), *_rotation(rotation)), (0.0,) * 36
            return pack(
                d.ODOMETRY, *_head(header), child, *pose, *unknown, *_motion(linear, angular), *unknown
            )
        case Joy(header, axes, buttons):
            shares = tuple(within("axis", share, -1.0, 1.0) for share in axes)
            pressed = tuple(whole("button", button, 0, INT32) for button in buttons)
            return pack(d.JOY, *_head(header), shares, pressed)
        case Image(header, width, height, pixels):
            _check_picture(width, height, pixels)
            return pack(d.IMAGE, *_head(header), height, width, ENCODING, 0, 3 * width, pixels)
        case Navdata(header, demo):
            return pack(d.NAVDATA, *_head(header), *_told(demo))


def decode(topic: str, data: bytes) -> Message | Malformed:
    """The message in the bytes that came over a topic; a twist is obeyed at once, so its numbers have to make sense."""
    try:
        expected = kind(topic)
    except UnknownName as error:
        return Malformed(str(error))
    values = unpack(expected, data)
    return values if isinstance(values, Malformed) else READERS[expected](values)


def _head(header: Header) -> Values:
    s, ns = divmod(whole("stamp [ns]", header.stamp_ns, 0, LATEST), NS)
    return whole("number of a message", header.number, 0, UINT32), s, ns, header.frame


def _place(place: Vec3) -> Values:
    return tuple(within("place [m]", x, -FARTHEST, FARTHEST) for x in (place.x, place.y, place.z))


def _rotation(q: Quat) -> Values:
    return tuple(within("part of a unit quaternion", x, -UNIT, UNIT) for x in (q.x, q.y, q.z, q.w))


def _motion(linear: Vec3, angular: Vec3) -> Values:
    speeds = (within("velocity [m/s]", x, -FASTEST, FASTEST) for x in (linear.x, linear.y, linear.z))
    turns = (angular.x, angular.y, angular.z)
    return *speeds, *(within("turn rate [rad/s]", x, -FASTEST_TURN, FASTEST_TURN) for x in turns)


def _told(demo: Demo) -> Values:
    """The fields of Navdata after its header."""
    battery = 100.0 * within("battery, as a share,", demo.battery, 0.0, 1.0)
    angles = (("roll", demo.roll), ("pitch", demo.pitch), ("yaw", demo.yaw))
    turned = (degrees(within(f"{name} [rad]", angle, -pi, pi)) for name, angle in angles)
    altitude = round(1e3 * within("altitude [m]", demo.altitude, -FARTHEST, FARTHEST))
    v = demo.velocity
    speeds = (1e3 * within("velocity [m/s]", x, -FASTEST, FASTEST) for x in (v.x, v.y, v.z))
    compass_and_wind, acceleration_and_motors, tags = (0,) * 8, (0,) * 7, (0, *((),) * 7)
    moving = (*turned, altitude, *speeds)
    return battery, int(demo.control), *compass_and_wind, *moving, *acceleration_and_motors, *tags, 0.0


def _check_picture(width: int, height: int, pixels: bytes) -> None:
    size = 3 * whole("width [px]", width, 0, MOST_PIXELS) * whole("height [px]", height, 0, MOST_PIXELS)
    if len(pixels) != size:
        raise OutOfRange("length of a picture [bytes]", len(pixels), f"{size}, 3 a pixel")


def _header(values: Values) -> Header | Malformed:
    """The header that a message begins with."""
    number, s, ns, frame = values[:4]
    if ns >= NS:
        return Malformed(f"a stamp with {ns} ns: valid is below {NS:,}")
    return Header(s * NS + ns, frame, number)


Reader = Callable[[Values], Message | Malformed]


def _headed(read: Callable[[Header, Values], Message | Malformed]) -> Reader:
    """A reader of a message that begins with a header."""

    def reader(values: Values) -> Message | Malformed:
        header = _header(values)
        return header if isinstance(header, Malformed) else read(header, values[4:])

    return reader


def _read_transform(header: Header, values: Values) -> TransformStamped:
    child, x, y, z, *q = values
    return TransformStamped(header, child, Vec3(x, y, z), _quat(*q))


def _read_twist(values: Values) -> Twist | Malformed:
    linear, angular = values[:3], values[3:]
    if not all(-FASTEST <= x <= FASTEST for x in linear) or not all(
        -FASTEST_TURN <= x <= FASTEST_TURN for x in angular
    ):
        return Malformed(f"a twist of {values}: valid is -{FASTEST:g} to {FASTEST:g}")
    return Twist(Vec3(*linear), Vec3(*angular))


def _read_odometry(header: Header, values: Values) -> Odometry:
    child, x, y, z, *q = values[:8]
    return Odometry(header, child, Vec3(x, y, z), _quat(*q), Vec3(*values[44:47]), Vec3(*values[47:50]))


def _read_image(header: Header, values: Values) -> Image | Malformed:
    height, width, encoding, _, step, pixels = values
    if encoding != ENCODING or step != 3 * width or len(pixels) != step * height:
        got = f"{width} x {height} {encoding!r} in rows of {step} bytes, {len(pixels)} in all"
        return Malformed(f"a picture of {got}: valid is {ENCODING!r}, 3 bytes a pixel, no gaps")
    return Image(header, width, height, pixels)


def _read_navdata(header: Header, values: Values) -> Navdata | Malformed:
    percent, state = values[:2]
    roll, pitch, yaw, altitude, *velocity = values[10:17]
    if state not in tuple(ControlState):
        return Malformed(f"control state {state}: valid is 0 to {max(ControlState)}")
    angles = (radians(roll), radians(pitch), radians(yaw))
    motion = altitude / 1e3, Vec3(*(x / 1e3 for x in velocity))
    return Navdata(header, Demo(ControlState(state), percent / 100.0, *angles, *motion))


def _quat(x: float, y: float, z: float, w: float) -> Quat:
    return Quat(w, x, y, z)


READERS: Mapping[Kind, Reader] = {
    d.TRANSFORM_STAMPED: _headed(_read_transform),
    d.TWIST: _read_twist,
    d.JOY: _headed(lambda header, values: Joy(header, *values)),
    d.ODOMETRY: _headed(_read_odometry),
    d.EMPTY: lambda values: Empty(),
    d.IMAGE: _headed(_read_image),
    d.NAVDATA: _headed(_read_navdata),
}
"""How each kind is read."""
