"""What people did who took over is learnt from: all of it that was theirs, and nothing that was not."""

from dataclasses import astuple, replace
from functools import cache

import jax
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fledge import lookup
from fledge.cockpit.flight import Choice, Live
from fledge.cockpit.seat import HANDS_OFF, Spoken
from fledge.engines import fly_plain
from fledge.episode import Flight, over
from fledge.errors import BadDemonstrations
from fledge.learning import training
from fledge.learning.recipe import Recipe
from fledge.learning.takeovers import LEAST, TAKE_OVERS, corrections
from fledge.manoeuvres import Climb, Descend, FixedAltitude
from fledge.observation import OBSERVATION_NAMES, Action, Axes, StickScale
from fledge.pilots import Servo
from fledge.runs.apprenticeship import Lesson
from fledge.safety import StopTube
from fledge.simulation import TICK, Case, Crew
from fledge.study.experiments import by_sub_task, composite_set
from fledge.study.setups import DEFAULT_METHOD, PAPER_METHOD
from fledge.supervision.inputs import Operator
from fledge.world import Reason, VelocityCommand, Verdict

pytestmark = pytest.mark.slow

ROWS = 60
HANDS = Action(0.5, -0.25, 0.75, 1.0)
"""A person's, all the time."""
SETUP = lookup.setup("primitive")


@cache
def flown(manoeuvre, number=0) -> Flight:
    """Nobody takes over."""
    key = (number, 1)
    case = Case.draw(manoeuvre, key, ROWS)
    episode = fly_plain(case, Crew(Servo(), Axes.of(manoeuvre.axes)), key)
    return Flight(episode, manoeuvre.name, "servo", "none", 0, number, manoeuvre.axes, case.plan.arena)


def taken_over(reasons, flight=None) -> Flight:
    """A flight whose supervisor gave these reasons, row by row; the person's hands were still."""
    flight = flight or flown(FixedAltitude())
    command = VelocityCommand(*(np.full(ROWS, one) for one in astuple(flight.sticks.command(HANDS))))
    padded = np.array([*reasons, *[Reason.NONE] * (ROWS - len(reasons))], float)
    uav = replace(flight.episode.verdicts[0], command=command, reason=padded)
    return replace(flight, episode=replace(flight.episode, verdicts=(uav, *flight.episode.verdicts[1:])))


BY_HAND, NET, POLICY = Reason.TAKE_OVER, Reason.WALL, Reason.NONE


@cache
def by_hand() -> Flight:
    """A person flew all of it."""
    return taken_over([BY_HAND] * ROWS)


def demonstrated():
    return [
        flown(manoeuvre, number) for manoeuvre in (FixedAltitude(), Climb(), Descend()) for number in (0, 1)
    ]


# Sticks and velocities

SCALE = st.builds(StickScale, *(st.floats(0.05, 10.0) for _ in range(3)))
STICK = st.floats(-1.0, 1.0)


@given(SCALE, st.builds(Action, STICK, STICK, STICK, STICK))
def test_a_command_says_which_sticks_asked_for_it(scale, said):
    assert astuple(scale.action(scale.command(said))) == pytest.approx(astuple(said), abs=1e-12)


@given(SCALE, st.builds(VelocityCommand, *(st.floats(-100.0, 100.0) for _ in range(4))))
def test_what_no_stick_can_ask_for_is_full_stick(scale, command):
    found = astuple(scale.action(command))
    assert all(abs(one) <= 1.0 for one in found)
    for one, asked, back in zip(found, astuple(command), astuple(scale.command(Action(*found))), strict=True):
        assert back == pytest.approx(asked) or (abs(one) == 1.0 and abs(back) < abs(asked))


# Which rows count


@given(st.lists(st.tuples(st.sampled_from((BY_HAND, NET, POLICY)), st.integers(1, 30)), max_size=8))
@settings(max_examples=50)
def test_every_run_of_a_second_or_longer_is_an_episode_and_nothing_else(runs):
    reasons = [reason for reason, rows in runs for _ in range(rows)][:ROWS]
    flight = taken_over(reasons)
    wanted, begin = [], 0
    for i, reason in enumerate([*reasons, POLICY]):
        if reason != BY_HAND:
            wanted += [(begin, i)] if i - begin >= LEAST else []
            begin = i + 1
    found = corrections([flight])
    assert len(found) == len(wanted)
    for (states, actions), (begin, end) in zip(found, wanted, strict=True):
        for column, name in enumerate(OBSERVATION_NAMES):
            seen = getattr(flight.episode.observation, name)[begin:end]
            np.testing.assert_array_equal(states[:, column], seen)
        np.testing.assert_allclose(actions, np.tile(astuple(HANDS)[:3], (end - begin, 1)))


def test_every_flight_counts():
    assert len(corrections([by_hand(), flown(Climb()), by_hand()])) == 2
    assert corrections([flown(Climb())]) == corrections([]) == []


def live(sticks, seconds) -> Flight:
    """In the cockpit, a servo being taken over after two seconds behind a net."""
    choice = Choice(Descend(), Servo(), StopTube(), "stop-tube", 400)
    flight = Live.draw(choice)
    memory, rows = flight.init(), []
    for i in range(round((2.0 + seconds) / TICK)):
        rest = Operator(arm=float(i >= 120))
        hands = replace(rest, command=StickScale().command(sticks), switch=1.0) if i >= 200 else rest
        memory, shown = flight.tick(memory, Spoken((hands, rest, rest, rest), HANDS_OFF, 0.0, False))
        rows += [] if shown.row is None else [shown.row]
    return replace(flight.about, episode=jax.tree.map(lambda *leaves: np.array(leaves), *rows))


def test_what_was_recorded_is_the_persons_up_to_where_the_net_stepped_in():
    forward = Action(1.0, 0.0, 0.0, 0.0)
    flight = live(forward, seconds=3.4)
    reasons = [Reason(int(reason)) for reason in flight.episode.verdicts[0].reason]
    assert reasons[39:41] == [POLICY, BY_HAND] and NET in reasons
    ((states, actions),) = corrections([flight])
    assert len(states) == reasons.index(NET) - 40 > LEAST
    np.testing.assert_array_equal(actions, np.tile([1.0, 0.0, 0.0], (len(actions), 1)))


def test_a_row_in_which_the_net_stepped_in_is_the_nets():
    hands, net = (
        Verdict(VelocityCommand(v, 0.0, 0.0, 0.0), 1.0, float(r), 1.0) for v, r in ((1, BY_HAND), (0, NET))
    )
    nobody = replace(hands, intervened=0.0, reason=0.0)
    assert over([hands, hands, net]).reason == over([net, hands, hands]).reason == NET
    assert over([nobody, hands, hands]).reason == BY_HAND
    assert over([hands, replace(net, reason=float(Reason.RECOVERING))]).reason == Reason.RECOVERING


# What is learnt


@pytest.mark.parametrize("method", (PAPER_METHOD, DEFAULT_METHOD), ids=("paper", "default"))
def test_they_are_one_sub_task_more(method):
    demos, pairs = by_sub_task(demonstrated(), "sub-tasks"), corrections([by_hand(), by_hand()])
    without, delay = composite_set("sub-tasks", method, demos)
    composite, same = composite_set("sub-tasks", method, demos, pairs)
    assert same == delay and composite.names == (*without.names, TAKE_OVERS.name)
    old = len(without.states)
    np.testing.assert_array_equal(composite.states[:old], without.states)
    np.testing.assert_array_equal(composite.mask[:old], without.mask)
    assert composite.mask[old:].all(), "a person at the sticks may use them all, and never learns to turn"
    assert len(composite.states) - old == 2 * (ROWS - delay)
    np.testing.assert_allclose(
        composite.actions[old:], np.tile([*astuple(HANDS)[:3], 0.0], (2 * (ROWS - delay), 1))
    )
    assert np.unique(composite.episode[old:]).size == 2


def test_with_nobody_who_took_over_there_is_no_lesson():
    short = taken_over([BY_HAND] * (LEAST - 1))
    with pytest.raises(BadDemonstrations, match="nobody took over for a second or longer in 2 flights"):
        Lesson.of(demonstrated(), SETUP, Recipe.fast(), 0, [short, flown(Climb())])


def test_who_took_over_through_other_eyes_is_not_learnt_from():
    with pytest.raises(BadDemonstrations, match="different lens, ideal radius or sticks"):
        Lesson.of(demonstrated(), SETUP, Recipe.fast(), 0, [replace(by_hand(), ideal_radius=90.0)])


def test_a_policy_does_more_of_what_the_person_did():
    plain, corrected = (
        Lesson.of(demonstrated(), SETUP, Recipe.fast(20), 0, more) for more in ([], [by_hand()])
    )
    assert plain.settings["data"] != corrected.settings["data"]
    ((states, actions),) = corrections([by_hand()])

    def off(lesson):
        """From what the person did, on average."""
        *_, state = training.train(lesson.composite, lesson.recipe, lesson.keys)
        many = training.policies(lesson.composite, lesson.recipe, state, lesson.contract)
        return np.abs(training.member(many, 0)(states)[:, :3] - actions).mean()

    assert off(corrected) < 0.5 * off(plain)
