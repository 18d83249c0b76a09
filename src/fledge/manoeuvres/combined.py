"""Combined: lateral motion while the formation climbs, descends and holds in random order, among obstacles.

The composite task of the paper ("Lateral-Movements-With-Climb-Descend"). The formation's centre follows a random
path; its spread holds, grows or shrinks in segments of 4 to 10 s; boxes stand in the UGVs' way, so that
avoiding them squeezes and stretches the triangle.
"""

from dataclasses import dataclass

import numpy as np

from fledge.geometry import Box
from fledge.manoeuvres.base import (
    MAX_SPREAD_RATE,
    SPREADS,
    AbstractManoeuvre,
    FormationTrack,
    Plan,
    smooth_ramp,
)
from fledge.manoeuvres.paths import FAMILIES, TRAINING_FAMILIES, travel
from fledge.observation import ROW_RATE
from fledge.world import Arena, Obstacle

OBSTACLES = 3
"""Boxes in the arena of every Combined flight; chosen, the paper says only "unexpected obstacles"."""


@dataclass(frozen=True, slots=True)
class Combined(AbstractManoeuvre):
    """The composite task: forward, left and up."""

    families: tuple[str, ...] = TRAINING_FAMILIES
    reach: float = 2.6
    """How far [m] from the middle of the arena the centre goes."""
    name = "combined"
    axes = (0, 1, 2)

    def plan(self, rng: np.random.Generator, rows: int) -> Plan:
        """A random path, a random sequence of spreads, and three boxes beside the path."""
        path = FAMILIES[str(rng.choice(self.families))](rng, self.reach)
        xy = travel(rng, path, rows)
        track = FormationTrack.through(xy[:, 0], xy[:, 1], spread_sequence(rng, rows))
        obstacles = tuple(place_obstacle(rng, track) for _ in range(OBSTACLES))
        square = Arena.square()
        arena = Arena(square.bounds, square.ceiling, obstacles)
        return Plan(arena, track, rng.uniform(0.0, 2.0 * np.pi))


def spread_sequence(rng: np.random.Generator, rows: int) -> np.ndarray:
    """Hold, climb and descend segments in random order; shape (rows,) [m]."""
    small, large = SPREADS
    spread = np.full(rows, rng.uniform(small, large))
    row = int(2.0 * ROW_RATE)
    while row < rows:
        length = int(rng.uniform(4.0, 10.0) * ROW_RATE)
        now = spread[-1]
        # The cubic's steepest slope is 1.5 times its mean.
        most = MAX_SPREAD_RATE * (length / ROW_RATE) / 1.5
        kind = rng.choice(["hold", "climb", "descend"])
        goal = {"hold": now, "climb": now + most, "descend": now - most}[str(kind)]
        goal = float(np.clip(goal, small, large))
        spread = spread + (goal - now) * smooth_ramp(rows, row, row + length)
        row += length
    return spread


def place_obstacle(rng: np.random.Generator, track: FormationTrack) -> Obstacle:
    """A box beside the path, where a corner of the triangle would pass, and clear of where it starts."""
    for _ in range(100):
        row = rng.integers(len(track.x))
        angle = rng.uniform(0.0, 2.0 * np.pi)
        off = track.spread[row] + rng.uniform(-0.1, 0.3)
        x, y = track.x[row] + off * np.cos(angle), track.y[row] + off * np.sin(angle)
        half_x, half_y = rng.uniform(0.1, 0.25, 2)
        height = rng.uniform(0.3, 0.8)
        from_start = np.hypot(x - track.x[0], y - track.y[0])
        if from_start > track.spread[0] + 1.0 and max(abs(x), abs(y)) < 4.5:
            return Obstacle(Box(x - half_x, x + half_x, y - half_y, y + half_y), height)
    # A path that never leaves its start has no room beside it: the box goes into a corner of the arena.
    return Obstacle(Box(4.5, 4.9, 4.5, 4.9), 0.5)
