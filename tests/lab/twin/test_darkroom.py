"""The darkroom, by its own protocol: what a picture shows against what the lens says, and how the program ends."""

import os
import subprocess
import sys
from contextlib import contextmanager
from math import radians
from pathlib import Path

import numpy as np
import pytest
from drawing import gone, middle, needs_egl, runs

from fledge.camera import REAL_BOTTOM_CAMERA, Lens
from fledge.geometry import Quat, Vec3
from fledge.lab.twin import darkroom
from fledge.lab.twin.bodies import BASES, NAMES, Airframe
from fledge.lab.twin.scene import mjcf
from fledge.world import Arena, UavState

WIDTH, HEIGHT = 640, 360
STILL = Vec3(0.0, 0.0, 0.0)
UGVS = ((0.55, 0.1, 1.0), (0.0, 0.55, 0.2), (-0.35, -0.45, 2.0))
"""x, y [m], heading [rad]."""


def turned(axis, angle):
    """A turn about body x, y or z."""
    half = 0.5 * angle
    return Quat(np.cos(half), *(np.sin(half) * (axis == one) for one in "xyz"))


LEVEL = Quat.from_yaw(0.0)
VIEWS = {
    "level": (Vec3(0.0, 0.0, 2.5), LEVEL),
    "aside": (Vec3(0.3, -0.2, 2.8), LEVEL),
    "turned": (Vec3(0.1, 0.0, 2.5), Quat.from_yaw(-2.0)),
    "right side down": (Vec3(0.0, 0.2, 2.6), turned("x", radians(6.0))),
    "nose down": (Vec3(0.2, 0.0, 2.6), turned("y", radians(6.0))),
}


@contextmanager
def dark(scene, width=WIDTH, height=HEIGHT, **variables):
    """A darkroom, told its scene."""
    process = subprocess.Popen(
        [sys.executable, "-m", "fledge.lab.twin.darkroom", str(width), str(height)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, "MUJOCO_GL": "egl", **darkroom.ALONE, **variables},
    )
    try:
        data = scene.encode()
        process.stdin.write(darkroom.LENGTH.pack(len(data)) + data)
        process.stdin.flush()
        yield process
    finally:
        process.kill()
        process.communicate()


def numbers(place, attitude):
    return (place.x, place.y, place.z, attitude.w, attitude.x, attitude.y, attitude.z)


def developed(process, uav, ugvs=UGVS, width=WIDTH, height=HEIGHT):
    """The picture that comes for a moment."""
    poses = [uav, *((Vec3(x, y, 0.0), Quat.from_yaw(heading)) for x, y, heading in ugvs)]
    process.stdin.write(darkroom.POSES.pack(*(number for pose in poses for number in numbers(*pose))))
    process.stdin.flush()
    size = width * height * darkroom.CHANNELS
    return np.frombuffer(process.stdout.read(size), np.uint8).reshape(height, width, darkroom.CHANNELS)


@pytest.fixture(scope="module")
def room():
    lens = Lens(levelled=False)
    with dark(mjcf(Arena.lab(), Airframe(), lens)) as process:
        assert process.stdout.readline() == b"\n"
        yield process


@needs_egl
@pytest.mark.slow
@pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS)
def test_a_ugv_is_where_the_lens_says(room, view):
    place, attitude = view
    picture = developed(room, view)
    below = attitude.rotate(Vec3(0.0, 0.0, -Airframe().half_height))
    eye = UavState(Vec3(place.x + below.x, place.y + below.y, place.z + below.z), STILL, attitude, STILL, 0.0)
    for name, base, (x, y, _) in zip(NAMES, BASES, UGVS, strict=True):
        found = middle(picture, name)
        assert found == pytest.approx(Lens(levelled=False).project(eye, x, y, base.hull.height), abs=1.0), (
            name
        )


@needs_egl
@pytest.mark.slow
def test_the_tilt_is_seen_as_no_levelled_lens_would(room):
    place, attitude = VIEWS["nose down"]
    found = middle(developed(room, (place, attitude)), "p3at")
    levelled = Lens().project(
        UavState(place, STILL, attitude, STILL, 0.0), *UGVS[0][:2], BASES[0].hull.height
    )
    assert levelled[1] - found[1] > 25.0  # 375 px tan 6 deg: it looks back, so things lie farther up


@needs_egl
@pytest.mark.slow
def test_the_top_of_the_picture_is_the_nose(room):
    picture = developed(room, VIEWS["level"], ((0.6, 0.0, 0.0), (0.0, 0.6, 0.0), (9.0, 9.0, 0.0)))
    assert middle(picture, "p3at")[1] < HEIGHT / 2 - 50
    assert middle(picture, "p3dx1")[0] < WIDTH / 2 - 50
    assert middle(picture, "p3dx2") is None


@needs_egl
@pytest.mark.slow
def test_a_longer_lens_and_another_size_are_drawn_as_well():
    lens = Lens(REAL_BOTTOM_CAMERA.focal_px / 2.0, 320.0, 180.0, levelled=False)
    with dark(mjcf(Arena.lab(), Airframe(), lens), 320, 180) as process:
        assert process.stdout.readline() == b"\n"
        height = 2.5 + Airframe().half_height
        ugvs = ((0.2, 0.3, 0.0), (9.0, 9.0, 0.0), (9.0, 9.0, 0.0))
        picture = developed(process, (Vec3(0.0, 0.0, height), LEVEL), ugvs, 320, 180)
    eye = UavState(Vec3(0.0, 0.0, 2.5), STILL, LEVEL, STILL, 0.0)
    assert middle(picture, "p3at") == pytest.approx(
        lens.project(eye, 0.2, 0.3, BASES[0].hull.height), abs=1.0
    )


@needs_egl
@pytest.mark.slow
def test_it_draws_in_one_thread_and_behind_others(room):
    developed(room, VIEWS["level"])
    names = [one.read_text() for one in Path(f"/proc/{room.pid}/task").glob("*/comm")]
    assert len(names) <= 2 and not any(
        "llvmpipe" in name for name in names
    )  # the other one keeps Mesa's cache
    assert os.getpriority(os.PRIO_PROCESS, room.pid) == min(os.getpriority(os.PRIO_PROCESS, 0) + 10, 19)


@needs_egl
@pytest.mark.slow
def test_it_ends_with_its_input():
    with dark(mjcf(Arena.lab())) as process:
        assert process.stdout.readline() == b"\n" and runs(process.pid)
        process.stdin.close()
        assert gone(process.pid)
        assert process.wait() == 0
        process.stdin = None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "variables", "said"),
    (
        ("no scene", {}, b"ValueError: "),
        (mjcf(Arena.lab()), {"MUJOCO_GL": "oil"}, b"invalid value for environment variable MUJOCO_GL: oil"),
    ),
    ids=("no scene", "nothing to draw with"),
)
def test_what_cannot_be_drawn_is_said_in_a_line(scene, variables, said):
    with dark(scene, **variables) as process:
        out = process.stdout.read()
        assert process.wait(timeout=20) == 0
    assert out.count(b"\n") == 1 and out.endswith(b"\n")
    assert said in out
