"""What is held out is seen by nobody in training, whichever way the rows are dealt out."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fledge.errors import BadDemonstrations
from fledge.learning.fusion import SubTask, fuse
from fledge.learning.recipe import Recipe
from fledge.learning.split import Split, hold_out


def demonstrations(seed=0, episodes=6, rows=50):
    rng = np.random.default_rng(seed)
    return [(states, states[:, :2]) for states in rng.normal(size=(episodes, rows, 3))]


@pytest.fixture(scope="module")
def two_tasks():
    """Six episodes of one action and four of the other, of different lengths."""
    left = [(s, a[:, :1]) for s, a in demonstrations(1, 6, 30)]
    right = [(s, a[:, 1:]) for s, a in demonstrations(2, 4, 40)]
    return fuse({SubTask("left", (0,)): left, SubTask("right", (1,)): right}, 2)


def split(composite, kind, share):
    data = Split.of(composite, Recipe(split=kind, validation=share))
    assert not set(data.train) & set(data.held_out)
    assert sorted([*data.train, *data.held_out]) == list(range(len(composite.states)))
    return data


@pytest.mark.slow
@given(st.floats(0.05, 0.7), st.lists(st.integers(2, 9), min_size=3, max_size=9), st.integers(2, 5))
@settings(max_examples=15)
def test_a_split_by_episode_shares_none(share, lengths, others):
    """And holds out the same share of every sub-task's episodes."""
    rng = np.random.default_rng(0)
    data = [(rng.normal(size=(n, 2)), rng.normal(size=(n, 1))) for n in lengths]
    composite = fuse({SubTask("a", (0,)): data, SubTask("b", (1,)): data[:1] * others}, 2)
    got = split(composite, "episode", share)
    train_episodes, held_episodes = (set(composite.episode[rows]) for rows in (got.train, got.held_out))
    assert not train_episodes & held_episodes
    for task, count in ((0, len(lengths)), (1, others)):
        held = {e for e in held_episodes if (composite.subtask[composite.episode == e] == task).all()}
        assert len(held) == max(round(share * count), 1)


@pytest.mark.slow
@given(st.floats(0.05, 0.9), st.integers(4, 40), st.integers(4, 40))
@settings(max_examples=15)
def test_a_split_by_row_takes_the_share_of_every_sub_task(share, first, second):
    rng = np.random.default_rng(0)
    composite = fuse(
        {SubTask(n, (d,)): (rng.normal(size=(r, 2)), rng.normal(size=(r, 1))) for n, d, r in
         (("a", 0, first), ("b", 1, second))}, 2
    )  # fmt: skip
    got = split(composite, "row", share)
    for task, count in ((0, first), (1, second)):
        assert np.sum(composite.subtask[got.held_out] == task) == max(round(share * count), 1)


def test_one_episode_is_split_into_blocks():
    """A bare pair: the last block is held out, so that only one row has a neighbour on the other side."""
    (pair,) = demonstrations(episodes=1)
    got = split(fuse({SubTask("a", (0, 1)): pair}, 2), "episode", 0.2)
    assert got.train.tolist() == list(range(40))
    assert got.held_out.tolist() == list(range(40, 50))


def test_every_seed_and_every_call_splits_alike(two_tasks):
    for kind in ("episode", "row"):
        one, other = (split(two_tasks, kind, 0.3) for _ in range(2))
        np.testing.assert_array_equal(one.held_out, other.held_out)


def test_the_normaliser_has_seen_training_rows_only(two_tasks):
    data = Split.of(two_tasks, Recipe())
    seen = two_tasks.states[data.train]
    np.testing.assert_allclose(data.mean, seen.mean(axis=0), rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(data.scale, seen.std(axis=0), rtol=1e-5)
    poisoned = two_tasks.states.copy()
    poisoned[data.held_out] = 1e6
    again = Split.of(replace(two_tasks, states=poisoned), Recipe())
    np.testing.assert_array_equal(data.mean, again.mean)
    np.testing.assert_array_equal(data.x[data.train], again.x[again.train])


def test_too_little_to_learn_from_is_said_clearly(two_tasks):
    (pair,) = demonstrations(episodes=1)
    (states, actions), one = pair, (pair[0][:1], pair[1][:1])
    lonely = {SubTask("much", (0, 1)): [pair, pair], SubTask("little", (2,)): (one[0], one[1][:, :1])}
    for data, recipe, names in (
        (fuse({SubTask("tiny", (0, 1)): one}, 2), Recipe(), ["tiny"]),
        (fuse({SubTask("tiny", (0, 1)): one}, 2), Recipe(split="row"), ["tiny"]),
        (fuse(lonely, 3), Recipe(), ["little"]),
        (fuse(lonely, 3), Recipe(split="row"), ["little"]),
        (fuse({SubTask("tiny", (0, 1)): [(states, actions)] * 3}, 2), Recipe(validation=0.95), ["tiny"]),
        (two_tasks.take(0), Recipe(), ["left", "right"]),
        (two_tasks.take(0), Recipe(split="row"), ["left", "right"]),
    ):
        with pytest.raises(BadDemonstrations) as caught:
            hold_out(data, recipe)
        message = str(caught.value)
        assert "\n" not in message and "more rows or episodes" in message
        assert all(name in message for name in names) and "much" not in message
