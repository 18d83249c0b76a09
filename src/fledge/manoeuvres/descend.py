"""Descend: the formation closes up on the spot; the UAV must descend to keep it the same size in the image."""

from dataclasses import dataclass

import numpy as np

from fledge.manoeuvres.base import SPREADS, AbstractManoeuvre, Plan
from fledge.manoeuvres.climb import plan_spread


@dataclass(frozen=True, slots=True)
class Descend(AbstractManoeuvre):
    """Sub-task three: up (downwards)."""

    name = "descend"
    axes = (2,)

    def plan(self, rng: np.random.Generator, rows: int) -> Plan:
        """The spread shrinks from about 1.2 to about 0.6 m."""
        small, large = SPREADS
        return plan_spread(rng, rows, large - rng.uniform(0.0, 0.1), small + rng.uniform(0.0, 0.1))
