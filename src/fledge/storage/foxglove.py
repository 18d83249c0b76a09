"""What Foxglove needs to show a flight at once: vehicles as moving frames, the arena as boxes.

Two of its well-known message types, as JSON: `foxglove.FrameTransforms`, one message per row, and
`foxglove.SceneUpdate`, one per flight. Everything here is derived from the stored rows for the eye, rounded
to a micrometre, and never read back. Foxglove asks of a JSON schema that it be an object whose properties
have one plain type each, and that an array say what its items are; `schema` makes one from an example.
"""

import json
import re
from typing import Any

import numpy as np

from fledge.geometry import Box, Quat
from fledge.world import Arena, WorldState

WORLD = "world"
"""Name of the frame that stands still: ENU."""

UAV_SIZE = (0.5, 0.5, 0.1)
UGV_SIZE = (0.5, 0.4, 0.25)
"""[m] of the boxes drawn for the vehicles; for the eye only, about an AR.Drone 2.0 and a Pioneer 3."""

OTHER_PRIMITIVES = ("arrows", "spheres", "cylinders", "lines", "triangles", "texts", "models")

_TYPES = {bool: "boolean", int: "integer", float: "number", str: "string"}


def schema(title: str, example: Any) -> dict[str, Any]:
    """The JSON schema of messages like `example`; every item of an array is like its first."""
    return {"title": title, **_schema(example)}


def template(tree: Any) -> str:
    """The JSON text of a tree whose leaves to be filled in are strings like "%s", ready for `%`."""
    return re.sub(r'"(%[^"]+)"', r"\1", json.dumps(tree, separators=(",", ":")))


def frame_names(ugvs: int) -> list[str]:
    """The vehicles' frames, UAV first."""
    return ["uav", *(f"ugv{i + 1}" for i in range(ugvs))]


def transforms(ugvs: int, number: Any = "%.6f", whole: Any = "%d") -> dict[str, Any]:
    """A FrameTransforms message with the same `number` everywhere: a template, or an example."""
    return {
        "transforms": [
            {
                "timestamp": {"sec": whole, "nsec": whole},
                "parent_frame_id": WORLD,
                "child_frame_id": name,
                "translation": dict.fromkeys("xyz", number),
                "rotation": dict.fromkeys("xyzw", number),
            }
            for name in frame_names(ugvs)
        ]
    }


def poses(world: WorldState, nanoseconds: np.ndarray) -> np.ndarray:
    """What fills the template of `transforms`, shape (rows, 9 per vehicle); not finite if a pose is not."""
    stamp = np.divmod(nanoseconds, 10**9)
    p, q = world.uav.position, world.uav.attitude
    columns = [*stamp, p.x, p.y, p.z, q.x, q.y, q.z, q.w]
    with np.errstate(invalid="ignore"):
        for ugv in world.ugvs:
            q = Quat.from_yaw(np.asarray(ugv.heading))
            columns += [*stamp, ugv.x, ugv.y, 0.0, q.x, q.y, q.z, q.w]
    full = [np.broadcast_to(column, nanoseconds.shape) for column in columns]
    return np.stack(full, axis=1).astype(float)


def scene(arena: Arena, ugvs: int, nanoseconds: int) -> dict[str, Any]:
    """A SceneUpdate message: arena, obstacles, and a box that rides on each vehicle's frame."""
    sec, nsec = divmod(nanoseconds, 10**9)
    stamp = {"sec": sec, "nsec": nsec}
    boxes = [(WORLD, "arena", *_standing(arena.bounds, arena.ceiling), (0.5, 0.6, 0.8, 0.1))]
    for i, obstacle in enumerate(arena.obstacles):
        place = _standing(obstacle.footprint, obstacle.height)
        boxes.append((WORLD, f"obstacle{i + 1}", *place, (0.6, 0.4, 0.3, 1.0)))
    uav, *others = frame_names(ugvs)
    boxes.append((uav, uav, (0.0, 0.0, 0.0), UAV_SIZE, (0.9, 0.3, 0.1, 1.0)))
    for name in others:
        boxes.append((name, name, (0.0, 0.0, UGV_SIZE[2] / 2.0), UGV_SIZE, (0.1, 0.4, 0.8, 1.0)))
    entities = [_entity(stamp, *box) for box in boxes if np.isfinite([*box[2], *box[3]]).all()]
    return {"deletions": [], "entities": entities}


Triple = tuple[float, float, float]


def _standing(box: Box, height: float) -> tuple[Triple, Triple]:
    """(centre, size) of a box on the floor."""
    width, depth = box.x_max - box.x_min, box.y_max - box.y_min
    return (box.x_min + width / 2.0, box.y_min + depth / 2.0, height / 2.0), (width, depth, height)


def _entity(
    stamp: dict[str, int], frame: str, name: str, centre: Triple, size: Triple, colour: tuple[float, ...]
) -> dict[str, Any]:
    upright = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
    cube = {
        "pose": {"position": _named("xyz", centre), "orientation": upright},
        "size": _named("xyz", size),
        "color": _named("rgba", colour),
    }
    return {
        "timestamp": stamp,
        "frame_id": frame,
        "id": name,
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": True,
        "metadata": [],
        "cubes": [cube],
        **{other: [] for other in OTHER_PRIMITIVES},
    }


def _named(names: str, values: tuple[float, ...]) -> dict[str, float]:
    return {name: float(value) for name, value in zip(names, values, strict=True)}


def _schema(example: Any) -> dict[str, Any]:
    if isinstance(example, dict):
        return {"type": "object", "properties": {name: _schema(part) for name, part in example.items()}}
    if isinstance(example, list):
        return {"type": "array", "items": _schema(example[0] if example else {})}
    return {"type": _TYPES[type(example)]}
