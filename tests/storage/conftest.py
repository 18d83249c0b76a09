"""One small real flight for all tests of the storage."""

import os
import subprocess
import sys
import textwrap

import pytest

from fledge.camera import Lens
from fledge.engines import fly_plain
from fledge.episode import Flight
from fledge.geometry import Box
from fledge.manoeuvres import FixedAltitude
from fledge.observation import StickScale
from fledge.pilots import Servo
from fledge.simulation import Case, Crew
from fledge.world import Arena, Obstacle


@pytest.fixture(scope="session")
def flight() -> Flight:
    case = Case.draw(FixedAltitude(), (0,), rows=20)
    arena = Arena(Box(-5.0, 5.0, -4.0, 4.0), 6, (Obstacle(Box(1.0, 2.0, 1.0, 2.5), 0.3),))
    return Flight(
        fly_plain(case, Crew(Servo()), (0, 1)),
        manoeuvre="fixed-altitude", pilot="my.pilots:Ünlü", net="NaN", seed=2**70, case=7, axes=(0, 1),
        arena=arena, lens=Lens(700.5, levelled=False), sticks=StickScale(0.3), ideal_radius=0.1 + 0.2,
    )  # fmt: skip


@pytest.fixture
def python():
    """Start another Python with a script; it knows the same packages."""
    started = []

    def start(script: str, *arguments: object) -> subprocess.Popen:
        process = subprocess.Popen(
            [sys.executable, "-c", textwrap.dedent(script), *map(str, arguments)],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()
