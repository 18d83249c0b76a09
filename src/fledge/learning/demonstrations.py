"""Demonstrations: state-action pairs, episode by episode.

`Demonstrations` is what the method eats: one pair of arrays per episode, rows x dimensions, of any task. Episodes
stay apart because neighbouring rows are nearly the same: a split by row leaks the training set into the
validation set (D7). `collect` lets a pilot fly the drone's, `of_flights` makes data of them.

The paper's text and its row counts contradict each other (episodes of 5 and 10 minutes would be 60,000 rows each);
`PAPER_ORDERS` follows the counts (D4).
"""

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fledge.engines import fly, fly_plain, take, traceable
from fledge.episode import Flight
from fledge.errors import BadDemonstrations
from fledge.manoeuvres import AbstractManoeuvre, Climb, Combined, Descend, FixedAltitude
from fledge.observation import ACTION_NAMES, OBSERVATION_NAMES, ROW_RATE, Axes
from fledge.pilots import AbstractPilot
from fledge.simulation import Case, Crew, Rig, flight_key


@dataclass(frozen=True, slots=True)
class Order:
    """How many episodes of a manoeuvre to fly, and how many rows in all."""

    manoeuvre: AbstractManoeuvre
    episodes: int
    rows: int

    def lengths(self) -> list[int]:
        """Rows of each episode: as even as can be, the longer ones first."""
        short, longer = divmod(self.rows, self.episodes)
        return [short + (i < longer) for i in range(self.episodes)]


PAPER_ORDERS = (
    Order(FixedAltitude(), 5, 5296),
    Order(Climb(), 10, 4691),
    Order(Descend(), 10, 4904),
    Order(Combined(), 10, 5464),
)
"""Section "Experiments": episodes and instances of each data set."""

MINUTE = round(60 * ROW_RATE)
"""Rows."""

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
        # A tuple of two is a bare pair, unless its first item is a pair itself.
        bare = isinstance(data, tuple) and len(data) == 2 and not isinstance(data[0], tuple)
        pairs: Iterable[Any] = [data] if bare else data
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


def collect(
    orders: Sequence[Order],
    pilot: AbstractPilot,
    seed: int,
    rig: Rig = Rig(),
    done: Collection[tuple[str, int]] = (),
) -> Iterator[Flight]:
    """Let a pilot demonstrate; each flight is a pure function of manoeuvre, pilot, seed and its number.

    They fly in batches, compiled; a pilot that JAX cannot trace flies one after the other, in plain Python.
    Those `done`, by manoeuvre and number, are left out.
    """
    jobs = [(order.manoeuvre, i, rows) for order in orders for i, rows in enumerate(order.lengths())]
    jobs = [
        (manoeuvre, number, rows) for manoeuvre, number, rows in jobs if (manoeuvre.name, number) not in done
    ]
    if not jobs:
        return
    # In whole minutes, as tests are flown: then both are flown by one program.
    longest = -(-max(rows for _, _, rows in jobs) // MINUTE) * MINUTE
    cases, crews, keys = [], [], []
    for manoeuvre, number, rows in jobs:
        key = flight_key(seed, "demonstration", manoeuvre.name, number)
        cases.append(Case.draw(manoeuvre, key, rows))
        crews.append(Crew(pilot.for_axes(manoeuvre.axes), Axes.of(manoeuvre.axes)))
        keys.append((*key, 1))
    compiled = fly([case.lasting(longest) for case in cases], crews, keys, rig) if traceable(pilot) else None
    for i, (manoeuvre, number, rows) in enumerate(jobs):
        plain = compiled is None
        episode = fly_plain(cases[i], crews[i], keys[i], rig) if plain else take(compiled, i, rows)
        yield Flight(
            episode=episode,
            manoeuvre=manoeuvre.name,
            pilot=pilot.name,
            net="none",
            seed=seed,
            case=number,
            axes=manoeuvre.axes,
            arena=cases[i].plan.arena,
            lens=rig.lens,
            sticks=rig.sticks,
            ideal_radius=rig.ideal_radius,
        )


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
    try:
        states, actions = (np.asarray(part, dtype=np.float64) for part in pair)
    except (TypeError, ValueError) as error:
        raise BadDemonstrations(f"{name}: not a pair (states, actions) of numbers: {error}") from error
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
