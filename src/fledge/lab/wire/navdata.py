"""The AR.Drone's navdata: what the drone says of itself, in datagrams from its port 5554.

All numbers are little-endian:

    uint32   0x55667788
    uint32   state: 32 flags
    uint32   sequence number
    uint32   whether it runs its vision
    options, each:
      uint16   tag
      uint16   size, these four bytes included
      ...
    the last option, tag 0xFFFF, size 8:
      uint32   checksum, the sum of all bytes before this option

Of the other options the lab reads one, "demo", tag 0, size 148:

    uint32      control state: major in the upper 16 bits, minor in the lower
    uint32      battery [%]
    float32[3]  pitch (nose up), roll (right), yaw (clockwise) [0.001 degrees]
    int32       altitude [mm]
    float32[3]  velocity forward, right, down [mm/s]
    ...         108 bytes that are deprecated or about pictures; zeros here

The records turn this into our body frame: x forward, y left, z up. Until a client configures
`general:navdata_demo`, the drone sends no option but the checksum, 24 bytes in all (`State.BOOTSTRAP`).

References: Parrot, AR.Drone Developer Guide 2.0, section on navdata; AR.Drone SDK 2.0, navdata_common.h (has
the altitude in cm: clients read mm) and ardrone_navdata_client.c; lib/navdata of
github.com/felixge/node-ar-drone. Signs as in github.com/AutonomyLab/ardrone_autonomy.
"""

from dataclasses import dataclass
from enum import IntEnum, IntFlag
from math import degrees, pi, radians
from struct import Struct

from fledge.geometry import Vec3
from fledge.lab import UINT32, Malformed, whole, within

PORT = 5554
MAGIC = 0x55667788
MAGICS = (MAGIC, MAGIC + 1)
"""The second announces a quicker way to acknowledge, which changes nothing here."""

HEAD = Struct("<4I")
OPTION = Struct("<2H")
DEMO = Struct("<2I3fi3f108x")
DEMO_TAG = 0
CHECKSUM = Struct("<2HI")
CHECKSUM_TAG = 0xFFFF

MOST_MINOR = 2**16 - 1
FARTHEST = 100.0
"""Altitude [m], either way, that a drone may report; chosen: it flies to a few metres."""
FASTEST = 100.0
"""Speed along one axis [m/s] that it may report; chosen: it flies a few."""


class State(IntFlag):
    """The flags of the state that mean something to the lab; others are kept as they are."""

    FLYING = 1 << 0
    COMMAND_ACK = 1 << 6
    """A CONFIG was taken; CTRL mode 5 clears it."""
    NAVDATA_DEMO = 1 << 10
    BOOTSTRAP = 1 << 11
    """No options are sent yet."""
    MOTORS_PROBLEM = 1 << 12
    COM_LOST = 1 << 13
    """No command for 2 s."""
    BATTERY_LOW = 1 << 15
    USER_EMERGENCY = 1 << 16
    MAGNETO_CALIBRATION = 1 << 18
    ANGLES_OUT_OF_RANGE = 1 << 19
    ULTRASOUND_DEAF = 1 << 21
    CUTOUT = 1 << 22
    COM_WATCHDOG = 1 << 30
    """No command for 50 ms; COMWDG clears it."""
    EMERGENCY = 1 << 31


class ControlState(IntEnum):
    """What the drone is doing."""

    DEFAULT = 0
    INIT = 1
    LANDED = 2
    FLYING = 3
    HOVERING = 4
    TEST = 5
    TAKING_OFF = 6
    GOING_TO_FIX = 7
    LANDING = 8
    LOOPING = 9


@dataclass(frozen=True, slots=True)
class Demo:
    """The drone's own estimates."""

    control: ControlState
    battery: float
    """What is left, as a share; the wire knows whole percents."""
    roll: float
    """About x, forward: left side up [rad]."""
    pitch: float
    """About y, left: nose down [rad]."""
    yaw: float
    """About z, up: counter-clockwise from above [rad], from where the drone takes its zero."""
    altitude: float
    """Above what is below it [m]; the wire knows whole millimetres."""
    velocity: Vec3
    """Forward, left, up [m/s]."""
    minor: int = 0
    """The finer control state, a number whose meaning depends on `control`."""


@dataclass(frozen=True, slots=True)
class Navdata:
    """One datagram."""

    sequence: int
    state: State
    demo: Demo | None = None
    vision: bool = False


def fresh(navdata: Navdata, last: int) -> bool:
    """Whether this came later than the one with the number `last`; 0 if there was none, or none for a second.

    A drone that reports its watchdog counts from the start, so its number says nothing.
    """
    return navdata.sequence > (0 if State.COM_WATCHDOG in navdata.state else last)


def encode(navdata: Navdata) -> bytes:
    """The datagram, with its checksum.

    Raises:
        OutOfRange: a number that is not finite, not in these units, or too large for the wire.
    """
    state = whole("state", int(navdata.state), 0, UINT32)
    sequence = whole("sequence number", navdata.sequence, 0, UINT32)
    data = HEAD.pack(MAGIC, state, sequence, bool(navdata.vision))
    if navdata.demo is not None:
        data += OPTION.pack(DEMO_TAG, OPTION.size + DEMO.size) + _packed(navdata.demo)
    return data + CHECKSUM.pack(CHECKSUM_TAG, CHECKSUM.size, sum(data))


def _packed(demo: Demo) -> bytes:
    minor = whole("minor control state", demo.minor, 0, MOST_MINOR)
    pitch, roll, yaw = (
        1e3 * degrees(within(f"{name} [rad]", angle, -pi, pi))
        for name, angle in (("pitch", demo.pitch), ("roll", demo.roll), ("yaw", demo.yaw))
    )
    v = demo.velocity
    forward, left, up = (1e3 * within("velocity [m/s]", x, -FASTEST, FASTEST) for x in (v.x, v.y, v.z))
    return DEMO.pack(
        demo.control << 16 | minor,
        round(100.0 * within("battery, as a share,", demo.battery, 0.0, 1.0)),
        -pitch,
        roll,
        -yaw,
        round(1e3 * within("altitude [m]", demo.altitude, -FARTHEST, FARTHEST)),
        forward,
        -left,
        -up,
    )


def decode(data: bytes) -> Navdata | Malformed:
    """What a datagram says. Options that the lab does not read are skipped."""
    options_end = len(data) - CHECKSUM.size
    if options_end < HEAD.size:
        return Malformed(f"{len(data)} bytes: navdata have at least {HEAD.size + CHECKSUM.size}")
    magic, state, sequence, vision = HEAD.unpack_from(data)
    if magic not in MAGICS:
        return Malformed(f"begins with {magic:#010x}: valid is {MAGIC:#010x}")
    tag, size, told = CHECKSUM.unpack_from(data, options_end)
    if (tag, size) != (CHECKSUM_TAG, CHECKSUM.size):
        return Malformed(f"ends with option {tag} of {size} bytes: valid is a checksum, {CHECKSUM_TAG} of 8")
    total = sum(data[:options_end])
    if told != total:
        return Malformed(f"the bytes add up to {total}: the checksum says {told}")
    demo = _demo_among(data[HEAD.size : options_end])
    if isinstance(demo, Malformed):
        return demo
    return Navdata(sequence, State(state), demo, bool(vision))


def _demo_among(options: bytes) -> Demo | Malformed | None:
    """The demo option among all; None if there is none."""
    demo = None
    while options and not isinstance(demo, Malformed):
        tag, size = OPTION.unpack_from(options.ljust(OPTION.size, b"\0"))
        if not OPTION.size <= size <= len(options):
            return Malformed(f"option {tag} of {size} bytes: valid is {OPTION.size} to {len(options)}")
        if tag == DEMO_TAG:
            demo = _demo(options[OPTION.size : size])
        options = options[size:]
    return demo


def _demo(body: bytes) -> Demo | Malformed:
    if len(body) != DEMO.size:
        return Malformed(f"a demo option of {len(body)} bytes: valid is {DEMO.size}")
    state, battery, theta, phi, psi, altitude, vx, vy, vz = DEMO.unpack(body)
    major, minor = state >> 16, state & MOST_MINOR
    if major not in tuple(ControlState):
        return Malformed(f"control state {major}: valid is 0 to {max(ControlState)}")
    return Demo(
        ControlState(major),
        battery / 100.0,
        radians(phi / 1e3),
        -radians(theta / 1e3),
        -radians(psi / 1e3),
        altitude / 1e3,
        Vec3(vx / 1e3, -vy / 1e3, -vz / 1e3),
        minor,
    )
