"""Foxglove's messages: schemas it can read, frames where the vehicles are."""

import json
import math

import numpy as np
import pytest

from fledge.geometry import Box, Quat, Vec3
from fledge.storage import foxglove
from fledge.world import Arena, Obstacle, UavState, UgvState, WorldState


def world(yaw: float) -> WorldState:
    still = Vec3(0.0, 0.0, 0.0)
    uav = UavState(Vec3(1.0, 2.0, 3.0), still, Quat.from_yaw(yaw), still, 0.0)
    return WorldState(0.0, uav, (UgvState(4.0, 5.0, yaw, 0.0, 0.0, 0.0),))


def schemas(part):
    yield part
    for value in part.get("properties", {}).values():
        yield from schemas(value)
    if "items" in part:
        yield from schemas(part["items"])


@pytest.mark.parametrize(
    "example",
    [foxglove.transforms(3, 0.5, 1), foxglove.scene(Arena.square(), 3, 0)],
    ids=["frames", "scene"],
)
def test_a_schema_has_one_plain_type_everywhere(example):
    schema = foxglove.schema("title", example)
    assert schema["type"] == "object"
    plain = {"object", "array", "number", "integer", "string", "boolean"}
    assert all(part["type"] in plain for part in schemas(schema))


def test_a_filled_template_is_json_with_every_pose():
    numbers = foxglove.poses(world(math.pi / 2), np.array([1_500_000_000]))
    text = foxglove.template(foxglove.transforms(1)) % tuple(numbers[0])
    uav, ugv = json.loads(text)["transforms"]
    assert uav["timestamp"] == {"sec": 1, "nsec": 500_000_000}
    assert (uav["translation"]["z"], ugv["translation"]["x"]) == (3.0, 4.0)
    assert ugv["rotation"]["z"] == pytest.approx(math.sqrt(0.5), abs=1e-6)


def test_obstacles_stand_on_the_floor():
    arena = Arena(Box(-1.0, 1.0, -1.0, 1.0), 2.0, (Obstacle(Box(0.0, 0.4, 0.0, 0.2), 0.6),))
    entities = {entity["id"]: entity for entity in foxglove.scene(arena, 1, 0)["entities"]}
    cube = entities["obstacle1"]["cubes"][0]
    assert cube["pose"]["position"] == pytest.approx({"x": 0.2, "y": 0.1, "z": 0.3})
    assert cube["size"] == pytest.approx({"x": 0.4, "y": 0.2, "z": 0.6})
    assert {"arena", "uav", "ugv1"} <= entities.keys()
