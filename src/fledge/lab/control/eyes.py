"""Motion capture, whichever wire it comes over: datagrams -> poses with stamps, and whose names were heard.

    Vicon    its object stream (`vicon`); a frame has everybody in it, and a number in place of a stamp
    topics   a topic per subject (`topics.pose`), as vicon_bridge speaks; stamped by its sender's clock

Stamps are made ours by `clock`. Nothing is judged here: a pose that is no number is a pose.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from fledge.lab import Malformed
from fledge.lab.control.clock import Clock, Reading
from fledge.lab.control.estimator import Pose
from fledge.lab.wire import topics, vicon
from fledge.lab.wire.datagrams import VICON, Datagram
from fledge.lab.wire.messages import TransformStamped

Poses = tuple[tuple[int, Pose], ...]
"""Of which vehicle, and where it was."""

FORGOTTEN = 1.0
"""[s] after which a name that is heard no more is not said to have been heard; chosen."""


class View(NamedTuple):
    """What is remembered of motion capture."""

    reading: Reading | None = None
    heard: float = -inf
    """When it last spoke [s]."""
    names: tuple[tuple[str, float], ...] = ()
    """Whom it named, and when it last did [s]."""
    trouble: str = ""
    """What was wrong with the last datagram that was no frame."""

    def lately(self, t: float) -> tuple[str, ...]:
        """Whom it named of late, at time `t` [s]."""
        return tuple(name for name, when in self.names if t - when <= FORGOTTEN)


class AbstractEyes(ABC):
    """One wire; subjects have the vehicles' order, the UAV first."""

    def init(self) -> View:
        """Nothing was seen yet."""
        return View()

    @abstractmethod
    def look(self, memory: View, t: float, datagram: Datagram) -> tuple[View, Poses]:
        """(memory, the poses in a datagram received at `t` [s]); what came over other wires has none."""


@dataclass(frozen=True, slots=True)
class ViconEyes(AbstractEyes):
    """Vicon's object stream."""

    subjects: tuple[str, ...]
    clock: Clock = Clock()

    def look(self, memory: View, t: float, datagram: Datagram) -> tuple[View, Poses]:
        """Everybody in a frame; other objects are left out."""
        if datagram.channel != VICON:
            return memory, ()
        frame = vicon.decode(datagram.data)
        if isinstance(frame, Malformed):
            return memory._replace(trouble=frame.why), ()
        reading, stamp = self.clock.step(memory.reading, frame.number, t)
        seen = {one.name: one for one in frame.objects}
        poses = tuple(
            (i, Pose(stamp, seen[name].position, seen[name].attitude))
            for i, name in enumerate(self.subjects)
            if name in seen
        )
        return View(reading, t, _named(memory, t, *seen)), poses


@dataclass(frozen=True, slots=True)
class TopicEyes(AbstractEyes):
    """Topics of transforms."""

    subjects: tuple[str, ...]
    clock: Clock = Clock(rate=1.0)
    """Counts in seconds."""

    def look(self, memory: View, t: float, datagram: Datagram) -> tuple[View, Poses]:
        """The one in a message."""
        subject = next((name for name in self.subjects if datagram.channel == topics.pose(name)), None)
        if subject is None:
            return memory, ()
        message = topics.decode(datagram.channel, datagram.data)
        if not isinstance(message, TransformStamped):
            return memory._replace(trouble=message.why if isinstance(message, Malformed) else ""), ()
        reading, stamp = self.clock.step(memory.reading, message.header.stamp, t)
        pose = Pose(stamp, message.translation, message.rotation)
        return View(reading, t, _named(memory, t, subject)), ((self.subjects.index(subject), pose),)


def _named(view: View, t: float, *names: str) -> tuple[tuple[str, float], ...]:
    """Whom it named of late, these among them."""
    others = ((name, when) for name, when in view.names if name not in names and t - when <= FORGOTTEN)
    return (*others, *((name, t) for name in names))
