"""Learning the composite policy from the composite set: Algorithm 1, line 8.

`train` is a generator of `Checkpoint`s: many seeds at once by `vmap`, and each checkpoint is all that is needed to go
on exactly where it was made. The order of the rows is a function of seed and epoch: nothing else is to be remembered.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import optax

from fledge.fusion import CompositeSet
from fledge.policy import HIDDEN, Contract, Policy
from fledge.recipe import Recipe
from fledge.split import Split, hold_out

Layers = tuple[tuple[Any, ...], tuple[Any, ...]]
"""(weights, biases); with many seeds every array has a leading axis of seeds."""


@dataclass(frozen=True, slots=True)
class LossCurve:
    """Mean squared errors, measured every few epochs; of one seed, or with a leading axis of seeds."""

    epochs: np.ndarray
    """Shape (points,)."""
    training: np.ndarray
    """Shape (..., points, sub-tasks + 1): of all rows, then of each sub-task."""
    validation: np.ndarray
    """The same on what was held out."""
    names: tuple[str, ...]
    """The sub-tasks."""


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """All that training needs to go on; every array has a leading axis of seeds."""

    epoch: int
    layers: Layers
    optimiser: Any
    best: Layers
    best_loss: Any
    """Shape (seeds,)."""
    curve: LossCurve


def fit(
    composite: CompositeSet,
    recipe: Recipe | None = None,
    key: int = 0,
    contract: Contract | None = None,
) -> tuple[Policy, LossCurve]:
    """Train one policy: the whole of `train`, and its result."""
    recipe = recipe or Recipe.fast()
    *_, last = train(composite, recipe, [key])
    return member(policies(composite, recipe, last, contract), 0), member_curve(last.curve, 0)


def train(
    composite: CompositeSet,
    recipe: Recipe,
    keys: Sequence[int],
    resume: Checkpoint | None = None,
) -> Iterator[Checkpoint]:
    """Train one network per key, all at once, from the beginning or from a checkpoint of the same run."""
    data = Split.of(composite, recipe.checked())
    seeds = jnp.stack([jax.random.key(key) for key in keys])
    optimiser = _optimiser(recipe, len(data.train))
    state = resume or begin(composite, recipe, keys)
    run = jax.jit(
        jax.vmap(partial(_epochs, data, recipe, optimiser), in_axes=(0, 0, 0, None)),
    )
    measure = jax.jit(jax.vmap(partial(_losses, data)))
    while state.epoch < recipe.epochs:
        epoch = min(state.epoch + recipe.stride, recipe.epochs)
        layers, opt_state = run(state.layers, state.optimiser, seeds, np.arange(state.epoch, epoch))
        training, validation = measure(layers)
        better = validation[:, 0] < state.best_loss
        best = jax.tree.map(
            lambda new, old: jnp.where(better.reshape((-1,) + (1,) * (new.ndim - 1)), new, old),  # noqa: B023
            layers,
            state.best,
        )
        state = Checkpoint(
            epoch,
            layers,
            opt_state,
            best,
            jnp.minimum(validation[:, 0], state.best_loss),
            _longer(state.curve, epoch, np.asarray(training), np.asarray(validation)),
        )
        yield state


def begin(composite: CompositeSet, recipe: Recipe, keys: Sequence[int]) -> Checkpoint:
    """Epoch 0."""
    sizes = (len(composite.inputs), *HIDDEN, composite.actions.shape[1])
    seeds = jnp.stack([jax.random.key(key) for key in keys])
    layers = jax.vmap(partial(_initial, sizes, recipe.init))(seeds)
    rows = len(hold_out(composite, recipe)[0])
    opt_state = jax.vmap(_optimiser(recipe, rows).init)(layers)
    empty = np.empty((len(keys), 0, len(composite.names) + 1))
    curve = LossCurve(np.empty(0, dtype=int), empty, empty, composite.names)
    return Checkpoint(0, layers, opt_state, layers, jnp.full(len(keys), jnp.inf), curve)


def arrays(state: Checkpoint) -> dict[str, np.ndarray]:
    """A checkpoint as named arrays, for a file."""
    leaves = jax.tree.leaves((state.layers, state.optimiser, state.best, state.best_loss))
    named = {f"state{i:03d}": np.asarray(leaf) for i, leaf in enumerate(leaves)}
    curve = state.curve
    return named | {
        "epoch": np.asarray(state.epoch),
        "curve_epochs": curve.epochs,
        "curve_training": curve.training,
        "curve_validation": curve.validation,
    }


def restore(
    composite: CompositeSet, recipe: Recipe, keys: Sequence[int], stored: dict[str, np.ndarray]
) -> Checkpoint:
    """The checkpoint that `arrays` took apart."""
    fresh = begin(composite, recipe, keys)
    like = (fresh.layers, fresh.optimiser, fresh.best, fresh.best_loss)
    leaves = [jnp.asarray(stored[name]) for name in sorted(stored) if name.startswith("state")]
    curve = LossCurve(
        stored["curve_epochs"], stored["curve_training"], stored["curve_validation"], composite.names
    )
    layers, optimiser, best, best_loss = jax.tree.unflatten(jax.tree.structure(like), leaves)
    return Checkpoint(int(stored["epoch"]), layers, optimiser, best, best_loss, curve)


def policies(
    composite: CompositeSet, recipe: Recipe, state: Checkpoint, contract: Contract | None = None
) -> Policy:
    """What was learnt: one Policy whose arrays have a leading axis of seeds (see `member`)."""
    data = Split.of(composite, recipe)
    weights, biases = state.best if recipe.keep == "best" else state.layers
    seeds = len(state.best_loss)
    if contract is not None:
        contract = replace(contract, data=composite.digest())
    return Policy(
        weights=tuple(np.asarray(w, dtype=np.float32) for w in weights),
        biases=tuple(np.asarray(b, dtype=np.float32) for b in biases),
        mean=np.tile(data.mean, (seeds, 1)),
        scale=np.tile(data.scale, (seeds, 1)),
        inputs=composite.inputs,
        states=composite.states.shape[1],
        contract=contract,
    )


def member(many: Policy, i: int) -> Policy:
    """The policy of one seed."""
    return replace(
        many,
        weights=tuple(w[i] for w in many.weights),
        biases=tuple(b[i] for b in many.biases),
        mean=many.mean[i],
        scale=many.scale[i],
    )


def member_curve(many: LossCurve, i: int) -> LossCurve:
    """The curve of one seed."""
    return replace(many, training=many.training[i], validation=many.validation[i])


def _initial(sizes: tuple[int, ...], init: str, key: jax.Array) -> Layers:
    weights = []
    for i, (rows, columns) in enumerate(zip(sizes[:-1], sizes[1:], strict=True)):
        normal = jax.random.normal(jax.random.fold_in(key, i), (rows, columns))
        scale = {"paper": 1e-4, "he": (2.0 / rows) ** 0.5, "constant": 1e-4}[init]
        weights.append(jnp.full((rows, columns), scale) if init == "constant" else scale * normal)
    return tuple(weights), tuple(jnp.zeros(columns) for columns in sizes[1:])


def _optimiser(recipe: Recipe, rows: int) -> optax.GradientTransformation:
    if recipe.schedule == "constant":
        return optax.adamw(recipe.learning_rate, weight_decay=recipe.weight_decay)
    steps = recipe.epochs * max(rows // (recipe.batch or rows), 1)
    return optax.adamw(
        optax.cosine_decay_schedule(recipe.learning_rate, steps), weight_decay=recipe.weight_decay
    )


def _predict(layers: Layers, x: Any) -> Any:
    weights, biases = layers
    for weight, bias in zip(weights[:-1], biases[:-1], strict=True):
        x = jax.nn.relu(x @ weight + bias)
    return jnp.tanh(x @ weights[-1] + biases[-1])


def _loss(layers: Layers, x: Any, y: Any, mask: Any) -> Any:
    """Mean squared error over what was demonstrated."""
    squared = mask * (_predict(layers, x) - y) ** 2
    return squared.sum() / jnp.maximum(mask.sum(), 1.0)


def _losses(data: Split, layers: Layers) -> tuple[Any, Any]:
    """(training, validation) losses, each of all rows and of every sub-task."""
    squared = data.mask * (_predict(layers, data.x) - data.y) ** 2

    def mean(rows: np.ndarray) -> Any:
        weights = data.subtask[rows]
        counted = weights.T @ data.mask[rows].sum(axis=1)
        return weights.T @ squared[rows].sum(axis=1) / jnp.maximum(counted, 1.0)

    return mean(data.train), mean(data.held_out)


def _epochs(
    data: Split,
    recipe: Recipe,
    optimiser: optax.GradientTransformation,
    layers: Layers,
    state: Any,
    key: jax.Array,
    numbers: Any,
) -> tuple[Layers, Any]:
    """Some epochs of one seed, shape (epochs,)."""
    rows = len(data.train)
    batch = min(recipe.batch or rows, rows)
    steps = rows // batch

    def step(carry: tuple[Layers, Any], index: Any) -> tuple[Any, tuple[()]]:
        layers, state = carry
        gradient = jax.grad(_loss)(layers, data.x[index], data.y[index], data.mask[index])
        updates, state = optimiser.update(gradient, state, layers)
        return (optax.apply_updates(layers, updates), state), ()

    def epoch(carry: tuple[Layers, Any], number: Any) -> tuple[Any, tuple[()]]:
        if recipe.batch is None:
            return step(carry, data.train)
        order = jax.random.permutation(jax.random.fold_in(key, number), data.train)
        return jax.lax.scan(step, carry, order[: steps * batch].reshape(steps, batch))[0], ()

    return jax.lax.scan(epoch, (layers, state), numbers)[0]


def _longer(curve: LossCurve, epoch: int, training: np.ndarray, validation: np.ndarray) -> LossCurve:
    return replace(
        curve,
        epochs=np.append(curve.epochs, epoch),
        training=np.concatenate([curve.training, training[:, None]], axis=1),
        validation=np.concatenate([curve.validation, validation[:, None]], axis=1),
    )
