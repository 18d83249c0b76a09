"""Navdata: to whom, when, how many, and what they say."""

from math import pi

import pytest

from fledge.geometry import Vec3
from fledge.lab.twin.firmware import Firmware, Phase
from fledge.lab.twin.senses import Sensed
from fledge.lab.twin.telemetry import Memory, Telemetry
from fledge.lab.wire import navdata
from fledge.lab.wire.ardrone import Pcmd, Ref
from fledge.lab.wire.navdata import ControlState, State

T = Telemetry()
ASKED = Memory(asked=True)
SENSED = Sensed(0.1, -0.2, Vec3(0.0, 0.0, 0.0), 0.3, -0.4, 0.5, 1.25, 3.5, 0.97)
ON_FLOOR = Firmware().init(0.0)._replace(demo=True)
IN_AIR = Firmware().aloft(0.0)._replace(demo=True)


def said(knows, seconds=1.0, silent=False, memory=ASKED, step=0.005):
    """Everything that was sent in a while, decoded."""
    found = []
    for i in range(round(seconds / step)):
        memory, data = T.say(memory, i * step, knows, SENSED, silent)
        if data is not None:
            found.append(navdata.decode(data))
    return found


def test_nobody_asked_nobody_is_told():
    assert said(ON_FLOOR, memory=Memory()) == []


@pytest.mark.parametrize(("demo", "count"), ((None, 15), (True, 15), (False, 200)))
def test_so_many_a_second(demo, count):
    assert len(said(ON_FLOOR._replace(demo=demo))) == count


def test_numbers_count_on():
    numbers = [one.sequence for one in said(IN_AIR, seconds=2.0)]
    assert numbers == list(range(1, len(numbers) + 1))


def test_before_the_configuration_there_is_nothing_but_the_state():
    memory, data = T.say(ASKED, 0.0, ON_FLOOR._replace(demo=None), SENSED, True)
    assert len(data) == 24
    told = navdata.decode(data)
    assert told.demo is None and State.BOOTSTRAP in told.state


def test_what_is_sensed_arrives_in_the_lab_s_frame():
    demo = said(IN_AIR)[0].demo
    assert (demo.roll, demo.pitch, demo.altitude) == pytest.approx((0.1, -0.2, 1.25), abs=1e-3)
    v = demo.velocity
    assert (v.x, v.y, v.z) == pytest.approx((0.3, -0.4, 0.5), abs=1e-3)
    assert demo.yaw == pytest.approx(3.5 - 2.0 * pi, abs=1e-5)


@pytest.mark.parametrize(
    ("knows", "state"),
    (
        (ON_FLOOR, ControlState.LANDED),
        (ON_FLOOR._replace(phase=Phase.SPINNING), ControlState.TAKING_OFF),
        (ON_FLOOR._replace(phase=Phase.TAKING_OFF), ControlState.TAKING_OFF),
        (IN_AIR, ControlState.HOVERING),
        (IN_AIR._replace(pcmd=Pcmd(0.0, 0.1, 0.0, 0.0)), ControlState.FLYING),
        (IN_AIR._replace(phase=Phase.LANDING), ControlState.LANDING),
        (IN_AIR._replace(phase=Phase.EMERGENCY), ControlState.DEFAULT),
    ),
)
def test_the_control_state_is_that_of_the_phase(knows, state):
    assert said(knows)[0].demo.control == state


def test_in_a_silence_it_hovers_whatever_it_was_told_last():
    knows = IN_AIR._replace(pcmd=Pcmd(0.0, 0.1, 0.0, 0.0))
    assert said(knows, silent=True)[0].demo.control == ControlState.HOVERING


@pytest.mark.parametrize(
    ("knows", "bit"),
    (
        (IN_AIR, State.FLYING),
        (IN_AIR._replace(ack=True), State.COMMAND_ACK),
        (IN_AIR, State.NAVDATA_DEMO),
        (IN_AIR._replace(demo=None), State.BOOTSTRAP),
        (IN_AIR._replace(lost=True), State.COM_LOST),
        (IN_AIR._replace(battery=0.19), State.BATTERY_LOW),
        (IN_AIR._replace(watchdog=True), State.COM_WATCHDOG),
        (IN_AIR._replace(phase=Phase.EMERGENCY), State.EMERGENCY),
        (IN_AIR._replace(phase=Phase.EMERGENCY, ref=Ref(False, True)), State.USER_EMERGENCY),
        (IN_AIR._replace(phase=Phase.EMERGENCY, tumbled=True), State.ANGLES_OUT_OF_RANGE),
    ),
)
def test_every_bit_says_one_thing(knows, bit):
    assert bit in said(knows)[0].state
    assert bit not in said(ON_FLOOR._replace(demo=False, watchdog=False))[0].state


def test_a_delay_is_not_made_up_for():
    memory, data = T.say(ASKED, 5.0, IN_AIR, SENSED, False)
    assert data is not None
    assert T.say(memory, 5.01, IN_AIR, SENSED, False)[1] is None
