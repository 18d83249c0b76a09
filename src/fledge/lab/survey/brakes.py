"""How a UGV stops: the deceleration that a net may count on, measured on the stops of flights.

A stop begins when a UGV that moves is told to stand. On the way to its standstill it covers

    way = v delay + v^2 / (2 acceleration)

and turns as far, with rates for speeds. One that was told to go faster than it went, and had yet to, counts with what
it was told, as nets do. The delay is the one that fits best, but no longer than nets count with; with
it, each stop has an acceleration of its own, and the least is kept, less by a tenth (`bounds.MORE`).

A UGV that was not ours to command, or stopped too seldom, says nothing.
"""

from typing import NamedTuple

import numpy as np

from fledge.lab.survey.bounds import MORE
from fledge.lab.survey.smoothing import Smooth, smooth
from fledge.lab.survey.traces import Driven

FEWEST = 5
"""Stops that say something; chosen."""
FAST, SPINNING = 0.2, 0.4
"""[m/s] and [rad/s] at which a stop begins at least; chosen: below, the way is some millimetres."""
STANDS = 0.1
"""Share of that speed at which it stands: casters creep on for long."""
WITHIN = 60
"""Ticks that it may take; chosen, a little more than half a second is the watchdog's time."""
APART = 1.5
"""How much faster the fastest stop must be than the slowest for a delay to be told from braking; else there is none."""
HARDEST = 20.0
"""[m/s^2, rad/s^2]; a way that is shorter than that says that it stood at once."""


class Brakes(NamedTuple):
    """What one UGV's stops say; NaN where they say nothing."""

    acceleration: float
    """[m/s^2]."""
    turn_acceleration: float
    """[rad/s^2]."""
    stops: int
    """That began at speed."""
    turns: int
    """That began turning."""
    fastest: float
    """Speed of the fastest of them [m/s]."""


def brakes(driven: Driven, delay: float) -> Brakes:
    """From one UGV's flight; it obeys up to `delay` [s] after a pose, as nets count."""
    moved = smooth(driven.stamp, np.stack([driven.x, driven.y, driven.heading], axis=1))
    nose = moved.value[:, 2]
    speed = moved.slope[:, 0] * np.cos(nose) + moved.slope[:, 1] * np.sin(nose)
    way = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(driven.stamp))])
    begins = _begins(driven, moved)
    ways = [(_going(speed, driven.told_speed, i), abs(way[_rest(speed, i)] - way[i])) for i in begins]
    rate = moved.slope[:, 2]
    turns = [(_going(rate, driven.told_turn, i), abs(nose[_rest(rate, i)] - nose[i])) for i in begins]
    straight, bent = _least(ways, FAST, delay), _least(turns, SPINNING, delay)
    fastest = max([v for v, _ in ways], default=0.0)
    return Brakes(straight[0], bent[0], straight[1], bent[1], fastest)


def _begins(driven: Driven, moved: Smooth) -> list[int]:
    """The ticks in which it is told to stand, and then stands for long enough."""
    told = np.abs(driven.told_speed) + np.abs(driven.told_turn)
    stop = (told[1:] == 0.0) & (told[:-1] > 0.0)
    return [
        i
        for i in (np.flatnonzero(stop) + 1).tolist()
        if i + WITHIN < len(told) and not told[i : i + WITHIN].any() and moved.known[i : i + WITHIN].all()
    ]


def _going(rate: np.ndarray, told: np.ndarray, i: int) -> float:
    """At which rate it counts as going when it is told to stand."""
    return float(max(abs(rate[i]), told[i - 1] * np.sign(rate[i])))


def _rest(rate: np.ndarray, i: int) -> int:
    """The tick, of those after `i`, in which it stands."""
    stands = np.flatnonzero(rate[i : i + WITHIN] * np.sign(rate[i]) <= STANDS * abs(rate[i]))
    return i + (int(stands[0]) if len(stands) else WITHIN - 1)


def _least(seen: list[tuple[float, float]], fast: float, delay: float) -> tuple[float, int]:
    """(the least acceleration of these stops, less a tenth; how many they are): rate at the beginning, and way."""
    ways = [(rate, way) for rate, way in seen if rate >= fast]
    if len(ways) < FEWEST:
        return float("nan"), len(ways)
    rates, gone = np.array(ways).T
    each = np.stack([np.ones_like(rates), 0.5 * rates], axis=1)
    told_apart = rates.max() > APART * rates.min()
    late = np.clip(np.linalg.lstsq(each, gone / rates)[0][0], 0.0, delay) if told_apart else 0.0
    braking = np.maximum(gone - rates * late, rates**2 / (2.0 * HARDEST))
    return float((rates**2 / (2.0 * braking)).min()) / MORE, len(ways)
