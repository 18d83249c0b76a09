"""Arithmetic on one number, whatever it is made of.

The core of fledge is written once, for one scene, and run twice: on plain Python floats in the lab
(no compilation, tens of microseconds a tick) and on JAX tracers in the study (compiled, by the ten
thousand). NumPy arrays work as well: a whole flight is then one record with arrays in it.
`+ - * /` and comparisons already mean the same on all three; the functions here are the rest.

Two laws hold on every backend, because a safety net rests on them: NaN goes in, NaN comes out (Python's
own `max` would swallow it), and nothing raises (`math.sqrt(-1)` would).

Conditions are combined with `&` and `|`, and negated with `negate`, since `~True` is -2 in Python.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

Scalar = Any
"""A Python float, a NumPy array or a JAX tracer: one quantity of one scene, or of many."""


def _namespace(*values: Scalar) -> Any:
    """The array library of the first array among `values`."""
    for value in values:
        if hasattr(value, "__array_namespace__"):
            return value.__array_namespace__()
    raise TypeError(f"no array among {[type(value).__name__ for value in values]}")


def _plain(*values: Scalar) -> bool:
    return all(type(value) is float or type(value) is int for value in values)


def sqrt(x: Scalar) -> Scalar:
    """Square root; NaN below zero."""
    if type(x) is float or _plain(x):
        return math.sqrt(x) if x >= 0 else math.nan
    return _namespace(x).sqrt(x)


def sin(x: Scalar) -> Scalar:
    """Sine of an angle [rad]; NaN for an infinite one."""
    if type(x) is float or _plain(x):
        return math.sin(x) if math.isfinite(x) else math.nan
    return _namespace(x).sin(x)


def cos(x: Scalar) -> Scalar:
    """Cosine of an angle [rad]; NaN for an infinite one."""
    if type(x) is float or _plain(x):
        return math.cos(x) if math.isfinite(x) else math.nan
    return _namespace(x).cos(x)


def asin(x: Scalar) -> Scalar:
    """Arc sine [rad] of `x` clipped to [-1, 1]: rounding must not make an angle undefined."""
    x = clip(x, -1.0, 1.0)
    return math.asin(x) if type(x) is float or _plain(x) else _namespace(x).arcsin(x)


def atan2(y: Scalar, x: Scalar) -> Scalar:
    """Angle [rad] of the vector (x, y), in (-pi, pi]."""
    return math.atan2(y, x) if type(y) is type(x) is float or _plain(y, x) else _namespace(y, x).arctan2(y, x)


def exp(x: Scalar) -> Scalar:
    """Exponential; infinity where it overflows."""
    if type(x) is float or _plain(x):
        return math.exp(x) if not x > 709.782712893384 else math.inf
    return _namespace(x).exp(x)


def round_(x: Scalar) -> Scalar:
    """Nearest whole number, halves to even."""
    if _plain(x):
        return float(round(x)) if math.isfinite(x) else x
    return _namespace(x).round(x)


def minimum(a: Scalar, b: Scalar) -> Scalar:
    """The smaller of two; NaN if either is."""
    if type(a) is type(b) is float or _plain(a, b):
        return a if a <= b or a != a else b
    return _namespace(a, b).minimum(a, b)


def maximum(a: Scalar, b: Scalar) -> Scalar:
    """The larger of two; NaN if either is."""
    if type(a) is type(b) is float or _plain(a, b):
        return a if a >= b or a != a else b
    return _namespace(a, b).maximum(a, b)


def clip(x: Scalar, low: Scalar, high: Scalar) -> Scalar:
    """`x` held within [low, high]; NaN stays NaN, and `high` wins where the bounds cross."""
    if type(x) is type(low) is type(high) is float:
        x = x if x >= low or x != x else low
        return x if x <= high or x != x else high
    return minimum(maximum(x, low), high)


def isfinite(x: Scalar) -> Scalar:
    """Whether a number is neither NaN nor infinite."""
    return math.isfinite(x) if type(x) is float or _plain(x) else _namespace(x).isfinite(x)


def negate(condition: Scalar) -> Scalar:
    """Logical not."""
    return not condition if isinstance(condition, bool) else ~condition


def where(condition: Scalar, yes: Any, no: Any) -> Any:
    """`yes` where the condition holds, else `no`: numbers, (named) tuples or whole records of numbers."""
    if isinstance(condition, bool):
        return yes if condition else no
    if is_dataclass(yes) and not isinstance(yes, type):
        pairs = ((getattr(yes, f.name), getattr(no, f.name)) for f in fields(yes))
        return type(yes)(*(where(condition, a, b) for a, b in pairs))
    if isinstance(yes, tuple):
        parts = (where(condition, a, b) for a, b in zip(yes, no, strict=True))
        return type(yes)(*parts) if hasattr(yes, "_fields") else tuple(parts)
    return _namespace(condition).where(condition, yes, no)


def cond(condition: Scalar, yes: Callable[[], Any], no: Callable[[], Any]) -> Any:
    """`where` of what two functions return; on plain numbers only the one is called."""
    if isinstance(condition, bool):
        return yes() if condition else no()
    return where(condition, yes(), no())


def surely(condition: Scalar) -> bool:
    """Whether a condition is known to hold, so that something can be left out; in a compiled program never."""
    return condition is True


def stack(values: Sequence[Scalar], like: Any) -> Any:
    """One array with `values` along its last axis, of the dtype of `like`: the way into a network."""
    if _plain(*values):
        return np.array(values, dtype=like.dtype)
    return _namespace(*values).stack(values, axis=-1).astype(like.dtype)


def unstack(array: Any) -> list[Scalar]:
    """The entries along the last axis: the way out of a network."""
    return (
        array.tolist()
        if type(array) is np.ndarray and array.ndim == 1
        else [array[..., i] for i in range(array.shape[-1])]
    )
