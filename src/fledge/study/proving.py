"""The test flights of a study: the same cases with the same chance, whoever flies."""

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from typing import Any

from fledge.engines import prepare
from fledge.episode import Flight
from fledge.learning.policy import Policy
from fledge.manoeuvres import AbstractManoeuvre
from fledge.observation import Axes
from fledge.pilots import AbstractPilot, HumanModel
from fledge.simulation import Case, Crew, Rig, flight_key
from fledge.study.crossover import Credibility, credibility
from fledge.study.evaluation import Score, evaluate
from fledge.study.restraint import compile_ahead
from fledge.study.setups import DEFAULT_METHOD, FLYING_AXES, TEST_MANOEUVRES, Setup, Study


def test_cases(study: Study) -> tuple[list[Case], list[tuple[int, ...]]]:
    """(cases, keys): Combined first, then the sub-tasks in the order of `TEST_MANOEUVRES`."""
    cases, keys = [], []
    for manoeuvre in TEST_MANOEUVRES:
        for number in range(count(study, manoeuvre)):
            key = flight_key(study.seed, "test", manoeuvre.name, number)
            cases.append(Case.draw(manoeuvre, key, study.rows))
            keys.append((*key, 1))
    return cases, keys


def count(study: Study, manoeuvre: AbstractManoeuvre) -> int:
    """How many test cases a study has of a manoeuvre."""
    return study.cases if manoeuvre.name == "combined" else study.manoeuvre_cases


def fly_tests(setup: Setup, study: Study, pilot: AbstractPilot, rig: Rig) -> tuple[Score, Flight]:
    """All test flights of a set-up: (scores, the first flight)."""
    cases, keys = test_cases(study)
    crew = Crew(pilot.for_axes(FLYING_AXES), Axes.of(FLYING_AXES))
    scores, first = evaluate(cases, crew, keys, rig, team=setup.trained_on is not None)
    return scores, Flight(
        episode=first,
        manoeuvre="combined",
        pilot=setup.name,
        net="none",
        seed=study.seed,
        case=0,
        axes=FLYING_AXES,
        arena=cases[0].plan.arena,
        lens=rig.lens,
        sticks=rig.sticks,
        ideal_radius=rig.ideal_radius,
    )


def get_ready(study: Study, rig: Rig) -> None:
    """Begin to compile what will fly those who have learnt by then: all networks are alike but for their numbers."""
    cases, keys = test_cases(replace(study, cases=1, manoeuvre_cases=0))
    for inputs in {setup.method.inputs for setup in study.setups if setup.trained_on}:
        prepare(cases, Crew(Policy.blank(inputs), Axes.of(FLYING_AXES)), keys, rig)
    if study.net_cases:
        compile_ahead(Policy.blank(DEFAULT_METHOD.inputs), study.nets, study.rows, rig)


class Bystanders:
    """Whoever learns nothing: they fly from the start, on a core of their own, while others demonstrate and learn.

    And for these, what is to fly them gets ready.

    A context: those who have not taken off when it is left stay on the ground.
    """

    flown: dict[str, Future[tuple[Score, Flight]]]
    """Their test flights, by set-up."""
    operator: Future[tuple[Credibility, ...]]

    def __init__(self, study: Study, rig: Rig = Rig()) -> None:
        """Take off."""
        self._core = ThreadPoolExecutor(1)
        self.operator = self._core.submit(credibility, HumanModel(), study.seed, rig=rig)
        self.flown = {
            setup.name: self._core.submit(fly_tests, setup, study, setup.pilot, rig)
            for setup in study.setups
            if setup.pilot
        }
        get_ready(study, rig)

    def __enter__(self) -> "Bystanders":
        return self

    def __exit__(self, *error: Any) -> None:
        self._core.shutdown(wait=False, cancel_futures=True)
