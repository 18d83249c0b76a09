"""The paper's study: section "Experiments", from stored demonstrations to a summary of what was found.

`run` is a stream of records: `Progress` while it works, one `Results` at the end. It touches no files. What is to be
run stands in `setups`, what is made of the scores in `findings`. No Combined demonstration reaches a set-up that
learns from sub-tasks, and everybody flies the same cases with the same chance.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import chain
from typing import Any

from fledge.episode import Flight
from fledge.errors import BadDemonstrations
from fledge.learning.demonstrations import PAPER_ORDERS, Demonstrations, Order, Pair, collect, of_flights
from fledge.learning.fusion import CompositeSet, estimate_delay, fuse
from fledge.learning.policy import Contract, Policy
from fledge.learning.takeovers import TAKE_OVERS
from fledge.learning.training import LossCurve, member, policies, train
from fledge.manoeuvres import AbstractManoeuvre, Combined
from fledge.observation import OBSERVATION_NAMES, VELOCITY_INPUTS, Axes
from fledge.pilots import AbstractPilot, HumanModel
from fledge.safety import AbstractNet, NoNet
from fledge.simulation import Case, Crew, Rig, flight_key
from fledge.study.evaluation import Score, evaluate
from fledge.study.findings import COMPARED, SetupResult, compare_pairs, summarise, summarise_scores, to_json
from fledge.study.proving import Bystanders, count, fly_tests
from fledge.study.restraint import NAMED, Entry, examine, trials
from fledge.study.restraint import summarise as summarise_nets
from fledge.study.setups import (
    CANDIDATES,
    COMBINED_ROWS,
    DEVELOPMENT,
    FLIGHT_ROWS,
    FLYING_AXES,
    TASKS,
    TEST_MANOEUVRES,
    YAW,
    Method,
    Setup,
    Study,
)


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a study is."""

    stage: str
    done: int
    total: int


@dataclass(frozen=True, slots=True)
class Results:
    """A finished study."""

    study: Study
    setups: dict[str, SetupResult]
    summary: dict[str, Any]
    """All that goes into results.json, but the times."""


def run(
    study: Study, flights: Sequence[Flight], rig: Rig = Rig(), bystanders: Bystanders | None = None
) -> Iterator[Progress | Results]:
    """The whole study on stored demonstrations of the four manoeuvres.

    Raises:
        BadDemonstrations: a manoeuvre's flights are missing.
    """
    demos = by_sub_task(flights)
    total = len(study.setups) + 2 + bool(study.development_cases)
    results: dict[str, SetupResult] = {}
    with bystanders or Bystanders(study, rig) as others:
        for done, setup in enumerate(study.setups):
            yield Progress(setup.name, done, total)
            learnt = None
            for learnt in learn(setup, demos, study, rig) if setup.trained_on else ():
                if isinstance(learnt, Progress):
                    yield learnt
            if isinstance(learnt, Learnt):
                # The contract names the data: left in, every set-up would be compiled anew.
                flown = fly_tests(setup, study, replace(learnt.policy, contract=None), rig)
            else:
                flown = others.flown[setup.name].result()
            results[setup.name] = _result(setup, study, *flown, learnt)
        yield Progress("operator", len(study.setups), total)
        operator = [asdict(axis) | {"inside": axis.inside} for axis in others.operator.result()]
    development = None
    if study.development_cases:
        yield Progress("development", total - 2, total)
        development = list(choose(study, demos, rig))
    nets = None
    for nets in behind_nets(study, results, rig):
        if isinstance(nets, Progress):
            yield nets
    yield Progress("statistics", total - 1, total)
    summary = summarise(study, results, operator, development, demos, rig)
    yield Results(study, results, summary | {"nets": nets})


def behind_nets(
    study: Study, results: Mapping[str, SetupResult], rig: Rig
) -> Iterator[Progress | dict[str, Any]]:
    """The default policy behind every net, and the operator, if not in the lab; nothing if the study has no nets."""
    learnt = results["primitive"].policy if "primitive" in results else None
    if not study.net_cases or learnt is None:
        return
    nets = {name: NAMED[name] for name in study.nets}
    flights = trials(study.net_cases, study.lab_cases, study.seed, study.rows)
    parts = [examine("primitive", replace(member(learnt, 0), contract=None), nets, flights, rig)]
    if study.operator_behind_nets:
        flights = {kind: some for kind, some in flights.items() if kind != "lab"}
        parts.append(examine("human-combined", HumanModel(), nets, flights, rig))
    entries: list[Entry] = []
    yield Progress("nets: flights", 0, len(parts) * len(nets))
    for entry in chain(*parts):
        entries.append(entry)
        yield Progress("nets: flights", len(entries), len(parts) * len(nets))
    yield summarise_nets(entries, study.rows, study.seed)


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
        name: of_flights([flight for flight in flights if flight.manoeuvre == name]) for name in sorted(found)
    }


def composite_set(
    trained_on: str,
    method: Method,
    demos: Mapping[str, Demonstrations],
    takeovers: Sequence[Pair] = (),
) -> tuple[CompositeSet, int]:
    """(the composite set, the delay in rows): what a set-up learns from, and from those who took over, if any did."""
    chosen = {task: demos[task.name] for task in TASKS[trained_on]}
    delay = estimate_delay(chosen, answers=VELOCITY_INPUTS) if method.delay == "estimated" else method.delay
    further = {TAKE_OVERS: Demonstrations.of(list(takeovers), TAKE_OVERS.name)} if takeovers else {}
    return fuse(chosen | further, 4, method.fill, method.inputs, delay, unused=YAW), delay


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


def _result(setup: Setup, study: Study, scores: Score, sample: Flight, learnt: Any) -> SetupResult:
    split: dict[str, Score] = {}
    start = 0
    for manoeuvre in TEST_MANOEUVRES:
        stop = start + count(study, manoeuvre)
        split[manoeuvre.name] = Score(*(getattr(scores, name)[:, start:stop] for name in Score.names()))
        start = stop
    if learnt is None:
        return SetupResult(setup, split, sample)
    return SetupResult(setup, split, sample, learnt.policy, learnt.curve, learnt.learning)


def choose(study: Study, demos: Mapping[str, Demonstrations], rig: Rig) -> Iterator[dict[str, Any]]:
    """Each candidate method on the development flights, three seeds each: how the default was chosen."""
    keys = [flight_key(study.seed, "development", "combined", i) for i in range(study.development_cases)]
    cases = [Case.draw(DEVELOPMENT, key, study.rows) for key in keys]
    for setup in CANDIDATES:
        *_, learnt = learn(setup, demos, study, rig)
        assert isinstance(learnt, Learnt)
        crew = Crew(replace(learnt.policy, contract=None), Axes.of(FLYING_AXES))
        scores, _ = evaluate(cases, crew, [(*key, 1) for key in keys], rig, team=True)
        row = summarise_scores(scores, study.rows)
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
    net: AbstractNet = NoNet(),
) -> dict[str, Any]:
    """Fly pilots on the same test cases behind a net: a summary of each, each compared with the first, paired."""
    keys = [flight_key(seed, "test", manoeuvre.name, i) for i in range(cases)]
    drawn = [Case.draw(manoeuvre, key, FLIGHT_ROWS) for key in keys]
    scores: dict[str, Score] = {}
    for number, (name, pilot) in enumerate(pilots.items()):
        done(number)
        crew = Crew(pilot.for_axes(FLYING_AXES), Axes.of(FLYING_AXES), net)
        scores[name], _ = evaluate(drawn, crew, [(*key, 1) for key in keys], rig)
    done(len(pilots))
    first, *others = scores
    found = compare_pairs([(first, other) for other in others], COMPARED, scores, seed)
    return {
        "entries": {name: summarise_scores(score, FLIGHT_ROWS) for name, score in scores.items()},
        "comparisons": [to_json(comparison) for comparison in found],
    }
