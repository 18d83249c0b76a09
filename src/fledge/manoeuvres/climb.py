"""Climb: the formation spreads out on the spot; the UAV must climb to keep it the same size in the image."""

from dataclasses import dataclass

import numpy as np

from fledge.manoeuvres.base import (
    MAX_SPREAD_RATE,
    SPREADS,
    AbstractManoeuvre,
    FormationTrack,
    Plan,
    smooth_ramp,
)
from fledge.observation import ROW_RATE
from fledge.world import Arena


@dataclass(frozen=True, slots=True)
class Climb(AbstractManoeuvre):
    """Sub-task two: up."""

    name = "climb"
    axes = (2,)

    def plan(self, rng: np.random.Generator, rows: int) -> Plan:
        """The spread grows from about 0.6 to about 1.2 m."""
        small, large = SPREADS
        return plan_spread(rng, rows, small + rng.uniform(0.0, 0.1), large - rng.uniform(0.0, 0.1))


def plan_spread(rng: np.random.Generator, rows: int, first: float, last: float) -> Plan:
    """A formation that stands still somewhere and changes its spread [m] once, smoothly and within its rate."""
    x, y = rng.uniform(-2.5, 2.5, 2)
    begin = int(rng.uniform(0.5, 2.0) * ROW_RATE)
    end = max(rows - int(rng.uniform(0.5, 4.0) * ROW_RATE), begin + rows // 2)
    # The cubic's steepest slope is 1.5 times its mean.
    most = MAX_SPREAD_RATE * (end - begin) / ROW_RATE / 1.5
    change = float(np.clip(last - first, -most, most))
    spread = first + change * smooth_ramp(rows, begin, end)
    track = FormationTrack.through(np.full(rows, x), np.full(rows, y), spread)
    return Plan(Arena.square(), track, rng.uniform(0.0, 2.0 * np.pi))
