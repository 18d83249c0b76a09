"""Algorithm 1: sub-task demonstrations become one composite set.

Each sub-task demonstrates some of the composite action dimensions. `SubTask.f_state` and `SubTask.f_action` are the
paper's F_state and F_action; `fuse` is its loop. Three choices are made here and nowhere else (D9, D15):

* **fill**: what an undemonstrated action dimension becomes. "zero" (the paper's likely reading) teaches the network
  to keep that axis still, whatever it sees there; "mask" leaves it out of the loss.
* **inputs**: which state entries the network may read. All eleven, or without the velocities, which nearly
  repeat the last action (the copycat trap).
* **delay**: a person's action answers what was seen a reaction time ago. With a delay of k rows the action of row t is
  paired with the state of row t - k.
"""

import hashlib
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from fledge.errors import BadDemonstrations, OutOfRange, UnknownName
from fledge.learning.demonstrations import Demonstrations, Pair

Fill = Literal["zero", "mask"]


@dataclass(frozen=True, slots=True)
class SubTask:
    """A part of the composite task, and which composite dimensions its demonstrations have."""

    name: str
    actions: tuple[int, ...]
    """Composite action dims it demonstrates: the sub-action space A_h."""
    states: tuple[int, ...] | None = None
    """Composite state dims it observes: the sub-state space S_h; None for all of them."""

    def f_state(self, states: np.ndarray, neutral: np.ndarray) -> np.ndarray:
        """F_state: sub-states, shape (rows, sub dims), to composite states, the rest `neutral`."""
        if self.states is None:
            return states
        composite = np.tile(neutral, (len(states), 1))
        composite[:, list(self.states)] = states
        return composite

    def f_action(self, actions: np.ndarray, action_dim: int) -> tuple[np.ndarray, np.ndarray]:
        """F_action: sub-actions to (composite actions, mask), shapes (rows, action_dim); 0 where not demonstrated."""
        composite = np.zeros((len(actions), action_dim))
        mask = np.zeros((len(actions), action_dim))
        composite[:, list(self.actions)] = actions
        mask[:, list(self.actions)] = 1.0
        return composite, mask


@dataclass(frozen=True, slots=True)
class CompositeSet:
    """The composite set of Algorithm 1; rows keep their episode."""

    states: np.ndarray
    """Shape (rows, state dims)."""
    actions: np.ndarray
    """Shape (rows, action dims)."""
    mask: np.ndarray
    """Shape (rows, action dims): 1 where the loss counts."""
    episode: np.ndarray
    """Shape (rows,): which episode a row comes from."""
    subtask: np.ndarray
    """Shape (rows,): index into `names`."""
    names: tuple[str, ...]
    """The sub-tasks."""
    inputs: tuple[int, ...]
    """State entries the network may read."""

    def digest(self) -> str:
        """SHA-256 of the content: which data a policy was trained on."""
        sha = hashlib.sha256(repr((self.names, self.inputs)).encode())
        for array in (self.states, self.actions, self.mask, self.episode, self.subtask):
            sha.update(repr(array.shape).encode() + np.ascontiguousarray(array).tobytes())
        return sha.hexdigest()

    def take(self, rows: int) -> "CompositeSet":
        """About `rows` rows, evenly from every episode: for data-matched set-ups (D14)."""
        share = min(rows / len(self.states), 1.0)
        keep = np.concatenate([
            np.flatnonzero(self.episode == e)[: round(share * np.sum(self.episode == e))]
            for e in np.unique(self.episode)
        ])
        return CompositeSet(
            self.states[keep],
            self.actions[keep],
            self.mask[keep],
            self.episode[keep],
            self.subtask[keep],
            self.names,
            self.inputs,
        )


def fuse(
    demonstrations: Mapping[SubTask, Demonstrations | Pair | Iterable[Pair]],
    action_dim: int,
    fill: Fill = "mask",
    inputs: Sequence[int] | None = None,
    delay: int = 0,
    neutral: Sequence[float] | None = None,
    unused: Sequence[int] = (),
) -> CompositeSet:
    """Algorithm 1, lines 1 to 7.

    Args:
        demonstrations: of each sub-task; per episode a pair (states, actions), rows x dims.
        action_dim: dimensions of the composite action.
        fill: "mask" or "zero", see above.
        inputs: state entries the network may read; all of them by default.
        delay: rows by which actions lag what they answer.
        neutral: a composite state, for the entries a sub-task with `states` does not observe.
        unused: action dims that nobody ever uses and that stay 0 (yaw, in the paper).

    Raises:
        BadDemonstrations: dimensions that do not fit, or an action dim that no sub-task demonstrates.
        OutOfRange: `delay` negative or not shorter than every episode, `inputs` or `unused` that do not exist.
        UnknownName: another `fill`.
    """
    checked = {task: Demonstrations.of(data, task.name) for task, data in demonstrations.items()}
    state_dim = _check(checked, action_dim, unused, neutral)
    if fill not in get_args(Fill):
        raise UnknownName("fill", fill, get_args(Fill))
    for what, dims, limit in (("inputs", inputs or (), state_dim), ("unused", unused, action_dim)):
        if any(not 0 <= dim < limit for dim in dims):
            raise OutOfRange(what, tuple(dims), f"0 to {limit - 1}")
    neutral_state = np.zeros(state_dim) if neutral is None else np.asarray(neutral, dtype=float)
    parts: list[tuple[np.ndarray, ...]] = []
    for index, (task, data) in enumerate(checked.items()):
        for states, actions in data.episodes:
            if not 0 <= delay < len(states):
                raise OutOfRange("delay [rows]", delay, f"0 to {len(states) - 1}, within an episode")
            composite = task.f_state(states[: len(states) - delay], neutral_state)
            wanted, mask = task.f_action(actions[delay:], action_dim)
            if fill == "zero":
                mask = np.ones_like(mask)
            mask[:, list(unused)] = 1.0
            label = np.full(len(composite), len(parts))
            parts.append((composite, wanted, mask, label, np.full(len(composite), index)))
    states, actions, mask, episode, subtask = (np.concatenate(part) for part in zip(*parts, strict=True))
    chosen = tuple(range(state_dim)) if inputs is None else tuple(inputs)
    names = tuple(task.name for task in checked)
    return CompositeSet(states, actions, mask, episode, subtask, names, chosen)


def estimate_delay(
    demonstrations: Mapping[SubTask, Demonstrations | Pair | Iterable[Pair]],
    most: int = 10,
    answers: Collection[int] = (),
) -> int:
    """Rows by which actions lag what they answer, read off the demonstrations alone (D15).

    The delay whose linear model from state to action leaves the least, summed over sub-tasks in units of each one's
    variance. Delays of 0 to `most` rows are tried, as far as the shortest episode has more rows.

    Args:
        demonstrations: of each sub-task, as for `fuse`.
        most: rows to try.
        answers: entries of the composite state that answer the actions, as a vehicle's velocity does. They are left
            out: they tell of the actions just past, and so, best without delay, of those to come.
    """
    tasks: list[list[Pair]] = []
    for task, data in demonstrations.items():
        whole = Demonstrations.of(data, task.name)
        entries = range(whole.state_dim) if task.states is None else task.states
        seen = [column for column, entry in enumerate(entries) if entry not in answers]
        tasks.append([(states[:, seen], actions) for states, actions in whole.episodes])
    shortest = min(len(states) for episodes in tasks for states, _ in episodes)
    left = [sum(_unexplained(episodes, k) for episodes in tasks) for k in range(min(most + 1, shortest))]
    return int(np.argmin(left))


def _unexplained(episodes: Sequence[Pair], delay: int) -> float:
    """Share of the actions' variance that a linear model of the state `delay` rows ago does not explain."""
    pairs = [(s[: len(s) - delay], a[delay:]) for s, a in episodes]
    states, actions = (np.concatenate(part) for part in zip(*pairs, strict=True))
    states = np.column_stack([states - states.mean(axis=0), np.ones(len(states))])
    coefficients = np.linalg.lstsq(states, actions, rcond=None)[0]
    spread = np.mean((actions - actions.mean(axis=0)) ** 2)
    return float(np.mean((states @ coefficients - actions) ** 2) / max(spread, 1e-12))


def _check(
    demonstrations: Mapping[SubTask, Demonstrations],
    action_dim: int,
    unused: Sequence[int],
    neutral: Sequence[float] | None,
) -> int:
    """The composite state's dimension, if everything fits together."""
    if not demonstrations:
        raise BadDemonstrations("no sub-task; at least one is needed")
    whole = {data.state_dim for task, data in demonstrations.items() if task.states is None} | (
        {len(neutral)} if neutral is not None else set()
    )
    if len(whole) != 1:
        raise BadDemonstrations(
            f"composite states of {sorted(whole) or 'unknown'} entries: sub-tasks without `states`, "
            "and `neutral`, must agree on one number"
        )
    state_dim = whole.pop()
    for task, data in demonstrations.items():
        if data.action_dim != len(task.actions):
            raise BadDemonstrations(
                f"{task.name}: actions have {data.action_dim} entries, but the sub-task "
                f"demonstrates {len(task.actions)}: {task.actions}"
            )
        if task.states is not None and data.state_dim != len(task.states):
            raise BadDemonstrations(
                f"{task.name}: states have {data.state_dim} entries, but the sub-task "
                f"observes {len(task.states)}: {task.states}"
            )
        for what, dims, limit in (
            ("action", task.actions, action_dim),
            ("state", task.states or (), state_dim),
        ):
            if any(not 0 <= dim < limit for dim in dims):
                raise OutOfRange(f"{task.name}: {what} dims", dims, f"0 to {limit - 1}")
    missing = set(range(action_dim)) - set(unused)
    missing -= {dim for task in demonstrations for dim in task.actions}
    if missing:
        raise BadDemonstrations(
            f"no sub-task demonstrates action {sorted(missing)}: give its demonstrations, "
            "or name it in `unused`"
        )
    return state_dim
