"""The measurement of an operator, on loops whose figures are known; and the shipped one, inside its bands."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fledge.observation import ROW_RATE
from fledge.pilots import HumanModel
from fledge.study.crossover import (
    BANDS,
    HARMONICS,
    ROWS,
    WARM_UP,
    Credibility,
    SumOfSines,
    _measure,
    credibility,
)

pytestmark = pytest.mark.slow

AXES = tuple(HARMONICS)
FLIGHTS = 4
T = np.arange(ROWS) / ROW_RATE


def omega(n):
    """[rad/s]."""
    return 2.0 * np.pi * n * ROW_RATE / ROWS


def known_loop(axis, crossover, delay, remnant, seed, noise=0.0):
    """(position, goal, stick) of L = w_c e^(-tau s) / s, in steady state, after a warm-up of pure nonsense.

    The stick has a share `remnant` of its power at frequencies that nothing forces; `noise` [m] is added to the
    position at all frequencies.
    """
    rng = np.random.default_rng(seed)
    position, goal, forced = (np.zeros((FLIGHTS, ROWS)) for _ in range(3))
    for n in HARMONICS[axis]:
        s = 1j * omega(n)
        wave = rng.uniform(0.2, 1.0) * np.exp(
            1j * (omega(n) * T + rng.uniform(0.0, 2.0 * np.pi, (FLIGHTS, 1)))
        )
        loop = crossover * np.exp(-delay * s) / s
        goal += wave.real
        position += (loop / (1.0 + loop) * wave).real
        forced += (s * loop / (1.0 + loop) * wave).real
    other = np.setdiff1d(np.arange(1, 200), HARMONICS[axis])[:, None, None]
    own = np.cos(omega(other) * T + rng.uniform(0.0, 2.0 * np.pi, (len(other), FLIGHTS, 1))).sum(axis=0)
    stick = forced + own * np.sqrt(remnant / (1.0 - remnant) * np.mean(forced**2) / np.mean(own**2))
    position = position + noise * rng.normal(size=position.shape)
    nonsense = rng.normal(0.0, 100.0, (3, FLIGHTS, WARM_UP))
    return tuple(
        np.concatenate([before, signal + 5.0], axis=1)
        for before, signal in zip(nonsense, (position, goal, stick), strict=True)
    )


@settings(max_examples=40)
@given(
    st.sampled_from(AXES), st.floats(0.3, 2.1), st.floats(0.0, 0.9), st.floats(0.0, 0.8), st.integers(0, 99)
)
def test_a_known_loop_is_measured_exactly(axis, crossover, delay, remnant, seed):
    got = _measure(axis, *known_loop(axis, crossover, delay, remnant, seed))
    assert got.axis == axis
    assert got.crossover == pytest.approx(crossover, rel=1e-6)
    assert got.delay == pytest.approx(delay, abs=1e-6)
    assert got.remnant == pytest.approx(remnant, abs=1e-6)


@pytest.mark.parametrize("axis", AXES)
def test_noise_averages_out(axis):
    """A position that shakes by a tenth of the forcing, everywhere in the spectrum."""
    got = _measure(axis, *known_loop(axis, 1.5, 0.4, 0.2, 3, noise=0.1))
    assert got.crossover == pytest.approx(1.5, rel=0.05)
    assert got.delay == pytest.approx(0.4, abs=0.05)


@given(st.sampled_from(AXES), st.floats(0.01, 100.0), st.floats(0.01, 100.0))
@settings(max_examples=15)
def test_units_of_position_and_stick_cancel(axis, metres, stick):
    position, goal, said = known_loop(axis, 1.2, 0.5, 0.15, 0)
    one, other = (
        _measure(axis, position, goal, said),
        _measure(axis, metres * position, metres * goal, stick * said),
    )
    for name in ("crossover", "delay", "remnant"):
        assert getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-6)


def test_a_stick_that_only_trembles_is_all_remnant():
    position, goal, _ = known_loop("up", 1.0, 0.3, 0.1, 0)
    tremble = np.random.default_rng(0).normal(size=position.shape)
    assert _measure("up", position, goal, tremble).remnant > 0.95


# The forcing


def test_no_two_forcings_are_alike():
    """Distinct lines on every axis, whole cycles, at or below a fourth of what 20 Hz could show."""
    lines = [n for harmonics in HARMONICS.values() for n in harmonics]
    assert len(set(lines)) == len(lines)
    assert all(harmonics == tuple(sorted(harmonics)) for harmonics in HARMONICS.values())
    assert max(lines) <= ROWS // 8


@pytest.mark.parametrize("axes", [(0, 1), (2,), (0, 1, 2)])
def test_the_formation_moves_by_those_lines_and_no_others(axes):
    track = SumOfSines(axes).plan(np.random.default_rng(0), ROWS).track
    for signal, axis in zip((track.x, track.y, track.spread), AXES, strict=True):
        power = np.abs(np.fft.rfft(signal))[1:]
        loud = tuple((np.flatnonzero(power > 1e-6 * ROWS) + 1).tolist())
        assert loud == (HARMONICS[axis] if AXES.index(axis) in axes else ())
    assert np.hypot(track.x, track.y).max() + track.spread.max() < 5.0
    assert track.spread.min() > 0.3


def test_phases_are_drawn_anew_for_every_flight():
    one, same, other = (SumOfSines((0, 1)).plan(np.random.default_rng(seed), 100).track for seed in (0, 0, 1))
    np.testing.assert_array_equal(one.x, same.x)
    assert not np.allclose(one.x, other.x)
    assert not np.allclose(one.x, one.y)


# The bands


def test_inside_means_inside_every_band():
    middle = {name: (low + high) / 2.0 for name, (low, high) in BANDS.items()}
    good = Credibility("up", **middle)
    assert good.inside
    for name, (low, high) in BANDS.items():
        assert 0.0 < low < high
        assert replace(good, **{name: low}).inside and replace(good, **{name: high}).inside
        assert not replace(good, **{name: 0.99 * low}).inside
        assert not replace(good, **{name: 1.01 * high}).inside
        assert not replace(good, **{name: float("nan")}).inside


def test_the_shipped_operator_is_credible():
    """On every axis, with the seed of the study."""
    measured = credibility(HumanModel(), seed=0)
    assert [one.axis for one in measured] == list(AXES)
    for one in measured:
        assert one.inside, one
