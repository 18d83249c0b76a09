"""What passes between the machines of a lab: datagrams, each on a channel.

Whatever the transport, UDP, ROS or a loop in one process, the controller and the twin are given bytes and a time, and
answer with bytes. A channel is a wire's name; a ROS topic is a channel of its own, whose name begins with "/".
"""

from dataclasses import dataclass

VICON = "vicon"
"""Poses, from motion capture to the controller."""
AT = "at"
"""Commands, from the controller to the AR.Drone."""
NAVDATA = "navdata"
"""What the AR.Drone says; the other way, what makes it speak."""
STICKS = "sticks"
"""What people say, from their devices to the controller."""
GLANCES = "glances"
"""What the controller shows, to people's eyes; the other way, what asks for it."""


@dataclass(frozen=True, slots=True)
class Datagram:
    """Bytes on a wire."""

    channel: str
    data: bytes


@dataclass(frozen=True, slots=True)
class Heard:
    """What came in since the last tick."""

    t: float
    """Now [s], since the process began; never runs backwards."""
    datagrams: tuple[Datagram, ...] = ()
    """In the order of their arrival."""
