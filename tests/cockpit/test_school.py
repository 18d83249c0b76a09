"""A training in a process of its own: the network that `fledge train` makes, told point by point, ended on demand."""

import time

import pytest

from fledge.cockpit.school import School, Subject
from fledge.errors import FledgeError
from fledge.learning.demonstrations import Order
from fledge.lookup import setup
from fledge.manoeuvres import MANOEUVRES
from fledge.pilots import HumanModel
from fledge.runs import apprenticeship, logbook


@pytest.fixture(scope="module")
def demos(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demos")
    logbook.fill(folder, [Order(one, 2, 240) for one in MANOEUVRES], HumanModel(), 0)
    return folder


def ended(school, within=120.0):
    end = time.monotonic() + within
    while school.lesson.state == "running":
        assert time.monotonic() < end
        time.sleep(0.05)
    return school.lesson


@pytest.mark.slow
def test_it_makes_the_network_that_the_command_makes(demos, tmp_path):
    told = []
    school = School(told.append)
    school.teach(Subject(demos, "primitive", tmp_path / "a.onnx", 3, False))
    with pytest.raises(FledgeError, match="trained already"):
        school.teach(Subject(demos, "primitive", tmp_path / "b.onnx", 3, False))
    lesson = ended(school)
    assert (lesson.state, lesson.policy, lesson.epoch, lesson.epochs) == (
        "done",
        str(tmp_path / "a.onnx"),
        3,
        3,
    )
    recipe = apprenticeship.recipe("fast", 3)
    same = apprenticeship.Lesson.of(logbook.read(demos), setup("primitive"), recipe, 0)
    curve = apprenticeship.learn(same, tmp_path / "c.onnx")
    assert (tmp_path / "a.onnx").read_bytes() == (tmp_path / "c.onnx").read_bytes()
    assert [point[0] for point in lesson.points] == curve.epochs.tolist()
    assert tuple(point for one in told for point in one.points) == lesson.points
    assert told[0].state == "running" and told[-1].state == "done"


@pytest.mark.slow
def test_what_is_cancelled_leaves_nothing_and_the_next_begins_anew(demos, tmp_path):
    school = School(lambda lesson: None)
    school.cancel()
    school.teach(Subject(demos, "primitive", tmp_path / "a.onnx", 100_000, False))
    end = time.monotonic() + 120.0
    while not school.lesson.points:
        assert time.monotonic() < end
        time.sleep(0.05)
    school.cancel()
    assert ended(school).state == "cancelled" and list(tmp_path.iterdir()) == []
    school.teach(Subject(tmp_path / "nowhere", "primitive", tmp_path / "a.onnx", 1, False))
    lesson = ended(school)
    assert lesson.state == "failed" and "nowhere" in lesson.problem and lesson.points == ()
