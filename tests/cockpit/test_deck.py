"""The deck in this process: who gives orders, what becomes of them, and what pages are told."""

import time

import pytest

from fledge.cockpit.asks import Cancel, Discard, Fly, Keep, Pause, Reset, Resume, Seat, Sticks
from fledge.cockpit.deck import PERSON_ONLY, UNSAVED, Deck
from fledge.cockpit.flight import Live
from fledge.cockpit.messages import encode
from fledge.cockpit.stock import Stock
from fledge.cockpit.tape import recover
from fledge.cockpit.tells import Flight, Frame, Notice, Seating, Stored

pytestmark = pytest.mark.slow

ONE, TWO = 1, 2
SERVO = Fly("fixed-altitude", "servo", "stop-tube")
CLIMB = Fly("climb", "person", "stop-tube", record="demonstration")


class Bridge:
    """A deck, two clients, and what each was told."""

    def __init__(self, folder):
        self.told = {ONE: [], TWO: []}
        self.folder, self.sequence = folder, 0
        self.stock = Stock(folder / "demos", folder / "policies", self.post)
        self.deck = Deck(self.stock, self.post)

    def __enter__(self):
        self.deck.start()
        self.deck.join(ONE)
        self.deck.hear(ONE, Seat(True))
        return self

    def __exit__(self, *_):
        self.deck.stop()
        self.stock.close()

    def post(self, client, told):
        for one in self.told if client is None else [client]:
            self.told[one].append(told)

    def last(self, kind, client=ONE):
        return next((one for one in reversed(self.told[client]) if isinstance(one, kind)), None)

    def until(self, condition, within=20.0, **flags):
        """Say sticks that are at rest until something is so."""
        end = time.monotonic() + within
        while not condition():
            assert time.monotonic() < end, self.told[ONE][-3:]
            self.sequence += 1
            now = time.monotonic() * 1e3
            self.deck.hear(ONE, Sticks(self.sequence, now, 0, (0.0, 0.0, 0.0, 0.0), **flags))
            time.sleep(0.01)

    def flies(self, fly):
        """Until it is armed and flown."""
        self.deck.hear(ONE, fly)
        self.until(lambda: self.mode == "READY")
        self.until(lambda: self.mode == "AUTO", arm=True)

    @property
    def mode(self):
        frame = self.last(Frame)
        return frame and frame.vehicles[0].mode

    @property
    def state(self):
        flight = self.last(Flight)
        return flight and flight.state


@pytest.fixture
def bridge(tmp_path):
    with Bridge(tmp_path) as made:
        yield made


def test_whoever_joins_is_told_what_is_flown_and_who_sits_where(bridge):
    bridge.until(lambda: bridge.last(Seating) == Seating("mine", 0))
    bridge.deck.join(TWO)
    bridge.until(lambda: bridge.last(Seating, TWO) == Seating("taken", 1))
    assert bridge.last(Flight, TWO).state == "none"
    bridge.deck.leave(TWO)
    bridge.until(lambda: bridge.last(Seating) == Seating("mine", 0))


def test_orders_are_the_holders(bridge):
    bridge.deck.join(TWO)
    for order in (SERVO, Pause(), Keep(), Cancel()):
        bridge.deck.hear(TWO, order)
    bridge.until(lambda: sum(isinstance(one, Notice) for one in bridge.told[TWO]) == 4)
    assert bridge.last(Notice, TWO).text == PERSON_ONLY and bridge.state == "none"


def test_without_a_flight_there_is_nothing_to_pause(bridge):
    bridge.deck.hear(ONE, Pause())
    bridge.until(lambda: bridge.last(Notice))
    assert "start a flight first" in bridge.last(Notice).text


def test_two_flights_are_not_prepared_at_once_and_a_wrong_one_is_said(bridge):
    bridge.deck.hear(ONE, SERVO)
    bridge.deck.hear(ONE, SERVO)
    bridge.until(lambda: bridge.last(Notice))
    assert "wait for it" in bridge.last(Notice).text
    bridge.until(lambda: bridge.state == "running")
    bridge.deck.hear(ONE, Fly("climb", "nobody", "stop-tube"))
    bridge.until(lambda: "pilot 'nobody'" in bridge.last(Notice).text)


def test_a_flight_from_begin_to_keep(bridge):
    bridge.flies(CLIMB)
    bridge.until(lambda: bridge.last(Frame).rows > 10, arm=True)
    frame = bridge.last(Frame)
    assert encode(frame) and frame.answer > 0.0 and frame.silent < 0.4 and frame.sequence > 0
    assert frame.vehicles[0].stop and frame.vehicles[0].commander == "person"
    bridge.deck.hear(ONE, Pause())
    bridge.until(lambda: bridge.state == "paused")
    time.sleep(0.1)  # until the last tick is shown, too
    t = bridge.last(Frame).t
    bridge.deck.hear(ONE, Fly("descend", "person", "stop-tube"))
    bridge.until(lambda: bridge.last(Notice))
    assert bridge.last(Notice).text == UNSAVED and bridge.last(Frame).t == t
    bridge.deck.hear(ONE, Resume())
    bridge.until(lambda: bridge.last(Frame).t > t, arm=True)
    bridge.deck.hear(ONE, Keep())
    bridge.until(lambda: bridge.last(Stored))
    assert bridge.state == "over" and bridge.last(Stored).name == "climb-000"
    bridge.deck.hear(ONE, Keep())
    bridge.until(lambda: "nothing was recorded" in bridge.last(Notice).text)
    found = bridge.deck.summary()
    assert found["ticks"] > 50 and found["answer_ms"]["count"] > 10 and found["dropped"]["late"] == 0


def test_a_manoeuvre_that_is_over_waits_for_a_word(bridge):
    bridge.flies(Fly("climb", "servo", "none", speed=4.0, record="flight"))
    bridge.until(lambda: bridge.last(Frame).over, arm=True, within=60.0)
    assert bridge.state == "over"
    bridge.deck.hear(ONE, Discard())
    time.sleep(0.1)
    assert [*(bridge.folder / "demos" / "flights").iterdir()] == []


def test_a_reset_throws_away_and_begins_anew(bridge):
    bridge.flies(CLIMB)
    bridge.until(lambda: bridge.last(Frame).rows > 3, arm=True)
    bridge.deck.hear(ONE, Reset())
    tapes = lambda: [*(bridge.folder / "demos").glob(".*.tape")]  # noqa: E731
    bridge.until(lambda: bridge.last(Frame).rows == 0 and bridge.state == "running" and len(tapes()) == 1)


def test_what_is_being_recorded_when_the_deck_ends_is_recovered(tmp_path):
    with Bridge(tmp_path) as bridge:
        bridge.flies(CLIMB)
        bridge.until(lambda: bridge.last(Frame).rows > 3, arm=True)
    assert [path.name for path in recover(tmp_path / "demos")] == ["climb-000.mcap"]


def test_a_seat_given_up_is_free(bridge):
    bridge.until(lambda: bridge.last(Seating))
    bridge.deck.hear(ONE, Seat(False))
    bridge.until(lambda: bridge.last(Seating).seat == "free")


def test_a_fault_of_ours_ends_the_flight_and_is_said(bridge, monkeypatch, caplog):
    bridge.flies(SERVO)

    def broken(*_):
        raise RuntimeError("a bug")

    monkeypatch.setattr(Live, "tick", broken)
    bridge.until(lambda: bridge.state == "over", arm=True)
    assert "a bug" in bridge.last(Notice).text
    monkeypatch.undo()
    bridge.flies(SERVO)
    monkeypatch.setattr(Live, "draw", broken)
    bridge.deck.hear(ONE, SERVO)
    bridge.until(lambda: "cannot be flown" in bridge.last(Notice).text)
