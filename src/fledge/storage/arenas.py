"""Arenas on disk: TOML that people write by hand, with the units in the names.

For example:

    name = "hall"      # for people; may be left out

    [bounds]           # the walls, in the world's frame: x east, y north, z up from the floor
    x_min_m = -5.0
    x_max_m = 5.0
    y_min_m = -5.0
    y_max_m = 5.0
    ceiling_m = 6.0

    [[obstacle]]       # a box that stands on the floor; one such table for each, or none
    x_min_m = 1.0
    x_max_m = 1.5
    y_min_m = -2.0
    y_max_m = -1.0
    height_m = 0.5

Vehicles fly by what stands here, so a file is read strictly: a key that is unknown, misspelt or missing is an error.
"""

import tomllib
from pathlib import Path
from typing import Any

from fledge import room
from fledge.errors import FledgeError, OutOfRange
from fledge.geometry import Box
from fledge.storage.atomic import AnyPath, reading
from fledge.storage.records import check_keys, shown
from fledge.world import Arena, Obstacle, check_arena

FARTHEST = 50.0
"""How far from the origin anything may stand [m], chosen: a hall. `room` lays it out in cells, and the obstacles that
pad an arena are to stand far outside."""

EDGES = ("x_min_m", "x_max_m", "y_min_m", "y_max_m")


def read_arena(path: AnyPath) -> Arena:
    """The arena in a file, checked.

    Raises:
        BadFile: missing, not TOML, or not an arena in which vehicles have room.
    """
    with reading(path, "an arena"):
        arena = check_arena(_arena(tomllib.loads(Path(path).read_bytes().decode())))
        if room.widest(arena) < 0.0:
            raise FledgeError("obstacles cover the whole floor: valid is an arena with some of it free")
        return arena


def _arena(file: dict[str, Any]) -> Arena:
    check_keys("an arena", file, ("bounds",), ("name", "obstacle"))
    name, obstacles = file.get("name", ""), file.get("obstacle", [])
    if not isinstance(name, str):
        raise FledgeError(f"name is {shown(name)}: valid is text")
    if not isinstance(obstacles, list):
        raise FledgeError(f"obstacle is {shown(obstacles)}: valid is a table under [[obstacle]] for each")
    return Arena(
        *_block("bounds", file["bounds"], "ceiling_m"),
        tuple(
            Obstacle(*_block(f"obstacle {i}", one, "height_m")) for i, one in enumerate(obstacles, start=1)
        ),
    )


def _block(name: str, table: Any, top: str) -> tuple[Box, float]:
    """The rectangle and the height, called `top`, that a table tells of."""
    keys = (*EDGES, top)
    check_keys(name, table, keys)
    *edges, height = (_metres(f"{key} of {name}", table[key]) for key in keys)
    return Box(*edges), height


def _metres(name: str, value: Any) -> float:
    if type(value) not in (int, float) or not -FARTHEST <= value <= FARTHEST:
        raise OutOfRange(name, shown(value), f"a number from {-FARTHEST:g} to {FARTHEST:g}")
    return float(value)
