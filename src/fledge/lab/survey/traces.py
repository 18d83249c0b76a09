"""What a lab flight tells of its vehicles: a controller's words, tick by tick, as arrays.

A tick has a row, but for those before everybody was seen. All numbers are as the controller had them: poses with their
stamps, velocities as they were estimated, commands as they were sent after net and supervisor had their say.

Where the vehicle flew by itself, taking off, landing or on the floor, what was told is NaN: it was not obeyed.

SI units; the world's frame ENU; commands in the heading's frame, as they are sent.
"""

from collections.abc import Iterable, Iterator
from math import nan
from typing import NamedTuple

import numpy as np

from fledge.lab import Malformed
from fledge.lab.control.phases import ALOFT
from fledge.lab.control.tick import Said
from fledge.lab.wire import ardrone, topics
from fledge.lab.wire.ardrone import Flag, Pcmd
from fledge.lab.wire.datagrams import AT, Datagram
from fledge.lab.wire.messages import Twist


class Driven(NamedTuple):
    """One UGV, tick by tick."""

    stamp: np.ndarray
    """Of the pose [s], shape (ticks,), like all that follows."""
    x: np.ndarray
    """[m]."""
    y: np.ndarray
    """[m]."""
    heading: np.ndarray
    """Unwrapped [rad]."""
    speed: np.ndarray
    """As estimated [m/s]."""
    turn_rate: np.ndarray
    """As estimated [rad/s]."""
    told_speed: np.ndarray
    """[m/s]; NaN where it was not ours to command."""
    told_turn: np.ndarray
    """[rad/s]; likewise."""


class Trace(NamedTuple):
    """One flight, tick by tick."""

    t: np.ndarray
    """[s], shape (ticks,)."""
    stamp: np.ndarray
    """Of the UAV's pose [s], shape (ticks,)."""
    position: np.ndarray
    """[m], shape (ticks, 3)."""
    attitude: np.ndarray
    """Quaternion (w, x, y, z), shape (ticks, 4)."""
    velocity: np.ndarray
    """As estimated [m/s], shape (ticks, 3)."""
    rates: np.ndarray
    """As estimated [rad/s], shape (ticks, 3)."""
    told: np.ndarray
    """Forward, left, up [m/s], turn [rad/s], shape (ticks, 4)."""
    tilt: np.ndarray
    """What the wire said: tilt forwards and to the left, as shares of the most, shape (ticks, 2); NaN if in m/s."""
    ugvs: tuple[Driven, ...]


def trace(ticks: Iterable[tuple[float, Said]], ours: bool, shares: bool = True) -> Trace:
    """A flight from what was said at which time [s].

    Args:
        ticks: In their order.
        ours: Whether the UGVs were ours to command.
        shares: Whether the vehicle is told shares of a tilt.
    """
    rows = [_row(t, said, ours, shares) for t, said in ticks if said.world is not None and said.decisions]
    uav = np.array([row[0] for row in rows]).reshape(len(rows), -1)
    ugvs = np.array([row[1] for row in rows]).reshape(len(rows), -1, len(Driven._fields))
    parts = np.split(uav, np.cumsum([1, 1, 3, 4, 3, 3, 4]), axis=1)
    t, stamp, position, attitude, velocity, rates, told, tilt = parts
    each = tuple(Driven(*ugvs[:, i].T) for i in range(ugvs.shape[1]))
    return Trace(t[:, 0], stamp[:, 0], position, attitude, velocity, rates, told, tilt, each)


def _row(t: float, said: Said, ours: bool, shares: bool) -> tuple[list[float], list[list[float]]]:
    """One tick: the UAV's numbers, and those of every UGV."""
    assert said.world is not None
    u, (first, *others) = said.world.uav, said.decisions
    p, v, q, w, c = u.position, u.velocity, u.attitude, u.rates, first.verdict.command
    flies = said.phase in ALOFT
    told = (c.forward, c.left, c.up, c.turn) if flies else (nan,) * 4
    tilt = _tilt(said.datagrams) if flies and shares else (nan, nan)
    state = (t, u.stamp, p.x, p.y, p.z, q.w, q.x, q.y, q.z, v.x, v.y, v.z, w.x, w.y, w.z)
    ugvs = [
        [g.stamp, g.x, g.y, g.heading, g.speed, g.turn_rate, *((o.forward, o.turn) if ours else (nan, nan))]
        for g, o in zip(said.world.ugvs, (other.verdict.command for other in others), strict=True)
    ]
    return [*state, *told, *tilt], ugvs


def _tilt(datagrams: Iterable[Datagram]) -> tuple[float, float]:
    """The last tilt that a tick's datagrams ask for; NaN if none does, or hovering was asked for."""
    return next(reversed([*_tilts(datagrams)]), (nan, nan))


def _tilts(datagrams: Iterable[Datagram]) -> Iterator[tuple[float, float]]:
    for datagram in datagrams:
        if datagram.channel == AT:
            for line in ardrone.decode(datagram.data):
                if not isinstance(line, Malformed) and isinstance(line.command, Pcmd):
                    yield _leaning(line.command)
        elif datagram.channel == topics.FLY:
            twist = topics.decode(topics.FLY, datagram.data)
            if isinstance(twist, Twist):
                yield twist.linear.x, twist.linear.y


def _leaning(pcmd: Pcmd) -> tuple[float, float]:
    return (-pcmd.pitch, -pcmd.roll) if Flag.PROGRESSIVE in pcmd.flags else (nan, nan)
