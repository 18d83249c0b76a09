"""Algorithm 1: nothing is lost, nothing is invented, and every choice does what it says."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fledge.errors import BadDemonstrations, FledgeError, OutOfRange
from fledge.learning.demonstrations import Demonstrations
from fledge.learning.fusion import CompositeSet, SubTask, estimate_delay, fuse

pytestmark = pytest.mark.slow

STATE_DIM, ACTION_DIM = 5, 4
ARRAYS = ("states", "actions", "mask", "episode", "subtask")


def episodes(seed, state_dim, action_dim, lengths):
    """Pairs without a zero in them."""
    rng = np.random.default_rng(seed)
    return [
        (rng.uniform(0.1, 1.0, (rows, state_dim)), rng.uniform(0.1, 1.0, (rows, action_dim)))
        for rows in lengths
    ]


@st.composite
def tasks(draw):
    """One to three sub-tasks that demonstrate every action between them, some seeing part of the state only."""
    count = draw(st.integers(1, 3))
    owners = draw(st.lists(st.integers(0, count - 1), min_size=ACTION_DIM, max_size=ACTION_DIM))
    extra = draw(
        st.lists(st.sets(st.integers(0, ACTION_DIM - 1), max_size=2), min_size=count, max_size=count)
    )
    demonstrations = {}
    for i in range(count):
        dims = (
            {dim for dim, owner in enumerate(owners) if owner == i}
            | extra[i]
            | ({i} if i not in owners else set())
        )
        actions = tuple(draw(st.permutations(sorted(dims))))
        states = None
        if draw(st.booleans()):
            seen = draw(st.sets(st.integers(0, STATE_DIM - 1), min_size=1))
            states = tuple(draw(st.permutations(sorted(seen))))
        lengths = draw(st.lists(st.integers(1, 6), min_size=1, max_size=3))
        width = STATE_DIM if states is None else len(states)
        demonstrations[SubTask(f"task {i}", actions, states)] = episodes(i, width, len(actions), lengths)
    return demonstrations


NEUTRAL = (7.0, 8.0, 9.0, 10.0, 11.0)


def rows_of(composite, *names):
    """The rows as a sorted list of tuples: the set, whatever its order."""
    columns = [np.asarray(getattr(composite, name)).reshape(len(composite.states), -1) for name in names]
    return sorted(map(tuple, np.column_stack(columns).tolist()))


# The laws of Algorithm 1


@given(tasks(), st.sampled_from(["zero", "mask"]))
def test_every_pair_is_kept_exactly_once(demonstrations, fill):
    """Projected back, the composite rows of a sub-task are its rows, in order; and there are no others."""
    composite = fuse(demonstrations, ACTION_DIM, fill, neutral=NEUTRAL)
    assert composite.names == tuple(task.name for task in demonstrations)
    assert len(composite.states) == sum(len(s) for data in demonstrations.values() for s, _ in data)
    number = 0
    for i, (task, data) in enumerate(demonstrations.items()):
        seen = list(range(STATE_DIM) if task.states is None else task.states)
        for states, actions in data:
            rows = composite.episode == number
            assert (composite.subtask[rows] == i).all()
            np.testing.assert_array_equal(composite.states[rows][:, seen], states)
            np.testing.assert_array_equal(composite.actions[rows][:, list(task.actions)], actions)
            number += 1
    assert set(composite.episode) == set(range(number))


@given(tasks())
def test_what_was_not_demonstrated_is_neutral_and_masked(demonstrations):
    """Unobserved entries are `neutral`; undemonstrated actions 0, and out of the loss unless filled with zero."""
    masked = fuse(demonstrations, ACTION_DIM, "mask", neutral=NEUTRAL)
    zeroed = fuse(demonstrations, ACTION_DIM, "zero", neutral=NEUTRAL)
    assert (zeroed.mask == 1.0).all()
    for name in ("states", "actions", "episode", "subtask"):
        np.testing.assert_array_equal(getattr(zeroed, name), getattr(masked, name))
    for i, task in enumerate(demonstrations):
        own = masked.subtask == i
        shown = np.isin(np.arange(ACTION_DIM), task.actions)
        assert (masked.mask[own] == shown).all()
        assert (masked.actions[own][:, ~shown] == 0.0).all()
        assert (masked.actions[own][:, shown] != 0.0).all()
        hidden = [d for d in range(STATE_DIM) if task.states is not None and d not in task.states]
        assert (masked.states[own][:, hidden] == np.array(NEUTRAL)[hidden]).all()


@given(tasks(), st.randoms(use_true_random=False))
def test_the_order_of_sub_tasks_does_not_matter(demonstrations, random):
    items = list(demonstrations.items())
    random.shuffle(items)
    one, other = (fuse(dict(some), ACTION_DIM, neutral=NEUTRAL) for some in (demonstrations.items(), items))
    parts = ("states", "actions", "mask")
    assert rows_of(one, *parts) == rows_of(other, *parts)
    assert sorted(one.names) == sorted(other.names)
    for name in one.names:
        mine, theirs = (c.states[c.subtask == c.names.index(name)] for c in (one, other))
        np.testing.assert_array_equal(mine, theirs)


@given(tasks())
def test_f_state_and_f_action_are_undone_by_projection(demonstrations):
    for task, data in demonstrations.items():
        for states, actions in data:
            composite = task.f_state(states, np.array(NEUTRAL))
            seen = list(range(STATE_DIM) if task.states is None else task.states)
            assert composite.shape == (len(states), STATE_DIM)
            np.testing.assert_array_equal(composite[:, seen], states)
            filled, mask = task.f_action(actions, ACTION_DIM)
            assert filled.shape == mask.shape == (len(actions), ACTION_DIM)
            np.testing.assert_array_equal(filled[:, list(task.actions)], actions)
            assert mask.sum() == actions.size


def test_a_sub_task_that_sees_everything_needs_no_neutral_and_gets_zeros_else():
    whole, part = SubTask("whole", (0,)), SubTask("part", (1,), states=(2, 0))
    demonstrations = {whole: episodes(0, 3, 1, [2]), part: episodes(1, 2, 1, [2])}
    composite = fuse(demonstrations, 2)
    ((states, _),) = demonstrations[part]
    np.testing.assert_array_equal(composite.states[2:], np.column_stack([states[:, 1], [0, 0], states[:, 0]]))


def test_fusing_changes_nothing_it_was_given():
    demonstrations = {SubTask("a", (0, 1)): episodes(0, 3, 2, [5, 4])}
    before = [(s.copy(), a.copy()) for s, a in next(iter(demonstrations.values()))]
    composite = fuse(demonstrations, 3, unused=(2,), delay=2)
    composite.states[:] = 0.0
    for (s, a), (s0, a0) in zip(next(iter(demonstrations.values())), before, strict=True):
        np.testing.assert_array_equal(s, s0)
        np.testing.assert_array_equal(a, a0)


# The choices


@given(st.integers(0, 5), st.lists(st.integers(6, 12), min_size=1, max_size=4))
def test_a_delay_pairs_an_action_with_what_was_seen_before(delay, lengths):
    """States and actions carry episode and row: action t stands beside state t - delay of the same episode."""
    data = [
        (np.stack([np.full(n, e), np.arange(n)], axis=1), np.stack([np.full(n, e), np.arange(n)], axis=1))
        for e, n in enumerate(lengths)
    ]
    composite = fuse({SubTask("a", (0, 1)): data}, 2, delay=delay)
    assert len(composite.states) == sum(lengths) - delay * len(lengths)
    np.testing.assert_array_equal(composite.states[:, 0], composite.actions[:, 0])
    np.testing.assert_array_equal(composite.states[:, 0], composite.episode)
    np.testing.assert_array_equal(composite.actions[:, 1] - composite.states[:, 1], delay)
    assert len(set(zip(composite.episode.tolist(), composite.actions[:, 1].tolist(), strict=True))) == len(
        composite.states
    )


def test_unused_actions_are_learnt_to_stay_at_zero():
    composite = fuse({SubTask("a", (0,)): episodes(0, 2, 1, [4]), SubTask("b", (1,)): episodes(1, 2, 1, [3])}, 4,
                     unused=(2, 3))  # fmt: skip
    assert (composite.actions[:, 2:] == 0.0).all()
    assert (composite.mask[:, 2:] == 1.0).all()
    assert composite.mask[:, :2].sum() == 7


def test_inputs_are_all_entries_unless_chosen():
    data = {SubTask("a", (0,)): episodes(0, 3, 1, [4])}
    assert fuse(data, 1).inputs == (0, 1, 2)
    chosen = fuse(data, 1, inputs=[2, 0])
    assert chosen.inputs == (2, 0)
    np.testing.assert_array_equal(chosen.states, fuse(data, 1).states)


# What is refused


GOOD = {SubTask("left", (0,)): episodes(0, 3, 1, [5]), SubTask("right", (1,)): episodes(1, 3, 1, [4])}


def good(**changes):
    return fuse(**({"demonstrations": GOOD, "action_dim": 2} | changes))


@pytest.mark.parametrize(
    ("changes", "error", "says"),
    [
        ({"demonstrations": {}}, BadDemonstrations, ["no sub-task"]),
        ({"action_dim": 3}, BadDemonstrations, ["action [2]", "unused"]),
        ({"action_dim": 5, "unused": (3,)}, BadDemonstrations, ["action [2, 4]"]),
        ({"action_dim": 1}, OutOfRange, ["right", "action dims", "(1,)", "0 to 0"]),
        ({"delay": -1}, OutOfRange, ["delay", "-1"]),
        ({"delay": 4}, OutOfRange, ["delay", "4", "0 to 3"]),
        ({"inputs": (0, 3)}, OutOfRange, ["inputs", "(0, 3)", "0 to 2"]),
        ({"inputs": (-1,)}, OutOfRange, ["inputs", "(-1,)"]),
        ({"unused": (2,)}, OutOfRange, ["unused", "(2,)", "0 to 1"]),
        ({"unused": (-1,)}, OutOfRange, ["unused", "(-1,)"]),
        ({"fill": "zeros"}, FledgeError, ["fill", "'zeros'", "mask, zero"]),
        ({"neutral": (0.0, 0.0)}, BadDemonstrations, ["[2, 3]", "agree"]),
        (
            {"demonstrations": GOOD | {SubTask("wide", (0,)): episodes(2, 4, 1, [3])}},
            BadDemonstrations,
            ["[3, 4]"],
        ),
        (
            {"demonstrations": {SubTask("odd", (0, 1)): episodes(2, 3, 1, [3])}},
            BadDemonstrations,
            ["odd", "(0, 1)"],
        ),
        ({"demonstrations": {SubTask("low", (-1, 0, 1)): episodes(2, 3, 3, [3])}}, OutOfRange, ["low", "-1"]),
        (
            {"demonstrations": GOOD | {SubTask("far", (0,), states=(0, 3)): episodes(2, 2, 1, [3])}},
            OutOfRange,
            ["far", "state dims", "(0, 3)", "0 to 2"],
        ),
        (
            {"demonstrations": GOOD | {SubTask("blind", (0,), states=(0,)): episodes(2, 2, 1, [3])}},
            BadDemonstrations,
            ["blind", "2 entries", "1: (0,)"],
        ),
        (
            {"demonstrations": {SubTask("only", (0, 1), states=(0, 1)): episodes(2, 2, 2, [3])}},
            BadDemonstrations,
            ["unknown", "neutral"],
        ),
    ],
)
def test_what_does_not_fit_is_refused_in_one_line(changes, error, says):
    with pytest.raises(error) as caught:
        good(**changes)
    message = str(caught.value)
    assert "\n" not in message
    for word in says:
        assert word in message


# The set


def test_the_digest_is_stable_and_notices_any_change():
    composite = good()
    digests = {composite.digest()}
    assert good().digest() in digests
    assert len(composite.digest()) == 64
    for name in ARRAYS:
        array = getattr(composite, name).copy()
        array.flat[-1] += 1
        digests.add(replace(composite, **{name: array}).digest())
    digests.add(replace(composite, inputs=(0, 1)).digest())
    digests.add(replace(composite, names=("left", "rigth")).digest())
    assert len(digests) == 1 + len(ARRAYS) + 2
    assert len(fields(CompositeSet)) == len(ARRAYS) + 2


def test_the_digest_knows_where_an_array_ends():
    """The same numbers in the same order, but dealt out differently."""
    numbers = np.arange(1.0, 6.0)
    one, other = (
        CompositeSet(
            numbers[None, :k], numbers[None, k:], np.ones((1, 2)), np.zeros(1), np.zeros(1), ("a",), (0,)
        )
        for k in (2, 3)
    )
    assert one.digest() != other.digest()


@given(st.lists(st.integers(1, 60), min_size=1, max_size=8), st.integers(1, 400))
def test_take_keeps_the_same_share_of_every_episode(lengths, rows):
    demonstrations = {SubTask("a", (0,)): episodes(0, 2, 1, lengths)}
    composite = fuse(demonstrations, 1)
    taken = composite.take(rows)
    total = sum(lengths)
    share = min(rows / total, 1.0)
    for e, length in enumerate(lengths):
        kept = np.flatnonzero(taken.episode == e)
        assert abs(len(kept) - share * length) <= 0.5
        np.testing.assert_array_equal(
            taken.states[kept], demonstrations[next(iter(demonstrations))][e][0][: len(kept)]
        )
    assert abs(len(taken.states) - min(rows, total)) <= 0.5 * len(lengths)
    if rows >= total:
        assert taken.digest() == composite.digest()


# The delay


def tracking(seed, delay, noise, rows=150, count=4, memory=0.9):
    """Two sub-tasks whose actions answer a wandering state, `delay` rows late."""
    rng = np.random.default_rng(seed)
    demonstrations = {}
    for name, dims in (("sideways", (0, 1)), ("up", (2,))):
        gains = rng.uniform(-1.0, 1.0, (4, len(dims)))
        data = []
        for _ in range(count):
            steps = rng.normal(size=(rows + delay, 4)) * np.sqrt(1.0 - memory**2)
            states = np.zeros_like(steps)
            for t in range(1, len(steps)):
                states[t] = memory * states[t - 1] + steps[t]
            actions = states[: len(states) - delay] @ gains
            # A column that never varies, as the image centre's does.
            seen = np.column_stack([states[delay:], np.full(rows, 320.0)])
            data.append((seen, actions + noise * actions.std() * rng.normal(size=actions.shape)))
        demonstrations[SubTask(name, dims)] = data
    return demonstrations


@settings(max_examples=40)
@given(st.integers(0, 8), st.integers(0, 1000), st.sampled_from([0.0, 0.3, 1.0]))
def test_the_delay_is_found_in_the_data(delay, seed, noise):
    """Even where as much of what was said is noise as is not."""
    assert estimate_delay(tracking(seed, delay, noise)) == delay


@given(st.integers(0, 8), st.floats(1e-4, 1e4), st.floats(-100.0, 100.0))
@settings(max_examples=20)
def test_the_delay_does_not_depend_on_units(delay, scale, offset):
    data = tracking(1, delay, 0.3)
    scaled = {
        task: [(scale * s + offset, a) for s, a in pairs] if task.name == "up" else pairs
        for task, pairs in data.items()
    }
    assert estimate_delay(scaled) == delay


def test_the_delay_that_was_found_makes_a_linear_task_linear_again():
    data = tracking(2, 3, 0.0)
    sideways = {task: pairs for task, pairs in data.items() if task.name == "sideways"}

    def left_over(delay):
        composite = fuse(sideways, 2, delay=delay)
        states = np.column_stack([composite.states, np.ones(len(composite.states))])
        model = np.linalg.lstsq(states, composite.actions, rcond=None)[0]
        return np.mean((states @ model - composite.actions) ** 2) / composite.actions.var()

    assert left_over(estimate_delay(data)) < 1e-12
    assert left_over(0) > 0.1


def holding(seed, delay, rows=2000):
    """A person with a slowly trembling hand holds a drifting thing: (how far off, how fast), and what was said."""
    rng = np.random.default_rng(seed)
    off, velocity, said, tremble = np.zeros(rows), np.zeros(rows), np.zeros(rows), 0.0
    for t in range(1, rows):
        tremble = 0.9 * tremble + 0.05 * rng.normal()
        velocity[t] = 0.3 * velocity[t - 1] + 0.7 * said[t - 1]
        off[t] = off[t - 1] + 0.05 * (velocity[t] + rng.normal())
        said[t] = tremble - off[max(t - delay, 0)]
    return np.column_stack([off, velocity]), said[:, None]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("delay", (2, 4, 6))
def test_what_answers_the_actions_would_hide_the_delay(delay, seed):
    """The velocity is what was said just now, tremble and all, which tells what is said next."""
    states, actions = holding(seed, delay)
    whole = SubTask("hold", (0,))
    assert estimate_delay({whole: (states, actions)}) == 0
    assert estimate_delay({whole: (states, actions)}, answers=(1,)) == delay
    # The entry is the composite state's, wherever a sub-task has it.
    part = SubTask("hold", (0,), states=(4, 2))
    assert estimate_delay({part: (states[:, ::-1], actions)}, answers=(4,)) == delay


def test_short_episodes_bound_the_delay():
    """No delay longer than every episode is ever chosen, and Demonstrations do as well as pairs."""
    data = tracking(3, 2, 0.0, rows=6, count=8)
    assert estimate_delay(data, most=30) < 6
    assert estimate_delay(tracking(3, 2, 0.0), most=0) == 0
    whole = tracking(4, 5, 0.1)
    assert estimate_delay({task: Demonstrations.of(d, task.name) for task, d in whole.items()}) == 5
