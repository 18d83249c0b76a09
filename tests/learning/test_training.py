"""Learning: it learns, it forgets nothing when interrupted, and nothing leaks that should not."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import fledge
from fledge.errors import FledgeError, OutOfRange
from fledge.learning.fusion import SubTask, fuse
from fledge.learning.policy import Contract
from fledge.learning.recipe import Recipe
from fledge.learning.split import Split
from fledge.learning.training import (
    arrays,
    begin,
    fit,
    member,
    member_curve,
    policies,
    restore,
    train,
)

pytestmark = pytest.mark.slow

SHORT = Recipe(epochs=3, batch=32, points=3)
WHOLE = replace(SHORT, batch=None)
"""Full batch: no shuffling to compile, for tests that are about something else."""


def smooth_map(states):
    """Two actions of three states, one of them in need of both layers."""
    a, b, c = states.T
    return 0.8 * np.tanh(np.stack([a - b * c, np.abs(b) - 1.0], axis=1))


def demonstrations(seed=0, episodes=6, rows=50):
    rng = np.random.default_rng(seed)
    states = rng.normal(size=(episodes, rows, 3))
    return [(s, smooth_map(s)) for s in states]


@pytest.fixture(scope="module")
def composite():
    return fuse({SubTask("whole", (0, 1)): demonstrations()}, 2)


@pytest.fixture(scope="module")
def two_tasks():
    """Six episodes of one action and four of the other, of different lengths."""
    left = [(s, a[:, :1]) for s, a in demonstrations(1, 6, 30)]
    right = [(s, a[:, 1:]) for s, a in demonstrations(2, 4, 40)]
    return fuse({SubTask("left", (0,)): left, SubTask("right", (1,)): right}, 2)


@pytest.fixture(scope="module")
def three_seeds(composite):
    *_, last = train(composite, SHORT, [3, 4, 5])
    return last


def run(composite, recipe, key=0):
    """(policy, curve)."""
    *_, last = train(composite, recipe, [key])
    return member(policies(composite, recipe, last), 0), member_curve(last.curve, 0)


def assert_same(one, other):
    """Two policies, or checkpoints, to the last bit."""
    jax.tree.map(np.testing.assert_array_equal, leaves(one), leaves(other))


def leaves(thing):
    if isinstance(thing, fledge.Policy):
        return [*thing.weights, *thing.biases, thing.mean, thing.scale]
    return arrays(thing)


def error_on(policy, composite, rows):
    """Mean squared error over what was demonstrated."""
    squared = composite.mask[rows] * (policy(composite.states[rows]) - composite.actions[rows]) ** 2
    return squared.sum() / composite.mask[rows].sum()


# It learns


def test_it_learns_a_smooth_map(composite):
    """A hundredth of the variance is left, on rows it has not seen; and the curve says what the policy does."""
    recipe = Recipe(epochs=60, batch=50, weight_decay=0.0, points=6)
    policy, curve = fit(composite, recipe, key=1)
    fresh = np.random.default_rng(9).normal(size=(500, 3))
    left = np.mean((policy(fresh) - smooth_map(fresh)) ** 2)
    assert left < 0.05 * smooth_map(fresh).var()
    assert curve.training[-1, 0] < 0.02 * smooth_map(fresh).var()
    assert curve.epochs.tolist() == [10, 20, 30, 40, 50, 60]
    assert curve.names == ("whole",)
    assert curve.training.shape == curve.validation.shape == (6, 2)
    np.testing.assert_allclose(curve.training[:, 0], curve.training[:, 1], rtol=1e-5)


def test_equal_weights_stay_equal_and_small_random_ones_learn(composite):
    """D5: "initialized at 0.0001" cannot mean a constant; a standard deviation of 0.0001 trains well."""
    recipe = replace(Recipe.paper(300), points=3)
    losses = {}
    for init in ("constant", "paper"):
        *_, last = train(composite, replace(recipe, init=init), [0])
        losses[init] = last.curve.training[0, :, 0]
        weights, biases = ([np.asarray(array[0]) for array in part] for part in last.learners.layers)
        for into, bias, out in zip(weights[:-1], biases[:-1], weights[1:], strict=True):
            units = np.concatenate([into, bias[None], out.T])
            apart = np.ptp(units, axis=1).max() / np.abs(units).max()
            assert apart < 1e-3 if init == "constant" else apart > 1.0
    variance = Split.of(composite, recipe).y.var()
    assert losses["constant"][-1] > 0.3 * variance
    assert losses["paper"][-1] < 0.02 * variance


def test_first_weights_are_what_the_recipe_says(composite):
    sizes = ((3, 300, 300), (300, 300, 2))
    wanted = {"paper": lambda rows: 1e-4, "he": lambda rows: (2.0 / rows) ** 0.5}
    for init, deviation in wanted.items():
        weights, biases = begin(composite, replace(SHORT, init=init), [0, 1, 2]).learners.layers
        for weight, shape in zip(weights, zip(*sizes, strict=True), strict=True):
            assert weight.shape == (3, *shape)
            error = 5.0 / np.sqrt(2.0 * weight.size)
            np.testing.assert_allclose(np.std(weight), deviation(shape[0]), rtol=error)
            assert abs(np.mean(weight)) < 5.0 * deviation(shape[0]) / np.sqrt(weight.size)
            assert not np.array_equal(weight[0], weight[1])
        assert not any(np.any(bias) for bias in biases)
    weights, _ = begin(composite, replace(SHORT, init="constant"), [0]).learners.layers
    assert all((np.asarray(weight) == np.float32(1e-4)).all() for weight in weights)


# Chance and interruption


def test_the_same_key_gives_the_same_policy(composite, three_seeds):
    """To the last bit; another key gives another one."""
    *_, again = train(composite, SHORT, [3, 4, 6])
    for i, same in enumerate((True, True, False)):
        for part in ("layers", "best", "optimiser"):
            one, other = (jax.tree.leaves(getattr(state.learners, part)) for state in (three_seeds, again))
            equal = [np.array_equal(a[i], b[i]) for a, b in zip(one, other, strict=True) if a[i].ndim]
            assert all(equal) if same else not any(equal)
        assert np.array_equal(three_seeds.curve.validation[i], again.curve.validation[i]) is same


def test_a_seed_trains_alike_alone_and_among_others(composite, three_seeds):
    alone, curve = fit(composite, SHORT, key=4)
    among = member(policies(composite, SHORT, three_seeds), 1)
    for a, b in zip(leaves(alone), leaves(among), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-4)
    np.testing.assert_allclose(curve.training, three_seeds.curve.training[1], rtol=1e-3)
    states = composite.states[:40]
    np.testing.assert_allclose(alone(states), among(states), atol=1e-4)
    assert (alone.inputs, alone.states, alone.contract) == ((0, 1, 2), 3, None)


def test_measuring_less_often_changes_nothing(composite, three_seeds):
    """The order of the rows is a function of seed and epoch, not of how the epochs are dealt out."""
    *_, last = train(composite, replace(SHORT, points=1), [3, 4, 5])
    for a, b in zip(
        jax.tree.leaves(last.learners.layers), jax.tree.leaves(three_seeds.learners.layers), strict=True
    ):
        np.testing.assert_allclose(a, b, atol=1e-4)


@pytest.mark.parametrize(
    "recipe",
    [
        Recipe(epochs=3, batch=64, points=3),
        Recipe(
            epochs=5, batch=None, schedule="constant", weight_decay=0.0, split="row", keep="last", points=2
        ),
    ],
    ids=["mini-batches", "full batch"],
)
def test_training_goes_on_exactly_where_it_stopped(composite, recipe):
    """From every checkpoint, through named arrays and back: bit for bit the run that was never interrupted."""
    keys = [7]
    whole = list(train(composite, recipe, keys))
    assert [state.epoch for state in whole] == list(whole[-1].curve.epochs)
    assert whole[-1].epoch == recipe.epochs  # not up to a stride more, where the points do not divide them
    for i, checkpoint in enumerate(whole):
        stored = {name: array.copy() for name, array in arrays(checkpoint).items()}
        assert all(type(array) is np.ndarray for array in stored.values())
        assert [array.dtype.hasobject for array in stored.values()] == [False] * len(stored)
        state = restore(composite, recipe, keys, stored)
        assert_same(state, checkpoint)
        rest = list(train(composite, recipe, keys, state))
        assert [later.epoch for later in rest] == [later.epoch for later in whole[i + 1 :]]
        for later, uninterrupted in zip(rest, whole[i + 1 :], strict=True):
            assert_same(later, uninterrupted)


# What counts


def test_inputs_that_never_vary_do_no_harm():
    """The image centre, the set-point: constant in training, read none the less."""
    rng = np.random.default_rng(0)
    states = rng.normal(size=(60, 3)) * [1.0, 0.0, 0.0] + [0.0, 320.0, 0.0]
    composite = fuse({SubTask("a", (0, 1)): (states, np.tanh(states[:, [0, 0]]))}, 2)
    data = Split.of(composite, Recipe())
    assert data.scale[1] == data.scale[2] == 1.0
    policy, curve = fit(composite, replace(WHOLE, points=1))
    for numbers in (*leaves(policy), curve.training, curve.validation, policy(states)):
        assert np.isfinite(numbers).all()


def test_labels_that_were_not_demonstrated_have_no_influence(two_tasks):
    """Whatever stands in a masked place: the same weights and the same losses, to the last bit."""
    assert (two_tasks.mask == 0.0).any(axis=0).all()
    noise = np.random.default_rng(0).normal(0.0, 50.0, two_tasks.actions.shape)
    poisoned = replace(two_tasks, actions=np.where(two_tasks.mask == 1.0, two_tasks.actions, noise))
    (one, curve), (other, poisoned_curve) = (run(data, WHOLE) for data in (two_tasks, poisoned))
    assert_same(one, other)
    np.testing.assert_array_equal(curve.training, poisoned_curve.training)
    np.testing.assert_array_equal(curve.validation, poisoned_curve.validation)


def test_losses_are_those_of_each_sub_task(two_tasks):
    """All of it is the mean over what was demonstrated; each column that of one sub-task's rows."""
    recipe = replace(WHOLE, keep="last")
    policy, curve = run(two_tasks, recipe)
    data = Split.of(two_tasks, recipe)
    assert curve.names == ("left", "right")
    for rows, got in ((data.train, curve.training[-1]), (data.held_out, curve.validation[-1])):
        own = [rows, *(rows[two_tasks.subtask[rows] == i] for i in range(2))]
        np.testing.assert_allclose(got, [error_on(policy, two_tasks, some) for some in own], rtol=1e-4)


@pytest.mark.parametrize("slack", (0.0, 0.05))
def test_the_best_policy_is_the_last_whose_held_out_loss_is_near_the_lowest(composite, slack):
    """Steps too large, so that the losses jump: "best" keeps the lowest point, or one near it, "last" the last one."""
    jumpy = Recipe(
        epochs=12,
        batch=None,
        learning_rate=0.05,
        schedule="constant",
        weight_decay=0.0,
        points=12,
        slack=slack,
    )
    *_, state = train(composite, jumpy, [0, 1, 2])
    held_out = Split.of(composite, jumpy).held_out
    losses = state.curve.validation[:, :, 0]
    near = losses <= (1.0 + slack) * np.minimum.accumulate(losses, axis=1)
    chosen = [loss[np.flatnonzero(row)[-1]] for loss, row in zip(losses, near, strict=True)]
    assert (np.array(chosen) != losses[:, -1]).any()
    assert (np.array(chosen) == losses.min(axis=1)).all() == (slack == 0.0)
    np.testing.assert_array_equal(state.learners.best_loss, losses.min(axis=1))
    for keep, wanted in (("best", chosen), ("last", losses[:, -1])):
        many = policies(composite, replace(jumpy, keep=keep), state)
        got = [error_on(member(many, i), composite, held_out) for i in range(3)]
        np.testing.assert_allclose(got, wanted, rtol=1e-4)


def test_the_contract_learns_which_data_it_was(composite, three_seeds):
    many = policies(composite, SHORT, three_seeds, Contract(rate=10.0))
    assert many.contract == Contract(rate=10.0, data=composite.digest())
    assert member(many, 2).contract == many.contract
    assert all(part.dtype == np.float32 for part in leaves(many))


# What is refused


def test_a_recipe_that_makes_no_sense_is_refused(composite):
    with pytest.raises(OutOfRange, match="recipe epochs is 0: valid is 1 or more"):
        fit(composite, Recipe.fast(0))


# Another task


def test_the_method_knows_nothing_of_drones():
    """Public names, plain lists, a task of one's own: three states, two actions shown one at a time."""
    rng = np.random.default_rng(3)

    def shown(dim):
        episodes = rng.uniform(-1.0, 1.0, (5, 40, 3))
        actions = 0.9 * np.tanh(
            2.0 * np.stack([episodes[..., 0], episodes[..., 1] - episodes[..., 2]], axis=-1)
        )
        return [(s.tolist(), a[:, [dim]].tolist()) for s, a in zip(episodes, actions, strict=True)]

    grip, lift = fledge.SubTask("grip", actions=(0,)), fledge.SubTask("lift", actions=(1,))
    composite = fledge.fuse({grip: shown(0), lift: shown(1)}, action_dim=2, fill="mask")
    recipe = fledge.Recipe(epochs=300, batch=None, weight_decay=0.0, points=1)
    policy, curve = fledge.fit(composite, recipe, key=0)
    assert isinstance(policy, fledge.Policy) and isinstance(curve, fledge.LossCurve)
    assert policy.contract is None
    both = policy(np.array([[0.5, 0.5, -0.5], [-0.5, 0.0, 0.0], [0.0, -0.3, 0.3]]))
    wanted = 0.9 * np.tanh([[1.0, 2.0], [-1.0, 0.0], [0.0, -1.2]])
    np.testing.assert_allclose(both, wanted, atol=0.12)
    with pytest.raises(fledge.FledgeError):
        policy([0.0, 0.0])
    with pytest.raises(FledgeError):
        fledge.fuse({grip: shown(0)}, action_dim=2)
    assert jnp.asarray(both).shape == (3, 2)
