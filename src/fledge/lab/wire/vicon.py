"""Vicon's UDP object stream: where the cameras see every object, one datagram a frame, sent to port 51001.

All numbers are little-endian, and nothing is aligned:

    uint32      frame number
    uint8       number of items; then, for each:
      uint8       kind of item, 0 for an object
      uint16      length of the rest of it, 72 for an object
      char[24]    name, filled up with zeros
      float64[3]  position x, y, z [mm]
      float64[3]  rotation rx, ry, rz [rad]

and padding up to 256, 512 or 1,024 bytes. The rotation is about x, then about the new y, then about the
newest z: world_from_body = Rx(rx) Ry(ry) Rz(rz).

We found no page of Vicon's that describes it. This is what its public readers agree on: the table of bytes
in github.com/TheWorkshopByGM/Vicon_UDP_Stream (whose own struct is aligned, and right for the first object
alone), the port in github.com/yambati03/vicon_ros.

The stream has no time stamp, and no word for an object that the cameras have lost.
"""

from dataclasses import dataclass
from math import pi
from struct import Struct

from fledge.errors import OutOfRange
from fledge.geometry import Quat, Vec3
from fledge.lab import UINT32, Malformed, whole, within
from fledge.scalars import asin, atan2, cos, sin

PORT = 51001
SIZES = (256, 512, 1024)
"""[bytes] that a datagram is padded to."""

HEAD = Struct("<IB")
ITEM = Struct("<BH")
OBJECT = Struct("<24s6d")
OBJECT_KIND = 0
LONGEST_NAME = 24
MOST_OBJECTS = (SIZES[-1] - HEAD.size) // (ITEM.size + OBJECT.size)

FARTHEST = 100.0
"""How far from the origin an object may be [m], chosen: no cameras see farther, and most values in mm are."""


@dataclass(frozen=True, slots=True)
class Object:
    """One rigid body, as the cameras see it."""

    name: str
    """Up to 24 printable ASCII characters."""
    position: Vec3
    """World position [m]."""
    rotation: Vec3
    """Rotation about x, the new y and the newest z [rad]."""

    @property
    def attitude(self) -> Quat:
        """Rotation world_from_body."""
        half = self.rotation * 0.5
        cx, cy, cz = cos(half.x), cos(half.y), cos(half.z)
        sx, sy, sz = sin(half.x), sin(half.y), sin(half.z)
        return Quat(
            cx * cy * cz - sx * sy * sz,
            sx * cy * cz + cx * sy * sz,
            cx * sy * cz - sx * cy * sz,
            sx * sy * cz + cx * cy * sz,
        )


@dataclass(frozen=True, slots=True)
class Frame:
    """What the cameras saw at one instant."""

    number: int
    """Counts frames; at 100 Hz it starts again after 16 months."""
    objects: tuple[Object, ...]


def rotation_of(attitude: Quat) -> Vec3:
    """The three angles [rad] of a rotation world_from_body, the middle one within +-pi / 2.

    Right up there, nose or tail skywards, the other two are not defined, and what is returned means nothing.
    """
    up = attitude.rotate(Vec3(0.0, 0.0, 1.0))  # the last column of the matrix
    ahead = attitude.conjugate().rotate(Vec3(1.0, 0.0, 0.0))  # its first row
    return Vec3(atan2(-up.y, up.z), asin(up.x), atan2(-ahead.y, ahead.x))


def encode(frame: Frame) -> bytes:
    """The datagram of a frame, padded.

    Raises:
        OutOfRange: more objects than fit, a bad name, or a number that is not finite, or not in these units.
    """
    number = whole("frame number", frame.number, 0, UINT32)
    count = whole("number of objects", len(frame.objects), 0, MOST_OBJECTS)
    data = HEAD.pack(number, count) + b"".join(_item(one) for one in frame.objects)
    return data.ljust(next(size for size in SIZES if size >= len(data)), b"\0")


def _item(one: Object) -> bytes:
    if not _is_name(one.name):
        raise OutOfRange(
            "name of an object", repr(one.name), f"1 to {LONGEST_NAME} printable ASCII characters"
        )
    p, r = one.position, one.rotation
    metres = (within(f"position of {one.name} [m]", x, -FARTHEST, FARTHEST) for x in (p.x, p.y, p.z))
    radians = (within(f"rotation of {one.name} [rad]", x, -pi, pi) for x in (r.x, r.y, r.z))
    body = OBJECT.pack(one.name.encode(), *(1e3 * x for x in metres), *radians)
    return ITEM.pack(OBJECT_KIND, OBJECT.size) + body


def decode(data: bytes) -> Frame | Malformed:
    """The frame in a datagram. Items that are no objects are skipped, and the padding, whatever it holds."""
    if len(data) < HEAD.size:
        return Malformed(f"{len(data)} bytes: a frame has at least {HEAD.size}")
    number, items = HEAD.unpack_from(data)
    objects, start = [], HEAD.size
    for i in range(1, items + 1):
        body = start + ITEM.size
        kind, size = ITEM.unpack_from(data, start) if body <= len(data) else (OBJECT_KIND, OBJECT.size)
        start = body + size
        if start > len(data):
            return Malformed(f"{len(data)} bytes: item {i} of {items} ends at byte {start}")
        if kind == OBJECT_KIND:
            one = _object(data[body:start])
            if isinstance(one, Malformed):
                return one
            objects.append(one)
    return Frame(number, tuple(objects))


def _object(body: bytes) -> Object | Malformed:
    if len(body) != OBJECT.size:
        return Malformed(f"an object of {len(body)} bytes: valid is {OBJECT.size}")
    padded, x, y, z, rx, ry, rz = OBJECT.unpack(body)
    name = padded.partition(b"\0")[0].decode("latin-1")
    if not _is_name(name):
        return Malformed(
            f"an object called {name!r}: valid is 1 to {LONGEST_NAME} printable ASCII characters"
        )
    return Object(name, Vec3(x / 1e3, y / 1e3, z / 1e3), Vec3(rx, ry, rz))


def _is_name(name: str) -> bool:
    return 0 < len(name) <= LONGEST_NAME and name.isascii() and name.isprintable()
