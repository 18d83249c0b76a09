"""What a lab flight tells of its vehicles, as arrays."""

import numpy as np
import pytest
from ticks import HOVER, decision, said, world

from fledge.geometry import Vec3
from fledge.lab.control.phases import Phase
from fledge.lab.survey.traces import trace
from fledge.lab.wire import ardrone, topics
from fledge.lab.wire.ardrone import Pcmd, Ref
from fledge.lab.wire.datagrams import AT, NAVDATA, Datagram
from fledge.lab.wire.messages import Twist
from fledge.world import VelocityCommand

GOING = VelocityCommand(0.5, -0.25, 0.1, 0.0)


def at(pcmd):
    return Datagram(AT, ardrone.encode(7, Ref(fly=True), pcmd))


def flown(phase=Phase.FLY, datagrams=(), **more):
    ticks = [(0.01 * k, said(0.01 * k, decision(command=GOING), phase, (), datagrams)) for k in range(5)]
    return trace(ticks, **({"ours": False} | more))


def test_every_tick_has_a_row():
    found = flown()
    seen = world().uav.position
    assert found.t.tolist() == pytest.approx([0.0, 0.01, 0.02, 0.03, 0.04])
    assert found.position.shape == (5, 3) and found.attitude.shape == (5, 4) and found.tilt.shape == (5, 2)
    assert found.position[0].tolist() == [seen.x, seen.y, seen.z]
    assert found.told[2].tolist() == [0.5, -0.25, 0.1, 0.0]
    assert len(found.ugvs) == 3 and found.ugvs[1].x.tolist() == [world().ugvs[1].x] * 5


@pytest.mark.parametrize("phase", [Phase.WAIT, Phase.TAKE_OFF, Phase.LAND, Phase.OVER])
def test_what_was_not_obeyed_was_not_told(phase):
    found = flown(phase, [at(Pcmd(0.1, 0.2, 0.0, 0.0))])
    assert np.isnan(found.told).all() and np.isnan(found.tilt).all()


def test_the_tilt_is_what_the_wire_said_either_wire():
    bytes_ = [Datagram(NAVDATA, b"x"), at(Pcmd(roll=-0.5, pitch=-0.25, gaz=0.0, yaw=0.0))]
    assert flown(datagrams=bytes_).tilt[0].tolist() == pytest.approx([0.25, 0.5])
    twist = Twist(Vec3(0.25, 0.5, 0.0), Vec3(0.0, 0.0, 0.0))
    over_ros = [Datagram(topics.FLY, topics.encode(twist))]
    assert flown(datagrams=over_ros).tilt[0].tolist() == pytest.approx([0.25, 0.5])
    assert np.isnan(flown(datagrams=over_ros, shares=False).tilt).all(), "a velocity is no tilt"


def test_hovering_by_itself_is_no_tilt():
    assert np.isnan(flown(datagrams=[at(Pcmd.hover())]).tilt).all()


def test_ugvs_were_told_only_if_they_are_ours():
    assert np.isnan(flown().ugvs[0].told_speed).all()
    assert flown(ours=True).ugvs[0].told_speed.tolist() == [HOVER.forward] * 5


def test_before_everybody_was_seen_there_is_nothing():
    blind = said(0.0)
    nobody = type(blind)((), Phase.WAIT)
    assert len(trace([(0.0, nobody), (0.01, said(0.01))], ours=False).t) == 1
