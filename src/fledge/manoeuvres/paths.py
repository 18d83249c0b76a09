"""Paths the formation's centre follows: seven families, two of them held out for testing (D10).

A path is a polyline in the plane, shape (points, 2) [m], inside a square around the origin. `travel` moves along
it at a speed that changes smoothly between 0.1 and 0.3 m/s, turning back at its ends.
"""

from collections.abc import Callable
from math import sqrt

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d

from fledge.observation import ROW_RATE

SPEEDS = (0.1, 0.3)
"""[m/s] slowest and fastest cruise (D10). In the tightest formation hulls are 0.3 m apart, and within that a UGV that
follows another may count on no more: were its link lost, it would go on for 0.6 s before it brakes."""

ACCELERATION = 0.25
"""[m/s^2] of the centre along the path; chosen well below the Pioneers' 1 m/s^2."""

POINTS = 400


def line(rng: np.random.Generator, reach: float) -> np.ndarray:
    """A straight leg through the middle of the arena."""
    angle = rng.uniform(0.0, 2.0 * np.pi)
    s = np.linspace(-reach, reach, POINTS)
    return s[:, None] * [np.cos(angle), np.sin(angle)] + rng.uniform(-0.3, 0.3, 2)


def sine(rng: np.random.Generator, reach: float) -> np.ndarray:
    """A straight leg with one to two waves across it."""
    s = np.linspace(-reach, reach, POINTS)
    wave = rng.uniform(0.4, 0.9) * np.sin(rng.uniform(1.0, 2.0) * np.pi * (s / reach) + rng.uniform(0, 6))
    return _turned(np.stack([s, wave], axis=1), rng)


def circle(rng: np.random.Generator, reach: float) -> np.ndarray:
    """A circle, almost closed."""
    radius = rng.uniform(0.5, 1.0) * reach
    angle = np.linspace(0.0, 1.9 * np.pi, POINTS) * rng.choice([-1.0, 1.0])
    return _turned(radius * np.stack([np.cos(angle), np.sin(angle)], axis=1), rng)


def ell(rng: np.random.Generator, reach: float) -> np.ndarray:
    """Two legs at a right angle, the corner rounded."""
    a, b = rng.uniform(0.6, 1.0, 2) * reach
    legs = np.concatenate([
        np.stack([np.linspace(-a, a, POINTS // 2), np.full(POINTS // 2, -b)], axis=1),
        np.stack([np.full(POINTS // 2, a), np.linspace(-b, b, POINTS // 2)], axis=1),
    ])
    return _turned(gaussian_filter1d(legs, 12.0, axis=0, mode="nearest") * 0.75, rng)


def spline(rng: np.random.Generator, reach: float) -> np.ndarray:
    """A smooth curve through five random way points."""
    way = rng.uniform(-reach, reach, (5, 2)) / np.sqrt(2.0)
    curve = CubicSpline(np.linspace(0.0, 1.0, 5), way)(np.linspace(0.0, 1.0, POINTS))
    return np.clip(curve, -reach, reach)


def zigzag(rng: np.random.Generator, reach: float) -> np.ndarray:
    """Straight legs between six random way points, the corners hardly rounded."""
    way = rng.uniform(-reach, reach, (6, 2)) / np.sqrt(2.0)
    s = np.linspace(0.0, 5.0, POINTS)
    legs = np.stack([np.interp(s, np.arange(6.0), way[:, i]) for i in range(2)], axis=1)
    return gaussian_filter1d(legs, 4.0, axis=0, mode="nearest")


def eight(rng: np.random.Generator, reach: float) -> np.ndarray:
    """A figure of eight."""
    t = np.linspace(0.0, 2.0 * np.pi, POINTS)
    size = rng.uniform(0.6, 1.0) * reach
    return _turned(size * np.stack([np.sin(t), np.sin(t) * np.cos(t)], axis=1), rng)


FAMILIES: dict[str, Callable[[np.random.Generator, float], np.ndarray]] = {
    "line": line,
    "sine": sine,
    "circle": circle,
    "ell": ell,
    "spline": spline,
    "zigzag": zigzag,
    "eight": eight,
}

TRAINING_FAMILIES = ("line", "sine", "circle")
"""Flown in demonstrations."""

DEVELOPMENT_FAMILIES = ("zigzag", "eight")
"""Flown while choosing the default method: new to whoever learnt from demonstrations, and not those of the tests."""

HELD_OUT_FAMILIES = ("ell", "spline")
"""Flown in tests only."""


def travel(rng: np.random.Generator, path: np.ndarray, rows: int) -> np.ndarray:
    """Positions at 20 Hz along `path`, there and back; shape (rows, 2) [m]."""
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    end, cruise = float(length[-1]), _cruise_speeds(rng, rows).tolist()
    s, speed, way = rng.uniform(0.2, 0.8) * end, 0.0, float(rng.choice([-1.0, 1.0]))
    change = ACCELERATION / ROW_RATE
    where = []
    for wanted in cruise:
        where.append(s)
        left = max(end - s if way > 0 else s, 0.0)
        # Brake so as to arrive at the end of the path at rest, then turn back.
        allowed = min(wanted, sqrt(2.0 * ACCELERATION * left) + 0.02)
        speed += min(max(allowed - speed, -2.0 * change), change)
        s += way * speed / ROW_RATE
        if left < 0.01:
            way, speed = -way, 0.0
            s = min(max(s, 0.0), end)
    return np.stack([np.interp(where, length, path[:, i]) for i in range(2)], axis=1)


def _cruise_speeds(rng: np.random.Generator, rows: int) -> np.ndarray:
    """A new cruising speed every 5 to 10 s, held between."""
    speeds = np.empty(rows)
    row = 0
    while row < rows:
        hold = int(rng.uniform(5.0, 10.0) * ROW_RATE)
        speeds[row : row + hold] = rng.uniform(*SPEEDS)
        row += hold
    return speeds


def _turned(points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    angle = rng.uniform(0.0, 2.0 * np.pi)
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, s], [-s, c]])
