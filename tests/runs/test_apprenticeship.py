"""A training ends in the same bytes however often it was interrupted, and goes on from its own checkpoint only."""

from dataclasses import replace

import pytest

from fledge import lookup
from fledge.engines import fly_plain
from fledge.episode import Flight
from fledge.errors import BadDemonstrations, BadFile
from fledge.learning import training
from fledge.learning.policy import Contract
from fledge.learning.recipe import Recipe
from fledge.manoeuvres import Climb, Descend, FixedAltitude
from fledge.observation import Axes
from fledge.pilots import Servo
from fledge.runs import apprenticeship
from fledge.runs.apprenticeship import Lesson, learn
from fledge.simulation import Case, Crew
from fledge.storage import read_policy

pytestmark = pytest.mark.slow

EPOCHS = 4
CHECKPOINT = "policy.onnx.checkpoint.npz"


def flown(manoeuvre, number):
    key = (number, 1)
    case = Case.draw(manoeuvre, key, rows=40)
    episode = fly_plain(case, Crew(Servo(), Axes.of(manoeuvre.axes)), key)
    return Flight(episode, manoeuvre.name, "servo", "none", 0, number, manoeuvre.axes, case.plan.arena)


@pytest.fixture(scope="module")
def flights():
    return [
        flown(manoeuvre, number) for manoeuvre in (FixedAltitude(), Climb(), Descend()) for number in range(2)
    ]


@pytest.fixture(scope="module")
def lesson(flights):
    return Lesson.of(flights, lookup.setup("primitive"), Recipe.fast(EPOCHS), seed=3)


@pytest.fixture(scope="module")
def policy(lesson, tmp_path_factory):
    """The file of an uninterrupted training."""
    path = tmp_path_factory.mktemp("whole") / "policy.onnx"
    learn(lesson, path)
    return path


class Killed(BaseException):
    pass


def interrupt(lesson, path, checkpoints):
    """Train until so many checkpoints were written."""

    def write(*arguments):
        real(*arguments)
        written.append(1)
        if len(written) == checkpoints:
            raise Killed

    written, real = [], apprenticeship.write_checkpoint
    with pytest.MonkeyPatch.context() as patch, pytest.raises(Killed):
        patch.setattr(apprenticeship, "write_checkpoint", write)
        learn(lesson, path)


@pytest.fixture(scope="module")
def midway(lesson, tmp_path_factory):
    """The content of a checkpoint."""
    folder = tmp_path_factory.mktemp("midway")
    interrupt(lesson, folder / "policy.onnx", checkpoints=2)
    return (folder / CHECKPOINT).read_bytes()


@pytest.fixture
def path(midway, tmp_path):
    """Of a policy whose training was interrupted."""
    (tmp_path / CHECKPOINT).write_bytes(midway)
    return tmp_path / "policy.onnx"


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_what_is_left_is_a_policy_and_its_losses(lesson, policy):
    assert names(policy.parent) == ["policy.onnx"]
    stored = read_policy(policy)
    assert stored.contract == Contract(data=lesson.composite.digest())
    assert len(learn(lesson, policy).epochs) == EPOCHS


def test_the_recipes_have_names():
    assert apprenticeship.recipe("fast") == Recipe.fast()
    assert apprenticeship.recipe("paper") == Recipe.paper()
    assert apprenticeship.recipe("paper", 7).epochs == apprenticeship.recipe("fast", 7).epochs == 7


@pytest.mark.parametrize("checkpoints", [1, EPOCHS])
def test_interrupted_and_resumed_it_ends_in_the_same_bytes(lesson, policy, tmp_path, checkpoints):
    path = tmp_path / "policy.onnx"
    interrupt(lesson, path, checkpoints)
    assert names(tmp_path) == [CHECKPOINT]
    curve = learn(lesson, path, resume=True)
    assert names(tmp_path) == ["policy.onnx"]
    assert path.read_bytes() == policy.read_bytes()
    assert curve.epochs.tolist() == list(range(1, EPOCHS + 1))


def test_a_checkpoint_is_never_written_over_by_accident(lesson, path, midway):
    with pytest.raises(BadFile, match="left by an interrupted training: go on with --resume, or remove it"):
        learn(lesson, path)
    assert (path.parent / CHECKPOINT).read_bytes() == midway


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"seed": 4}, "seed"),
        ({"recipe": Recipe.fast(EPOCHS + 1)}, "recipe"),
        ({"recipe": Recipe.paper(EPOCHS), "seed": 4}, "recipe, seed"),
        ({"composite": None}, "data"),
    ],
)
def test_another_training_does_not_go_on_from_it(lesson, flights, path, midway, change, what):
    if "composite" in change:
        other = Lesson.of(flights[::-1], lookup.setup("primitive"), lesson.recipe, 3)
        change = {"composite": other.composite}
    with pytest.raises(BadFile, match=f"left by a training with other {what}: valid are the same"):
        learn(replace(lesson, **change), path, resume=True)
    assert (path.parent / CHECKPOINT).read_bytes() == midway


@pytest.mark.parametrize("length", [0, 7, 1000])
def test_a_damaged_checkpoint_is_refused(lesson, path, midway, length):
    (path.parent / CHECKPOINT).write_bytes(midway[:length])
    with pytest.raises(BadFile, match="checkpoint.npz: "):
        learn(lesson, path, resume=True)


def test_without_a_checkpoint_it_begins_anew_and_says_so(lesson, policy, tmp_path, capsys):
    learn(lesson, tmp_path / "policy.onnx", resume=True)
    assert "training starts from the beginning" in capsys.readouterr().err
    assert (tmp_path / "policy.onnx").read_bytes() == policy.read_bytes()


def test_a_place_that_cannot_hold_a_policy_is_refused_before_training(lesson, tmp_path, monkeypatch):
    monkeypatch.setattr(training, "train", lambda *_: pytest.fail("trained"))
    with pytest.raises(BadFile, match="a folder: valid is a file's name"):
        learn(lesson, tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError):
        learn(lesson, tmp_path / "file" / "policy.onnx")


def test_the_set_up_decides_what_is_learnt(flights):
    zero = Lesson.of(flights, lookup.setup("primitive-paper"), Recipe.fast(), 0)
    mask = Lesson.of(flights, lookup.setup("primitive"), Recipe.fast(), 0)
    assert zero.composite.mask.all() and not mask.composite.mask.all()
    with pytest.raises(
        BadDemonstrations, match="no demonstrations of combined; found climb, descend, fixed-altitude"
    ):
        Lesson.of(flights, lookup.setup("dnn-combined"), Recipe.fast(), 0)


def test_flights_through_different_eyes_do_not_mix(flights):
    odd = [replace(flight, ideal_radius=90.0) for flight in flights]
    assert Lesson.of(odd, lookup.setup("primitive"), Recipe.fast(), 0).contract.ideal_radius == 90.0
    with pytest.raises(BadDemonstrations, match="flights of different lens, ideal radius or sticks"):
        Lesson.of([*odd[:1], *flights[1:]], lookup.setup("primitive"), Recipe.fast(), 0)
