"""What a file says is what stands in the arena; whatever is not quite an arena is refused in one line."""

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.errors import BadFile
from fledge.geometry import Box
from fledge.storage import arenas, read_arena
from fledge.world import Arena, Obstacle

DOCS = Path(__file__).parents[2] / "docs"
BOUNDS = {"x_min_m": -3.0, "x_max_m": 3, "y_min_m": -2.0, "y_max_m": 2.5, "ceiling_m": 4.0}
BOX = {"x_min_m": 1.0, "x_max_m": 1.5, "y_min_m": -1.0, "y_max_m": 1.0, "height_m": 0.5}
ARENA = Arena(Box(-3.0, 3.0, -2.0, 2.5), 4.0)
STANDING = Obstacle(Box(1.0, 1.5, -1.0, 1.0), 0.5)


def table(header: str, entries: dict) -> str:
    return "\n".join([header, *(f"{key} = {value}" for key, value in entries.items()), ""])


def toml(bounds: dict = BOUNDS, *obstacles: dict, top: str = "") -> str:
    return "\n".join([top, table("[bounds]", bounds), *(table("[[obstacle]]", one) for one in obstacles)])


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.toml"


def refused(path, content: str | bytes) -> str:
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(BadFile) as caught:
        read_arena(path)
    line = str(caught.value)
    assert line.startswith(f"{path}: ") and "\n" not in line and len(line) < 400
    return line.removeprefix(f"{path}: ")


def test_what_a_file_says_is_what_stands_there(path):
    path.write_text(toml(top="name = 'Hängar'"), encoding="utf-8")
    assert read_arena(path) == ARENA
    path.write_text(toml(BOUNDS, BOX, BOX))
    assert read_arena(path) == Arena(ARENA.bounds, 4.0, (STANDING, STANDING))
    assert all(type(edge) is float for edge in (read_arena(path).bounds.x_max, read_arena(path).ceiling))


def test_the_examples_in_the_module_and_in_the_docs_are_arenas(path):
    example = re.search(r"(?s)For example:\n\n(.*?)\nVehicles", arenas.__doc__ or "")
    documented = re.search(r"(?s)```toml\n(.*?)```", (DOCS / "how-to" / "files.md").read_text())
    assert example and documented
    for text in (example[1], documented[1]):
        path.write_text(text)
        assert len(read_arena(path).obstacles) == 1


@given(st.lists(st.floats(-50.0, 50.0), min_size=4, max_size=4, unique=True), st.floats(0.1, 50.0))
def test_every_digit_arrives(tmp_path_factory, edges, ceiling):
    x_min, x_max, y_min, y_max = *sorted(edges[:2]), *sorted(edges[2:])
    path = tmp_path_factory.getbasetemp() / "digits.toml"
    path.write_text(toml(dict(zip(BOUNDS, (x_min, x_max, y_min, y_max, ceiling), strict=True))))
    assert read_arena(path) == Arena(Box(x_min, x_max, y_min, y_max), ceiling)


@pytest.mark.parametrize("key", BOUNDS)
def test_a_missing_or_misspelt_edge_is_named(path, key):
    fewer = {k: v for k, v in BOUNDS.items() if k != key}
    assert refused(path, toml(fewer)).startswith(f"bounds has no {key}: valid is one with x_min_m, x_max_m,")
    line = refused(path, toml(fewer | {key[:-2]: 1.0}))
    assert line.startswith(f"bounds has '{key[:-2]}': valid are x_min_m, ") and key in line


def test_tables_are_named_that_are_missing_misspelt_or_none(path):
    assert refused(path, "") == "an arena has no bounds: valid is one with bounds"
    assert refused(path, toml(top="walls = 1")) == "an arena has 'walls': valid are bounds, name, obstacle"
    assert refused(path, "bounds = 5").startswith("bounds is 5: valid is a table with x_min_m")
    assert (
        refused(path, toml(top="obstacle = 5"))
        == "obstacle is 5: valid is a table under [[obstacle]] for each"
    )
    assert refused(path, toml() + table("[obstacle]", BOX)).startswith("obstacle is {'x_min_m': 1.0, ")
    assert refused(path, toml(top="obstacle = [7]")).startswith(
        "obstacle 1 is 7: valid is a table with x_min"
    )
    assert refused(path, toml(top="name = 5")) == "name is 5: valid is text"
    assert refused(path, toml(BOUNDS, BOX, {})).startswith("obstacle 2 has no x_min_m")
    assert refused(path, toml(BOUNDS, BOX | {"ceiling_m": 1.0})).startswith("obstacle 1 has 'ceiling_m'")


@pytest.mark.parametrize(
    "value", ["nan", "-inf", "'1'", "true", "[1]", "1979-05-27", "50.01", f"1{'0' * 400}"]
)
def test_an_edge_is_a_number_of_metres(path, value):
    line = refused(path, toml(BOUNDS | {"x_max_m": value}))
    assert line.startswith("x_max_m of bounds is ") and line.endswith(": valid is a number from -50 to 50")
    line = refused(path, toml(BOUNDS, BOX, BOX | {"height_m": value}))
    assert line.startswith("height_m of obstacle 2 is ")


def test_rectangles_are_upright_and_heights_positive(path):
    assert "bounds has x_min 3.5 m and x_max 3.0 m" in refused(path, toml(BOUNDS | {"x_min_m": 3.5}))
    assert "obstacle 1 has y_min 1.0 m and y_max 1.0 m" in refused(path, toml(BOUNDS, BOX | {"y_min_m": 1.0}))
    assert "ceiling [m] is 0.0: valid is a positive" in refused(path, toml(BOUNDS | {"ceiling_m": 0}))
    assert "height of obstacle 1 [m] is -1.0" in refused(path, toml(BOUNDS, BOX | {"height_m": -1}))


def test_obstacles_stand_in_the_arena_and_leave_some_of_it(path):
    behind = BOX | {"x_min_m": 3.0, "x_max_m": 4.0}
    assert "obstacle 2 stands outside, at x 3.0..4.0 m" in refused(path, toml(BOUNDS, BOX, behind))
    through = BOX | {"x_max_m": 4.0}
    path.write_text(toml(BOUNDS, through))
    assert read_arena(path).obstacles[0].footprint.x_max == 4.0
    halves = [BOUNDS | {"x_max_m": 0.1}, BOUNDS | {"x_min_m": -0.1}]
    for half in halves:
        half["height_m"] = half.pop("ceiling_m")
    assert "cover the whole floor" in refused(path, toml(BOUNDS, *halves))
    assert "number of obstacles is 65: valid is at most 64" in refused(path, toml(BOUNDS, *[BOX] * 65))


def test_what_is_no_toml_is_refused(path):
    for content in (
        b"\xff\xfe",
        bytes(100),
        b"[bounds",
        b"#!/bin/sh\nexit 1",
        toml() + "[bounds]",
    ):
        assert refused(path, content).startswith("damaged, or not an arena at all (")
    assert "line 3" in refused(path, "name = 'a'\n\nbounds 5")


def test_what_is_no_file_is_refused(tmp_path):
    with pytest.raises(BadFile, match="nowhere.toml: cannot be read: No such file or directory"):
        read_arena(tmp_path / "nowhere.toml")
    with pytest.raises(BadFile, match="cannot be read: Is a directory"):
        read_arena(tmp_path)


def test_a_file_cut_anywhere_is_refused_or_lacks_whole_obstacles(path):
    whole = toml(BOUNDS, BOX)
    for size in range(len(whole)):
        path.write_text(whole[:size])
        try:
            assert read_arena(path) in (ARENA, Arena(ARENA.bounds, 4.0, (STANDING,)))
        except BadFile:
            continue
