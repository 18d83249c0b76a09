"""A logbook: the folder of one pilot's demonstrations, one MCAP file per flight.

Every flight stands whole under its name or not at all, and none is ever written over: whoever is interrupted goes on
where they were, and whoever asks for something else in the same folder is told so.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from fledge import console
from fledge.episode import Flight
from fledge.errors import BadFile, FledgeError, OutOfRange
from fledge.learning.demonstrations import PAPER_ORDERS, Order, collect
from fledge.manoeuvres import AbstractManoeuvre
from fledge.observation import ROW_RATE
from fledge.pilots import AbstractPilot
from fledge.storage import list_flights, read_flight, sweep, write_flight

EPISODES, ROWS = 10, 5000
"""Of a manoeuvre the paper does not have: about what each of its own has."""

FLIGHTS = "flights"
"""Within a logbook: flights that are no demonstrations, by policies mostly."""

MOST_ROWS = 1_000_000
"""That fit into the memory of a small machine at once: 14 hours of flight."""


def orders(
    manoeuvres: Sequence[AbstractManoeuvre], episodes: int | None = None, minutes: float | None = None
) -> list[Order]:
    """What to fly: the paper's numbers, where none are given.

    Raises:
        FledgeError: two manoeuvres of one name, or too many rows.
    """
    if len({manoeuvre.name for manoeuvre in manoeuvres}) < len(manoeuvres):
        raise FledgeError(f"manoeuvres {[one.name for one in manoeuvres]}: valid are different names")
    paper = {order.manoeuvre.name: (order.episodes, order.rows) for order in PAPER_ORDERS}
    usual = [Order(one, *paper.get(one.name, (EPISODES, ROWS))) for one in manoeuvres]
    chosen = [_resized(order, episodes or order.episodes, minutes) for order in usual]
    rows = sum(order.rows for order in chosen)
    if rows > MOST_ROWS:
        raise OutOfRange("rows in all", f"{rows:,}", f"up to {MOST_ROWS:,}: fewer episodes, or fewer minutes")
    return chosen


def fill(folder: Path, wanted: Sequence[Order], pilot: AbstractPilot, seed: int) -> list[Flight]:
    """Fly and store what is missing in a folder; the flights that were wanted, in their order.

    Raises:
        BadFile: the folder or a file cannot be read or written.
        FledgeError: the folder holds other flights under the same names, or by another pilot or seed.
    """
    folder.mkdir(parents=True, exist_ok=True)
    sweep(folder)
    lengths = {
        _name(order.manoeuvre.name, number): rows
        for order in wanted
        for number, rows in enumerate(order.lengths())
    }
    flights = {path.name: _checked(path, pilot, seed, lengths) for path in list_flights(folder)}
    done = [
        (order.manoeuvre.name, number)
        for order in wanted
        for number in range(order.episodes)
        if _name(order.manoeuvre.name, number) in flights
    ]
    if len(done) < len(lengths):
        with console.progress() as bar:
            bar.update("demonstrations", len(done), len(lengths))
            for number, flight in enumerate(collect(wanted, pilot, seed, done=done), start=len(done) + 1):
                name = _name(flight.manoeuvre, flight.case)
                write_flight(folder / name, flight)
                flights[name] = flight
                bar.update("demonstrations", number, len(lengths))
    return [flights[name] for name in lengths]


def read(folder: Path) -> list[Flight]:
    """All flights in a folder, whoever flew them.

    Raises:
        BadFile: there is no such folder, no flight in it, or one that cannot be read.
    """
    flights = [read_flight(path) for path in list_flights(folder)]
    if not flights:
        raise BadFile(folder, "there are no flights (*.mcap) in it; `fledge demonstrate` makes some")
    return flights


def taken_over(folder: Path) -> list[Flight]:
    """The flights in which people may have taken over, beside a logbook's demonstrations: in its folder `flights`.

    Raises:
        BadFile: there are none, or one cannot be read.
    """
    return read(folder / FLIGHTS)


def _resized(order: Order, episodes: int, minutes: float | None) -> Order:
    if minutes is not None:
        return replace(order, episodes=episodes, rows=round(minutes * 60.0 * ROW_RATE) * episodes)
    return replace(order, episodes=episodes, rows=order.rows * episodes // order.episodes)


def _name(manoeuvre: str, number: int) -> str:
    return f"{manoeuvre}-{number:03d}.mcap"


def _checked(path: Path, pilot: AbstractPilot, seed: int, lengths: dict[str, int]) -> Flight:
    """A stored flight, if it is one of this logbook's."""
    flight = read_flight(path)
    has = f"{flight.rows} rows by {flight.pilot} with seed {flight.seed}"
    fits = f"{lengths.get(path.name, flight.rows)} rows by {pilot.name} with seed {seed}"
    if has != fits:
        raise FledgeError(f"{path}: {has}, where {fits} belong: go on as it was begun, or give another --out")
    return flight
