"""Air that moves: about its mean, by its gusts, however finely time is cut."""

import numpy as np
import pytest

from fledge.geometry import Vec3
from fledge.lab.twin.bodies import Airframe
from fledge.lab.twin.draught import NORMALS, Draught
from fledge.safety.contract import Contract

pytestmark = pytest.mark.slow


def winds(draught, steps, dt=0.01):
    rng, gust, found = np.random.default_rng(0), draught.init(), []
    for _ in range(steps):
        gust, wind = draught.step(gust, rng.standard_normal(NORMALS).tolist(), dt)
        found.append((wind.x, wind.y, wind.z))
    return np.array(found)


def test_it_blows_about_its_mean():
    draught = Draught(Vec3(0.3, -0.2, 0.1), gust=0.2)
    found = winds(draught, 20_000, dt=1.0)
    assert found.mean(axis=0) == pytest.approx((0.3, -0.2, 0.1), abs=0.02)
    assert found.std(axis=0) == pytest.approx((0.2, 0.2, 0.0), abs=0.01)


def test_a_gust_lasts():
    found = winds(Draught(Vec3(0.0, 0.0, 0.0), gust=1.0), 20_000)[:, 0]
    after = int(Draught().memory / 0.01)
    assert np.corrcoef(found[:-after], found[after:])[0, 1] == pytest.approx(np.exp(-1.0), abs=0.15)


def test_still_air_is_still():
    assert not winds(Draught(Vec3(0.0, 0.0, 0.0), gust=0.0), 100).any()


def test_it_stays_within_what_the_nets_allow_for():
    push = Airframe().drag * np.abs(winds(Draught(), 100_000)[:, :2]).max()
    assert push < Contract().disturbance
