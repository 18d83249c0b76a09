"""The visual servo: what follows from proportional-derivative control in the image, whatever its gains."""

from dataclasses import astuple, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.observation import Action, Observation, StickScale
from fledge.pilots import Servo

NO_NOISE = (0.0, 0.0, 0.0, 0.0)
SETTLED = Observation(320.0, 180.0, 320.0, 180.0, 3.0, 108.0, 108.0, 0.0, 0.0, 0.0, 0.0)
SMALL = st.floats(-20.0, 20.0, allow_subnormal=False)


def act(observation: Observation, servo: Servo = Servo()) -> Action:
    memory, action = servo.act(servo.init(), observation, NO_NOISE)
    assert memory == ()
    return action


def test_when_all_is_well_it_keeps_its_hands_still():
    assert astuple(act(SETTLED)) == (0.0, 0.0, 0.0, 0.0)


def test_it_goes_where_the_ugvs_are():
    assert act(replace(SETTLED, ugv_v=100.0)).forward > 0.0  # up the picture is ahead
    assert act(replace(SETTLED, ugv_v=260.0)).forward < 0.0
    assert act(replace(SETTLED, ugv_u=200.0)).left > 0.0
    assert act(replace(SETTLED, ugv_u=440.0)).left < 0.0
    assert act(replace(SETTLED, radius=140.0)).up > 0.0  # too large in the picture: climb
    assert act(replace(SETTLED, radius=80.0)).up < 0.0


def test_it_brakes_what_moves_too_fast():
    assert act(replace(SETTLED, forward=0.5)).forward < 0.0
    assert act(replace(SETTLED, left=-0.5)).left > 0.0


@given(SMALL, SMALL, SMALL)
def test_the_answer_is_odd_and_each_axis_minds_its_own_error(du, dv, dr):
    def nudged(sign):
        return replace(SETTLED, ugv_u=320.0 + sign * du, ugv_v=180.0 + sign * dv, radius=108.0 + sign * dr)

    there, back = act(nudged(1.0)), act(nudged(-1.0))
    assert astuple(there) == pytest.approx(tuple(-part for part in astuple(back)), abs=1e-12)
    alone = act(replace(SETTLED, ugv_v=180.0 + dv))
    assert (alone.forward, alone.left, alone.up) == (there.forward, 0.0, 0.0)


@given(st.floats(-1000.0, 1000.0), st.floats(-1000.0, 1000.0))
def test_a_larger_error_never_gets_a_smaller_answer(a, b):
    near, far = min(a, b), max(a, b)
    assert (
        act(replace(SETTLED, ugv_v=180.0 - near)).forward <= act(replace(SETTLED, ugv_v=180.0 - far)).forward
    )


@given(st.floats(-0.1, 0.1), st.floats(1.0, 5.0), st.floats(1.0, 5.0))
def test_the_same_metres_get_the_same_stick_at_any_altitude(metres, low, high):
    """x metres ahead is f x / z pixels up the picture; the servo undoes the division."""

    def at(z):
        pixels = Servo().focal_px * metres / z
        return act(replace(SETTLED, altitude=z, ugv_v=180.0 - pixels)).forward

    assert at(low) == pytest.approx(at(high), abs=1e-9)


@given(st.floats(-0.2, 0.2), st.floats(0.1, 2.0))
def test_the_velocity_it_asks_for_does_not_depend_on_what_full_stick_means(metres, scale):
    default, other = StickScale(), StickScale(horizontal=scale, vertical=scale)
    seen = replace(SETTLED, ugv_v=180.0 - Servo().focal_px * metres / 3.0)
    usual, scaled = act(seen), act(seen, Servo(sticks=other))
    if max(abs(usual.forward), abs(scaled.forward)) < 1.0:
        assert other.command(scaled).forward == pytest.approx(default.command(usual).forward, abs=1e-9)


def test_it_ignores_the_noise_and_reads_arrays():
    servo, rows = Servo(), np.linspace(-300.0, 300.0, 7)
    seen = replace(SETTLED, ugv_v=180.0 + rows)
    assert servo.act((), SETTLED, NO_NOISE) == servo.act((), SETTLED, (9.0, -9.0, 9.0, -9.0))
    many = act(seen).forward
    for i, row in enumerate(rows.tolist()):
        assert many[i] == act(replace(SETTLED, ugv_v=180.0 + row)).forward
