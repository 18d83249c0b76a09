"""What is on offer, and what is told of what lies on disk."""

import shutil
import time

import pytest

from fledge.cockpit import stock as module
from fledge.cockpit.asks import Fly, Train
from fledge.cockpit.flight import Live
from fledge.cockpit.messages import encode
from fledge.cockpit.stock import Stock
from fledge.cockpit.tells import Harvest, Notice, Stored
from fledge.errors import BadFile, FledgeError, UnknownName
from fledge.learning.demonstrations import PAPER_ORDERS
from fledge.manoeuvres import Climb
from fledge.pilots import HumanModel
from fledge.runs import logbook

pytestmark = pytest.mark.slow


@pytest.fixture
def told():
    return []


@pytest.fixture
def stock(tmp_path, told):
    made = Stock(tmp_path / "demos", tmp_path / "policies", lambda client, one: told.append(one))
    yield made
    made.close()


def until(told, kind):
    end = time.monotonic() + 60.0
    while not any(isinstance(one, kind) for one in told):
        assert time.monotonic() < end, told
        time.sleep(0.02)
    return next(one for one in told if isinstance(one, kind))


@pytest.fixture(scope="module")
def demonstrated(tmp_path_factory):
    """The synthetic operator's first climb, as the paper has it."""
    folder = tmp_path_factory.mktemp("logbook")
    logbook.fill(
        folder, [order for order in PAPER_ORDERS if order.manoeuvre.name == "climb"], HumanModel(), 0
    )
    return folder / "climb-000.mcap"


def test_all_that_is_told_can_be_said(stock):
    for one in (stock.welcome(), stock.harvest(), stock.flight("none", None, None), stock.school.lesson):
        assert encode(one)


def test_goals_are_the_papers(stock):
    assert {task.name: task.goal for task in stock.welcome().tasks} == {
        order.manoeuvre.name: order.rows for order in PAPER_ORDERS
    }


def test_what_is_on_offer_can_be_flown_and_nothing_else(stock):
    welcome = stock.welcome()
    for pilot in welcome.pilots:
        assert isinstance(stock.scene(Fly("climb", pilot, "stop-tube")), Live)
    for net in welcome.nets:
        assert stock.scene(Fly("climb", "person", net)).about.net == net
    for task in welcome.tasks:
        assert stock.scene(Fly(task.name, "person", "none")).about.axes == task.axes
    for wrong in (
        Fly("climb", "fledge.pilots:Servo", "none"),
        Fly("climb", "person", "fledge.safety:NoNet"),
        Fly("fledge.manoeuvres:Climb", "person", "none"),
        Fly("climb", "person", "none", world="attached"),
    ):
        with pytest.raises(UnknownName, match="valid"):
            stock.scene(wrong)


def test_a_policy_that_is_none_is_refused_when_it_is_chosen(stock, tmp_path):
    path = tmp_path / "policies" / "broken.onnx"
    path.write_bytes(b"nothing")
    assert str(path) in stock.welcome().pilots
    with pytest.raises(BadFile, match="broken.onnx"):
        stock.scene(Fly("climb", str(path), "none"))


def test_each_demonstration_is_the_next_flight_of_the_synthetic_operator(stock, tmp_path, demonstrated):
    fly = Fly("climb", "person", "stop-tube", record="demonstration")
    lengths = [*next(order for order in PAPER_ORDERS if order.manoeuvre.name == "climb").lengths()]
    first = stock.scene(fly)
    assert isinstance(first, Live) and (first.about.case, len(first.targets)) == (0, lengths[0])
    shutil.copy(demonstrated, tmp_path / "demos" / "climb-000.mcap")
    second = stock.scene(fly)
    assert isinstance(second, Live) and (second.about.case, len(second.targets)) == (1, lengths[1])


def test_a_demonstration_is_marked_beside_the_synthetic_operator_of_the_same_scene(
    stock, tmp_path, told, demonstrated
):
    path = tmp_path / "demos" / "climb-000.mcap"
    shutil.copy(demonstrated, path)
    stock.stored(path)
    stored, harvest = until(told, Stored), until(told, Harvest)
    # It is that very operator, flown once more; compiled before, in plain Python now.
    assert stored.synthetic.in_view == stored.marks.in_view == 1.0
    assert stored.synthetic.radius == pytest.approx(stored.marks.radius, rel=0.01)
    assert {heap.manoeuvre: (heap.flights, heap.rows) for heap in harvest.heaps}["climb"] == (1, stored.rows)


def test_a_flight_of_others_is_no_demonstration(stock, tmp_path, told, demonstrated):
    path = tmp_path / "demos" / "flights" / "climb-000.mcap"
    shutil.copy(demonstrated, path)
    stock.stored(path)
    assert until(told, Stored).synthetic is None
    assert all(heap.flights == 0 for heap in until(told, Harvest).heaps)


def test_a_flight_that_is_gone_is_said_in_a_line(stock, tmp_path, told):
    stock.stored(tmp_path / "demos" / "climb-007.mcap")
    assert "climb-007" in until(told, Notice).text


def test_who_may_record_what(stock):
    about = stock.scene(Fly("climb", "person", "none")).about
    assert stock.tape(Fly("climb", "person", "none"), about) is None
    for wrong in (
        Fly("climb", "servo", "none", record="demonstration"),
        Fly("climb", "person", "none", record="demonstration", world="twin"),
    ):
        with pytest.raises(FledgeError, match="flown by a person"):
            stock.tape(wrong, about)


def test_what_cannot_be_trained_is_refused(stock):
    with pytest.raises(UnknownName, match="primitive"):
        stock.teach(Train("alchemy"))


def test_a_folder_that_cannot_be_is_said(tmp_path):
    (tmp_path / "demos").write_text("a file")
    with pytest.raises(BadFile, match="demos"):
        Stock(tmp_path / "demos", tmp_path / "policies", lambda client, told: None)


def test_lengths_go_on_like_the_last():
    lengths = [*next(order for order in PAPER_ORDERS if order.manoeuvre == Climb()).lengths()]
    assert [module._length("climb", number) for number in range(12)] == [*lengths, lengths[-1], lengths[-1]]
