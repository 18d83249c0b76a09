"""Fixed-altitude: the formation moves about and keeps its size; the UAV follows and keeps its height."""

from dataclasses import dataclass

import numpy as np

from fledge.manoeuvres.base import AbstractManoeuvre, FormationTrack, Plan
from fledge.manoeuvres.paths import FAMILIES, TRAINING_FAMILIES, travel
from fledge.world import Arena


@dataclass(frozen=True, slots=True)
class FixedAltitude(AbstractManoeuvre):
    """Sub-task one: forward and left."""

    families: tuple[str, ...] = TRAINING_FAMILIES
    spread: float = 0.8
    """Circumradius [m] (D10)."""
    reach: float = 2.6
    """How far [m] from the middle of the arena the centre goes: 1.2 m of spread still clears the walls."""
    arena: Arena = Arena.square()
    name = "fixed-altitude"
    axes = (0, 1)

    def plan(self, rng: np.random.Generator, rows: int) -> Plan:
        """A random path of one of the families."""
        path = FAMILIES[str(rng.choice(self.families))](rng, self.reach)
        xy = travel(rng, path, rows)
        track = FormationTrack.through(xy[:, 0], xy[:, 1], np.full(rows, self.spread))
        return Plan(self.arena, track, rng.uniform(0.0, 2.0 * np.pi))
