"""The set-ups as data: who flies, what each learnt from and how, on which flights it is tested.

A `Setup` is one row of the paper's table; a `Study` says how many seeds and cases. Everything a result depends on is
declared here, before any result (D10): tests are Combined flights of 60 s along the two path families that no
demonstration used, and the three sub-tasks likewise; the default method was chosen on `DEVELOPMENT` flights, Combined,
too, but along families of their own.
"""

from dataclasses import dataclass, field, replace
from typing import Any, Literal

from fledge.errors import OutOfRange
from fledge.learning.demonstrations import PAPER_ORDERS
from fledge.learning.fusion import Fill, SubTask
from fledge.learning.recipe import Recipe
from fledge.manoeuvres import Climb, Combined, Descend, FixedAltitude
from fledge.manoeuvres.paths import DEVELOPMENT_FAMILIES, HELD_OUT_FAMILIES
from fledge.observation import OBSERVATION_NAMES, VELOCITY_INPUTS
from fledge.pilots import AbstractPilot, HumanModel, Servo

FLIGHT_ROWS = 1200
"""60 s (D10)."""
TEST_MANOEUVRES = (
    Combined(families=HELD_OUT_FAMILIES),
    FixedAltitude(families=HELD_OUT_FAMILIES),
    Climb(),
    Descend(),
)
DEVELOPMENT = Combined(families=DEVELOPMENT_FAMILIES)
FLYING_AXES = (0, 1, 2)
"""Forward, left, up: everyone's in evaluation."""
SUB_TASKS = (
    SubTask("fixed-altitude", FixedAltitude.axes),
    SubTask("climb", Climb.axes),
    SubTask("descend", Descend.axes),
)
COMPOSITE_TASK = SubTask("combined", Combined.axes)
TASKS = {
    "sub-tasks": SUB_TASKS,
    "combined": (COMPOSITE_TASK,),
    "everything": (*SUB_TASKS, COMPOSITE_TASK),
}
YAW = (3,)
"""Never demonstrated, never needed (D1)."""

ALL_INPUTS = tuple(range(len(OBSERVATION_NAMES)))
NO_VELOCITY = tuple(i for i in ALL_INPUTS if i not in VELOCITY_INPUTS)


@dataclass(frozen=True, slots=True)
class Method:
    """The choices of `fuse`."""

    fill: Fill
    inputs: tuple[int, ...]
    delay: int | Literal["estimated"]


PAPER_METHOD = Method("zero", ALL_INPUTS, 0)
DEFAULT_METHOD = Method("mask", ALL_INPUTS, "estimated")
"""Chosen on development flights, from among `CANDIDATES`."""


@dataclass(frozen=True, slots=True)
class Setup:
    """One row of the table."""

    name: str
    title: str
    pilot: AbstractPilot | None = None
    """Who flies, where nothing is learnt."""
    trained_on: Literal["sub-tasks", "combined"] | None = None
    method: Method = PAPER_METHOD
    recipe: Recipe = field(default_factory=Recipe.fast)
    rows: int | None = None
    """Data-matched: learn from so many rows (D14)."""
    seeds: int | None = None
    """Training seeds, where not the study's."""


PRIMITIVE_ROWS = sum(order.rows for order in PAPER_ORDERS[:3])
COMBINED_ROWS = PAPER_ORDERS[3].rows

BASIC = (
    Setup("human-combined", "Synthetic operator on Combined", HumanModel()),
    Setup("dnn-combined", "Network trained on Combined", trained_on="combined"),
    Setup("primitive-paper", "ABS-DL, the paper's method", trained_on="sub-tasks"),
    Setup("primitive", "ABS-DL, the default method", trained_on="sub-tasks", method=DEFAULT_METHOD),
    Setup("servo", "Visual servo", Servo()),
    Setup(
        "human-combined-undivided",
        "Synthetic operator, attention not shared",
        HumanModel(share_attention=False),
    ),
)
FURTHER = (
    Setup(
        "primitive-zero",
        "ABS-DL, default but zero fill",
        trained_on="sub-tasks",
        method=replace(DEFAULT_METHOD, fill="zero"),
    ),
    Setup(
        "primitive-matched",
        "ABS-DL, default, on as many rows as Combined",
        trained_on="sub-tasks",
        method=DEFAULT_METHOD,
        rows=COMBINED_ROWS,
    ),
    Setup(
        "dnn-combined-matched",
        "Network trained on Combined, on as many rows as the sub-tasks",
        trained_on="combined",
        rows=PRIMITIVE_ROWS,
    ),
    Setup(
        "primitive-paper-10000",
        "ABS-DL, the paper's method and recipe",
        trained_on="sub-tasks",
        recipe=Recipe.paper(),
        seeds=1,
    ),
    Setup(
        "dnn-combined-10000",
        "Network trained on Combined, the paper's recipe",
        trained_on="combined",
        recipe=Recipe.paper(),
        seeds=1,
    ),
)


CANDIDATES = tuple(
    Setup(name, name, trained_on="sub-tasks", method=method, recipe=recipe, seeds=3)
    for name, method, recipe in (
        ("zero fill (the paper)", PAPER_METHOD, Recipe.fast()),
        ("zero fill, delay", replace(PAPER_METHOD, delay="estimated"), Recipe.fast()),
        ("mask", replace(DEFAULT_METHOD, delay=0), Recipe.fast()),
        ("mask, delay (the default)", DEFAULT_METHOD, Recipe.fast()),
        ("mask, delay, no velocities", replace(DEFAULT_METHOD, inputs=NO_VELOCITY), Recipe.fast()),
        ("mask, delay, He's initial weights", DEFAULT_METHOD, replace(Recipe.fast(), init="he")),
        ("mask, delay, lowest held-out loss", DEFAULT_METHOD, replace(Recipe.fast(), slack=0.0)),
    )
)
"""What the default was chosen from: fill, inputs, delay and optimiser, one change at a time."""


NETS = ("none", "paper", "stop-tube", "paper-repaired", "conformal", "barrier")
"""By their modules."""
BRIEFLY = ("none", "paper", "stop-tube", "barrier")
"""Those of a brief study: the paper's, the default, and the one that changes least."""


@dataclass(frozen=True, slots=True)
class Study:
    """How much of it to run."""

    mode: str
    setups: tuple[Setup, ...]
    cases: int
    """Combined test cases."""
    manoeuvre_cases: int
    """Test cases of each sub-task."""
    training_seeds: int
    development_cases: int = 0
    """For the table of methods; 0 leaves it out."""
    seed: int = 0
    rows: int = FLIGHT_ROWS
    """Of a test flight."""
    nets: tuple[str, ...] = NETS
    """Behind which the default policy flies."""
    net_cases: int = 0
    """Of the Combined test cases; 0 leaves the nets out."""
    lab_cases: int = 0
    """Flights in a room of the lab's size, behind each net."""
    operator_behind_nets: bool = False
    """Whether the operator flies behind the nets, too."""

    @classmethod
    def of(cls, mode: Literal["quick", "brief", "full"], seed: int = 0) -> "Study":
        """Under one minute, under six, or under thirty on two cores."""
        if seed < 0:
            raise OutOfRange("seed", seed, "0 or more")
        if mode == "full":
            behind_nets: dict[str, Any] = {"net_cases": 200, "lab_cases": 1000, "operator_behind_nets": True}
            return cls(mode, BASIC + FURTHER, 200, 50, 20, development_cases=100, seed=seed, **behind_nets)
        if mode == "brief":
            return cls(mode, BASIC, 200, 40, 8, seed=seed, nets=BRIEFLY, net_cases=40, lab_cases=40)
        return cls(mode, BASIC, 200, 20, 1, seed=seed)

    def seeds_of(self, setup: Setup) -> int:
        """How many networks a set-up trains."""
        return setup.seeds or self.training_seeds
