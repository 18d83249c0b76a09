"""The twin in real time: the loop around `lab.twin`, with its clock and its sockets.

    wait for the next tick -> datagrams in -> 10 ms of the twin's world -> datagrams out

Ticks lie on a grid of 10 ms, or of as much less as the twin is to run faster. A tick that is late begins at once; one
that is late by more than a whole one is missed: the twin's world then stands still for that long, and the tick is
counted. Nothing is made up for, since nobody at the other end could tell a lab in a hurry from a fault.

Ctrl-C, SIGTERM and a terminal that is closed end it after the tick they come in.
"""

import gc
import signal
import time
from array import array
from collections.abc import Iterator
from contextlib import contextmanager
from math import inf
from typing import Any

import numpy as np

from fledge.errors import OutOfRange
from fledge.lab.shell.link import Link
from fledge.lab.twin.contacts import Contact
from fledge.lab.twin.picture import Pictures
from fledge.lab.twin.twin import TICK, Twin
from fledge.lab.wire.datagrams import Heard

SPEEDS = (0.01, 50.0)
"""How much slower or faster than real time it may be asked to run; chosen."""

TIDY = 1000
"""Ticks from one collection of garbage to the next: a few milliseconds in ten seconds; chosen."""

NS = 1_000_000_000


class Stage:
    """A twin that is on."""

    def __init__(
        self,
        twin: Twin,
        link: Link,
        speed: float = 1.0,
        clock: int = 0,
        pictures: Pictures | None = None,
    ) -> None:
        """A twin, switched on.

        Args:
            twin: Who plays.
            link: The wires.
            speed: Of its world, in seconds a second.
            clock: What leads from `time.monotonic_ns` to the time of messages' stamps [ns].
            pictures: Where the twin is shown, if anywhere.

        Raises:
            OutOfRange: a speed that is not within `SPEEDS`.
        """
        if not SPEEDS[0] <= speed <= SPEEDS[1]:
            raise OutOfRange("speed of the twin", speed, f"{SPEEDS[0]:g} to {SPEEDS[1]:g}")
        self.twin, self.link = twin, link
        self.missed = 0
        """Ticks that were left out."""
        self._period = round(NS * TICK / speed)
        self._took = array("q")
        self._ending = False
        self._clock, self._pictures = clock, pictures

    def run(self, duration: float = inf) -> Iterator[Contact]:
        """Play for so many seconds of the twin's time, or until somebody ends it; yields contacts as they begin."""
        began = due = time.monotonic_ns()
        told, contacts = 0, self.twin.contacts
        self.twin.epoch = (began + self._clock) / NS
        with _undisturbed(), self._ended_by_signals():
            while self.twin.t < duration - 0.5 * TICK and not self._ending:
                time.sleep(max(due - time.monotonic_ns(), 0) / NS)
                self._tick(began)
                while told < len(contacts):
                    yield contacts[told]
                    told += 1
                due = self._next(due + self._period)

    def summary(self) -> dict[str, Any]:
        """What came of it, in plain JSON values; times are those that a tick took."""
        took = np.array(self._took or [0])
        p50, p99, p999 = (float(np.percentile(took, share)) for share in (50.0, 99.0, 99.9))
        return {
            "seconds": self.twin.t,
            "ticks": len(self._took),
            "missed": self.missed,
            "tick_us": {"p50": p50, "p99": p99, "p999": p999, "max": int(took.max())},
            "contacts": [told(contact) for contact in self.twin.contacts],
            "phase": self.twin.phase.value,
            "battery": self.twin.battery,
        }

    def _tick(self, began: int) -> None:
        start = time.monotonic_ns()
        datagrams = tuple(arrival.datagram for arrival in self.link.receive())
        now = (start - began) / NS
        self.link.send(self.twin.tick(Heard(now, datagrams)))
        if self._pictures and self._pictures.watched:
            self._pictures.show(self.twin.epoch + now, self.twin.poses())
        self._took.append((time.monotonic_ns() - start) // 1000)
        if len(self._took) % TIDY == 0:
            gc.collect()

    def _next(self, due: int) -> int:
        """When the next tick is due [ns]; those that nobody can begin any more are missed."""
        late = max(time.monotonic_ns() - due, 0) // self._period
        self.missed += late
        self.twin.miss(late)
        return due + late * self._period

    @contextmanager
    def _ended_by_signals(self) -> Iterator[None]:
        def end(number: int, frame: Any) -> None:
            self._ending = True

        numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
        before = {number: signal.signal(number, end) for number in numbers}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)


def told(contact: Contact) -> dict[str, Any]:
    """A contact in plain JSON values."""
    t, who, what, witness = contact
    return {"t": round(t, 2), "who": who, "what": what, "witness": witness.value}


@contextmanager
def _undisturbed() -> Iterator[None]:
    """No garbage is collected unbidden."""
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
        gc.unfreeze()
