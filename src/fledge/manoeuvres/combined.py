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

OBSTACLES = 2
"""Boxes in the arena of every Combined flight; chosen, the paper says only "unexpected obstacles"."""

PASSAGE = 1.6
"""[m] free between boxes: a Pioneer's hull disc is 0.8 m across, and its guidance keeps 0.1 m on either side."""


@dataclass(frozen=True, slots=True)
class Combined(AbstractManoeuvre):
    """The composite task: forward, left and up."""

    families: tuple[str, ...] = TRAINING_FAMILIES
    reach: float = 2.6
    """How far [m] from the middle of the arena the centre goes."""
    name = "combined"
    axes = (0, 1, 2)

    def plan(self, rng: np.random.Generator, rows: int) -> Plan:
        """A random path, a random sequence of spreads, and boxes beside the path."""
        path = FAMILIES[str(rng.choice(self.families))](rng, self.reach)
        xy = travel(rng, path, rows)
        track = FormationTrack.through(xy[:, 0], xy[:, 1], spread_sequence(rng, rows))
        square = Arena.square()
        arena = Arena(square.bounds, square.ceiling, place_obstacles(rng, track))
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


def place_obstacles(rng: np.random.Generator, track: FormationTrack) -> tuple[Obstacle, ...]:
    """Boxes beside the path, where a corner of the triangle would pass, clear of its start and of one another."""
    placed: list[Obstacle] = []
    for _ in range(200):
        row = rng.integers(len(track.x))
        angle = rng.uniform(0.0, 2.0 * np.pi)
        off = track.spread[row] + rng.uniform(-0.1, 0.3)
        x = float(track.x[row] + off * np.cos(angle))
        y = float(track.y[row] + off * np.sin(angle))
        half_x, half_y, height = rng.uniform(0.1, 0.25), rng.uniform(0.1, 0.25), rng.uniform(0.3, 0.8)
        footprint = Box(x - half_x, x + half_x, y - half_y, y + half_y)
        clear_of_start = np.hypot(x - track.x[0], y - track.y[0]) > track.spread[0] + 1.0
        if clear_of_start and _passable(footprint, placed):
            placed.append(Obstacle(footprint, height))
        if len(placed) == OBSTACLES:
            break
    # A path with no room beside it leaves boxes over; they stand in the corners of the arena, out of the way.
    corners = [Obstacle(Box(x, x + 0.4, y, y + 0.4), 0.5) for x in (-5.0, 4.6) for y in (-5.0, 4.6)]
    return (*placed, *corners)[:OBSTACLES]


def _passable(box: Box, others: list[Obstacle]) -> bool:
    """Whether a UGV gets through between this box and every other one, and the walls."""
    gaps = [5.0 - max(abs(edge) for edge in (box.x_min, box.x_max, box.y_min, box.y_max))]
    for other in others:
        o = other.footprint
        across = max(o.x_min - box.x_max, box.x_min - o.x_max, 0.0)
        along = max(o.y_min - box.y_max, box.y_min - o.y_max, 0.0)
        gaps.append(np.hypot(across, along))
    return min(gaps) > PASSAGE
