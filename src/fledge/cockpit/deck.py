"""The deck: one flight in real time, whoever watches. The only clock and the only thread of its own in the cockpit.

    wait for the slot -> what pages said -> seat -> 10 ms of the scene -> tape -> what pages are shown

Slots follow each other as in the lab (`pace`); at another speed they are shorter or longer. A slot that comes late is
missed, counted and never made up for, so flight time falls behind and `Frame.factor` says so. Pages are shown a frame
30 times a second; one that is slow is shown fewer (`site`), and delays nothing here.

Only who has the operator's seat gives orders. What was recorded waits until somebody keeps it or throws it away, also
when its flight is over or its pilot has left.
"""

import gc
import sys
import time
from array import array
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from math import inf
from queue import Empty, SimpleQueue
from statistics import median
from threading import Event, Thread
from typing import Any, NamedTuple

import numpy as np

from fledge.cockpit import asks, tells
from fledge.cockpit.asks import Fly, Sticks
from fledge.cockpit.scene import Scene, Shown
from fledge.cockpit.screen import frame
from fledge.cockpit.seat import Seats
from fledge.cockpit.stock import Stock
from fledge.cockpit.tape import Tape
from fledge.errors import FledgeError
from fledge.lab.shell.pace import PERIOD, Pacer
from fledge.lab.shell.runtime import one_thread, urgent
from fledge.supervision.supervisor import IDLE

Post = Callable[[int | None, Any], None]
"""Hands something said to a client, or to all; returns at once."""

PICTURES = 30.0
"""Frames a second."""
LATELY = 100
"""Sticks over which the time to answer is taken."""
SWITCH = 0.0005
"""[s] after which Python takes the turn from a thread that wants to go on; chosen: a twentieth of a slot."""
TIDY = 1000
"""Ticks from one collection of all garbage to the next."""
PERSON_ONLY = "take the operator's seat first"
UNSAVED = "a recording waits: keep it or throw it away first"


class Ready(NamedTuple):
    """A flight that was chosen, ready to begin."""

    fly: Fly
    scene: Scene
    memory: Any
    tape: Tape | None


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
        self._seats = Seats()
        self._seating = self._seats.init()
        self._fly: Fly | None = None
        self._scene: Scene | None = None
        self._memory: Any = None
        self._shown: Shown | None = None
        self._state = "none"
        self._preparing = False
        self._tape: Tape | None = None
        self._told = ""
        """The problem of the tape that people were told."""
        self._pacer = Pacer()
        self._ending = Event()
        self._thread = Thread(target=self._run, name="deck", daemon=True)
        self._answers: deque[float] = deque(maxlen=LATELY)
        self._all_answers = array("d")
        self._due = -inf
        self._pace = _Pace()
        self.missed = 0
        """Slots without a tick."""
        self.ticks = 0
        if stock.attached is not None:
            scene = stock.scene(Fly("lab", "", "", world="attached"))
            fly = Fly("lab", scene.about.pilot, scene.about.net, world="attached")
            self.hear(0, Ready(fly, scene, scene.init(), None))

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
        answers = np.array(self._all_answers or [0.0])
        p50, p99 = (float(np.percentile(answers, share)) for share in (50.0, 99.0))
        took = {"count": len(self._all_answers), "p50": p50, "p99": p99, "max": float(answers.max())}
        return {
            "ticks": self.ticks,
            "missed": self.missed,
            "answer_ms": {name: round(value, 3) for name, value in took.items()},
            "dropped": self._seating.dropped._asdict(),
        }

    def _run(self) -> None:
        sys.setswitchinterval(SWITCH)
        with urgent(), one_thread():
            slot = self._pacer.first(time.monotonic_ns())
            while not self._ending.is_set():
                time.sleep(max(slot.ends - time.monotonic_ns(), 0) / 1e9)
                sticks = self._listen()
                if self._state == "running":
                    self._tick()
                    self._answered(sticks)
                self._show()
                slot, missed = self._pacer.next(slot, time.monotonic_ns())
                self.missed += missed if self._state == "running" else 0
            if self._tape is not None:
                self._tape.leave()
            if self._scene is not None:
                self._scene.close()

    # What pages say.

    def _listen(self) -> list[float]:
        """When the sticks that count came in, of those that did since the last slot [s]."""
        sticks = []
        while True:
            try:
                heard = self._inbox.get_nowait()
            except Empty:
                break
            before = self._seating.heard
            self._obey(heard)
            if isinstance(heard.said, Sticks) and self._seating.heard > before:
                sticks.append(heard.at)
        self._seated(self._seats.tick(self._seating, time.monotonic()))
        return sticks

    def _obey(self, heard: Heard) -> None:
        at, client, said = heard
        if isinstance(said, (Ready, FledgeError)):
            self._prepared(client, said)
        elif isinstance(said, bool):
            self._came(client, at) if said else self._seated(self._seats.leave(self._seating, client, at))
        elif isinstance(said, Sticks):
            self._seated(self._seats.hear(self._seating, client, said, at))
        elif isinstance(said, asks.Seat):
            change = self._seats.ask if said.want else self._seats.give_up
            self._seated(change(self._seating, client, at))
        elif client != self._seating.holder:
            self._post(client, tells.Notice(PERSON_ONLY, "warning"))
        else:
            try:
                self._order(client, said)
            except FledgeError as error:
                self._complain(client, error)

    def _complain(self, client: int, error: FledgeError) -> None:
        self._post(client, tells.Notice(str(error)[:500], "error"))

    def _came(self, client: int, at: float) -> None:
        self._seating = self._seats.join(self._seating, client)
        self._post(client, self._flight())
        for one in self._seating.clients:
            self._post(one, self._seat(one))

    def _seated(self, seating: Any) -> None:
        before, self._seating = self._seating, seating
        if (before.clients, before.holder, before.waiting) != (
            seating.clients,
            seating.holder,
            seating.waiting,
        ):
            for client in seating.clients:
                self._post(client, self._seat(client))

    def _seat(self, client: int) -> tells.Seating:
        seating = self._seating
        mine, waits = seating.holder == client, client in seating.waiting
        seat = "mine" if mine else "waiting" if waits else "free" if seating.holder is None else "taken"
        return tells.Seating(seat, len(seating.clients) - (seating.holder is not None))

    def _order(self, client: int, said: Any) -> None:
        if isinstance(said, Fly) and self._stock.attached is None:
            self._begin(client, said)
        elif isinstance(said, asks.Train):
            self._stock.teach(said)
        elif isinstance(said, asks.Cancel):
            self._stock.school.cancel()
        elif self._fly is None:
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
            self._discard()
            self._begin(client, self._fly)
        elif isinstance(said, asks.Keep):
            self._keep()
        elif isinstance(said, asks.Discard):
            self._discard()

    # The flight.

    def _begin(self, client: int, fly: Fly) -> None:
        """Have a flight prepared, which takes a second or two, by somebody who has the time."""
        if self._tape is not None:
            raise FledgeError(UNSAVED)
        if self._preparing:
            raise FledgeError("a flight is being prepared: wait for it")
        self._preparing = True
        self._change("none")

        def prepare() -> None:
            try:
                scene = self._stock.scene(fly)
                ready: Any = Ready(fly, scene, scene.init(), self._stock.tape(fly, scene.about))
            except FledgeError as error:
                ready = error
            self.hear(client, ready)

        self._stock.clerk.submit(prepare)

    def _prepared(self, client: int, ready: Ready | FledgeError) -> None:
        self._preparing = False
        if isinstance(ready, FledgeError):
            self._complain(client, ready)
            return
        if self._scene is not None:
            self._scene.close()
        self._fly, self._scene, self._memory, self._tape = ready
        self._shown, self._told = None, ""
        self._pacer = Pacer(period=round(PERIOD / ready.fly.speed))
        gc.collect()
        gc.freeze()
        self._change("running")

    def _tick(self) -> None:
        assert self._scene is not None
        spoken = self._seats.say(self._seating, time.monotonic())
        self._memory, self._shown = self._scene.tick(self._memory, spoken)
        self.ticks += 1
        self._pace.step()
        self._record(self._shown)
        if self._shown.over and self._tape is not None:
            self._change("over")
        if self.ticks % TIDY == 0:
            gc.collect()

    def _record(self, shown: Shown) -> None:
        tape, fly = self._tape, self._fly
        if tape is None or fly is None or shown.row is None:
            return
        airborne = int(shown.decisions[0].mode) not in IDLE
        if shown.flown if fly.record == "demonstration" else airborne:
            tape.add(shown.row)
        if tape.problem != self._told:
            self._told = tape.problem
            self._post(None, tells.Notice(f"the recording ends here: {tape.problem}"[:500], "error"))

    def _keep(self) -> None:
        tape, self._tape = self._tape, None
        if tape is None:
            raise FledgeError("nothing was recorded that could be kept")
        self._change("over")
        self._stock.stored(tape.keep())

    def _discard(self) -> None:
        if self._tape is not None:
            self._tape.discard()
            self._tape = None
        self._change("over")

    def _change(self, state: str) -> None:
        self._state = state
        self._pace = _Pace()
        self._post(None, self._flight())

    # What pages are shown.

    def _answered(self, sticks: list[float]) -> None:
        """The command that answers these sticks is out."""
        now = time.monotonic()
        for at in sticks:
            self._answers.append(1e3 * (now - at))
            self._all_answers.append(1e3 * (now - at))

    def _flight(self) -> tells.Flight:
        return self._stock.flight(self._state, self._fly, self._scene)

    def _show(self) -> None:
        now = time.monotonic()
        if self._shown is None or self._scene is None or now < self._due:
            return
        self._due = max(self._due + 1.0 / PICTURES, now)
        seating = self._seating
        told = frame(self._shown, self._scene.about, self._scene.halts(self._memory))
        told = replace(
            told,
            rows=self._tape.rows if self._tape is not None else 0,
            factor=self._pace.factor(),
            silent=now - seating.heard if seating.heard > -inf else None,
            answer=median(self._answers) if self._answers else None,
        )
        for client in seating.clients:
            mine = client == seating.holder and seating.sticks is not None
            self._post(client, replace(told, **_newest(seating.sticks)) if mine else told)


def _newest(sticks: Any) -> dict[str, Any]:
    return {"sequence": sticks.sequence, "stamp": sticks.stamp}


class _Pace:
    """How much flight time passes in real time, over the last second or so."""

    def __init__(self) -> None:
        self._ticks = 0
        self._marks: deque[tuple[float, int]] = deque([(time.monotonic(), 0)], maxlen=100)

    def step(self) -> None:
        """One tick more."""
        self._ticks += 1
        if self._ticks % 2 == 0:
            self._marks.append((time.monotonic(), self._ticks))

    def factor(self) -> float:
        """Flight time over real time."""
        (begin, first), (end, last) = self._marks[0], self._marks[-1]
        return (last - first) * PERIOD / 1e9 / (end - begin) if end > begin else 1.0
