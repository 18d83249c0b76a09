"""The deck: one flight in real time, whoever watches. The only clock and the only thread of its own in the cockpit.

    wait for the slot -> what pages said -> seat -> 10 ms of the sortie -> what pages are shown

Slots follow each other as in the lab (`pace`); at another speed they are shorter or longer. A slot that comes late is
missed, counted and never made up for, so flight time falls behind and `Frame.factor` says so. Pages are shown a frame
30 times a second; one that is slow is shown fewer (`site`), and delays nothing here.

Only who has the operator's seat gives orders.
"""

import gc
import logging
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from math import inf
from queue import Empty, SimpleQueue
from threading import Event, Thread
from typing import Any, NamedTuple

from fledge.cockpit import asks, tells
from fledge.cockpit.asks import Fly, Sticks
from fledge.cockpit.meters import Answers, Pace
from fledge.cockpit.sortie import Sortie
from fledge.cockpit.stock import Stock
from fledge.cockpit.usher import Post, Usher
from fledge.errors import FledgeError
from fledge.lab.shell.pace import PERIOD, Pacer
from fledge.lab.shell.runtime import one_thread, urgent

PICTURES = 30.0
"""Frames a second."""
SWITCH = 0.0005
"""[s] after which Python takes the turn from a thread that wants to go on; chosen: a twentieth of a slot."""
TIDY = 1000
"""Ticks from one collection of all garbage to the next."""
PERSON_ONLY = "take the operator's seat first"
PREPARING = "a flight is being prepared: wait for it"
UNSAVED = "a recording waits: keep it or throw it away first"

logger = logging.getLogger(__name__)


class Heard(NamedTuple):
    """Something a page said, or that it came or went."""

    at: float
    """When it came in [s]."""
    client: int
    said: Any
    """An `Ask`, or whether the page is there; from the clerk what it was asked to prepare, or why there is none."""


class Deck:
    """A flight under way, or none; `start` begins the thread, `stop` ends it."""

    def __init__(self, stock: Stock, post: Post) -> None:
        """With the flight that there is to see, if that is what it is for.

        Raises:
            FledgeError: it cannot be seen.
        """
        self._stock, self._post = stock, post
        self._inbox: SimpleQueue[Heard] = SimpleQueue()
        self._usher = Usher(post)
        self._sortie: Sortie | None = None
        self._state = "none"
        self._preparing = False
        self._pacer = Pacer()
        self._ending = Event()
        self._thread = Thread(target=self._run, name="deck", daemon=True)
        self._answers, self._pace = Answers(), Pace()
        self._due = -inf
        self.missed = 0
        """Slots without a tick."""
        self.ticks = 0
        if stock.attached is not None:
            scene = stock.scene(Fly("lab", "", "", world="attached"))
            fly = Fly("lab", scene.about.pilot, scene.about.net, world="attached")
            self.hear(0, Sortie(fly, scene))

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """End; what is being recorded stays on disk, to be recovered."""
        self._ending.set()
        self._thread.join()

    def join(self, client: int) -> None:
        """A page is there."""
        self._inbox.put(Heard(time.monotonic(), client, True))

    def leave(self, client: int) -> None:
        """It is gone."""
        self._inbox.put(Heard(time.monotonic(), client, False))

    def hear(self, client: int, said: Any) -> None:
        """It said something."""
        self._inbox.put(Heard(time.monotonic(), client, said))

    def summary(self) -> dict[str, Any]:
        """What came of it, in plain JSON values."""
        return {
            "ticks": self.ticks,
            "missed": self.missed,
            "answer_ms": self._answers.summary(),
            "dropped": self._usher.seating.dropped._asdict(),
        }

    def _run(self) -> None:
        with _undisturbed(), urgent(), one_thread():
            slot = self._pacer.first(time.monotonic_ns())
            while not self._ending.is_set():
                time.sleep(max(slot.ends - time.monotonic_ns(), 0) / 1e9)
                sticks = self._listen()
                if self._sortie is not None and self._state == "running":
                    self._go_on(self._sortie, sticks)
                self._show()
                slot, missed = self._pacer.next(slot, time.monotonic_ns())
                self.missed += missed if self._state == "running" else 0
            if self._sortie is not None:
                self._sortie.close()

    def _go_on(self, sortie: Sortie, sticks: list[float]) -> None:
        """10 ms; whatever goes wrong in them ends the flight, not the deck."""
        try:
            self._tick(sortie)
        except Exception as error:
            logger.exception("a flight has ended")
            self._post(None, tells.Notice(f"the flight has ended by a fault of ours: {error}"[:500], "error"))
            self._change("over")
        for at in sticks:
            self._answers.add(at)

    # What pages say.

    def _listen(self) -> list[float]:
        """When the sticks that count came in, of those that did since the last slot [s]."""
        sticks = []
        with suppress(Empty):
            while True:
                heard = self._inbox.get_nowait()
                if isinstance(heard.said, Sticks):
                    if self._usher.hear(heard.client, heard.said, heard.at):
                        sticks.append(heard.at)
                else:
                    self._obey(heard)
        self._usher.tick()
        return sticks

    def _obey(self, heard: Heard) -> None:
        at, client, said = heard
        if isinstance(said, (Sortie, FledgeError)):
            self._prepared(client, said)
        elif said is True:
            self._post(client, self._flight())
            self._usher.come(client)
        elif said is False:
            self._usher.go(client, at)
        elif isinstance(said, asks.Seat):
            self._usher.ask(client, said.want, at)
        elif client != self._usher.seating.holder:
            self._post(client, tells.Notice(PERSON_ONLY, "warning"))
        else:
            try:
                self._order(client, said)
            except FledgeError as error:
                self._complain(client, error)

    def _complain(self, client: int, error: FledgeError) -> None:
        self._post(client, tells.Notice(str(error)[:500], "error"))

    def _order(self, client: int, said: Any) -> None:
        if isinstance(said, Fly) and self._stock.attached is None:
            self._begin(client, said)
        elif isinstance(said, asks.Train):
            self._stock.teach(said)
        elif isinstance(said, asks.Cancel):
            self._stock.school.cancel()
        elif self._preparing:
            raise FledgeError(PREPARING)
        elif self._sortie is None:
            raise FledgeError("nothing is being flown: start a flight first")
        elif self._stock.attached is not None:
            raise FledgeError(
                "this flight is another process's: it can be taken over and landed, and no more"
            )
        elif isinstance(said, asks.Pause) and self._state == "running":
            self._change("paused")
        elif isinstance(said, asks.Resume) and self._state == "paused":
            self._change("running")
        elif isinstance(said, asks.Reset):
            self._sortie.discard()
            self._begin(client, self._sortie.fly)
        elif isinstance(said, asks.Keep):
            self._keep(self._sortie)
        elif isinstance(said, asks.Discard):
            self._sortie.discard()
            self._change("over")

    # The flight.

    def _begin(self, client: int, fly: Fly) -> None:
        """Have a flight prepared, which takes a second or two, by somebody who has the time."""
        if self._sortie is not None and self._sortie.tape is not None:
            raise FledgeError(UNSAVED)
        if self._preparing:
            raise FledgeError(PREPARING)
        self._preparing = True
        self._change("none")

        def prepare() -> None:
            try:
                scene = self._stock.scene(fly)
                ready: Any = Sortie(fly, scene, self._stock.tape(fly, scene.about))
            except FledgeError as error:
                ready = error
            except Exception as error:  # else everybody would wait for ever
                logger.exception("a flight that cannot be prepared")
                ready = FledgeError(f"it cannot be flown, by a fault of ours: {error}")
            self.hear(client, ready)

        self._stock.clerk.submit(prepare)

    def _prepared(self, client: int, ready: Sortie | FledgeError) -> None:
        self._preparing = False
        if isinstance(ready, FledgeError):
            self._complain(client, ready)
            return
        if self._sortie is not None:
            self._sortie.close()
        self._sortie = ready
        self._pacer = Pacer(period=round(PERIOD / ready.fly.speed))
        gc.collect()
        gc.freeze()
        self._change("running")

    def _tick(self, sortie: Sortie) -> None:
        problem = sortie.tick(self._usher.say())
        self.ticks += 1
        self._pace.step()
        if problem:
            self._post(None, tells.Notice(f"the recording ends here: {problem}"[:500], "error"))
        if sortie.is_recorded:
            self._change("over")
        if self.ticks % TIDY == 0:
            gc.collect()

    def _keep(self, sortie: Sortie) -> None:
        if sortie.tape is not None:
            self._change("over")
        self._stock.stored(sortie.keep())

    def _change(self, state: str) -> None:
        self._state = state
        self._pace = Pace()
        self._post(None, self._flight())

    # What pages are shown.

    def _flight(self) -> tells.Flight:
        sortie = self._sortie
        return self._stock.flight(self._state, sortie and sortie.fly, sortie and sortie.scene)

    def _show(self) -> None:
        now = time.monotonic()
        if self._sortie is None or now < self._due:
            return
        told = self._sortie.frame()
        if told is None:
            return
        self._due = max(self._due + 1.0 / PICTURES, now)
        seating = self._usher.seating
        factor, silent, answer = self._pace.factor(), self._usher.silent, self._answers.lately
        told = replace(told, factor=factor, silent=silent, answer=answer)
        for client in seating.clients:
            mine = client == seating.holder and seating.sticks is not None
            self._post(client, replace(told, **_newest(seating.sticks)) if mine else told)


def _newest(sticks: Any) -> dict[str, Any]:
    return {"sequence": sticks.sequence, "stamp": sticks.stamp}


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Other threads yield soon, and what was there before a flight is no garbage during it."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH)
    try:
        yield
    finally:
        sys.setswitchinterval(before)
        gc.unfreeze()
