"""What comes in during one tick."""

from dataclasses import fields, replace
from math import inf, nan

import numpy as np
import pytest

from fledge.geometry import Quat, Vec3
from fledge.supervision.inputs import HOVER, Inputs, Operator, finite, said, sane
from fledge.world import Commands, UavState, UgvState, VelocityCommand, WorldState

FLAGS = [field.name for field in fields(Operator) if field.name not in ("command", "deflection")]


def world(t) -> WorldState:
    still = Vec3(0.0, 0.0, 0.0)
    uav = UavState(Vec3(0.0, 0.0, 2.0), still, Quat(1.0, 0.0, 0.0, 0.0), still, t)
    return WorldState(t, uav, (UgvState(1.0, 0.0, 0.0, 0.0, 0.0, t),) * 2)


@pytest.mark.parametrize(
    "flag, meant",
    (
        (0.0, False),
        (1.0, True),
        (False, False),
        (True, True),
        (nan, False),
        (inf, False),
        (-inf, False),
        (0.5, False),
    ),
)
def test_a_flag_is_set_above_one_half(flag, meant):
    assert said(flag) is meant
    assert said(np.array([flag]))[0] == meant


@pytest.mark.parametrize("bad", (nan, inf, -inf))
@pytest.mark.parametrize("axis", [field.name for field in fields(VelocityCommand)])
def test_a_command_is_finite_if_all_of_it_is(axis, bad):
    command = VelocityCommand(1.0, -2.0, 3.0, -4.0)
    assert finite(command)
    assert not finite(replace(command, **{axis: bad}))
    assert not sane(Operator(replace(command, **{axis: bad})))


@pytest.mark.parametrize("bad", (nan, inf, -inf))
@pytest.mark.parametrize("name", ("deflection", *FLAGS))
def test_one_broken_field_breaks_what_an_operator_says(name, bad):
    assert sane(Operator()) and sane(Operator(**{flag: True for flag in FLAGS}))
    assert not sane(replace(Operator(), **{name: bad}))


def test_infinities_do_not_cancel():
    assert not finite(VelocityCommand(inf, -inf, 0.0, 0.0))
    assert not sane(Operator(switch=inf, stop=-inf))


def test_an_unattended_flight_lacks_nothing():
    proposed = Commands(VelocityCommand(0.1, 0.0, 0.0, 0.0), (HOVER, HOVER))
    begin, later = Inputs.unattended(world(0.0), proposed), Inputs.unattended(world(3.0), proposed)
    assert [said(o.arm) for o in begin.operators] == [False] * 3, "what is armed too early never flies"
    assert [said(o.arm) for o in later.operators] == [True] * 3
    for inputs, t in ((begin, 0.0), (later, 3.0)):
        assert inputs.proposed == proposed
        assert inputs.decided == inputs.heard == inputs.seen.t == t
        assert inputs.batteries == (1.0,) * 3 and said(inputs.airborne)
        assert all(replace(o, arm=0.0) == Operator() for o in inputs.operators)
