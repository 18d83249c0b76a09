"""How much of an arena is left once a vehicle keeps its margin from every wall and obstacle.

The floor is laid out in square cells of 5 cm, and a cell is free if its centre is. A corridor narrower than twice
the margin is closed, one wider by less than a cell may count as closed, too; neither is an error. Heights do not
count: what is said here holds for a UGV, and for a UAV that flies no higher than the lowest obstacle.
"""

from functools import reduce
from math import ceil

import numpy as np

from fledge.errors import FledgeError
from fledge.world import Arena

CELL = 0.05
"""Longest edge of a cell [m]; chosen, a tenth of a vehicle. Cells are stretched to fit the walls."""


def free_share(arena: Arena, margin: float) -> float:
    """Share of the floor that a vehicle's centre may reach at `margin` [m] from everything, 0 to 1.

    Where obstacles cut the floor in pieces, the largest piece counts: a vehicle cannot go from one to another.
    """
    from scipy.ndimage import label  # half a second to load, which reading an arena need not spend

    pieces, _ = label(_clearances(arena) >= margin)
    return np.bincount(pieces.ravel())[1:].max(initial=0) / pieces.size


def widest(arena: Arena) -> float:
    """The largest margin [m] that leaves room: that of the place farthest from everything; below 0 if there is none."""
    return float(_clearances(arena).max())


def check_room(arena: Arena, margin: float) -> Arena:
    """The arena itself, if a vehicle that keeps `margin` [m] (its hull's radius included) can be in it at all.

    Raises:
        FledgeError: it cannot.
    """
    most = widest(arena)
    if not most >= margin:
        bounds = arena.bounds
        raise FledgeError(
            f"a margin of {margin:g} m leaves no room in an arena of {bounds.x_max - bounds.x_min:g} x "
            f"{bounds.y_max - bounds.y_min:g} m with {len(arena.obstacles)} obstacles: valid is at most {most:g} m"
        )
    return arena


def _clearances(arena: Arena) -> np.ndarray:
    """Distance [m] from each cell's centre to the nearest wall or obstacle, below 0 inside one; shape (x, y)."""
    bounds = arena.bounds
    x = _centres(bounds.x_min, bounds.x_max)[:, None]
    y = _centres(bounds.y_min, bounds.y_max)
    to_obstacles = (obstacle.footprint.distance(x, y) for obstacle in arena.obstacles)
    return reduce(np.minimum, to_obstacles, -bounds.distance(x, y))


def _centres(low: float, high: float) -> np.ndarray:
    """Centres [m] of the cells between two walls."""
    cells = ceil((high - low) / CELL)
    return low + (np.arange(cells) + 0.5) * (high - low) / cells
