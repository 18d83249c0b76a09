"""Flights with faults: what the program does to the vehicles, behind no net, so that it is compiled quickly."""

from functools import partial

import jax
import numpy as np
import pytest

from fledge.faults.catalogue import FAULTS
from fledge.faults.drills import draw_drill
from fledge.faults.injection import fly_drills
from fledge.safety import NoNet
from fledge.supervision.modes import Mode as M
from fledge.supervision.supervisor import Supervisor

pytestmark = pytest.mark.slow

NAMED = {fault.name: fault for fault in FAULTS}
JOBS = [
    (NAMED[name], phase, (4, i))
    for name, phase in (
        ("10 % of the poses are lost", "cruise"),
        ("a pose jumps by 0.5 m", "cruise"),
        ("the same, a person flies", "climb"),
        ("a battery runs low", "cruise"),
        ("NaN from the sticks, a person flies", "cruise"),
        ("the policy proposes 1e30", "wall"),
        ("a vehicle hears nothing for 0.3 s", "wall"),
    )
    for i in range(4)
]
DRILLS = [draw_drill(*job) for job in JOBS]
KEYS = [key for _, _, key in JOBS]
fly = partial(fly_drills, supervisor=Supervisor(NoNet()))


@pytest.fixture(scope="module")
def report():
    return fly(DRILLS, KEYS)


def of(report, name: str) -> tuple[np.ndarray, ...]:
    """(smallest gaps, last modes, last speeds, when it was named, who was struck); arrays (vehicles, flights)."""
    own = [i for i, (fault, _, _) in enumerate(JOBS) if fault.name == name]
    struck = np.array([DRILLS[i].struck for i in own]).T > 0.5
    return (*(np.array(part)[:, own] for part in report[:4]), struck)


def test_the_same_drills_end_the_same(report):
    jax.tree.map(np.testing.assert_array_equal, report, fly(DRILLS, KEYS))


def test_without_a_net_a_policy_that_pushes_at_a_wall_gets_there(report):
    gaps, modes, _, _, _ = of(report, "the policy proposes 1e30")
    assert (gaps <= 0.0).all(axis=0).any() and (modes == M.AUTO).all()


def test_a_fault_that_is_none_is_not_named(report):
    _, modes, _, named, _ = of(report, "10 % of the poses are lost")
    assert np.isinf(named).all() and (modes == M.AUTO).all()


def test_who_is_struck_is_named_at_once_and_stops(report):
    _, modes, speeds, named, struck = of(report, "a pose jumps by 0.5 m")
    assert (named[struck] <= 0.05).all() and np.isinf(named[~struck]).all()
    assert (modes[struck] == M.STOPPED).all() and (modes[~struck] == M.AUTO).all()
    assert (speeds[struck] < 0.15).all()


def test_who_flies_by_hand_is_missed_after_half_a_second_and_comes_down(report):
    _, modes, _, named, struck = of(report, "the same, a person flies")
    assert named[struck] == pytest.approx(0.5, abs=0.02)
    assert np.isin(modes[struck], (M.LAND, M.INIT)).all()


def test_a_landed_uav_stays_down_and_its_belly_touches_nothing(report):
    gaps, modes, speeds, _, struck = of(report, "a battery runs low")
    assert (modes[struck] == M.INIT).all() and (speeds[struck] < 0.01).all()


def test_a_person_keeps_the_vehicle(report):
    _, modes, _, named, struck = of(report, "NaN from the sticks, a person flies")
    assert (modes[struck] == M.MANUAL).all() and (modes[~struck] == M.AUTO).all()
    assert (named[struck] <= 0.05).all()


def test_what_the_supervisor_cannot_see_it_does_not_name(report):
    _, _, _, named, _ = of(report, "a vehicle hears nothing for 0.3 s")
    assert np.isinf(named).all()
