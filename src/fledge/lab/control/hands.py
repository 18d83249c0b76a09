"""Whoever holds the sticks, as the controller knows them: the last thing they said, and when.

Two devices are understood, `sticks` (JSON) and a gamepad (`joy`, over ROS). What is late is dropped: a sequence number
must be larger than the last, unless nothing was heard for `anew`, as after a device has started again.
"""

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from fledge.lab import Malformed
from fledge.lab.control import joy
from fledge.lab.wire import sticks, topics
from fledge.lab.wire.datagrams import STICKS, Datagram
from fledge.lab.wire.messages import Joy
from fledge.supervision.inputs import Operator


class Holding(NamedTuple):
    """What is remembered of what people said."""

    operators: tuple[Operator, ...]
    """One per vehicle, the UAV first."""
    heard: float = -inf
    """When they last said something [s]."""
    sequence: int = -1
    """Of the last JSON datagram."""
    pad: joy.Memory = joy.Memory()
    trouble: str = ""
    """What was wrong with the last datagram that was none."""


@dataclass(frozen=True, slots=True)
class Hands:
    """How they are read."""

    gamepad: joy.Gamepad
    anew: float = 0.5  # [s]; chosen: PX4's COM_RC_LOSS_T, after which a link counts as lost

    def init(self) -> Holding:
        """Nobody has said anything."""
        return Holding((Operator(),) * self.gamepad.vehicles)

    def hear(self, memory: Holding, t: float, datagram: Datagram) -> Holding:
        """The memory after a datagram at time `t` [s]; what is none of a person's changes nothing."""
        if datagram.channel == STICKS:
            return self._hear_sticks(memory, t, sticks.decode(datagram.data))
        if datagram.channel == topics.JOY:
            return self._hear_pad(memory, t, topics.decode(datagram.channel, datagram.data))
        return memory

    def _hear_sticks(self, memory: Holding, t: float, said: sticks.Sticks | Malformed) -> Holding:
        if isinstance(said, Malformed):
            return memory._replace(trouble=said.why)
        if said.sequence <= memory.sequence and t - memory.heard <= self.anew:
            return memory
        wanted = self.gamepad.vehicles
        if len(said.operators) != wanted:
            return memory._replace(
                trouble=f"{len(said.operators)} operators: valid is {wanted}, one per vehicle"
            )
        return memory._replace(operators=said.operators, heard=t, sequence=said.sequence, trouble="")

    def _hear_pad(self, memory: Holding, t: float, message: object) -> Holding:
        if not isinstance(message, Joy):
            return memory._replace(trouble=message.why if isinstance(message, Malformed) else "")
        pad, operators = self.gamepad.step(memory.pad, message)
        if isinstance(operators, Malformed):
            return memory._replace(pad=pad, trouble=operators.why)
        return memory._replace(pad=pad, operators=operators, heard=t, trouble="")
