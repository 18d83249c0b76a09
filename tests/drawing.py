"""How tests of the twin's pictures are skipped where nothing can be drawn, and how they read a picture."""

import os
import time
from ctypes.util import find_library
from pathlib import Path

import numpy as np
import pytest

from fledge.lab.twin import darkroom

needs_egl = pytest.mark.skipif(
    find_library("EGL") is None and os.environ.get("CI") != "true",
    reason="nothing to draw with here: apt-get install libegl1 libgl1",
)

CHANNELS = {"p3at": 0, "p3dx2": 1, "p3dx1": 2}
"""Which of red, green, blue a UGV is."""


def middle(picture, name):
    """(u, v) of the middle of a UGV's lid in a picture [px], by its colour; None where there is none of it.

    Its sides have the same colour, but the light comes from above.
    """
    colours = picture.astype(int)
    channel = CHANNELS[name]
    others = np.delete(colours, channel, axis=2).max(axis=2)
    its = np.where(colours[:, :, channel] > 1.5 * others + 30, colours[:, :, channel], 0)
    rows, columns = np.nonzero(its > 0.8 * max(its.max(), 1))
    return (columns.mean() + 0.5, rows.mean() + 0.5) if len(rows) else None


def runs(pid):
    """Whether a process is there, and no mere entry that nobody has read."""
    stat = _read(f"/proc/{pid}/stat")
    return stat != "" and stat.rpartition(")")[2].split()[0] not in "ZX"


def gone(pid, patience=10.0):
    """Whether a process ends in time."""
    late = time.monotonic() + patience
    while runs(pid) and time.monotonic() < late:
        time.sleep(0.02)
    return not runs(pid)


def drawers(pid):
    """The processes that draw pictures for a process, and that still run."""
    children = [
        int(child) for path in Path(f"/proc/{pid}/task").glob("*/children") for child in _read(path).split()
    ]
    return [
        child for child in children if runs(child) and darkroom.__name__ in _read(f"/proc/{child}/cmdline")
    ]


def _read(path):
    """What a file says; nothing if what it tells of has ended."""
    try:
        return Path(path).read_text()
    except OSError:
        return ""
