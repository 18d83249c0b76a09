"""Learning the composite policy from the composite set: Algorithm 1, line 8.

`train` is a generator of `Checkpoint`s: many seeds at once, and each checkpoint is all that is needed to go on exactly
where it was made. The order of the rows is a function of seed and epoch: nothing else is to be remembered.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import optax

from fledge.cores import cores
from fledge.learning.fusion import CompositeSet
from fledge.learning.policy import HIDDEN, Contract, Policy
from fledge.learning.recipe import Recipe
from fledge.learning.split import Split, hold_out

PIECE = 2048
"""Rows whose gradient is taken at once; with more of them a layer's outputs do not stay in the cache."""

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


class Learner(NamedTuple):
    """One network in training; with many seeds every array has a leading axis of seeds."""

    layers: Layers
    optimiser: Any
    best: Layers
    best_loss: Any
    """The lowest held-out loss so far."""


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """All that training needs to go on."""

    epoch: int
    learners: Learner
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
    state = resume or begin(composite, recipe, keys)
    seeds = jnp.stack([jax.random.key(key) for key in keys])
    leg = _program(recipe)
    # A network and its optimiser fit into a core's cache; vmap over twenty on a CPU takes twice as long.
    size = 1 if jax.default_backend() == "cpu" else len(keys)
    groups = [slice(i, i + size) for i in range(0, len(keys), size)]
    with cores() as pool:
        while state.epoch < recipe.epochs:
            epochs = np.arange(state.epoch, min(state.epoch + recipe.stride, recipe.epochs))

            def gone_on(group: slice, state: Checkpoint = state, epochs: np.ndarray = epochs) -> Any:
                learners = jax.tree.map(lambda leaf: leaf[group], state.learners)
                return jax.block_until_ready(leg(data, learners, seeds[group], epochs))

            parts = list(pool.map(gone_on, groups))
            learners, *losses = jax.tree.map(lambda *leaves: jnp.concatenate(leaves), *parts)
            state = Checkpoint(
                state.epoch + len(epochs), learners, _longer(state.curve, state.epoch + len(epochs), *losses)
            )
            yield state


def begin(composite: CompositeSet, recipe: Recipe, keys: Sequence[int]) -> Checkpoint:
    """Epoch 0."""
    sizes = (len(composite.inputs), *HIDDEN, composite.actions.shape[1])
    rows = len(hold_out(composite, recipe)[0])
    seeds = jnp.stack([jax.random.key(key) for key in keys])
    learners = jax.jit(jax.vmap(partial(_untaught, sizes, recipe, rows)))(seeds)
    empty = np.empty((len(keys), 0, len(composite.names) + 1))
    return Checkpoint(0, learners, LossCurve(np.empty(0, dtype=int), empty, empty, composite.names))


def arrays(state: Checkpoint) -> dict[str, np.ndarray]:
    """A checkpoint as named arrays, for a file."""
    named = {f"state{i:03d}": np.asarray(leaf) for i, leaf in enumerate(jax.tree.leaves(state.learners))}
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
    like = begin(composite, recipe, keys).learners
    leaves = [jnp.asarray(stored[name]) for name in sorted(stored) if name.startswith("state")]
    curve = LossCurve(
        stored["curve_epochs"], stored["curve_training"], stored["curve_validation"], composite.names
    )
    return Checkpoint(int(stored["epoch"]), jax.tree.unflatten(jax.tree.structure(like), leaves), curve)


def policies(
    composite: CompositeSet, recipe: Recipe, state: Checkpoint, contract: Contract | None = None
) -> Policy:
    """What was learnt: one Policy whose arrays have a leading axis of seeds (see `member`)."""
    data = Split.of(composite, recipe)
    weights, biases = state.learners.best if recipe.keep == "best" else state.learners.layers
    seeds = len(state.learners.best_loss)
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


def _untaught(sizes: tuple[int, ...], recipe: Recipe, rows: int, key: jax.Array) -> Learner:
    layers = _initial(sizes, recipe.init, key)
    return Learner(layers, _optimiser(recipe, rows).init(layers), layers, jnp.float32(jnp.inf))


def _initial(sizes: tuple[int, ...], init: str, key: jax.Array) -> Layers:
    weights = []
    for i, shape in enumerate(zip(sizes[:-1], sizes[1:], strict=True)):
        scale = {"paper": 1e-4, "he": (2.0 / shape[0]) ** 0.5, "constant": 1e-4}[init]
        normal = jax.random.normal(jax.random.fold_in(key, i), shape)
        weights.append(scale * (jnp.ones(shape) if init == "constant" else normal))
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


def _gradient(data: Split, layers: Layers, index: Any) -> Layers:
    """Of the mean squared error over what was demonstrated in these rows; summed up over pieces of them."""
    pieces = -(-len(index) // PIECE)
    length = -(-len(index) // pieces)
    padded = jnp.resize(index, (pieces, length))
    mask = data.mask[padded] * (jnp.arange(pieces * length) < len(index)).reshape(pieces, length, 1)
    total = jnp.maximum(mask.sum(), 1.0)

    def error(layers: Layers, x: Any, y: Any, mask: Any) -> Any:
        return (mask * (_predict(layers, x) - y) ** 2).sum() / total

    def add(gradient: Layers, piece: Any) -> tuple[Layers, tuple[()]]:
        return jax.tree.map(jnp.add, gradient, jax.grad(error)(layers, *piece)), ()

    nothing = jax.tree.map(jnp.zeros_like, layers)
    return jax.lax.scan(add, nothing, (data.x[padded], data.y[padded], mask))[0]


def _losses(data: Split, layers: Layers) -> tuple[Any, Any]:
    """(training, validation) losses, each of all rows and of every sub-task."""
    squared = data.mask * (_predict(layers, data.x) - data.y) ** 2

    def mean(rows: np.ndarray) -> Any:
        weights = data.subtask[rows]
        counted = weights.T @ data.mask[rows].sum(axis=1)
        return weights.T @ squared[rows].sum(axis=1) / jnp.maximum(counted, 1.0)

    return mean(data.train), mean(data.held_out)


@cache
def _program(recipe: Recipe) -> Callable[..., tuple[Learner, Any, Any]]:
    """`_leg` of many seeds, compiled; one program for all data of the same shape."""
    return jax.jit(jax.vmap(partial(_leg, recipe), in_axes=(None, 0, 0, None)))


def _leg(
    recipe: Recipe, data: Split, learner: Learner, key: jax.Array, epochs: Any
) -> tuple[Learner, Any, Any]:
    """Some epochs of one seed, and (training, validation) losses after them."""
    layers, optimiser = _epochs(data, recipe, learner, key, epochs)
    training, validation = _losses(data, layers)
    lowest = jnp.minimum(validation[0], learner.best_loss)
    better = validation[0] <= (1.0 + recipe.slack) * lowest
    best = jax.tree.map(partial(jnp.where, better), layers, learner.best)
    return Learner(layers, optimiser, best, lowest), training, validation


def _epochs(
    data: Split, recipe: Recipe, learner: Learner, key: jax.Array, numbers: Any
) -> tuple[Layers, Any]:
    """(layers, optimiser) after some epochs, shape (epochs,)."""
    optimiser = _optimiser(recipe, len(data.train))
    rows = len(data.train)
    batch = min(recipe.batch or rows, rows)
    steps = rows // batch

    def step(carry: tuple[Layers, Any], index: Any) -> tuple[Any, tuple[()]]:
        layers, state = carry
        updates, state = optimiser.update(_gradient(data, layers, index), state, layers)
        return (optax.apply_updates(layers, updates), state), ()

    def epoch(carry: tuple[Layers, Any], number: Any) -> tuple[Any, tuple[()]]:
        if recipe.batch is None:
            return step(carry, data.train)
        order = jax.random.permutation(jax.random.fold_in(key, number), data.train)
        return jax.lax.scan(step, carry, order[: steps * batch].reshape(steps, batch))[0], ()

    return jax.lax.scan(epoch, (learner.layers, learner.optimiser), numbers)[0]


def _longer(curve: LossCurve, epoch: int, training: np.ndarray, validation: np.ndarray) -> LossCurve:
    return replace(
        curve,
        epochs=np.append(curve.epochs, epoch),
        training=np.concatenate([curve.training, training[:, None]], axis=1),
        validation=np.concatenate([curve.validation, validation[:, None]], axis=1),
    )
