"""A training in the background: in a process of its own, behind everything that flies.

`School.teach` begins one; what comes of it is handed on as `tells.Lesson`, point by point of the loss curve. The
network and its file are those of `fledge train` with the same demonstrations, set-up and seed.
"""

import os
from collections.abc import Callable
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Thread
from typing import NamedTuple

from fledge.cockpit.tells import Lesson
from fledge.errors import FledgeError

NICE = 10
"""How far behind others a training stands in line for a core; chosen."""
SPAWN = get_context("spawn")
"""A forked child would have the locks of threads that it does not have."""


class Subject(NamedTuple):
    """What is to be learnt."""

    demos: Path
    setup: str
    policy: Path
    """Where the network goes."""
    epochs: int | None
    takeovers: bool


class School:
    """One training at a time."""

    def __init__(self, tell: Callable[[Lesson], None]) -> None:
        """`tell` is called in a thread of the school's."""
        self._tell = tell
        self._process = None
        self._cancelled = False
        self.lesson = Lesson("none")
        """How far it is, with all points so far."""

    def teach(self, subject: Subject) -> None:
        """Begin.

        Raises:
            FledgeError: there is a training already.
        """
        if self.lesson.state == "running":
            raise FledgeError("a network is being trained already: wait for it, or cancel it")
        ours, theirs = SPAWN.Pipe(duplex=False)
        self._cancelled = False
        self._process = SPAWN.Process(target=_work, args=(theirs, subject), name="school", daemon=True)
        self._process.start()
        theirs.close()
        self._note(Lesson("running", subject.setup))
        Thread(target=self._attend, args=(ours, subject), name="school", daemon=True).start()

    def cancel(self) -> None:
        """End it, if there is one."""
        if self._process is not None and self.lesson.state == "running":
            self._cancelled = True
            self._process.terminate()

    def _attend(self, ours: Connection, subject: Subject) -> None:
        assert self._process is not None
        problem = "the training ended without a word"
        try:
            while True:
                said = ours.recv()
                if said is None:
                    problem = ""
                elif isinstance(said, str):
                    problem = said
                else:
                    epoch, epochs, points = said
                    self._note(Lesson("running", subject.setup, "", epoch, epochs, points))
        except EOFError:
            self._process.join()
        epoch, epochs = self.lesson.epoch, self.lesson.epochs
        if self._cancelled:
            subject.policy.with_name(f"{subject.policy.name}.checkpoint.npz").unlink(missing_ok=True)
            self._note(Lesson("cancelled", subject.setup, "", epoch, epochs))
        elif problem:
            self._note(Lesson("failed", subject.setup, "", epoch, epochs, problem=problem[:500]))
        else:
            self._note(Lesson("done", subject.setup, str(subject.policy), epoch, epochs))

    def _note(self, news: Lesson) -> None:
        before = () if news.state == "running" and not news.epoch else self.lesson.points
        self.lesson = Lesson(
            news.state,
            news.setup,
            news.policy,
            news.epoch,
            news.epochs,
            (*before, *news.points),
            news.problem,
        )
        self._tell(news)


def _work(theirs: Connection, subject: Subject) -> None:
    """The child's part: says (epoch, epochs, new points) again and again, then None, or what went wrong."""
    os.nice(NICE)
    from fledge import lookup
    from fledge.runs import apprenticeship, logbook

    try:
        flights = logbook.read(subject.demos)
        taken_over = logbook.taken_over(subject.demos) if subject.takeovers else []
        recipe = apprenticeship.recipe("fast", subject.epochs)
        lesson = apprenticeship.Lesson.of(flights, lookup.setup(subject.setup), recipe, 0, taken_over)
        told = 0
        for curve in apprenticeship.steps(lesson, subject.policy):
            every = zip(curve.epochs, curve.training[:, 0], curve.validation[:, 0], strict=True)
            points = tuple(tuple(map(float, point)) for point in every)
            theirs.send((int(curve.epochs[-1]), recipe.epochs, points[told:]))
            told = len(points)
        theirs.send(None)
    except FledgeError as error:
        theirs.send(str(error))
