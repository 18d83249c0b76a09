"""What stands in a logbook stays; what is missing is flown; what does not belong is refused."""

from dataclasses import dataclass

import pytest

from fledge.engines import fly_plain
from fledge.errors import BadFile, FledgeError, OutOfRange
from fledge.learning import demonstrations
from fledge.learning.demonstrations import PAPER_ORDERS, Order
from fledge.manoeuvres import MANOEUVRES, Climb, Combined, Descend, FixedAltitude
from fledge.observation import Action
from fledge.pilots import AbstractPilot
from fledge.runs import logbook
from fledge.storage import read_flight

pytestmark = pytest.mark.slow


@dataclass(frozen=True)
class Untraceable(AbstractPilot):
    """Flown flight by flight, in plain Python, which is quick for a second of flight."""

    name: str = "untraceable"

    def act(self, memory, seen, noise):
        return memory, Action(0.1 if seen.ugv_v < seen.centre_v else -0.1, 0.0, 0.0, 0.0)


PILOT = Untraceable()
ORDERS = [Order(FixedAltitude(), 2, 41), Order(Climb(), 1, 20)]
NAMES = ["climb-000.mcap", "fixed-altitude-000.mcap", "fixed-altitude-001.mcap"]


def stats(folder):
    return {path.name: (path.stat().st_ino, path.stat().st_mtime_ns) for path in folder.iterdir()}


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    folder = tmp_path_factory.mktemp("logbook")
    logbook.fill(folder, ORDERS, PILOT, 0)
    return folder


@pytest.fixture
def book(full, tmp_path):
    """A copy of it."""
    for path in full.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    return tmp_path


def test_without_numbers_the_papers_are_flown():
    assert logbook.orders(MANOEUVRES) == list(PAPER_ORDERS)
    assert logbook.orders([Climb()]) == [PAPER_ORDERS[1]]


@pytest.mark.parametrize("episodes", [None, 1, 3])
@pytest.mark.parametrize("minutes", [None, 0.1, 10.0])
def test_each_number_can_be_given(episodes, minutes):
    for order, paper in zip(logbook.orders(MANOEUVRES, episodes, minutes), PAPER_ORDERS, strict=True):
        assert order.episodes == (episodes or paper.episodes)
        usual = paper.rows / paper.episodes
        assert all(abs(rows - (1200 * minutes if minutes else usual)) < 1.0 for rows in order.lengths())


def test_a_strangers_manoeuvre_gets_numbers_like_the_papers():
    (order,) = logbook.orders([Combined(families=("line",))])
    assert (order.episodes, order.rows) == (10, 5464)
    (order,) = logbook.orders([_Renamed()])
    assert (order.episodes, order.rows) == (logbook.EPISODES, logbook.ROWS)


class _Renamed(Climb):
    name = "hop"


def test_names_must_differ_and_memory_is_finite():
    with pytest.raises(FledgeError, match="'climb', 'climb'.: valid are different names"):
        logbook.orders([Climb(), Climb()])
    with pytest.raises(OutOfRange, match="rows in all is 1,200,000: valid is up to 1,000,000"):
        logbook.orders([Climb()], episodes=100, minutes=10.0)


def test_it_holds_what_was_ordered(full):
    assert sorted(stats(full)) == NAMES
    assert [read_flight(full / name).rows for name in NAMES] == [20, 21, 20]
    assert {read_flight(full / name).seed for name in NAMES} == {0}


def test_what_stands_there_is_read_and_not_touched(book):
    before = stats(book)
    flights = logbook.fill(book, ORDERS, PILOT, 0)
    assert [(flight.manoeuvre, flight.case, flight.rows) for flight in flights] == [
        ("fixed-altitude", 0, 21),
        ("fixed-altitude", 1, 20),
        ("climb", 0, 20),
    ]
    assert stats(book) == before


@pytest.mark.parametrize("lost", NAMES)
def test_what_is_missing_is_flown_as_it_was_and_nothing_else_is(book, full, lost, monkeypatch):
    flown = []
    monkeypatch.setattr(
        demonstrations, "fly_plain", lambda case, *scene: flown.append(case) or fly_plain(case, *scene)
    )
    (book / lost).unlink()
    before = stats(book)
    logbook.fill(book, ORDERS, PILOT, 0)
    assert len(flown) == 1
    assert before.items() <= stats(book).items()
    assert all((book / name).read_bytes() == (full / name).read_bytes() for name in NAMES)


def test_other_manoeuvres_may_join(book):
    before = stats(book)
    flights = logbook.fill(book, [Order(Descend(), 1, 20)], PILOT, 0)
    assert [flight.manoeuvre for flight in flights] == ["descend"]
    assert before.items() <= stats(book).items()


@pytest.mark.parametrize(
    ("orders", "pilot", "seed", "line"),
    [
        (
            ORDERS,
            PILOT,
            1,
            "20 rows by untraceable with seed 0, where 20 rows by untraceable with seed 1 belong",
        ),
        (ORDERS, Untraceable("other"), 0, "where 20 rows by other with seed 0 belong"),
        ([Order(Climb(), 1, 30)], PILOT, 0, "climb-000.mcap: 20 rows by .*, where 30 rows by .* belong"),
    ],
)
def test_what_does_not_belong_is_refused(book, orders, pilot, seed, line):
    before = stats(book)
    with pytest.raises(FledgeError, match=line):
        logbook.fill(book, orders, pilot, seed)
    assert stats(book) == before


def test_leftovers_of_the_killed_are_swept_away(book):
    (book / ".climb-001.mcap.01234567.partial").write_bytes(b"half a flight")
    logbook.fill(book, ORDERS, PILOT, 0)
    assert sorted(stats(book)) == NAMES


def test_reading_takes_whoever_flew(book):
    logbook.fill(book / "other", ORDERS[1:], Untraceable("other"), 5)
    (book / "other" / "climb-000.mcap").rename(book / "climb-other.mcap")
    assert {flight.pilot for flight in logbook.read(book)} == {"untraceable", "other"}
    with pytest.raises(BadFile, match="there are no flights"):
        logbook.read(book / "other")
    with pytest.raises(BadFile, match="there is no such folder"):
        logbook.read(book / "nowhere")
