"""A UAV of few parts, flown restlessly: a dead time, a tilt of second order, drag; and the lab's own velocity loop."""

from collections import deque
from math import cos, nan, sin, tan

import numpy as np

from fledge.dynamics import GRAVITY, UGV_FLEET
from fledge.geometry import Quat, Vec3
from fledge.lab.control.tilt import Tilt
from fledge.lab.survey.traces import Driven, Trace
from fledge.world import UavState, UgvState, VelocityCommand

TICK, STEPS = 0.01, 5
DRAG = 0.4
"""[1/s]."""
QUICK, DAMPED = 12.0, 0.8
"""[rad/s] and damping of the tilt."""
CLIMB = 0.3
"""[s] of lag in height."""
AT_REST = UgvState(0.0, 0.0, 0.3, 0.0, 0.0, 0.0)


def flight(seconds=60.0, delay=2, seed=0, noise=0.0005, strength=1.0, ours=False):
    """The trace of a flight; commands take effect `delay` ticks after they were sent."""
    rng, tilt = np.random.default_rng(seed), Tilt()
    memory, told, left, rest = tilt.init(), VelocityCommand.hover(), 0, 100
    sent = deque([(0.0, 0.0, 0.0)] * delay)
    p, v, lean, turning = [0.0] * 3, [0.0] * 3, [0.0] * 2, [0.0] * 2
    rows, ugvs = [], [AT_REST] * 3
    driven = []
    for k in range(round(seconds / TICK)):
        t = k * TICK
        if left <= 0 and rest >= 100:
            left, rest = int(rng.integers(40, 180)), 0
        if left > 0 and (left % 30 == 0 or told == VelocityCommand.hover()):
            f, s, u = np.clip(rng.uniform(-1.5, 1.5, 3), -1.0, 1.0) * strength
            told = VelocityCommand(float(f), float(s), 0.5 * float(u), 0.0)
        left, rest = left - 1, rest + (left <= 0)
        if left <= 0:
            told = VelocityCommand.hover()
        pitch, roll = lean[0], -lean[1]
        state = UavState(Vec3(*p), Vec3(*v), _attitude(pitch, roll), Vec3(-turning[1], turning[0], 0.0), t)
        seen = [*(p + noise * rng.standard_normal(3))]
        memory, pcmd = tilt.step(memory, state, told, t)
        asked = (-pcmd.pitch, -pcmd.roll)
        q, r = state.attitude, state.rates
        rows.append(
            [t, t, *seen, q.w, q.x, q.y, q.z, *v, r.x, r.y, r.z]
            + [told.forward, told.left, told.up, 0.0, *asked]
        )
        sent.append((*asked, told.up))
        *now, up = sent.popleft()
        for _ in range(STEPS):
            dt = TICK / STEPS
            for i in range(2):
                turning[i] += dt * (
                    QUICK**2 * (tilt.most_tilt * now[i] - lean[i]) - 2.0 * DAMPED * QUICK * turning[i]
                )
                lean[i] += dt * turning[i]
                v[i] += dt * (GRAVITY * tan(lean[i]) - DRAG * v[i])
            v[2] += dt * (up - v[2]) / CLIMB
            p = [a + dt * b for a, b in zip(p, v, strict=True)]
        order = VelocityCommand(0.3, 0.0, 0.0, 0.5) if k % 250 < 150 else VelocityCommand.hover()
        driven.append([[t, g.x, g.y, g.heading, g.speed, g.turn_rate, *_told(order, ours)] for g in ugvs])
        ugvs = [model.step(g, order, TICK) for model, g in zip(UGV_FLEET, ugvs, strict=True)]
    a = np.split(np.array(rows), np.cumsum([1, 1, 3, 4, 3, 3, 4]), axis=1)
    each = tuple(Driven(*one.T) for one in np.array(driven).transpose(1, 0, 2))
    return Trace(a[0][:, 0], a[1][:, 0], *a[2:], each)


def _told(order, ours):
    return (order.forward, order.turn) if ours else (nan, nan)


def _attitude(pitch, roll):
    a, b, c, d = cos(pitch / 2), sin(pitch / 2), cos(roll / 2), sin(roll / 2)
    return Quat(a * c, a * d, b * c, -b * d)
