"""What is declared of faults, and the fault matrix in its short form."""

import re
from math import inf
from pathlib import Path

import jax
import numpy as np
import pytest

from fledge.faults.catalogue import DOWN, FAULTS, FLYING_ON, Promise
from fledge.faults.drills import PHASES, draw_drill, judge
from fledge.faults.injection import fly_drills
from fledge.supervision.modes import Mode
from fledge.world import Reason

EVERY_FAULT = pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
PROMISED = [fault for fault in FAULTS if fault.promise != Promise.NONE]
CASE = (Path(__file__).parents[2] / "docs" / "safety-case.md").read_text()


def test_there_are_enough_of_them_and_each_has_a_name():
    assert len(PROMISED) >= 20 and len({fault.name for fault in FAULTS}) == len(FAULTS)


@EVERY_FAULT
def test_a_fault_is_declared_in_full(fault):
    shortest, longest = fault.lasts
    assert 0.0 < shortest <= longest
    assert fault.ends and set(fault.ends) <= {*FLYING_ON, *DOWN, Mode.STOPPED, Mode.MANUAL}
    assert bool(fault.reasons) == (fault.within < inf)
    assert all(set(group) <= {0, 1, 2, 3} for group in fault.strikes)
    if fault.promise == Promise.DETECTABLE:
        assert fault.reasons, "what is detectable has a name"


def test_every_reason_of_the_watchdog_is_called_for():
    called = {reason for fault in FAULTS for reason in fault.reasons}
    assert called >= {reason for reason in Reason if Reason.STALE <= reason <= Reason.CLOCK}


@EVERY_FAULT
def test_the_safety_case_shows_it(fault):
    """Nothing touched, nobody in a mode that was not declared, nothing without its name, of what is promised."""
    assert CASE.index(f"**{str(fault.promise).capitalize()}**") < CASE.index(f"| {fault.name} |")
    cells = next(line for line in CASE.splitlines() if line.startswith(f"| {fault.name} |")).split(" | ")
    touched, unsafe, named = cells[1:4]
    if fault.promise != Promise.NONE:
        assert (touched, unsafe) == ("0 / 0 / 0", "0")
        assert not named or re.fullmatch(r"(\d+) of \1", named)


SEEDS = range(2)


@pytest.fixture(scope="module")
def flown():
    """(fault, phase) of every flight, the drills, and what came of them."""
    jobs = [(fault, phase, (1, n, i)) for fault in FAULTS for n, phase in enumerate(PHASES) for i in SEEDS]
    drills = [draw_drill(*job) for job in jobs]
    return jobs, drills, fly_drills(drills, [key for _, _, key in jobs])


@pytest.mark.slow
@EVERY_FAULT
def test_what_is_promised_of_a_fault_holds(flown, fault):
    jobs, drills, reports = flown
    own = [i for i, (other, _, _) in enumerate(jobs) if other is fault]
    result = judge(fault, jax.tree.map(lambda leaf: leaf[own], reports), [drills[i] for i in own])
    if fault.promise == Promise.NONE:
        assert np.isin(result.touched, (True, False)).all(), "it is flown, no more"
        return
    assert not result.touched.any()
    assert result.safe.all()
    assert not result.overdue.any()
