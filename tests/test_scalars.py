"""One number on three backends: plain floats, NumPy arrays and JAX arrays."""

import math
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge import scalars

ONE = (scalars.sqrt, scalars.sin, scalars.cos, scalars.asin, scalars.exp, scalars.round_)
TWO = (scalars.minimum, scalars.maximum, scalars.atan2)
THREE = (scalars.clip,)
ARITY = {f: n for n, group in enumerate((ONE, TWO, THREE), start=1) for f in group}

ODD_NUMBERS = (
    *(-math.inf, -1e300, -800.0, -math.pi, -1.0, -0.5, -0.0, 0.0, 0.5, 1.0, 1.5, 2.5),
    *(math.pi, 705.0, 709.78, 709.783, 1e15, 1e300, math.inf, math.nan),
)

# JAX flushes subnormal numbers to zero, so the backends may differ there.
ordinary = st.floats(-1e6, 1e6, allow_subnormal=False)


@pytest.fixture(autouse=True)
def double_precision_and_quiet():
    with jax.enable_x64(True), np.errstate(all="ignore"):
        yield


def name_of(value: Any) -> str:
    return getattr(value, "__name__", str(value))


def on_every_backend(f, *columns: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`f` over columns of arguments: on plain floats one by one, on NumPy and on JAX at once."""
    plain = np.array([f(*row) for row in zip(*columns, strict=True)])
    numpy = f(*(np.array(column) for column in columns))
    return plain, numpy, np.asarray(f(*(jnp.array(column) for column in columns)))


@pytest.mark.parametrize("f", ARITY, ids=name_of)
def test_nan_goes_in_nan_comes_out(f):
    for place in range(ARITY[f]):
        arguments = [0.5] * ARITY[f]
        arguments[place] = math.nan
        for result in on_every_backend(f, *((value,) for value in arguments)):
            assert np.isnan(result).all(), f"argument {place}"


@pytest.mark.slow
@pytest.mark.parametrize("f", ARITY, ids=name_of)
def test_nothing_raises_and_the_backends_agree_on_odd_numbers(f):
    grid = np.meshgrid(*(ODD_NUMBERS,) * ARITY[f])
    plain, numpy, jaxed = on_every_backend(f, *(tuple(axis.ravel().tolist()) for axis in grid))
    np.testing.assert_allclose(numpy, plain, rtol=1e-15)
    np.testing.assert_allclose(jaxed, plain, rtol=1e-15)


@pytest.mark.slow
@pytest.mark.parametrize("f", ARITY, ids=name_of)
@given(data=st.data())
def test_the_backends_agree_on_ordinary_numbers(f, data):
    rows = data.draw(st.lists(st.tuples(*(ordinary,) * ARITY[f]), min_size=6, max_size=6))
    plain, numpy, jaxed = on_every_backend(f, *zip(*rows, strict=True))
    np.testing.assert_allclose(numpy, plain, rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(jaxed, plain, rtol=1e-14, atol=1e-15)


@given(ordinary, ordinary)
def test_minimum_and_maximum_are_pythons_own_on_ordinary_numbers(a, b):
    assert scalars.minimum(a, b) == min(a, b)
    assert scalars.maximum(a, b) == max(a, b)


@given(ordinary, ordinary, ordinary)
def test_clip_lands_between_its_bounds_and_on_the_upper_one_where_they_cross(x, a, b):
    low, high = min(a, b), max(a, b)
    assert low <= scalars.clip(x, low, high) <= high
    if low <= x <= high:
        assert scalars.clip(x, low, high) == x
    for crossed in on_every_backend(scalars.clip, (x,), (high,), (low,)):
        assert crossed == low


def test_sqrt_of_a_negative_number_is_nan():
    for result in on_every_backend(scalars.sqrt, (-1.0, -1e-300, 4.0)):
        np.testing.assert_array_equal(result, [math.nan, math.nan, 2.0])


def test_asin_forgives_rounding():
    for result in on_every_backend(scalars.asin, (1.0 + 1e-9, -1.0 - 1e-9)):
        np.testing.assert_allclose(result, [math.pi / 2, -math.pi / 2])


def test_exp_overflows_to_infinity_only_where_doubles_end():
    for result in on_every_backend(scalars.exp, (709.78, 709.79, 1e6, math.inf)):
        assert np.isfinite(result[0]) and np.isinf(result[1:]).all()


def test_round_takes_halves_to_even():
    for result in on_every_backend(scalars.round_, (0.5, 1.5, 2.5, -0.5, -1.5, 2.4999)):
        np.testing.assert_array_equal(result, [0.0, 2.0, 2.0, 0.0, -2.0, 2.0])


def test_isfinite_knows_nan_and_infinity():
    for result in on_every_backend(scalars.isfinite, (0.0, 1e300, math.nan, math.inf, -math.inf)):
        np.testing.assert_array_equal(result, [True, True, False, False, False])


def test_negate_is_a_logical_not():
    for result in on_every_backend(lambda x: scalars.negate(x > 0.0), (1.0, -1.0)):
        np.testing.assert_array_equal(result, [False, True])


def test_an_array_and_a_float_mix():
    for array in (np.array([1.0, 3.0]), jnp.array([1.0, 3.0])):
        np.testing.assert_array_equal(scalars.minimum(array, 2.0), [1.0, 2.0])
        np.testing.assert_array_equal(scalars.maximum(2.0, array), [2.0, 3.0])
        np.testing.assert_array_equal(scalars.clip(2.5, 0.0, array), [1.0, 2.5])


def test_a_numpy_number_counts_as_an_array():
    assert scalars.sqrt(np.float64(4.0)) == 2.0
    assert np.isnan(scalars.sqrt(np.float64(-1.0)))


def test_what_is_no_number_is_named():
    with pytest.raises(TypeError, match="no array among .*str"):
        scalars.sqrt("four")


@dataclass(frozen=True)
class Pair:
    a: Any
    b: Any


@pytest.mark.parametrize("array", (float, np.array, jnp.array), ids=("plain", "numpy", "jax"))
def test_where_chooses_between_numbers_tuples_and_records(array):
    x = array(3.0)
    for condition, wanted in ((x > 2.0, 1.0), (x > 4.0, 2.0)):
        assert scalars.where(condition, 1.0, 2.0) == wanted
        assert scalars.where(condition, (1.0, (1.0,)), (2.0, (2.0,))) == (wanted, (wanted,))
        chosen = scalars.where(condition, Pair(1.0, (1.0,)), Pair(2.0, (2.0,)))
        assert chosen == Pair(wanted, (wanted,))


def test_where_chooses_element_by_element():
    x = np.array([1.0, -1.0])
    chosen = scalars.where(x > 0.0, Pair(x, 0.0), Pair(-x, 5.0))
    np.testing.assert_array_equal(chosen.a, [1.0, 1.0])
    np.testing.assert_array_equal(chosen.b, [0.0, 5.0])


def test_where_refuses_tuples_of_different_lengths():
    with pytest.raises(ValueError, match="shorter|longer"):
        scalars.where(np.array(True), (1.0, 2.0), (1.0,))


def test_plain_numbers_are_sure_and_compiled_programs_never():
    x = np.array([1.0, -1.0])
    assert scalars.surely(2.0 > 1.0) and not scalars.surely(1.0 > 2.0)
    assert not scalars.surely(x < 5.0) and jax.jit(lambda x: scalars.surely(x < 5.0) * x)(1.0) == 0.0


@pytest.mark.parametrize("rows", ((), (3,)), ids=("one", "many"))
@pytest.mark.parametrize("xp", (np, jnp), ids=("numpy", "jax"))
def test_unstack_undoes_stack(xp, rows):
    values = [xp.full(rows, float(i)) for i in range(4)]
    like = xp.zeros(2, dtype=xp.float32)
    stacked = scalars.stack(values, like=like)
    assert stacked.shape == (*rows, 4) and stacked.dtype == like.dtype
    for i, entry in enumerate(scalars.unstack(stacked)):
        np.testing.assert_array_equal(entry, values[i])


def test_plain_floats_are_stacked_by_numpy_and_come_back_plain():
    stacked = scalars.stack([1.0, 2.0], like=np.zeros(1, dtype=np.float32))
    assert stacked.dtype == np.float32
    assert [type(entry) for entry in scalars.unstack(stacked)] == [float, float]
