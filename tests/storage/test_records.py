"""Records as trees of JSON: nothing lost on the way, and clear words for what does not fit."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.camera import Lens
from fledge.errors import FledgeError
from fledge.geometry import Box, Vec3
from fledge.storage.records import from_json, to_json
from fledge.world import Arena, Obstacle

any_float = st.floats(allow_nan=True, allow_infinity=True)


@given(any_float, any_float, any_float)
def test_every_number_comes_back_through_strict_json(x, y, z):
    text = json.dumps(to_json(Vec3(x, y, z)), allow_nan=False)
    back = from_json(Vec3, json.loads(text))
    for before, after in zip((x, y, z), (back.x, back.y, back.z), strict=True):
        assert before == after or (math.isnan(before) and math.isnan(after))


def test_nested_records_and_tuples_come_back():
    arena = Arena(Box(-1.0, 1.0, -2.0, 2.0), 3.0, (Obstacle(Box(0.0, 0.5, 0.0, 0.5), 0.4),))
    assert from_json(Arena, json.loads(json.dumps(to_json(arena)))) == arena


def test_a_missing_field_is_named():
    tree = to_json(Lens())
    del tree["focal_px"]
    with pytest.raises(FledgeError, match="valid are focal_px"):
        from_json(Lens, tree)


def test_a_wrong_type_is_named_where_it_stands():
    tree = to_json(Lens()) | {"width_px": "wide"}
    with pytest.raises(FledgeError, match="lens.width_px is 'wide'"):
        from_json(Lens, tree, "lens")


def test_a_truth_is_no_number():
    with pytest.raises(FledgeError, match="focal_px is True"):
        from_json(Lens, to_json(Lens()) | {"focal_px": True})
