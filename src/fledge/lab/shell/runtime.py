"""A lab flight in real time: the 100 Hz loop around `lab.tick`, with the only clock and sockets there are.

    wait for a pose, or for the end of the slot (`pace`) -> datagrams in -> controller -> datagrams out
    -> what can wait: counting, the log, the view, the garbage

*Time.* A tick is timed from the moment the kernel took its newest pose off the wire to the moment the last datagram is
handed back to the kernel; without a pose, from the end of its slot. A tick over 10 ms is a deadline missed, and so is
every slot without one. Python's garbage is collected in the slack between two ticks; what is there before the flight is
never looked at again. Threads hand over within 0.2 ms, and go before all other processes where the system allows it
(`urgent`).

*Course.* Before take-off there are some seconds (`Flight.patience`) for everything to be there; what is missing then
ends the run with one line. The flight is over when the controller says so. An order to land (Ctrl-C, SIGTERM, a
terminal that is closed) is passed on by the `desk`, and the loop goes on until the vehicle is on the floor; a second
Ctrl-C ends the process, as a crash would, and leaves the vehicle to its own watchdog. Ctrl-Z would do that to a flying
drone as well, so it is not heard.
"""

import gc
import os
import signal
import sys
import time
from array import array
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import inf
from typing import Any, NamedTuple

from threadpoolctl import threadpool_limits

from fledge.errors import FledgeError
from fledge.lab.control.phases import Phase
from fledge.lab.control.tick import Controller, Said
from fledge.lab.shell.desk import Desk
from fledge.lab.shell.link import Arrival, Link
from fledge.lab.shell.logs import Entry, Log
from fledge.lab.shell.pace import PERIOD, Pacer, Slot
from fledge.lab.shell.tally import Count, Tally
from fledge.lab.wire.datagrams import Heard
from fledge.supervision.modes import Mode
from fledge.world import Reason

PATIENCE = 3.0
"""[s] for everything to be there before take-off."""
AFTERWARDS = 0.5
"""[s] for which the loop goes on when all is over, so that the last word is heard; chosen, fifty datagrams."""
LOST = 30.0
"""[s] in which nothing at all is heard after which a flight is given up; chosen: by then a drone has landed itself."""
SWITCH = 0.0002
"""[s] after which Python takes the turn from a thread that wants to go on; chosen: ticks wait no longer for the log."""
PRIORITY = 10
"""Of real-time threads; chosen: above all ordinary ones, below the kernel's own, which have 50."""
YOUNG, MIDDLE = 10, 100
"""Ticks from one collection of young garbage, and of older, to the next; chosen: some 50 us each."""
ROOM = 3_000_000
"""[ns] that must be left of a slot for that."""


@dataclass(frozen=True, slots=True)
class Flight:
    """Everything that a run needs, opened and ready."""

    controller: Controller
    link: Link
    desk: Desk
    tally: Tally
    log: Log | None = None
    show: Callable[["Now"], None] = lambda now: None
    """Called after every tick; must return at once."""
    dry: bool = False
    """Nobody arms, and the run is over once nothing is missing, or after `duration`."""
    duration: float = 0.0
    """[s] of a dry run."""
    patience: float = PATIENCE
    """[s] for everything to be there before take-off."""


class Now(NamedTuple):
    """What there is to show after a tick."""

    t: float
    """[s]."""
    said: Said
    counted: Count
    took_us: int
    missed: int
    lost: int
    """Datagrams that could not be sent."""
    ready: bool
    landing: bool
    wires: str = ""
    """What is wrong with a transport itself."""


class Outcome(NamedTuple):
    """What a run comes to."""

    counted: Count
    took_us: array
    """Of every tick [us]."""
    skipped: int
    """Slots without a tick."""
    said: Said
    """The last word."""


def fly(flight: Flight) -> Outcome:
    """Fly, to the end.

    Raises:
        FledgeError: something is missing before take-off, or nobody is heard any more after it; says what.
        KeyboardInterrupt: Ctrl-C while it lands already.
    """
    with _undisturbed(), _orders(flight.desk):
        return _Loop(flight).run()


class _Loop:
    """One run."""

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._pacer = Pacer()
        self._began = time.monotonic_ns()
        self._memory = flight.controller.init()
        self._count = flight.tally.init()
        self._took = array("q")
        self._skipped = 0
        self._heard_at = 0.0

    def run(self) -> Outcome:
        """Tick by tick."""
        slot, over, number = self._pacer.first(time.monotonic_ns()), inf, 0
        while True:
            heard, pose = self._heard(slot)
            self._memory, said = self._flight.controller.step(self._memory, heard)
            self._flight.link.send(said.datagrams)
            done = time.monotonic_ns()
            took = (done - (slot.ends if pose is None else pose)) // 1000
            self._note(Entry(number, heard, said, took, self._flight.link.complaint))
            self._ready(heard.t, said)
            if self._is_over(heard.t, said):
                over = min(over, heard.t)
            if heard.t - over >= AFTERWARDS:
                return Outcome(self._count, self._took, self._skipped, said)
            slot, number = self._next(number, slot, pose), number + 1

    def _heard(self, slot: Slot) -> tuple[Heard, int | None]:
        """(what came in, when its newest pose did [ns])."""
        early = slot.begins - time.monotonic_ns()
        if early > 0:
            time.sleep(early / 1e9)
        self._flight.link.wait(slot.ends)
        arrivals = self._flight.link.receive()
        t = (time.monotonic_ns() - self._began) / 1e9
        if arrivals:
            self._heard_at = t
        datagrams = self._flight.desk.hear(t, [arrival.datagram for arrival in arrivals])
        return Heard(t, datagrams), self._newest(arrivals)

    def _newest(self, arrivals: list[Arrival]) -> int | None:
        awaited = self._flight.link.awaited
        return next((one.at for one in reversed(arrivals) if one.datagram.channel in awaited), None)

    def _note(self, entry: Entry) -> None:
        """What can wait until the command is out."""
        flight = self._flight
        if flight.log is not None:
            flight.log.tick(entry)
        self._took.append(entry.took_us)
        self._count = flight.tally.step(self._count, entry.heard.t, entry.said)
        lost = sum(flight.link.lost.values())
        ready, landing = flight.desk.ready, flight.desk.landing
        t, took = entry.heard.t, entry.took_us
        now = Now(t, entry.said, self._count, took, self._skipped, lost, ready, landing, entry.wires)
        flight.show(now)

    def _ready(self, t: float, said: Said) -> None:
        """Whether arming may begin; ends the run if it may not in time."""
        desk = self._flight.desk
        if desk.ready or desk.landing or said.phase is not Phase.WAIT:
            return
        missing = _missing(said)
        if not missing:
            desk.ready = not self._flight.dry
        elif t >= max(self._flight.patience, self._flight.duration if self._flight.dry else 0.0):
            raise FledgeError(f"no take-off: {missing}")

    def _is_over(self, t: float, said: Said) -> bool:
        """Whether the vehicle is on the floor, and nobody wants to have it elsewhere."""
        flight = self._flight
        if said.phase is Phase.OVER:
            return True
        if said.phase is not Phase.WAIT and t - self._heard_at > LOST:
            raise FledgeError(f"nothing was heard for {LOST:g} s: the vehicle is left to itself")
        ready = flight.dry and t >= flight.duration and not _missing(said)
        return said.phase is Phase.WAIT and (flight.desk.landing or ready)

    def _next(self, number: int, slot: Slot, pose: int | None) -> Slot:
        """The next slot; the garbage is collected if it leaves time for that."""
        slot, missed = self._pacer.next(slot, time.monotonic_ns(), pose)
        self._skipped += missed
        if number % YOUNG == 0 and slot.begins + PERIOD // 2 - time.monotonic_ns() > ROOM:
            gc.collect(1 if number % MIDDLE == 0 else 0)
        return slot


def _missing(said: Said) -> str:
    """What is missing before take-off, in one line; empty if nothing is."""
    if said.complaint:
        return said.complaint
    if not said.decisions:
        return "nobody was seen yet"
    uav = said.decisions[0]
    if uav.mode == Mode.INIT:
        reason = Reason(int(uav.alarm.reason)).name.lower().replace("_", " ")
        return f"the supervisor waits, {reason if uav.alarm.reason else 'for a second of calm, disarmed'}"
    return ""


def one_thread() -> Any:
    """A context in which NumPy multiplies matrices on one core: another may be busy, and sums in another order."""
    return threadpool_limits(1, "blas")


@contextmanager
def urgent() -> Iterator[bool]:
    """This thread, and those it starts, go before all ordinary ones, if the system lets them; whether it does.

    Where it does not, everything flies as well, but ticks wait for whatever else the machine is busy with. Who was
    started to be nice (`nice`) stays so.
    """
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        if os.nice(0) > 0:
            raise PermissionError
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except OSError:  # that takes CAP_SYS_NICE, or an rtprio in limits.conf
        yield False
        return
    try:
        yield True
    finally:
        os.sched_setscheduler(0, *before)


@contextmanager
def _undisturbed() -> Iterator[None]:
    """No garbage is collected unbidden, and other threads yield soon."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH)
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        with one_thread():
            yield
    finally:
        gc.enable()
        gc.unfreeze()
        sys.setswitchinterval(before)


@contextmanager
def _orders(desk: Desk) -> Iterator[None]:
    """What the system tells the process becomes an order to land; a second Ctrl-C ends it."""

    def land(number: int, frame: Any) -> None:
        if number == signal.SIGINT and desk.landing:
            raise KeyboardInterrupt
        desk.landing = True

    heard = {signal.SIGINT: land, signal.SIGTERM: land, signal.SIGHUP: land, signal.SIGTSTP: signal.SIG_IGN}
    before = {number: signal.signal(number, handler) for number, handler in heard.items()}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
