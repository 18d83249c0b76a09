"""An apprenticeship on disk: from a logbook to a policy's file, through checkpoints that survive being killed.

Beside the policy to be stands `NAME.checkpoint.npz` until it is done. A checkpoint says which data, recipe and
seed it belongs to, and no other training goes on from it. Interrupted and resumed, a training ends in the same bytes.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from fledge import console
from fledge.episode import Flight
from fledge.errors import BadDemonstrations, BadFile
from fledge.learning import training
from fledge.learning.fusion import CompositeSet
from fledge.learning.policy import Contract
from fledge.learning.recipe import Recipe
from fledge.learning.takeovers import corrections
from fledge.learning.training import LossCurve
from fledge.storage import read_checkpoint, sweep, write_checkpoint, write_policy
from fledge.study.experiments import by_sub_task, composite_set
from fledge.study.setups import Setup


@dataclass(frozen=True, slots=True)
class Lesson:
    """What is learnt, how, and from which initial weights."""

    composite: CompositeSet
    delay: int
    """By which actions lag what they answer [rows]."""
    contract: Contract
    recipe: Recipe
    seed: int

    @classmethod
    def of(
        cls,
        flights: Sequence[Flight],
        setup: Setup,
        recipe: Recipe,
        seed: int,
        taken_over: Sequence[Flight] = (),
    ) -> "Lesson":
        """Fuse what was flown as a set-up says (Algorithm 1), and what people did in flights that they took over.

        Raises:
            BadDemonstrations: a manoeuvre is missing, or the flights saw through different eyes.
        """
        assert setup.trained_on
        demonstrations = by_sub_task(flights, setup.trained_on)
        further = corrections(taken_over)
        if taken_over and not further:
            raise BadDemonstrations(f"nobody took over for a second or longer in {len(taken_over)} flights")
        composite, delay = composite_set(setup.trained_on, setup.method, demonstrations, further)
        return cls(composite, delay, _contract([*flights, *taken_over]), recipe, seed)

    @property
    def settings(self) -> dict[str, Any]:
        """By which a checkpoint knows its lesson."""
        return {"data": self.composite.digest(), "recipe": asdict(self.recipe), "seed": self.seed}

    @property
    def keys(self) -> list[int]:
        """Of the one network that is trained; the same as a study's first."""
        return [1000 * self.seed]


def recipe(name: Literal["fast", "paper"], epochs: int | None = None) -> Recipe:
    """A recipe by its name, with its own number of epochs or another."""
    kind = {"fast": Recipe.fast, "paper": Recipe.paper}[name]
    return kind() if epochs is None else kind(epochs)


def learn(lesson: Lesson, path: Path, resume: bool = False) -> LossCurve:
    """Train, and store the policy under `path`.

    Raises:
        BadFile: a file cannot be written; or there is a checkpoint of another training, or of one to resume.
    """
    curve = None
    with console.progress() as bar:
        for curve in steps(lesson, path, resume):
            bar.update("training", int(curve.epochs[-1]), lesson.recipe.epochs)
    assert curve is not None
    return curve


def steps(lesson: Lesson, path: Path, resume: bool = False) -> Iterator[LossCurve]:
    """The curve so far, checkpoint by checkpoint; once all are over, the policy is stored.

    Raises:
        BadFile: as `learn`.
    """
    checkpoint = path.with_name(f"{path.name}.checkpoint.npz")
    _make_room(path, checkpoint, resume)
    state = start = _resumed(lesson, checkpoint) if resume else None
    if start is not None:
        yield training.member_curve(start.curve, 0)
    for state in training.train(lesson.composite, lesson.recipe, lesson.keys, start):
        write_checkpoint(checkpoint, training.arrays(state), lesson.settings)
        yield training.member_curve(state.curve, 0)
    assert state is not None
    many = training.policies(lesson.composite, lesson.recipe, state, lesson.contract)
    write_policy(path, training.member(many, 0))
    checkpoint.unlink(missing_ok=True)


def _make_room(path: Path, checkpoint: Path, resume: bool) -> None:
    if path.is_dir():
        raise BadFile(path, "a folder: valid is a file's name")
    if checkpoint.exists() and not resume:
        raise BadFile(checkpoint, "left by an interrupted training: go on with --resume, or remove it")
    path.parent.mkdir(parents=True, exist_ok=True)
    sweep(path.parent)


def _resumed(lesson: Lesson, checkpoint: Path) -> training.Checkpoint | None:
    if not checkpoint.exists():
        console.note(f"no checkpoint {checkpoint}: training starts from the beginning")
        return None
    arrays, settings = read_checkpoint(checkpoint)
    other = [name for name, value in lesson.settings.items() if settings.get(name) != value]
    if other:
        raise BadFile(
            checkpoint,
            f"left by a training with other {', '.join(other)}: valid are the same; or remove it to begin anew",
        )
    return training.restore(lesson.composite, lesson.recipe, lesson.keys, arrays)


def _contract(flights: Sequence[Flight]) -> Contract:
    """The eyes and hands with which all of them flew."""
    found = {Contract(lens=f.lens, ideal_radius=f.ideal_radius, sticks=f.sticks) for f in flights}
    if len(found) > 1:
        raise BadDemonstrations("flights of different lens, ideal radius or sticks: valid are alike")
    return found.pop()
