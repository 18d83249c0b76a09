"""What the deck measures of itself: how fast flight time passes, and how long sticks wait for their command."""

import time
from array import array
from collections import deque
from statistics import median
from typing import Any

import numpy as np

from fledge.lab.shell.pace import PERIOD

LATELY = 100
"""Sticks over which the time to answer is taken, and pairs of ticks over which that of a flight is."""


class Pace:
    """How much flight time passes in real time, over the last two seconds or so."""

    def __init__(self) -> None:
        self._ticks = 0
        self._marks: deque[tuple[float, int]] = deque([(time.monotonic(), 0)], maxlen=LATELY)

    def step(self) -> None:
        """One tick more."""
        self._ticks += 1
        if self._ticks % 2 == 0:
            self._marks.append((time.monotonic(), self._ticks))

    def factor(self) -> float:
        """Flight time over real time."""
        (begin, first), (end, last) = self._marks[0], self._marks[-1]
        return (last - first) * PERIOD / 1e9 / (end - begin) if end > begin else 1.0


class Answers:
    """From sticks that came in to the command that went out [ms]."""

    def __init__(self) -> None:
        self._lately: deque[float] = deque(maxlen=LATELY)
        self._all = array("d")

    def add(self, came: float) -> None:
        """The command that answers what came then [s] is out."""
        took = 1e3 * (time.monotonic() - came)
        self._lately.append(took)
        self._all.append(took)

    @property
    def lately(self) -> float | None:
        """The median of the last ones; None if there were none."""
        return median(self._lately) if self._lately else None

    def summary(self) -> dict[str, Any]:
        """Of all, in plain JSON values."""
        took = np.array(self._all or [0.0])
        p50, p99 = (float(np.percentile(took, share)) for share in (50.0, 99.0))
        found = {"p50": p50, "p99": p99, "max": float(took.max())}
        return {"count": len(self._all)} | {name: round(value, 3) for name, value in found.items()}
