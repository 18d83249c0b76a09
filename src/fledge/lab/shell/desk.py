"""Who sits at the sticks of a flight, and the order to land that a process is given in their place.

People speak over wires of their own (`sticks`, `joy`), and the controller hears them itself; the desk only listens
along. Two others have no wire, so the desk speaks for them: a keyboard (`keys`), and nobody, who arms once all is ready
and then sits still.

**The order to land** comes from outside the flight: a signal, or its time is up. From then on the desk speaks for
everybody: it repeats what people say, and says "land" beside it as long as no take-over switch is on. So whoever is
there can still take over a landing, and if nobody is there, the vehicle lands all the same.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

from fledge.lab.control import keys
from fledge.lab.control.hands import Hands
from fledge.lab.control.joy import Gamepad
from fledge.lab.shell.keyboard import Terminal
from fledge.lab.wire import sticks, topics
from fledge.lab.wire.datagrams import STICKS, Datagram
from fledge.supervision.inputs import Operator, said

PEOPLE = (STICKS, topics.JOY)
"""The channels that people speak over."""

EVERY = 5
"""Ticks from one word of the desk's to the next; chosen: 20 Hz, a tenth of the silence that ends MANUAL."""


class Device(Protocol):
    """Somebody without a wire."""

    def says(self, t: float, ready: bool) -> tuple[Operator, ...] | None:
        """One operator per vehicle at time `t` [s]; None if nobody is there any more.

        `ready` tells whether there is nothing any more for which arming would have to wait.
        """
        ...


class Nobody:
    """Arms, and sits still."""

    def __init__(self, vehicles: int) -> None:
        self._vehicles = vehicles

    def says(self, t: float, ready: bool) -> tuple[Operator, ...]:
        """The same for all."""
        return (Operator(arm=float(ready)),) * self._vehicles


class Typist:
    """Whoever presses keys."""

    def __init__(self, board: keys.Keyboard, terminal: Terminal) -> None:
        self._board, self._terminal = board, terminal
        self._keys = board.init()

    def says(self, t: float, ready: bool) -> tuple[Operator, ...] | None:
        """What the keys say; an early "go" is not heard, since arming has to be seen unset before."""
        for key in self._terminal.keys():
            if ready or key != keys.GO:
                self._keys = self._board.press(self._keys, key, t)
        return None if self._terminal.gone else self._board.says(self._keys, t)


class Desk:
    """What of all this the controller hears, tick by tick."""

    def __init__(self, vehicles: int, device: Device | None = None) -> None:
        """`device` is who has no wire; None where people speak for themselves."""
        self.ready = False
        """Whether there is nothing any more for which arming would have to wait."""
        self.landing = False
        """Whether the order to land was given."""
        self._device = device
        self._hands = Hands(Gamepad(vehicles))
        self._holding = self._hands.init()
        self._still = (Operator(arm=1.0),) * vehicles
        self._ticks = 0
        self._sequence = 0

    def hear(self, t: float, datagrams: Sequence[Datagram]) -> tuple[Datagram, ...]:
        """What came in at time `t` [s], with the people's part as the controller is to hear it."""
        turn = self._ticks % EVERY == 0
        self._ticks += 1
        heard = (*datagrams, *self._spoken(t)) if turn else tuple(datagrams)
        for datagram in heard:
            if datagram.channel in PEOPLE:
                self._holding = self._hands.hear(self._holding, t, datagram)
        if not self.landing:
            return heard
        others = tuple(datagram for datagram in heard if datagram.channel not in PEOPLE)
        return (*others, self._datagram(t, self._ordered(t))) if turn else others

    def _spoken(self, t: float) -> tuple[Datagram, ...]:
        operators = None if self._device is None else self._device.says(t, self.ready)
        return (self._datagram(t, operators),) if operators else ()

    def _ordered(self, t: float) -> tuple[Operator, ...]:
        """What people say, and land."""
        there = t - self._holding.heard <= self._hands.anew
        operators = self._holding.operators if there else self._still
        if any(said(operator.switch) for operator in operators):
            return operators
        return tuple(replace(operator, land=1.0) for operator in operators)

    def _datagram(self, t: float, operators: tuple[Operator, ...]) -> Datagram:
        self._sequence = 1 + max(self._sequence, self._holding.sequence)
        return Datagram(STICKS, sticks.encode(sticks.Sticks(self._sequence, t, operators)))
