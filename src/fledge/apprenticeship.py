"""An apprenticeship on disk: from a logbook to a policy's file, through checkpoints that survive being killed.

Beside the policy to be stands `NAME.checkpoint.npz` until it is done. A checkpoint says which data, recipe and
seed it belongs to, and no other training goes on from it. Interrupted and resumed, a training ends in the same bytes.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from fledge import console, training
from fledge.episode import Flight
from fledge.errors import BadDemonstrations, BadFile
from fledge.experiments import by_sub_task, composite_set
from fledge.fusion import CompositeSet
from fledge.policy import Contract
from fledge.recipe import Recipe
from fledge.setups import Setup
from fledge.storage import read_checkpoint, sweep, write_checkpoint, write_policy
from fledge.training import LossCurve


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
    def of(cls, flights: Sequence[Flight], setup: Setup, recipe: Recipe, seed: int) -> "Lesson":
        """Fuse what was flown as a set-up says (Algorithm 1).

        Raises:
            BadDemonstrations: a manoeuvre is missing, or the flights saw through different eyes.
        """
        assert setup.trained_on
        demonstrations = by_sub_task(flights, setup.trained_on)
        composite, delay = composite_set(setup.trained_on, setup.method, demonstrations)
        return cls(composite, delay, _contract(flights), recipe, seed)

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
    checkpoint = path.with_name(f"{path.name}.checkpoint.npz")
    _make_room(path, checkpoint, resume)
    state = start = _resumed(lesson, checkpoint) if resume else None
    with console.progress() as bar:
        bar.update("training", start.epoch if start else 0, lesson.recipe.epochs)
        for state in training.train(lesson.composite, lesson.recipe, lesson.keys, start):
            write_checkpoint(checkpoint, training.arrays(state), lesson.settings)
            bar.update("training", state.epoch, lesson.recipe.epochs)
    assert state is not None
    many = training.policies(lesson.composite, lesson.recipe, state, lesson.contract)
    write_policy(path, training.member(many, 0))
    checkpoint.unlink(missing_ok=True)
    return training.member_curve(state.curve, 0)


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
