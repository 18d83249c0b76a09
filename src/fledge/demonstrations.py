"""Demonstrations: state-action pairs, episode by episode.

`Demonstrations` is what the method eats: one pair of arrays per episode, rows x dimensions, of any task. `of_flights`
makes them from stored flights of the drone. Episodes stay apart because neighbouring rows are nearly the same: a
split by row leaks the training set into the validation set (D7).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from fledge.episode import Flight
from fledge.errors import BadDemonstrations
from fledge.observation import ACTION_NAMES, OBSERVATION_NAMES

Pair = tuple[np.ndarray, np.ndarray]
"""(states, actions) of one episode, shapes (rows, state dims) and (rows, action dims)."""


@dataclass(frozen=True, slots=True)
class Demonstrations:
    """Episodes of one task, checked: same dimensions throughout, finite, never empty."""

    episodes: tuple[Pair, ...]

    @classmethod
    def of(cls, data: "Demonstrations | Pair | Iterable[Pair]", name: str) -> "Demonstrations":
        """From a list of pairs, one per episode, or a bare pair, which counts as one episode.

        Raises:
            BadDemonstrations: wrong shapes, no rows, or numbers that are not finite; `name` says of what.
        """
        if isinstance(data, Demonstrations):
            return data
        bare = isinstance(data, tuple) and len(data) == 2 and np.ndim(data[0]) == 2
        pairs: Iterable[Pair] = [data] if bare else data  # type: ignore[list-item]
        episodes = tuple(_checked(pair, f"{name}, episode {i}") for i, pair in enumerate(pairs))
        if not episodes:
            raise BadDemonstrations(f"{name}: no episode; at least one is needed")
        widths = {(states.shape[1], actions.shape[1]) for states, actions in episodes}
        if len(widths) > 1:
            raise BadDemonstrations(f"{name}: episodes differ in (state, action) dims: {widths}")
        return cls(episodes)

    @property
    def rows(self) -> int:
        """Rows of all episodes."""
        return sum(len(states) for states, _ in self.episodes)

    @property
    def state_dim(self) -> int:
        """Entries of a state."""
        return self.episodes[0][0].shape[1]

    @property
    def action_dim(self) -> int:
        """Entries of an action."""
        return self.episodes[0][1].shape[1]


def of_flights(flights: Sequence[Flight]) -> Demonstrations:
    """What the pilots saw and said; states (rows, 11), actions (rows, axes in use of the flight)."""
    if not flights:
        raise BadDemonstrations("no flight; at least one is needed")
    pairs = []
    for flight in flights:
        seen, said = flight.episode.observation, flight.episode.action
        states = np.stack([getattr(seen, name) for name in OBSERVATION_NAMES], axis=1)
        used = [ACTION_NAMES[i] for i in flight.axes]
        pairs.append((states, np.stack([getattr(said, name) for name in used], axis=1)))
    return Demonstrations.of(pairs, flights[0].manoeuvre)


def _checked(pair: Pair, name: str) -> Pair:
    states, actions = (np.asarray(part, dtype=np.float64) for part in pair)
    if states.ndim != 2 or actions.ndim != 2 or len(states) != len(actions) or not len(states):
        raise BadDemonstrations(
            f"{name}: states of shape {states.shape} and actions of shape {actions.shape}; "
            "valid are (rows, dims) each, with the same number of rows, at least one"
        )
    for what, part in (("states", states), ("actions", actions)):
        if not np.isfinite(part).all():
            row, column = np.argwhere(~np.isfinite(part))[0]
            raise BadDemonstrations(
                f"{name}: {what} row {row}, entry {column} is {part[row, column]}; "
                "every number must be finite"
            )
    return states, actions
