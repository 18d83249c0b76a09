"""What a UAV says of itself, whatever the wire."""

from dataclasses import replace

import pytest

from fledge.lab.control.vehicle import ALOFT, STEADY, Orders, Report
from fledge.lab.wire.ardrone import Pcmd
from fledge.lab.wire.navdata import ControlState
from fledge.world import VelocityCommand


def test_who_has_said_nothing_is_neither_in_the_air_nor_ready():
    report = Report()
    assert not (report.aloft or report.steady or report.configured)
    assert not report.battery >= 0.0


@pytest.mark.parametrize("control", ControlState)
def test_who_obeys_is_in_the_air_and_who_has_no_motors_is_not(control):
    report = Report(1.0, control)
    assert report.steady <= report.aloft
    assert report.steady == (control in STEADY)
    assert report.aloft == (control in ALOFT)
    dead = report._replace(emergency=True)
    assert not (dead.aloft or dead.steady)


def test_on_the_ground_nobody_is_in_the_air():
    assert not {ControlState.DEFAULT, ControlState.INIT, ControlState.LANDED} & {*ALOFT}


def test_no_orders_are_to_stay_on_the_ground():
    orders = Orders()
    assert not (orders.fly or orders.cut or orders.trim or orders.revive)
    assert (orders.velocity, orders.tilt, orders.ugvs) == (VelocityCommand.hover(), Pcmd.hover(), ())
    assert replace(Pcmd.hover()) == orders.tilt
