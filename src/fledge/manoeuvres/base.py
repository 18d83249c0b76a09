"""The protocol of a manoeuvre: a plan for the UGVs' formation, drawn from a random generator.

Three UGVs stand on the corners of an equilateral triangle around a centre that may move, with a circumradius
("spread") that may change (D10: the paper shows its formations only in a figure that is not in the source).
A manoeuvre says where that triangle should be at every row; `formation.py` drives the UGVs there, and the
simulator puts the UAV above it. The plan is drawn once per flight in NumPy, so an own manoeuvre is free to use
all of it.

"Manoeuvre" is the paper's word; in Algorithm 1 the three primitive ones are the sub-tasks.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np

from fledge.observation import ROW_RATE
from fledge.world import Arena

MAX_SPREAD_RATE = 0.1
"""[m/s] so that the altitude that answers it, 3.5 m per metre of spread, stays within 0.5 m/s."""

SPREADS = (0.6, 1.2)
"""[m] smallest and largest circumradius; altitudes of 2.1 and 4.2 m (D10)."""


@dataclass(frozen=True, slots=True)
class FormationTrack:
    """Where the formation should be; each leaf has shape (rows,), or is a number for one instant."""

    x: Any
    """Centre [m]."""
    y: Any
    """Centre [m]."""
    vx: Any
    """Velocity of the centre [m/s]."""
    vy: Any
    """Velocity of the centre [m/s]."""
    spread: Any
    """Circumradius of the triangle [m]."""
    spread_rate: Any
    """Its rate of change [m/s]."""

    @classmethod
    def through(cls, x: np.ndarray, y: np.ndarray, spread: np.ndarray) -> "FormationTrack":
        """From positions and spreads at 20 Hz; the rates are their differences."""
        rates = (np.gradient(values) * ROW_RATE for values in (x, y, spread))
        vx, vy, spread_rate = rates
        return cls(x, y, vx, vy, spread, spread_rate)


@dataclass(frozen=True, slots=True)
class Plan:
    """What is drawn before a flight: the arena, and the formation's way through it."""

    arena: Arena
    track: FormationTrack
    orientation: Any
    """Direction in which the first UGV stands from the centre [rad]."""


class AbstractManoeuvre(ABC):
    """What the UGVs do."""

    name: str
    """What the command line and the files call it."""
    axes: tuple[int, ...]
    """Indices of the actions a demonstrator may use: the sub-action space A_h of Algorithm 1."""

    @abstractmethod
    def plan(self, rng: np.random.Generator, rows: int) -> Plan:
        """A flight of `rows` rows at 20 Hz, a pure function of the generator's state."""


def smooth_ramp(rows: int, first: int, last: int) -> np.ndarray:
    """0 before row `first`, 1 after row `last`, a cubic with level ends between; shape (rows,)."""
    s = np.clip((np.arange(rows) - first) / max(last - first, 1), 0.0, 1.0)
    return s * s * (3.0 - 2.0 * s)
