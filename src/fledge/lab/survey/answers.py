"""How late, and how, a UAV answers what it is told.

*Delay.* The tilt asked for on the wire, u, against the tilt seen, theta:

    theta(t) = gain y(t - delay) + bias,    y = u through lags of first and first, and of second order

The lags are the vehicle's own loops and rotors; what is left, and moves nothing, is the delay from a command's sending
to its effect. All six numbers are fitted at once, gain and bias by linear least squares within (G. H. Golub and V.
Pereyra, SIAM J. Numer. Anal. 10, 1973). Times are those of stamps, so that the age of a pose is not counted twice.

*Ramp.* The velocity seen against the velocity told, the latter through a lag of first order: the lag that fits best,
and by how much the velocity then differs, which is the tracking error.
"""

from collections.abc import Sequence
from math import exp
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares, minimize_scalar
from scipy.signal import cont2discrete, lfilter

from fledge.geometry import Quat
from fledge.lab.survey.stops import Flown
from fledge.lab.survey.traces import Trace
from fledge.supervision.watchdog import TICK

SLOWEST = 1.0
"""[s] of a lag; an answer slower than that is none."""
GUESS = (0.02, 0.02, 0.04, 0.1, 0.7)
"""Where the search begins: delay, two lags [s], a period [s], a damping."""
LOW, HIGH = (0.0, 0.001, 0.001, 0.01, 0.2), (0.3, 0.3, 0.3, SLOWEST, 3.0)
"""Between which it looks."""


class Answer(NamedTuple):
    """How the velocity follows its command."""

    lag: float
    """[s]."""
    error: float
    """Root of the mean square of what is left, per axis [m/s]."""
    largest: float
    """[m/s]."""


def delay(traces: Sequence[Trace]) -> float:
    """From a tilt's sending to its effect [s]; NaN if no flight tells."""
    pieces = [piece for one in traces for piece in _pieces(one) if len(piece[0]) > SLOWEST / TICK]
    if not pieces:
        return float("nan")
    return float(least_squares(_misfit, GUESS, bounds=(LOW, HIGH), x_scale=GUESS, args=(pieces,)).x[0])


def answer(flights: Sequence[Flown], dead: float) -> Answer:
    """How the velocity in the plane follows, `dead` [s] after the command."""
    best = minimize_scalar(
        lambda lag: np.square(_behind(flights, lag, dead)).mean(), bounds=(0.02, SLOWEST), method="bounded"
    )
    left = _behind(flights, best.x, dead)
    return Answer(float(best.x), float(np.sqrt(np.square(left).mean())), float(np.abs(left).max()))


def _pieces(trace: Trace) -> list[tuple[np.ndarray, ...]]:
    """(time of sending, what was sent, time of seeing, what was seen) of every run of ticks, along each axis.

    Attitudes are as they came: smoothed ones would seem to know a command before it is heard.
    """
    tilt = trace.tilt
    good = np.isfinite(tilt).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(int)))
    roll, pitch, _ = Quat(*trace.attitude.T).tilt()
    return [
        (trace.t[a:b], sent[a:b], trace.stamp[a:b], seen[a:b])
        for a, b in zip(edges[::2], edges[1::2], strict=True)
        for sent, seen in ((tilt[:, 0], pitch), (tilt[:, 1], -roll))
    ]


def _misfit(guess: np.ndarray, pieces: Sequence[tuple[np.ndarray, ...]]) -> np.ndarray:
    """What is left of the tilt seen [rad]."""
    dead, first, second, period, damping = guess
    slow = np.polymul([first, 1.0], [second, 1.0])
    system: Any = ([1.0], np.polymul(slow, [period**2, 2.0 * damping * period, 1.0]))
    (b,), a, _ = cont2discrete(system, TICK, "zoh")  # pyright: ignore[reportCallIssue]
    answers = []
    for sent_at, sent, seen_at, _ in pieces:
        grid = sent_at[0] + TICK * np.arange(round((sent_at[-1] - sent_at[0]) / TICK) + 1)
        held = sent[np.clip(np.searchsorted(sent_at, grid + 1e-6) - 1, 0, None)]
        answers.append(np.interp(seen_at - dead, grid, lfilter(b, a, held)))
    skip = round(SLOWEST / TICK)
    said = np.concatenate([one[skip // 4 :] for one in answers])
    seen = np.concatenate([piece[3][skip // 4 :] for piece in pieces])
    known = np.stack([said, np.ones_like(said)], axis=1)
    return known @ np.linalg.lstsq(known, seen, rcond=None)[0] - seen


def _behind(flights: Sequence[Flown], lag: float, dead: float) -> np.ndarray:
    """The velocity seen less the one that a lag makes of the command [m/s], along x and y."""
    keep, late = exp(-TICK / lag), round(dead / TICK)
    left = []
    for flight in flights:
        told, v = np.nan_to_num(flight.commands[:, :2]), flight.state.velocity
        told = np.concatenate([np.zeros((late, 2)), told])[: len(told)]
        ideal = lfilter([1.0 - keep], [1.0, -keep], told, axis=0)
        flying = np.isfinite(flight.commands[:, 0]) & flight.known
        left.append((np.stack([v.x, v.y], axis=1) - ideal)[flying])
    return np.concatenate(left)
