"""A UAV at the other end of a wire, whichever wire: what it is told every tick, and what it says of itself.

A vehicle holds parameters; its memory is passed, and is a `NamedTuple` with a `report`. It keeps up its own protocol:
whoever gives the orders does not know whether they become AT commands or ROS messages.
"""

from abc import ABC, abstractmethod
from math import inf, nan
from typing import Any, NamedTuple

from fledge.lab.wire.ardrone import Pcmd
from fledge.lab.wire.datagrams import Datagram
from fledge.lab.wire.navdata import ControlState
from fledge.supervision.inputs import HOVER
from fledge.world import VelocityCommand

C = ControlState
STEADY = (C.FLYING, C.HOVERING, C.GOING_TO_FIX, C.LOOPING)
"""It is in the air and obeys."""
ALOFT = (*STEADY, C.TAKING_OFF, C.LANDING)
"""It is off the ground, or about to be."""


class Report(NamedTuple):
    """What a UAV last said of itself."""

    heard: float = -inf
    """When [s]."""
    control: ControlState | None = None
    """What it is doing; None while it has not said."""
    battery: float = nan
    """What is left, as a share."""
    emergency: bool = False
    """Whether its motors are cut."""
    configured: bool = False
    """Whether it has taken the limits that the controller counts on."""

    @property
    def aloft(self) -> bool:
        """Whether it is off the ground, or on its way up or down."""
        return self.control in ALOFT and not self.emergency

    @property
    def steady(self) -> bool:
        """Whether it flies and obeys."""
        return self.control in STEADY and not self.emergency


class Orders(NamedTuple):
    """What a tick comes to."""

    fly: bool = False
    """Take off and stay in the air; unset, land and stay on the ground."""
    trim: bool = False
    """It stands level now."""
    cut: bool = False
    """Motors off, wherever it is."""
    revive: bool = False
    """It stands on the floor: if its motors were cut, it may have them again."""
    velocity: VelocityCommand = HOVER
    """How to fly [m/s]."""
    tilt: Pcmd = Pcmd.hover()
    """The same, as the tilt that brings it about."""
    ugvs: tuple[VelocityCommand, ...] = ()
    """One command per UGV; none if they are not ours to command."""


class AbstractVehicle(ABC):
    """One wire."""

    @abstractmethod
    def init(self) -> Any:
        """The memory before anything was said."""

    @abstractmethod
    def hear(self, memory: Any, t: float, datagram: Datagram) -> Any:
        """The memory after a datagram at time `t` [s]; what came over other wires changes nothing."""

    @abstractmethod
    def say(self, memory: Any, t: float, orders: Orders) -> tuple[Any, tuple[Datagram, ...]]:
        """(memory, what to send at time `t` [s])."""
