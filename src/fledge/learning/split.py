"""The composite set, made ready for training: some rows held out, the others' normaliser applied to all.

Rows are held out one by one, as the paper seems to do it, or by the episode, since neighbours are nearly the same (D7);
of every sub-task the same share, and the same rows for every seed.
"""

from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp
import numpy as np

from fledge.errors import BadDemonstrations
from fledge.learning.fusion import CompositeSet
from fledge.learning.recipe import Recipe
from fledge.pytrees import pytree


@pytree
@dataclass(frozen=True, slots=True)
class Split:
    """The rows of a composite set as a network wants them, and which of them it learns from."""

    x: Any
    """Inputs, normalised; shape (rows, inputs)."""
    y: Any
    """Actions, shape (rows, actions)."""
    mask: Any
    """1 where an action was demonstrated, else 0; shape (rows, actions)."""
    subtask: Any
    """Weights of a row in each loss, shape (rows, sub-tasks + 1)."""
    train: np.ndarray
    """Row numbers."""
    held_out: np.ndarray
    """Row numbers."""
    mean: np.ndarray
    """Of the inputs, shape (inputs,)."""
    scale: np.ndarray
    """Their standard deviations; 1 for an input that does not vary, which would become 0 / 0."""

    @classmethod
    def of(cls, composite: CompositeSet, recipe: Recipe) -> "Split":
        """Hold out and normalise; the normaliser sees the training rows only."""
        train, held_out = hold_out(composite, recipe)
        states = composite.states[:, list(composite.inputs)]
        mean, scale = states[train].mean(axis=0), states[train].std(axis=0)
        scale = np.where(scale > 1e-6 * np.maximum(np.abs(mean), 1.0), scale, 1.0)
        groups = np.eye(len(composite.names))[composite.subtask]
        return cls(
            x=jnp.asarray((states - mean) / scale, dtype=jnp.float32),
            y=jnp.asarray(composite.actions, dtype=jnp.float32),
            mask=jnp.asarray(composite.mask, dtype=jnp.float32),
            subtask=jnp.asarray(np.column_stack([np.ones(len(states)), groups]), dtype=jnp.float32),
            train=train,
            held_out=held_out,
            mean=mean.astype(np.float32),
            scale=scale.astype(np.float32),
        )


def hold_out(composite: CompositeSet, recipe: Recipe) -> tuple[np.ndarray, np.ndarray]:
    """Row numbers for training and validation.

    Raises:
        BadDemonstrations: nothing of a sub-task is left to train on.
    """
    rng = np.random.default_rng(67)
    unit = composite.episode if recipe.split == "episode" else np.arange(len(composite.states))
    held: list[np.ndarray] = []
    for task in range(len(composite.names)):
        units = np.unique(unit[composite.subtask == task])
        if recipe.split == "episode" and len(units) == 1:
            # One episode: its last block is held out.
            rows = np.flatnonzero(composite.subtask == task)
            held.append(rows[len(rows) - max(round(recipe.validation * len(rows)), 1) :])
            continue
        count = min(max(round(recipe.validation * len(units)), 1), len(units))
        held.append(np.flatnonzero(np.isin(unit, rng.choice(units, count, replace=False))))
    held_out = np.sort(np.concatenate(held))
    train = np.setdiff1d(np.arange(len(composite.states)), held_out)
    bare = [name for i, name in enumerate(composite.names) if i not in composite.subtask[train]]
    if bare:
        raise BadDemonstrations(
            f"{len(composite.states)} rows leave nothing of {', '.join(bare)} to train on after holding out "
            f"{len(held_out)}: give more rows or episodes"
        )
    return train, held_out
