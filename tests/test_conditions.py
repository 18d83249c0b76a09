"""Wind, noise and delay, against the theory of the processes they claim to be."""

import math
from dataclasses import astuple, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.conditions import (
    DRIFT_ROWS,
    GUST_MEMORY,
    NORMALS,
    SIGHT_ROWS,
    UNIFORMS,
    Conditions,
    next_drift,
    next_gust,
    row_noise,
    sense,
)
from fledge.geometry import Vec3
from fledge.observation import OBSERVATION_NAMES, ROW_RATE, Observation
from fledge.world import VelocityCommand

SILENCE = row_noise([0.0] * NORMALS, [0.0] * UNIFORMS)
NOISY = ("ugv_u", "ugv_v", "radius", "altitude", "forward", "left", "up", "turn")
"""What the senses blur, in the order of `RowNoise.sight`."""


def views(rng: np.random.Generator) -> tuple[Observation, ...]:
    return tuple(Observation(*rng.normal(size=len(OBSERVATION_NAMES)).tolist()) for _ in range(SIGHT_ROWS))


def gusts(flights: int, rows: int, sd: float) -> np.ndarray:
    """Eastward gusts of many flights; shape (rows, flights)."""
    rng = np.random.default_rng(0)
    calm = np.zeros(flights)
    gust, history = Vec3(calm, calm, calm), []
    for _ in range(rows):
        noise = replace(SILENCE, gust=Vec3(*rng.normal(size=(3, flights))))
        gust = next_gust(gust, noise, Conditions(gust=sd))
        history.append(gust.x)
    return np.array(history)


def test_gusts_are_an_ornstein_uhlenbeck_process():
    """From rest: variance s^2 (1 - e^(-2 t / T)); later: correlation e^(-t / T)."""
    flights, sd = 20_000, 0.3
    history = gusts(flights, 240, sd)
    t = np.arange(1, 241) / ROW_RATE
    wanted = sd**2 * (1.0 - np.exp(-2.0 * t / GUST_MEMORY))
    # A variance estimated from n flights has a relative deviation of sqrt(2 / n); five of them.
    np.testing.assert_allclose(history.var(axis=1), wanted, rtol=5.0 * math.sqrt(2.0 / flights))
    assert np.abs(history.mean(axis=1)).max() < 5.0 * sd / math.sqrt(flights)
    lag = round(GUST_MEMORY * ROW_RATE)
    correlation = np.corrcoef(history[-1], history[-1 - lag])[0, 1]
    assert correlation == pytest.approx(math.exp(-1.0), abs=5.0 / math.sqrt(flights))


def test_without_noise_a_gust_dies_out():
    gust = Vec3(1.0, -2.0, 0.5)
    for _ in range(round(GUST_MEMORY * ROW_RATE)):
        gust = next_gust(gust, SILENCE, Conditions(gust=0.3))
    assert (gust.x, gust.y, gust.z) == pytest.approx((math.exp(-1), -2 * math.exp(-1), 0.5 * math.exp(-1)))


def test_the_drift_is_drawn_anew_every_hundred_rows_and_stays_in_between():
    rng = np.random.default_rng(1)
    conditions = Conditions(command_drift=0.03)
    drift, history = VelocityCommand.hover(), []
    for row in range(3 * DRIFT_ROWS):
        noise = row_noise([0.0] * NORMALS, rng.uniform(-1.0, 1.0, UNIFORMS).tolist())
        drift = next_drift(drift, float(row), noise, conditions)
        history.append(drift)
        if row % DRIFT_ROWS == 0:
            assert drift == noise.drift.scaled(0.03)
    for start in range(0, 3 * DRIFT_ROWS, DRIFT_ROWS):
        assert set(history[start : start + DRIFT_ROWS]) == {history[start]}
    assert len(set(history)) == 3
    assert DRIFT_ROWS / ROW_RATE == 5.0


@given(st.floats(0.0, 0.1), st.lists(st.floats(-1.0, 1.0), min_size=UNIFORMS, max_size=UNIFORMS))
def test_the_drift_stays_within_its_half_width(width, uniform):
    noise = row_noise([0.0] * NORMALS, uniform)
    drift = next_drift(VelocityCommand.hover(), 0.0, noise, Conditions(command_drift=width))
    assert all(abs(part) <= width for part in astuple(drift))


@pytest.mark.parametrize("rows", range(SIGHT_ROWS))
def test_a_delay_of_whole_rows_shows_exactly_that_row(rows):
    history = views(np.random.default_rng(2))
    seen = sense(history, SILENCE, Conditions(delay=rows / ROW_RATE))
    for name in NOISY:
        assert getattr(seen, name) == pytest.approx(getattr(history[rows], name), abs=1e-12)


def test_a_delay_between_two_rows_shows_their_mixture():
    history = views(np.random.default_rng(3))
    seen = sense(history, SILENCE, Conditions(delay=2.25 / ROW_RATE))
    for name in NOISY:
        wanted = 0.75 * getattr(history[2], name) + 0.25 * getattr(history[3], name)
        assert getattr(seen, name) == pytest.approx(wanted)


@given(st.floats(0.0, (SIGHT_ROWS - 1) / ROW_RATE))
def test_what_does_not_change_looks_the_same_at_any_delay(delay):
    still = views(np.random.default_rng(4))[:1] * SIGHT_ROWS
    assert astuple(sense(still, SILENCE, Conditions(delay=delay))) == pytest.approx(astuple(still[0]))


def test_a_perfect_day_shows_exactly_what_is():
    history = views(np.random.default_rng(5))
    loud = row_noise([3.0] * NORMALS, [1.0] * UNIFORMS)
    perfect = Conditions()
    assert sense(history, loud, perfect) == history[0]
    calm = Vec3(0.0, 0.0, 0.0)
    assert next_gust(calm, loud, perfect) == calm
    assert next_drift(VelocityCommand.hover(), 0.0, loud, perfect) == VelocityCommand.hover()
    assert loud.command.scaled(perfect.command_noise) == VelocityCommand.hover()


@pytest.mark.parametrize("place", range(len(NOISY)))
def test_each_sense_has_its_own_noise_in_its_own_unit(place):
    history = views(np.random.default_rng(6))
    sight = tuple(2.0 if i == place else 0.0 for i in range(len(NOISY)))
    seen = sense(history, replace(SILENCE, sight=sight), Conditions(pixel_noise=1.5, motion_noise=0.02))
    for name in OBSERVATION_NAMES:
        sd = 1.5 if name in ("ugv_u", "ugv_v", "radius") else 0.02
        extra = 2.0 * sd if name == NOISY[place] else 0.0
        assert getattr(seen, name) == pytest.approx(getattr(history[0], name) + extra), name


def test_the_chance_of_a_row_is_dealt_out_once_each():
    normal, uniform = list(range(NORMALS)), list(range(100, 100 + UNIFORMS))
    noise = row_noise(normal, uniform)
    dealt = [*astuple(noise.gust), *noise.sight, *noise.pilot]
    assert sorted(dealt) == normal
    assert sorted([*astuple(noise.command), *astuple(noise.drift)]) == uniform


def test_a_nominal_day_is_a_pure_function_of_its_generator_and_within_what_is_declared():
    days = [Conditions.draw(np.random.default_rng(seed)) for seed in range(200)]
    assert days[0] == Conditions.draw(np.random.default_rng(0)) != days[1]
    for day in days:
        assert math.hypot(day.wind.x, day.wind.y) <= 0.5 and day.wind.z == 0.0
        assert 0.05 <= day.delay <= 0.15 <= (SIGHT_ROWS - 1) / ROW_RATE
        assert max(abs(day.offset.x), abs(day.offset.y)) <= 0.15 and abs(day.offset.z) <= 0.1
        assert abs(day.yaw) <= math.pi
    # tum_simulator's command noise and drift.
    assert {(day.command_noise, day.command_drift) for day in days} == {(0.05, 0.03)}
