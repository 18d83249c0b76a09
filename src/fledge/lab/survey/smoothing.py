"""How a vehicle really moved, as well as its poses tell afterwards.

An estimator knows the past alone, and is late; a log knows what came next. Poses are laid on a grid of one tick, and
through the nine about each goes a polynomial of third order, whose slope is the velocity (A. Savitzky and M. J. E.
Golay, Analytical Chemistry 36, 1964). With 0.5 mm of noise a velocity is wrong by 2 cm/s, and nothing is late.

Where more than `GAP` is missing between two poses nothing is known; that is said, and whoever asks has to look.
"""

from typing import NamedTuple

import numpy as np
from scipy.signal import savgol_filter

from fledge.supervision.watchdog import TICK

WINDOW, ORDER = 9, 3
"""Ticks about each, and the polynomial's order; chosen: 40 ms to either side is less than a vehicle's lags."""
GAP = 0.025
"""[s] between two poses that are bridged; chosen: one frame may be missing."""


class Smooth(NamedTuple):
    """Quantities at the stamps that were asked for, and how fast they change."""

    value: np.ndarray
    """Shape (ticks, n)."""
    slope: np.ndarray
    """Per second, shape (ticks, n)."""
    known: np.ndarray
    """Whether there are poses enough about this tick, shape (ticks,)."""


def smooth(stamps: np.ndarray, values: np.ndarray) -> Smooth:
    """Values [shape (ticks, n)] that were measured at these stamps [s], some of which may repeat."""
    _, first = np.unique(stamps, return_index=True)
    at, seen = stamps[first], values[first]
    grid = at[0] + TICK * np.arange(max(round((at[-1] - at[0]) / TICK) + 1, WINDOW))
    laid = np.stack([np.interp(grid, at, one) for one in seen.T], axis=1)
    value = savgol_filter(laid, WINDOW, ORDER, axis=0)
    slope = savgol_filter(laid, WINDOW, ORDER, deriv=1, delta=TICK, axis=0)
    back = [np.stack([np.interp(stamps, grid, one) for one in each.T], axis=1) for each in (value, slope)]
    return Smooth(back[0], back[1], _known(stamps, at))


def _known(stamps: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Whether no gap is near, nor the beginning or the end."""
    half = 0.5 * WINDOW * TICK
    holes = [(a - half, b + half) for a, b in zip(at[:-1], at[1:], strict=True) if b - a > GAP]
    known = (stamps >= at[0] + half) & (stamps <= at[-1] - half)
    for a, b in holes:
        known &= (stamps < a) | (stamps > b)
    return known
