"""Records as JAX pytrees: the one file that makes them so."""

from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass
from threading import Lock
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from fledge.pilots.base import AbstractPilot
from fledge.safety import AbstractNet

_registered: set[type] = set()
_one_at_a_time = Lock()


def pytree(kind: type) -> type:
    """Make a dataclass a pytree; a field with `metadata={"static": True}` is no leaf."""
    _once(kind, jax.tree_util.register_dataclass)
    return kind


def _once(kind: type, registers: Callable[[type], Any]) -> None:
    with _one_at_a_time:
        if kind not in _registered:
            registers(kind)
            _registered.add(kind)


def register(value: Any) -> None:
    """Make every record in `value` a pytree; a net becomes a constant, and a stranger's pilot that is no record."""
    if isinstance(value, tuple):
        for item in value:
            register(item)
    elif isinstance(value, AbstractNet) or (isinstance(value, AbstractPilot) and not is_dataclass(value)):
        _once(type(value), jax.tree_util.register_static)
    elif is_dataclass(value):
        pytree(type(value))
        for field in fields(value):
            if not field.metadata.get("static"):
                register(getattr(value, field.name))


def stack(records: Sequence[Any]) -> Any:
    """One record whose leaves have a leading axis, of many alike."""
    for record in records:
        register(record)
    return jax.tree.map(lambda *leaves: jnp.asarray(np.array(leaves, dtype=float)), *records)
