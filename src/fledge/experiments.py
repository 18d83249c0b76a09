"""The paper's study as data, and what it finds: section "Experiments", table by table.

A `Setup` says who flies and what that pilot learnt from; a `Study` says how many seeds and cases. `run` does the rest
as a stream of records: `Progress` while it works, one `Results` at the end. It touches no files.

**What is tested on** is declared here, before any result (D10): Combined flights of 60 s along the two path families
no demonstration used, with keys no demonstration used, the same for every set-up; and the three sub-tasks
likewise. **What the default method was chosen on** are `DEVELOPMENT` flights: Combined, too, but with keys and path
families of their own. No Combined demonstration reaches a set-up that learns from sub-tasks.
"""

import platform
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from importlib.metadata import version
from typing import Any, Literal

import numpy as np

from fledge import statistics
from fledge.crossover import BANDS, credibility
from fledge.demonstrations import PAPER_ORDERS, Demonstrations, Order, collect, of_flights
from fledge.episode import Episode, Flight
from fledge.errors import BadDemonstrations, OutOfRange
from fledge.evaluation import Score, evaluate
from fledge.fusion import CompositeSet, Fill, SubTask, estimate_delay, fuse
from fledge.manoeuvres import AbstractManoeuvre, Climb, Combined, Descend, FixedAltitude
from fledge.manoeuvres.paths import DEVELOPMENT_FAMILIES, HELD_OUT_FAMILIES, TRAINING_FAMILIES
from fledge.observation import OBSERVATION_NAMES, ROW_RATE, VELOCITY_INPUTS, Axes
from fledge.pilots import AbstractPilot, HumanModel, Servo
from fledge.policy import Contract, Policy
from fledge.simulation import Case, Crew, Rig, flight_key
from fledge.training import LossCurve, Recipe, member_curve, policies, train

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
    )
)
"""What the default was chosen from: fill, inputs, delay and optimiser, one change at a time."""


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

    @classmethod
    def of(cls, mode: Literal["quick", "brief", "full"], seed: int = 0) -> "Study":
        """Under a minute, a few minutes, or half an hour on two cores."""
        if seed < 0:
            raise OutOfRange("seed", seed, "0 or more")
        if mode == "full":
            return cls(mode, BASIC + FURTHER, 200, 50, 20, development_cases=100, seed=seed)
        return cls(mode, BASIC, 200, 40, {"quick": 1, "brief": 8}[mode], seed=seed)

    def seeds_of(self, setup: Setup) -> int:
        """How many networks a set-up trains."""
        return setup.seeds or self.training_seeds


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a study is."""

    stage: str
    done: int
    total: int


@dataclass(frozen=True, slots=True)
class SetupResult:
    """What one set-up did."""

    setup: Setup
    scores: dict[str, Score]
    """By manoeuvre; leaves (seeds, cases)."""
    sample: Flight
    """The first test case, flown by the first seed."""
    policy: Policy | None = None
    """All seeds' policies, stacked."""
    curve: LossCurve | None = None
    learning: dict[str, Any] | None = None


@dataclass(frozen=True, slots=True)
class Results:
    """A finished study."""

    study: Study
    setups: dict[str, SetupResult]
    summary: dict[str, Any]
    """All that goes into results.json, but the times."""


def run(study: Study, flights: Sequence[Flight], rig: Rig = Rig()) -> Iterator[Progress | Results]:
    """The whole study on stored demonstrations of the four manoeuvres.

    Raises:
        BadDemonstrations: a manoeuvre's flights are missing.
    """
    demos = by_sub_task(flights)
    total = len(study.setups) + 2 + bool(study.development_cases)
    cases, keys = test_cases(study)
    results: dict[str, SetupResult] = {}
    for done, setup in enumerate(study.setups):
        yield Progress(setup.name, done, total)
        learnt = None
        if setup.trained_on:
            for learnt in learn(setup, demos, study, rig):
                if isinstance(learnt, Progress):
                    yield learnt
        # The contract names the data: left in, every set-up would be compiled anew.
        pilot = replace(learnt.policy, contract=None) if isinstance(learnt, Learnt) else setup.pilot
        assert pilot is not None
        crew = Crew(pilot.for_axes(FLYING_AXES), Axes.of(FLYING_AXES))
        scores, first = evaluate(cases, crew, keys, rig, team=setup.trained_on is not None)
        results[setup.name] = _result(setup, study, scores, _sample(study, setup, first, cases[0], rig), learnt)
    yield Progress("operator", len(study.setups), total)
    operator = [asdict(axis) | {"inside": axis.inside} for axis in credibility(HumanModel(), study.seed, rig=rig)]
    development = None
    if study.development_cases:
        yield Progress("development", total - 2, total)
        development = list(choose(study, demos, rig))
    yield Progress("statistics", total - 1, total)
    yield Results(study, results, summarise(study, results, operator, development, demos, rig))


def by_sub_task(flights: Sequence[Flight], trained_on: str = "everything") -> dict[str, Demonstrations]:
    """Demonstrations of each manoeuvre that is there, if those of "sub-tasks", "combined" or everything are.

    Raises:
        BadDemonstrations: names the manoeuvres that are missing.
    """
    found = {flight.manoeuvre for flight in flights}
    needed = {task.name for task in TASKS[trained_on]}
    if needed - found:
        raise BadDemonstrations(
            f"no demonstrations of {', '.join(sorted(needed - found))}; "
            f"found {', '.join(sorted(found)) or 'none'}"
        )
    return {
        name: of_flights([flight for flight in flights if flight.manoeuvre == name])
        for name in sorted(found)
    }


def test_cases(study: Study) -> tuple[list[Case], list[tuple[int, ...]]]:
    """(cases, keys): Combined first, then the sub-tasks in the order of `TEST_MANOEUVRES`."""
    cases, keys = [], []
    for manoeuvre in TEST_MANOEUVRES:
        for number in range(_count(study, manoeuvre)):
            key = flight_key(study.seed, "test", manoeuvre.name, number)
            cases.append(Case.draw(manoeuvre, key, FLIGHT_ROWS))
            keys.append((*key, 1))
    return cases, keys


def _count(study: Study, manoeuvre: AbstractManoeuvre) -> int:
    return study.cases if manoeuvre.name == "combined" else study.manoeuvre_cases


def composite_set(
    trained_on: str, method: Method, demos: Mapping[str, Demonstrations]
) -> tuple[CompositeSet, int]:
    """(the composite set, the delay in rows): what a set-up learns from."""
    chosen = {task: demos[task.name] for task in TASKS[trained_on]}
    delay = estimate_delay(chosen) if method.delay == "estimated" else method.delay
    return fuse(chosen, 4, method.fill, method.inputs, delay, unused=YAW), delay


@dataclass(frozen=True, slots=True)
class Learnt:
    """What training left."""

    policy: Policy
    curve: LossCurve
    learning: dict[str, Any]


def learn(
    setup: Setup, demos: Mapping[str, Demonstrations], study: Study, rig: Rig
) -> Iterator[Progress | Learnt]:
    """Train all of a set-up's seeds at once."""
    assert setup.trained_on
    if setup.trained_on == "combined" and (setup.rows or 0) > demos["combined"].rows:
        demos = {**demos, "combined": _more_combined(setup.rows or 0, study, rig)}
    composite, delay = composite_set(setup.trained_on, setup.method, demos)
    if setup.rows:
        composite = composite.take(setup.rows)
    keys = [1000 * study.seed + i for i in range(study.seeds_of(setup))]
    state = None
    for state in train(composite, setup.recipe, keys):
        yield Progress(f"{setup.name}: training", state.epoch, setup.recipe.epochs)
    assert state is not None
    contract = Contract(lens=rig.lens, ideal_radius=rig.ideal_radius, sticks=rig.sticks)
    yield Learnt(
        policies(composite, setup.recipe, state, contract),
        state.curve,
        {
            "fill": setup.method.fill,
            "inputs": [OBSERVATION_NAMES[i] for i in setup.method.inputs],
            "delay_rows": delay,
            "rows": len(composite.states),
            "recipe": "paper" if setup.recipe.batch is None else "fast",
        },
    )


def _more_combined(rows: int, study: Study, rig: Rig) -> Demonstrations:
    """Further Combined demonstrations by the same operator, for a data-matched set-up."""
    episodes = round(rows / (COMBINED_ROWS / PAPER_ORDERS[3].episodes))
    return of_flights(list(collect([Order(Combined(), episodes, rows)], HumanModel(), study.seed, rig)))


def _sample(study: Study, setup: Setup, first: Episode, case: Case, rig: Rig) -> Flight:
    return Flight(
        episode=first,
        manoeuvre="combined",
        pilot=setup.name,
        net="none",
        seed=study.seed,
        case=0,
        axes=FLYING_AXES,
        arena=case.plan.arena,
        lens=rig.lens,
        sticks=rig.sticks,
        ideal_radius=rig.ideal_radius,
    )


def _result(setup: Setup, study: Study, scores: Score, sample: Flight, learnt: Any) -> SetupResult:
    split: dict[str, Score] = {}
    start = 0
    for manoeuvre in TEST_MANOEUVRES:
        stop = start + _count(study, manoeuvre)
        split[manoeuvre.name] = Score(*(getattr(scores, name)[:, start:stop] for name in Score.names()))
        start = stop
    if learnt is None:
        return SetupResult(setup, split, sample)
    return SetupResult(setup, split, sample, learnt.policy, learnt.curve, learnt.learning)


def choose(study: Study, demos: Mapping[str, Demonstrations], rig: Rig) -> Iterator[dict[str, Any]]:
    """Each candidate method on the development flights, three seeds each: how the default was chosen."""
    keys = [flight_key(study.seed, "development", "combined", i) for i in range(study.development_cases)]
    cases = [Case.draw(DEVELOPMENT, key, FLIGHT_ROWS) for key in keys]
    for setup in CANDIDATES:
        *_, learnt = learn(setup, demos, study, rig)
        assert isinstance(learnt, Learnt)
        crew = Crew(replace(learnt.policy, contract=None), Axes.of(FLYING_AXES))
        scores, _ = evaluate(cases, crew, [(*key, 1) for key in keys], rig, team=True)
        row = _summary(scores)
        yield {"name": setup.name, **learnt.learning} | {
            key: row[key] for key in ("distance_rmse_px", "radius_rmse_px", "in_view")
        }


def duel(
    pilots: Mapping[str, AbstractPilot],
    manoeuvre: AbstractManoeuvre,
    cases: int,
    seed: int,
    done: Callable[[int], None] = lambda number: None,
    rig: Rig = Rig(),
) -> dict[str, Any]:
    """Fly pilots on the same test cases: a summary of each, and each compared with the first, paired."""
    keys = [flight_key(seed, "test", manoeuvre.name, i) for i in range(cases)]
    drawn = [Case.draw(manoeuvre, key, FLIGHT_ROWS) for key in keys]
    scores: dict[str, Score] = {}
    for number, (name, pilot) in enumerate(pilots.items()):
        done(number)
        crew = Crew(pilot.for_axes(FLYING_AXES), Axes.of(FLYING_AXES))
        scores[name], _ = evaluate(drawn, crew, [(*key, 1) for key in keys], rig)
    done(len(pilots))
    first, *others = scores
    found = _compare([(first, other) for other in others], (*METRICS, "in_view"), scores, seed)
    return {
        "entries": {name: _summary(score) for name, score in scores.items()},
        "comparisons": [asdict(comparison) for comparison in found],
    }


# What is found


METRICS = ("distance_rmse", "radius_rmse")
PRIMARY = (("primitive", "dnn-combined"), ("primitive", "human-combined"))
"""The family of tests fixed in advance: two pairs by two metrics, Holm over the four."""
EXPLORATORY = (
    ("primitive", "primitive-paper"),
    ("primitive", "servo"),
    ("primitive-paper", "human-combined"),
    ("dnn-combined", "human-combined"),
    ("human-combined", "human-combined-undivided"),
    ("primitive", "primitive-zero"),
    ("primitive-matched", "dnn-combined"),
    ("primitive", "dnn-combined-matched"),
)
MARGIN = 0.10
"""Non-inferior: at most 10 % worse (D12)."""

PAPER_TABLE = {
    "human-combined": {"distance": (14.2, 9.0), "radius": (12.9, 21.9)},
    "dnn-combined": {"distance": (12.6, 8.1), "radius": (26.2, 19.1)},
    "primitive": {"distance": (12.9, 8.2), "radius": (10.9, 9.9)},
}
"""Table 4: mean and standard deviation over ten test runs; no unit given."""

SYNTHETIC = (
    "No person flew in this study: every demonstration, and every flight called human, is by a synthetic operator, "
    "a model from the manual-control literature."
)


def summarise(
    study: Study,
    results: Mapping[str, SetupResult],
    operator: list[dict[str, Any]],
    development: list[dict[str, Any]] | None,
    demos: Mapping[str, Demonstrations],
    rig: Rig,
) -> dict[str, Any]:
    """Everything in results.json but the times."""
    scores = {name: result.scores["combined"] for name, result in results.items()}
    primary = _compare(PRIMARY, (*METRICS, ), scores, study.seed)
    exploratory = _compare(EXPLORATORY, (*METRICS, "in_view"), scores, study.seed)
    return {
        "version": version("fledge"),
        "seed": study.seed,
        "settings": _settings(study, demos, rig),
        "operator": {"sentence": SYNTHETIC, "axes": operator, "bands": BANDS},
        "setups": {name: _setup_summary(result) for name, result in results.items()},
        "comparisons": [
            asdict(comparison) | {"family": family}
            for family, found in (("primary", primary), ("exploratory", exploratory))
            for comparison in found
        ],
        "non_inferiority": [
            _non_inferior(metric, scores, study.seed) for metric in METRICS if set(PRIMARY[1]) <= set(scores)
        ],
        "paper": {"table": PAPER_TABLE, "welch": _welch()},
        "development": development,
    }


def _compare(
    pairs: Sequence[tuple[str, str]], metrics: Sequence[str], scores: Mapping[str, Score], seed: int
) -> tuple[statistics.Comparison, ...]:
    return statistics.with_holm(
        statistics.compare(a, getattr(scores[a], metric), b, getattr(scores[b], metric), metric, seed)
        for a, b in pairs
        if a in scores and b in scores
        for metric in metrics
    )


def _non_inferior(metric: str, scores: Mapping[str, Score], seed: int) -> dict[str, Any]:
    a, b = PRIMARY[1]
    found = statistics.non_inferior(getattr(scores[a], metric), getattr(scores[b], metric), MARGIN, seed)
    return {"a": a, "b": b, "metric": metric} | asdict(found)


def _welch() -> list[dict[str, Any]]:
    """The tests the paper's own printed numbers allow: Welch on mean, sd and n = 10, Holm over the six."""
    pairs = [("human-combined", "dnn-combined"), ("human-combined", "primitive"), ("dnn-combined", "primitive")]
    named = [(a, b, metric) for metric in ("distance", "radius") for a, b in pairs]
    found = [
        statistics.welch_p(*PAPER_TABLE[a][metric], 10, *PAPER_TABLE[b][metric], 10)
        for a, b, metric in named
    ]
    return [
        {"a": a, "b": b, "metric": metric, "p": p, "p_holm": adjusted}
        for (a, b, metric), p, adjusted in zip(named, found, statistics.holm(found), strict=True)
    ]


def _summary(scores: Score) -> dict[str, Any]:
    """One line of a table; means over flights."""

    def spread(values: np.ndarray) -> dict[str, float]:
        return {"mean": float(values.mean()), "sd": float(values.std(ddof=1))}

    seconds = FLIGHT_ROWS / ROW_RATE
    return {
        "flights": int(scores.distance.size),
        "distance": spread(scores.distance),
        "radius": spread(scores.radius),
        "distance_rmse_px": float(scores.distance_rmse.mean()),
        "radius_rmse_px": float(scores.radius_rmse.mean()),
        "distance_integral_px_s": float(scores.distance.mean()) * seconds,
        "radius_integral_px2_s": float(scores.radius.mean()) * seconds,
        "in_view": float(scores.in_view.mean()),
        "smoothness": float(scores.smoothness.mean()),
        "effort": float(scores.effort.mean()),
    }


def _setup_summary(result: SetupResult) -> dict[str, Any]:
    combined = result.scores["combined"]
    return _summary(combined) | {
        "title": result.setup.title,
        "trained_on": result.setup.trained_on,
        "seeds": len(combined.distance),
        "manoeuvres": {name: _summary(scores) for name, scores in result.scores.items()},
        "scores": {name: np.asarray(getattr(combined, name)).tolist() for name in Score.names()},
        "curve": None if result.curve is None else _curve(member_curve(result.curve, 0)),
        "learning": result.learning,
    }


def _curve(curve: LossCurve) -> dict[str, Any]:
    names = ("all", *curve.names)
    return {
        "epochs": curve.epochs.tolist(),
        "training": {name: curve.training[:, i].tolist() for i, name in enumerate(names)},
        "validation": {name: curve.validation[:, i].tolist() for i, name in enumerate(names)},
    }


def _settings(study: Study, demos: Mapping[str, Demonstrations], rig: Rig) -> dict[str, Any]:
    return {
        "mode": study.mode,
        "command": f"fledge reproduce{'' if study.mode == 'brief' else f' --{study.mode}'} --seed {study.seed}",
        "cases": study.cases,
        "manoeuvre_cases": study.manoeuvre_cases,
        "training_seeds": study.training_seeds,
        "flight_seconds": FLIGHT_ROWS / ROW_RATE,
        "row_rate_hz": ROW_RATE,
        "families": {
            "training": TRAINING_FAMILIES,
            "development": DEVELOPMENT_FAMILIES,
            "test": HELD_OUT_FAMILIES,
        },
        "lens": asdict(rig.lens),
        "sticks": asdict(rig.sticks),
        "uav": asdict(rig.uav),
        "ideal_radius_px": rig.ideal_radius,
        "method": asdict(DEFAULT_METHOD) | {"inputs": [OBSERVATION_NAMES[i] for i in DEFAULT_METHOD.inputs]},
        "recipes": {"fast": asdict(Recipe.fast()), "paper": asdict(Recipe.paper())},
        "operator": asdict(HumanModel()),
        "servo": asdict(Servo()),
        "demonstrations": {
            name: {"episodes": len(data.episodes), "rows": data.rows} for name, data in demos.items()
        },
        "versions": {"python": platform.python_version()}
        | {name: version(name) for name in ("fledge", "jax", "jaxlib", "numpy", "optax", "scipy")},
    }


