"""The ROS 1 messages that a lab speaks, as records in SI units; `topics` makes bytes of them.

    TransformStamped   where motion capture sees a vehicle, as vicon_bridge says it
    Twist              what a vehicle is told
    Joy                what a person's device says
    Odometry           where a UGV thinks it is
    Empty              take off, land, reset: what is said by being said
    Image              a picture, raw
    Navdata            what the AR.Drone says of itself

Frames are ROS's own, REP 103: x forward, y left, z up. Stamps are by the clock of whoever measured, since 1970.

`Twist` has no unit of its own. To a Pioneer (rosaria) and to tum_simulator's drone it is m/s and rad/s; to a real
AR.Drone under ardrone_autonomy it is a share from -1 to 1, of tilt in x and y.

References: wiki.ros.org/common_msgs; REP 103; src/teleop_twist.cpp of github.com/AutonomyLab/ardrone_autonomy;
src/quadrotor_simple_controller.cpp of github.com/tum-vision/tum_simulator; RosAria.cpp of
github.com/amor-ros-pkg/rosaria.
"""

from dataclasses import dataclass

from fledge.geometry import Quat, Vec3
from fledge.lab import within
from fledge.lab.wire.navdata import Demo

NS = 10**9
"""[ns] in a second."""
LATEST = 2**32 * NS - 1
"""[ns] since 1970: in February 2106, ROS 1 runs out of time."""


@dataclass(frozen=True, slots=True)
class Header:
    """Who measured, and when."""

    stamp_ns: int = 0
    """[ns] since 1970, by the clock of whoever measured; whole, as a float would round them."""
    frame: str = ""
    number: int = 0
    """Counts messages."""

    @classmethod
    def at(cls, stamp: float, frame: str = "", number: int = 0) -> "Header":
        """From a time [s]."""
        return cls(round(NS * within("stamp [s]", stamp, 0.0, LATEST // NS)), frame, number)

    @property
    def stamp(self) -> float:
        """[s], to a quarter of a microsecond."""
        return self.stamp_ns / NS


@dataclass(frozen=True, slots=True)
class TransformStamped:
    """Where something is."""

    header: Header
    child: str
    """The frame of what is there; `header.frame` is the world."""
    translation: Vec3
    """[m]."""
    rotation: Quat
    """world_from_body."""


@dataclass(frozen=True, slots=True)
class Twist:
    """How to move."""

    linear: Vec3
    """Forward, left, up; [m/s], or shares."""
    angular: Vec3
    """About these; [rad/s], or shares."""


@dataclass(frozen=True, slots=True)
class Joy:
    """Sticks and buttons, as the device has them."""

    header: Header
    axes: tuple[float, ...]
    """From -1 to 1; left and up are positive."""
    buttons: tuple[int, ...]
    """1 where pressed."""


@dataclass(frozen=True, slots=True)
class Odometry:
    """Where something thinks it is, and how it moves."""

    header: Header
    child: str
    """The frame of the velocities; `header.frame` is that of the place."""
    position: Vec3
    """[m]."""
    attitude: Quat
    """odometry_from_body."""
    linear: Vec3
    """In its own frame [m/s]."""
    angular: Vec3
    """Likewise [rad/s]."""


@dataclass(frozen=True, slots=True)
class Empty:
    """Nothing."""


@dataclass(frozen=True, slots=True)
class Image:
    """A picture."""

    header: Header
    width: int
    height: int
    pixels: bytes
    """Red, green, blue of each, row by row from the upper left."""


@dataclass(frozen=True, slots=True)
class Navdata:
    """What the AR.Drone says of itself."""

    header: Header
    demo: Demo
    """Without the minor control state, which this message has no place for."""


Message = TransformStamped | Twist | Joy | Odometry | Empty | Image | Navdata
