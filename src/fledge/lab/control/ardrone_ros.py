"""An AR.Drone and the UGVs over ROS topics (`topics`), under one of two drivers.

They mean two things by `/cmd_vel`:

    shares     ardrone_autonomy, the real drone: of a tilt in x and y, of a climb rate in z, of a turn rate
    m/s        tum_simulator: velocities

Topics have no state that holds: take-off and landing are events. They are sent anew every half second until navdata
say that the drone did so; a reset, which switches the emergency on and off, once a second. Under ardrone_autonomy a
twist of six zeros means the drone's own hover; a level tilt that is not to be taken for it sets `angular.x`,
which the driver reads for nothing else.

Levelling (FTRIM) and the configuration are services and parameters of the driver, so they are its launch file's to
set; as configured counts a drone that is heard.

References: src/teleop_twist.cpp and docs/usage of github.com/AutonomyLab/ardrone_autonomy (commit d35607b);
src/quadrotor_simple_controller.cpp of github.com/tum-vision/tum_simulator (commit a020d89).
"""

from dataclasses import dataclass
from enum import StrEnum
from math import inf
from typing import NamedTuple

from fledge.geometry import Vec3
from fledge.lab.control.vehicle import AbstractVehicle, Orders, Report
from fledge.lab.wire import topics
from fledge.lab.wire.ardrone import Flag, Pcmd
from fledge.lab.wire.datagrams import Datagram
from fledge.lab.wire.messages import Empty, Navdata, Twist
from fledge.lab.wire.navdata import ControlState
from fledge.world import VelocityCommand

AGAIN = 0.5
"""[s] between events that were not heeded; chosen."""
RESET_AGAIN = 1.0
"""[s] likewise: a second reset would undo the first before navdata tell of it."""
NO_HOVER = 1.0
"""Anything but zero."""
EMPTY = topics.encode(Empty())


class Meaning(StrEnum):
    """What the numbers of `/cmd_vel` are."""

    SHARES = "shares"
    VELOCITY = "m/s"


class Line(NamedTuple):
    """What is remembered of the drone."""

    report: Report = Report()
    event: float = -inf
    """When it was last told to take off, or to land [s]."""
    flying: bool = False
    """Which of the two."""
    reset: float = -inf
    """When it was last reset [s]."""


@dataclass(frozen=True, slots=True)
class ArDroneRos(AbstractVehicle):
    """The UGVs' names, in the vehicles' order, and what the driver reads."""

    ugvs: tuple[str, ...] = ()
    meaning: Meaning = Meaning.SHARES

    def init(self) -> Line:
        """Nothing was heard yet."""
        return Line()

    def hear(self, memory: Line, t: float, datagram: Datagram) -> Line:
        """Navdata."""
        if datagram.channel != topics.NAVDATA:
            return memory
        told = topics.decode(datagram.channel, datagram.data)
        if not isinstance(told, Navdata):
            return memory
        demo = told.demo
        emergency = demo.control is ControlState.DEFAULT
        return memory._replace(report=Report(t, demo.control, demo.battery, emergency, configured=True))

    def say(self, memory: Line, t: float, orders: Orders) -> tuple[Line, tuple[Datagram, ...]]:
        """(memory, a twist for every vehicle, and the event that is due)."""
        memory, events = self._events(memory, t, orders)
        tilted = self.meaning is Meaning.SHARES
        twists = [Datagram(topics.FLY, _shares(orders.tilt) if tilted else _velocity(orders.velocity))]
        for name, command in zip(self.ugvs, orders.ugvs, strict=False):
            twists.append(Datagram(topics.drive(name), _velocity(command)))
        return memory, (*events, *twists)

    def _events(self, memory: Line, t: float, orders: Orders) -> tuple[Line, list[Datagram]]:
        report = memory.report
        switch = (orders.cut and not report.emergency) or (orders.revive and report.emergency)
        if switch and t - memory.reset >= RESET_AGAIN:
            return memory._replace(reset=t), [Datagram(topics.RESET, EMPTY)]
        heeded = report.aloft == orders.fly and (orders.fly or report.control is not None)
        due = t - memory.event >= AGAIN or memory.flying != orders.fly
        if heeded or orders.cut or not due:
            return memory, []
        topic = topics.TAKE_OFF if orders.fly else topics.LAND
        return memory._replace(event=t, flying=orders.fly), [Datagram(topic, EMPTY)]


def _shares(tilt: Pcmd) -> bytes:
    if Flag.PROGRESSIVE not in tilt.flags:
        return _twist(0.0, 0.0, 0.0, 0.0)
    return _twist(-tilt.pitch, -tilt.roll, tilt.gaz, -tilt.yaw, NO_HOVER)


def _velocity(command: VelocityCommand) -> bytes:
    return _twist(command.forward, command.left, command.up, command.turn)


def _twist(forward: float, left: float, up: float, turn: float, roll: float = 0.0) -> bytes:
    return topics.encode(Twist(Vec3(forward, left, up), Vec3(roll, 0.0, turn)))
