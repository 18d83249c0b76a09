"""Whose word counts, and when."""

from dataclasses import replace
from math import inf

import pytest

from fledge.geometry import Quat, Vec3
from fledge.lab.control.arming import Arming
from fledge.lab.control.hands import Holding
from fledge.lab.control.phases import Phase
from fledge.supervision.inputs import Operator
from fledge.supervision.modes import Mode
from fledge.supervision.supervisor import Supervisor
from fledge.world import Arena, UavState, UgvState, WorldState

P, M = Phase, Mode
STILL = Vec3(0.0, 0.0, 0.0)
WORLD = WorldState(
    0.0,
    UavState(STILL, STILL, Quat(1.0, 0.0, 0.0, 0.0), STILL, 0.0),
    (UgvState(1.0, 0.0, 0.0, 0.0, 0.0, 0.0),),
)
FRESH = Supervisor().init(Arena.square(), WORLD)
ARMED = (Operator(arm=1.0, stop=1.0), Operator(arm=1.0))
HEARD = Holding(ARMED, heard=3.0)
NOBODY = Holding((Operator(), Operator()))


def modes(uav, ugv=M.READY):
    """What a supervisor remembers that is in these modes."""
    return FRESH._replace(
        posts=tuple(post._replace(mode=m) for post, m in zip(FRESH.posts, (uav, ugv), strict=True))
    )


def says(arming=Arming(), holding=HEARD, cleared=True, phase=P.WAIT, mode=M.READY, ugv=M.READY):
    return arming.operators(holding, cleared, phase, modes(mode, ugv), 5.0)


def test_what_people_say_is_passed_on_with_when_they_said_it():
    assert says(Arming(ugvs=True)) == (ARMED, 3.0)


def test_over_ugvs_that_are_not_ours_nobody_has_a_say():
    assert says()[0] == (ARMED[0], Operator())


def test_arming_counts_once_it_was_seen_unset_while_nothing_was_missing():
    cleared, trail = False, []
    unarmed = Holding((Operator(), Operator()), 3.0)
    for complaint, holding in [
        ("", HEARD),  # it was set before anything
        ("something", unarmed),
        ("something", HEARD),
        ("", HEARD),  # set while something was missing
        ("", unarmed),
        ("", HEARD),
        ("something", HEARD),
        ("", HEARD),
    ]:
        cleared = Arming().cleared(cleared, complaint, holding)
        trail.append(cleared)
    assert trail == [False, False, False, False, True, True, False, False]


@pytest.mark.parametrize("phase", list(P))
def test_on_the_ground_only_does_it_matter_whether_arming_counts(phase):
    uav, ugv = says(Arming(ugvs=True), cleared=False, phase=phase, mode=M.LAND)[0]
    counts = phase not in (P.WAIT, P.OVER)
    assert uav == replace(ARMED[0], arm=float(counts))
    assert ugv == Operator(arm=float(counts))


@pytest.mark.parametrize("mode", M)
def test_a_flight_that_is_to_land_is_told_so_until_it_does(mode):
    uav, _ = says(phase=P.LAND, mode=mode)[0]
    assert uav.land == float(mode is not M.LAND)
    assert says(phase=P.FLY, mode=mode)[0][0].land == 0.0


@pytest.mark.parametrize(("mode", "ugv"), [(M.INIT, M.READY), (M.READY, M.INIT), (M.READY, M.READY)])
def test_where_nobody_attends_arming_waits_until_everybody_is_ready(mode, ugv):
    arming = Arming(unattended=True, ugvs=True)
    operators, heard = says(arming, NOBODY, mode=mode, ugv=ugv)
    assert operators == (Operator(arm=float(M.INIT not in (mode, ugv))),) * 2
    assert heard == 5.0


def test_where_nobody_attends_it_is_armed_for_as_long_as_the_flight_lasts_and_no_longer():
    arming = Arming(unattended=True)
    assert says(arming, NOBODY, phase=P.FLY, mode=M.INIT)[0][0].arm == 1.0
    assert says(arming, NOBODY, phase=P.OVER)[0][0].arm == 0.0
    assert says(arming, NOBODY, cleared=False)[0][0].arm == 0.0


def test_where_somebody_must_attend_silence_is_silence():
    assert says(holding=NOBODY) == ((Operator(), Operator()), -inf)


def test_who_speaks_attends():
    assert says(Arming(unattended=True, ugvs=True)) == (ARMED, 3.0)
