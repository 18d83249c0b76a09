"""The synthetic operator, stage by stage, against the formulas its docstring states."""

import math
from dataclasses import astuple, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from fledge.observation import ROW_RATE, Observation
from fledge.pilots import HumanModel
from fledge.pilots.human_model import DELAY_ROWS, STICK_STEPS

NO_NOISE = (0.0, 0.0, 0.0, 0.0)
LINEAR = HumanModel(remnant=0.0, threshold_px=0.0)
"""Without noise and without a dead zone the chain is linear, up to the stops of the stick."""

ALTITUDE = 3.0


def seeing(ahead=0.0, aside=0.0, above=0.0, altitude=ALTITUDE) -> Observation:
    """Errors [px] of each axis."""
    centre_u, centre_v, ideal, zero = 320.0, 180.0, 108.0, 0.0
    return Observation(
        *(centre_u, centre_v, centre_u - aside, centre_v - ahead, altitude, ideal, ideal + above),
        *(zero, zero, zero, zero),
    )


def fly(pilot, views, noises=None):
    """(memories, actions) row by row."""
    memory, memories, actions = pilot.init(), [], []
    for i, view in enumerate(views):
        memory, action = pilot.act(memory, view, noises[i] if noises is not None else NO_NOISE)
        memories.append(memory)
        actions.append(action)
    return memories, actions


def forward_sticks(pilot, errors) -> np.ndarray:
    """The forward stick before it is rounded to steps."""
    memories, _ = fly(pilot, [seeing(ahead=error) for error in errors])
    return np.array([memory[0].stick for memory in memories])


def impulse(rows: int = 30) -> list[float]:
    return [10.0] + [0.0] * (rows - 1)


@pytest.mark.parametrize("rows", range(DELAY_ROWS))
def test_nothing_moves_before_the_reaction_delay_is_over(rows):
    sticks = forward_sticks(replace(LINEAR, delay=rows / ROW_RATE), impulse())
    np.testing.assert_allclose(sticks[:rows], 0.0, atol=1e-15)
    assert sticks[rows] > 1e-3


@given(st.floats(0.0, (DELAY_ROWS - 2) / ROW_RATE))
def test_a_row_more_of_delay_is_the_same_a_row_later(delay):
    sooner = forward_sticks(replace(LINEAR, delay=delay), impulse())
    later = forward_sticks(replace(LINEAR, delay=delay + 1.0 / ROW_RATE), impulse())
    np.testing.assert_allclose(later[1:], sooner[:-1], atol=1e-12)


def test_the_default_delay_is_within_the_line_and_the_literature():
    assert 0.15 <= HumanModel().delay <= 0.25 <= (DELAY_ROWS - 1) / ROW_RATE


def test_the_linear_chain_is_gain_lead_delay_and_lag():
    """Against SciPy's filters: (T_L s + 1) / (T_I s + 1), whole rows of delay, 1 / (T_N s + 1)."""
    pilot = replace(LINEAR, delay=3.0 / ROW_RATE)
    errors = np.random.default_rng(0).normal(0.0, 4.0, 200)
    a, b = math.exp(-1.0 / ROW_RATE / pilot.lag), math.exp(-1.0 / ROW_RATE / pilot.neuromuscular)
    lagged = lfilter([1.0 - a], [1.0, -a], errors)
    led = lagged + pilot.lead / pilot.lag * (errors - lagged)
    delayed = np.concatenate([np.zeros(3), led[:-3]])
    gain = pilot.crossover * ALTITUDE / pilot.focal_px / pilot.sticks.horizontal
    np.testing.assert_allclose(
        forward_sticks(pilot, errors.tolist()), lfilter([1.0 - b], [1.0, -b], gain * delayed), atol=1e-12
    )


@pytest.mark.parametrize("altitude", (2.0, 4.0))
def test_in_the_long_run_a_metre_of_error_asks_for_the_crossover_frequency(altitude):
    """K e = w_c (z / f) e: what is x metres off is approached at w_c x metres per second."""
    metres = 0.1
    pixels = LINEAR.focal_px * metres / altitude
    memories, _ = fly(LINEAR, [seeing(ahead=pixels, aside=-pixels, altitude=altitude)] * 200)
    speed = LINEAR.sticks.horizontal * memories[-1][0].stick
    assert speed == pytest.approx(LINEAR.crossover * metres, rel=1e-6)
    assert memories[-1][1].stick == pytest.approx(-memories[-1][0].stick)


def test_in_the_long_run_the_radius_asks_for_a_climb_at_its_own_crossover():
    """The radius goes with 1 / z: a share dr / r of error is dz = z dr / r metres."""
    memories, _ = fly(LINEAR, [seeing(above=5.4)] * 200)
    speed = LINEAR.sticks.vertical * memories[-1][2].stick
    assert speed == pytest.approx(LINEAR.crossover_up * ALTITUDE * 5.4 / 108.0, rel=1e-6)


@given(st.floats(-1.0, 1.0, allow_subnormal=False))
def test_errors_within_the_threshold_leave_the_stick_alone(share):
    pilot = HumanModel(remnant=0.0)
    error = share * pilot.threshold_px
    _, actions = fly(pilot, [seeing(error, error, error)] * 20)
    assert {astuple(action) for action in actions} == {(0.0, 0.0, 0.0, 0.0)}


@pytest.mark.parametrize("sign", (1.0, -1.0))
def test_beyond_the_threshold_only_the_excess_counts(sign):
    pilot = HumanModel(remnant=0.0)
    errors = [sign * (pilot.threshold_px + 4.0)] * 40
    np.testing.assert_allclose(
        forward_sticks(pilot, errors), forward_sticks(LINEAR, [sign * 4.0] * 40), atol=1e-12
    )


@given(st.lists(st.floats(-2000.0, 2000.0), min_size=8, max_size=8))
def test_the_stick_stops_at_one_and_moves_in_steps(errors):
    _, actions = fly(HumanModel(), [seeing(e, -e, 0.2 * e) for e in errors for _ in range(2)])
    for said in (part for action in actions for part in astuple(action)):
        assert -1.0 <= said <= 1.0
        assert said * STICK_STEPS == pytest.approx(round(said * STICK_STEPS), abs=1e-9)
    assert STICK_STEPS == 127.0


OPERATORS = 20_000


def staring(error: float, pilot: HumanModel, power: float):
    """Memory of an operator who has long been looking at one constant error, with no dead zone."""
    return tuple(replace(axis, lagged=error, power=power) for axis in pilot.init())


def stared_at(pilot: HumanModel, error: float, rows: int) -> list:
    """Memories of many operators who stare at one constant error, its power known to them."""
    rng = np.random.default_rng(0)
    pilot = replace(pilot, threshold_px=0.0)
    memory, memories = staring(error, pilot, power=error**2), []
    for _ in range(rows):
        memory, _ = pilot.act(memory, seeing(error, error, error), tuple(rng.normal(size=(4, OPERATORS))))
        memories.append(memory)
    return memories


def test_the_remnant_has_the_stated_variance_and_colour():
    """V = pi rho E[e^2] / f through a lag T_n has variance V / (2 T_n) and correlation e^(-t / T_n)."""
    pilot, error = HumanModel(share_attention=False), 20.0
    memories = stared_at(pilot, error, 60)
    wanted = math.pi * pilot.remnant * error**2 / (2.0 * pilot.remnant_lag)
    for axis in range(3):
        last = memories[-1][axis].remnant
        assert last.var() == pytest.approx(wanted, rel=5.0 * math.sqrt(2.0 / OPERATORS))
        correlation = np.corrcoef(last, memories[-3][axis].remnant)[0, 1]
        assert correlation == pytest.approx(
            math.exp(-0.1 / pilot.remnant_lag), abs=5.0 / math.sqrt(OPERATORS)
        )
    independent = np.corrcoef([memories[-1][axis].remnant for axis in range(3)])
    np.testing.assert_allclose(independent, np.eye(3), atol=5.0 / math.sqrt(OPERATORS))


def test_the_remnant_grows_with_what_is_displayed():
    ten, forty = (stared_at(HumanModel(), error, 3)[-1][0].remnant for error in (10.0, 40.0))
    np.testing.assert_allclose(forty, 4.0 * ten, rtol=1e-9)


def test_the_running_power_forgets_with_its_time_constant():
    """After n rows a share (1 - dt / T)^n of what was believed is left."""
    pilot, rows = replace(HumanModel(), threshold_px=0.0), 100
    memory = staring(30.0, pilot, power=100.0)
    for _ in range(rows):
        memory, _ = pilot.act(memory, seeing(30.0, 30.0, 30.0), NO_NOISE)
    left = (1.0 - 1.0 / ROW_RATE / pilot.power_memory) ** rows
    assert memory[0].power == pytest.approx(900.0 + (100.0 - 900.0) * left)


def test_an_operator_without_remnant_is_not_touched_by_noise():
    views = [seeing(ahead=30.0)] * 20
    noises = np.random.default_rng(4).normal(size=(20, 4)).tolist()
    assert fly(LINEAR, views, noises) == fly(LINEAR, views)
    assert fly(HumanModel(), views, noises)[1] != fly(HumanModel(), views)[1]


@pytest.mark.parametrize(
    ("axes", "share"), (((0,), 1), ((2,), 1), ((0, 1), 2), ((0, 1, 2), 3), ((0, 1, 2, 3), 3))
)
def test_attention_is_shared_between_the_axes_in_use(axes, share):
    """With f = 1 / n the variance of the remnant is n times as large."""
    noises = np.random.default_rng(1).normal(size=(50, 4)).tolist()
    views = [seeing(20.0, 20.0, 20.0)] * 50
    sharing = fly(HumanModel().for_axes(axes), views, noises)[0]
    undivided = fly(HumanModel(share_attention=False).for_axes(axes), views, noises)[0]
    for row in (0, 20, 49):
        for axis in range(3):
            wanted = math.sqrt(share) * undivided[row][axis].remnant
            assert sharing[row][axis].remnant == pytest.approx(wanted)


@pytest.mark.parametrize("axes", ((0, 1), (2,), (0, 1, 2)))
def test_the_operator_keeps_hands_off_what_is_not_in_use(axes):
    noises = np.random.default_rng(2).normal(size=(30, 4)).tolist()
    _, actions = fly(HumanModel().for_axes(axes), [seeing(90.0, -90.0, 30.0)] * 30, noises)
    said = np.array([astuple(action) for action in actions])
    for axis in range(4):
        assert said[:, axis].any() == (axis in axes)


def test_each_axis_minds_its_own_error_and_its_own_noise():
    alone = fly(HumanModel(), [seeing(ahead=40.0)] * 20, [(1.0, 0.0, 0.0, 0.0)] * 20)[0]
    together = fly(HumanModel(), [seeing(40.0, 70.0, -30.0)] * 20, [(1.0, -1.0, 2.0, 5.0)] * 20)[0]
    assert [memory[0] for memory in alone] == [memory[0] for memory in together]


def test_hands_are_at_rest_before_the_first_look():
    for axis in HumanModel().init():
        assert axis.stick == axis.lagged == axis.remnant == 0.0
        assert set(axis.delayed) == {0.0}
