"""The set-ups are data: what they promise can be read off them."""

import pytest

from fledge.errors import OutOfRange
from fledge.manoeuvres.paths import DEVELOPMENT_FAMILIES, HELD_OUT_FAMILIES, TRAINING_FAMILIES
from fledge.study.setups import (
    BASIC,
    CANDIDATES,
    COMBINED_ROWS,
    DEFAULT_METHOD,
    DEVELOPMENT,
    FURTHER,
    PAPER_METHOD,
    PRIMITIVE_ROWS,
    SUB_TASKS,
    TEST_MANOEUVRES,
    Study,
)


def test_three_purposes_three_sets_of_paths():
    sets = [set(TRAINING_FAMILIES), set(DEVELOPMENT_FAMILIES), set(HELD_OUT_FAMILIES)]
    assert sum(len(families) for families in sets) == len(set.union(*sets))
    assert set(DEVELOPMENT.families) == sets[1]
    assert {set(m.families) == sets[2] for m in TEST_MANOEUVRES if hasattr(m, "families")} == {True}


def test_the_paper_s_set_ups_are_there():
    names = {setup.name for setup in BASIC}
    assert {"human-combined", "dnn-combined", "primitive-paper", "primitive", "servo"} <= names
    assert {"primitive-zero", "primitive-matched", "dnn-combined-matched"} <= {s.name for s in FURTHER}


def test_the_paper_s_method_is_the_plain_one():
    assert (PAPER_METHOD.fill, PAPER_METHOD.delay, len(PAPER_METHOD.inputs)) == ("zero", 0, 11)


def test_the_default_is_among_what_it_was_chosen_from():
    assert DEFAULT_METHOD in {candidate.method for candidate in CANDIDATES}
    assert all(candidate.trained_on == "sub-tasks" for candidate in CANDIDATES)


def test_matched_set_ups_have_each_other_s_rows():
    rows = {setup.name: setup.rows for setup in FURTHER}
    assert rows["primitive-matched"] == COMBINED_ROWS == 5464
    assert rows["dnn-combined-matched"] == PRIMITIVE_ROWS == 14891


def test_sub_tasks_cover_every_action_but_yaw_once():
    lateral, climb, descend = SUB_TASKS
    assert (lateral.actions, climb.actions, descend.actions) == ((0, 1), (2,), (2,))


def test_one_network_flies_the_paper_s_ten_thousand_epochs():
    study = Study.of("full")
    paper = [setup for setup in study.setups if setup.recipe.epochs == 10_000]
    assert paper and all(study.seeds_of(setup) == 1 for setup in paper)
    assert {study.seeds_of(setup) for setup in study.setups if setup not in paper} == {20}


def test_a_negative_seed_is_refused():
    with pytest.raises(OutOfRange, match="seed is -1: valid is 0 or more"):
        Study.of("quick", seed=-1)
