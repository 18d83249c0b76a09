"""The program that develops the twin's pictures: poses in on standard input, pixels out on standard output.

    uint32 length, MJCF of the scene                                             in
    a line: empty, or why there will be no pictures                              out
    then, again and again: 7 doubles a vehicle, the UAV first (`POSES`)          in
                           red, green, blue of every pixel, row by row           out

`picture` runs it, as `python -m fledge.lab.twin.darkroom WIDTH HEIGHT`. It renders what it is asked for and nothing
else, in one thread (`ALONE`), behind everything that matters more (`NICE`). Its input ends when whoever asked ends,
however that came about, and then it ends as well.

No shadows, no reflections, no smoothed edges: a frame of 640 x 360 px takes Mesa's software renderer some 5 ms instead
of 60. Poses are those of bodies: wheels do not turn, and nothing moves but the vehicles.
"""

import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from struct import Struct
from typing import IO, Any

from fledge.lab.twin.bodies import NAMES, UAV_NAME

POSE = 7
"""Numbers of a pose: x, y, z [m] and the quaternion world_from_body, scalar part first."""
POSES = Struct(f"={POSE * (1 + len(NAMES))}d")
"""A moment: the poses of all vehicles."""
LENGTH = Struct("=I")
CHANNELS = 3
"""Bytes of a pixel."""

ALONE = {"LP_NUM_THREADS": "0", "OPENBLAS_NUM_THREADS": "1"}
"""What keeps Mesa's renderer, and NumPy, to the thread that calls them; to be set before it begins."""
NICE = 10
"""How far behind others it stands in line for a core; chosen."""


class Camera:
    """The bottom camera, and what is before it."""

    def __init__(self, scene: str, width: int, height: int) -> None:
        """A scene in MJCF, and the size of pictures [px]; raises whatever MuJoCo raises where it cannot draw."""
        lib: Any = import_module("mujoco")  # which fails already where it does not know how to draw
        self._lib, self._model = lib, lib.MjModel.from_xml_string(scene)
        self._data = lib.MjData(self._model)
        starts = [int(self._model.joint(name).qposadr[0]) for name in (UAV_NAME, *NAMES)]
        self._poses = [self._data.qpos[at : at + POSE] for at in starts]
        self._renderer = lib.Renderer(self._model, height, width)
        for flag in (lib.mjtRndFlag.mjRND_SHADOW, lib.mjtRndFlag.mjRND_REFLECTION):
            self._renderer.scene.flags[flag] = 0

    def shoot(self, poses: Sequence[float]) -> bytes:
        """A picture of a moment."""
        for i, pose in enumerate(self._poses):
            pose[:] = poses[POSE * i : POSE * (i + 1)]
        self._lib.mj_kinematics(self._model, self._data)
        self._lib.mj_camlight(self._model, self._data)
        self._renderer.update_scene(self._data, camera="bottom")
        return self._renderer.render().tobytes()


def develop(wanted: IO[bytes], done: IO[bytes], width: int, height: int) -> None:
    """Answer every moment that comes with its picture, until no more come."""
    (length,) = LENGTH.unpack(wanted.read(LENGTH.size))
    try:
        camera = Camera(wanted.read(length).decode(), width, height)
    except Exception as error:  # MuJoCo, PyOpenGL and what lies below raise as they please
        _put(done, f"{type(error).__name__}: {error}".splitlines()[0].encode() + b"\n")
        return
    _put(done, b"\n")
    while len(moment := wanted.read(POSES.size)) == POSES.size:
        _put(done, camera.shoot(POSES.unpack(moment)))


def _put(done: IO[bytes], data: bytes) -> None:
    done.write(data)
    done.flush()


def main() -> None:
    """Work for whoever is at the other end of the two pipes."""
    os.nice(NICE)
    with suppress(BrokenPipeError), os.fdopen(os.dup(1), "wb") as done:
        os.dup2(2, 1)  # what a driver prints shall not come between the pixels
        develop(sys.stdin.buffer, done, int(sys.argv[1]), int(sys.argv[2]))


if __name__ == "__main__":
    main()
