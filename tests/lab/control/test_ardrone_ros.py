"""What an AR.Drone and the UGVs are told over ROS, under both drivers."""

import pytest

from fledge.geometry import Vec3
from fledge.lab.control.ardrone_ros import AGAIN, RESET_AGAIN, ArDroneRos, Meaning
from fledge.lab.control.vehicle import Orders
from fledge.lab.wire import topics
from fledge.lab.wire.ardrone import Pcmd
from fledge.lab.wire.datagrams import Datagram
from fledge.lab.wire.messages import Empty, Header, Navdata, Twist
from fledge.lab.wire.navdata import ControlState, Demo
from fledge.world import VelocityCommand

TICK = 0.01
ROS = ArDroneRos(("p3at", "p3dx1"))
C = ControlState
FLYING = Orders(
    fly=True,
    velocity=VelocityCommand(0.4, -0.2, 0.1, 0.3),
    tilt=Pcmd(roll=0.25, pitch=-0.5, gaz=0.125, yaw=-0.75),
    ugvs=(VelocityCommand(0.3, 0.0, 0.0, 0.6), VelocityCommand.hover()),
)


def says(control, battery=0.8) -> Datagram:
    demo = Demo(control, battery, 0.0, 0.0, 0.0, 0.0, Vec3(0.0, 0.0, 0.0))
    return Datagram(topics.NAVDATA, topics.encode(Navdata(Header(), demo)))


def said(ros=ROS, orders=FLYING, control=C.HOVERING):
    """What goes over each topic in the first tick after the drone has spoken, decoded."""
    _, datagrams = ros.say(ros.hear(ros.init(), 0.0, says(control)), TICK, orders)
    return {one.channel: topics.decode(one.channel, one.data) for one in datagrams}


def events(orders, controls, ros=ROS):
    """When which event was sent, if the drone is found in these states tick by tick."""
    memory, found = ros.init(), []
    for i, control in enumerate(controls):
        t = round(i * TICK, 9)
        memory = ros.hear(memory, t, says(control))
        memory, datagrams = ros.say(memory, t, orders(i) if callable(orders) else orders)
        found += [
            (t, one.channel) for one in datagrams if isinstance(topics.decode(one.channel, one.data), Empty)
        ]
    return found


def test_under_ardrone_autonomy_the_twist_is_shares_with_the_signs_of_ros():
    twist = said()[topics.FLY]
    assert twist.linear == Vec3(0.5, -0.25, 0.125)
    assert twist.angular.z == 0.75


def test_six_zeros_are_hover_and_a_level_tilt_is_never_taken_for_it():
    hover = said(orders=Orders(fly=True))[topics.FLY]
    assert hover == Twist(Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.0))
    level = said(orders=Orders(fly=True, tilt=Pcmd(0.0, 0.0, 0.0, 0.0)))[topics.FLY]
    assert level != hover
    assert (level.linear, level.angular.z) == (hover.linear, 0.0)


def test_under_tum_simulator_the_twist_is_the_velocity():
    twist = said(ArDroneRos(meaning=Meaning.VELOCITY))[topics.FLY]
    assert twist == Twist(Vec3(0.4, -0.2, 0.1), Vec3(0.0, 0.0, 0.3))


def test_every_ugv_is_told_over_a_topic_of_its_own_if_it_is_ours_to_tell():
    told = said()
    assert told[topics.drive("p3at")] == Twist(Vec3(0.3, 0.0, 0.0), Vec3(0.0, 0.0, 0.6))
    assert told[topics.drive("p3dx1")] == Twist(Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.0))
    assert set(said(orders=Orders(fly=True))) == {topics.FLY}


def test_take_off_and_landing_are_said_until_they_are_heeded():
    lifts = events(FLYING, [C.LANDED] * 120 + [C.TAKING_OFF] * 100 + [C.HOVERING] * 100)
    assert [topic for _, topic in lifts] == [topics.TAKE_OFF] * 3
    assert lifts[1][0] - lifts[0][0] == pytest.approx(AGAIN)
    # Coming down it is still in the air, and told until it stands.
    landings = events(Orders(), [C.HOVERING] * 60 + [C.LANDING] * 60 + [C.LANDED] * 100)
    assert {topic for _, topic in landings} == {topics.LAND}
    assert landings[0][0] == 0.0 and landings[-1][0] < 1.2


def test_who_changes_their_mind_is_heard_at_once():
    found = events(lambda i: FLYING if i < 10 else Orders(), [C.LANDED] * 2 + [C.TAKING_OFF] * 20)
    assert found == [(0.0, topics.TAKE_OFF), (0.1, topics.LAND)]


def test_who_stands_on_the_ground_is_not_told_to_land_but_who_has_not_said_so_is():
    assert events(Orders(), [C.LANDED] * 300) == []
    _, datagrams = ROS.say(ROS.init(), 0.0, Orders())
    assert [one.channel for one in datagrams] == [topics.LAND, topics.FLY]


def test_to_cut_and_to_revive_are_a_reset_each_until_they_are_heeded():
    cuts = events(Orders(cut=True), [C.HOVERING] * 150 + [C.DEFAULT] * 300)
    assert cuts == [(0.0, topics.RESET), (RESET_AGAIN, topics.RESET)]
    revivals = events(Orders(revive=True), [C.DEFAULT] * 50 + [C.LANDED] * 300)
    assert revivals == [(0.0, topics.RESET)]


def test_what_it_says_of_itself_is_reported():
    memory = ROS.hear(ROS.init(), 2.0, says(C.HOVERING, 0.42))
    report = memory.report
    assert (report.heard, report.control, report.battery) == (2.0, C.HOVERING, 0.42)
    assert report.steady and report.configured and not report.emergency
    assert ROS.hear(memory, 3.0, says(C.DEFAULT)).report.emergency
    assert ROS.hear(memory, 3.0, Datagram(topics.NAVDATA, b"short")) == memory
    assert ROS.hear(memory, 3.0, Datagram("navdata", says(C.LANDED).data)) == memory
