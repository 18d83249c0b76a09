"""The drivers between the twin and ROS topics: orders become AT commands, what the vehicles say becomes messages."""

from math import inf, pi

import pytest

from fledge.geometry import Quat, Vec3
from fledge.lab.twin.bridge import HEARD, Bridge, Memory, Told
from fledge.lab.twin.cameras import SUBJECTS, Shot
from fledge.lab.twin.drivers import Memory as Robot
from fledge.lab.wire import ardrone, navdata, topics
from fledge.lab.wire.ardrone import Comwdg, Config, Ctrl, Flag, Line, Mode, Pcmd, Ref
from fledge.lab.wire.datagrams import AT, Datagram
from fledge.lab.wire.messages import Empty, Navdata, Odometry, TransformStamped, Twist
from fledge.lab.wire.navdata import ControlState, Demo, State
from fledge.lab.wire.vicon import Frame, Object

EVENT = topics.encode(Empty())
DEMO = Demo(ControlState.FLYING, 0.5, 0.1, 0.2, 0.3, 1.5, Vec3(0.4, -0.2, 0.1))


def twist(x=0.0, y=0.0, z=0.0, turn=0.0, roll=0.0):
    return topics.encode(Twist(Vec3(x, y, z), Vec3(roll, 0.0, turn)))


def orders(bridge, memory, t, *said):
    """(memory, the AT commands by their kind, what UGVs are told)."""
    memory, sent, robots = bridge.hear(memory, t, [Datagram(*one) for one in said])
    lines = [line for one in sent if one.channel == AT for line in ardrone.decode(one.data)]
    assert all(isinstance(line, Line) for line in lines)
    return memory, {type(line.command): line.command for line in lines}, robots


def seen(state=State(0), demo=DEMO):
    return Memory(seen=navdata.Navdata(1, state, demo))


def test_events_become_refs():
    memory, said, _ = orders(Bridge(), Memory(), 0.0)
    assert said[Ref] == Ref(fly=False)
    memory, said, _ = orders(Bridge(), memory, 0.02, (topics.TAKE_OFF, EVENT))
    assert said[Ref] == Ref(fly=True)
    memory, said, _ = orders(Bridge(), memory, 0.04)
    assert said[Ref] == Ref(fly=True)  # and stay so
    memory, said, _ = orders(Bridge(), memory, 0.06, (topics.LAND, EVENT))
    assert said[Ref] == Ref(fly=False)


def test_a_reset_is_pressed_once_and_let_go():
    memory, said, _ = orders(Bridge(), Memory(fly=True), 0.0, (topics.RESET, EVENT))
    assert said[Ref] == Ref(fly=False, emergency=True)
    _, said, _ = orders(Bridge(), memory, 0.02)
    assert said[Ref] == Ref(fly=False, emergency=False)


def test_a_reset_between_two_datagrams_is_not_lost():
    memory, _, _ = orders(Bridge(), Memory(), 0.0)
    memory, said, _ = orders(Bridge(), memory, 0.01, (topics.RESET, EVENT))
    assert said == {}
    assert orders(Bridge(), memory, 0.02)[1][Ref].emergency


def test_shares_are_those_of_ardrone_autonomy():
    # x forward, y left, z up, counter-clockwise; on the wire right, back, up, clockwise
    _, said, _ = orders(Bridge(), Memory(), 0.0, (topics.FLY, twist(0.5, 0.25, -0.75, 1.0)))
    assert said[Pcmd] == Pcmd(-0.25, -0.5, -0.75, -1.0, Flag.PROGRESSIVE)


def test_shares_have_a_stop():
    _, said, _ = orders(Bridge(), Memory(), 0.0, (topics.FLY, twist(5.0, -9.0, 2.0, -3.0)))
    assert said[Pcmd] == Pcmd(1.0, -1.0, 1.0, 1.0, Flag.PROGRESSIVE)


def test_six_zeros_are_the_drones_own_hover_and_others_are_not():
    assert orders(Bridge(), Memory(), 0.0, (topics.FLY, twist()))[1][Pcmd] == Pcmd.hover()
    level = orders(Bridge(), Memory(), 0.0, (topics.FLY, twist(roll=1.0)))[1][Pcmd]
    assert level == Pcmd(0.0, 0.0, 0.0, 0.0, Flag.PROGRESSIVE)


def test_a_velocity_becomes_a_tilt_that_lessens_as_it_is_reached():
    bridge = Bridge(velocity=True)
    faster = orders(bridge, seen(), 0.0, (topics.FLY, twist(0.6, -0.2, 0.35, 0.875)))[1][Pcmd]
    assert faster.pitch < 0.0 and faster.roll == 0.0  # nose down; aside it is as fast as it should be
    assert (faster.gaz, faster.yaw) == pytest.approx((0.5, -0.5))
    slower = orders(bridge, seen(), 0.0, (topics.FLY, twist(0.2, -0.2)))[1][Pcmd]
    assert slower.pitch > 0.0


def test_a_twist_holds_for_a_while_then_it_hovers_then_it_lands():
    bridge = Bridge()
    memory, *_ = orders(bridge, Memory(fly=True), 0.0, (topics.FLY, twist(0.5)))
    assert orders(bridge, memory, 0.14)[1][Pcmd].pitch == -0.5
    memory, said, _ = orders(bridge, memory, 0.17)
    assert said[Pcmd] == Pcmd.hover() and said[Ref].fly
    memory, said, _ = orders(bridge, memory, 1.9)
    assert said[Ref].fly
    assert not orders(bridge, memory, 2.1)[1][Ref].fly


def test_who_left_it_hovering_may_be_silent():
    memory, *_ = orders(Bridge(), Memory(fly=True), 0.0, (topics.FLY, twist()))
    assert orders(Bridge(), memory, 60.0)[1][Ref].fly
    never = Memory(fly=True)
    assert orders(Bridge(), never, 60.0)[1] == orders(Bridge(), never, 0.0)[1]


def test_before_a_new_take_off_the_last_flights_twist_is_forgotten():
    memory, *_ = orders(Bridge(), Memory(fly=True), 0.0, (topics.FLY, twist(0.5)))
    memory, *_ = orders(Bridge(), memory, 0.02, (topics.LAND, EVENT))
    memory, said, _ = orders(Bridge(), memory, 0.04, (topics.TAKE_OFF, EVENT))
    assert said[Pcmd] == Pcmd.hover() and memory.heard == inf


def test_the_protocol_is_kept_up():
    assert orders(Bridge(), Memory(), 0.0)[1][Config] == Config("general:navdata_demo", "FALSE")
    quiet = orders(Bridge(), seen(), 0.0)[1]
    assert set(quiet) == {Ref, Pcmd}
    busy = orders(Bridge(), seen(State.COMMAND_ACK | State.COM_WATCHDOG), 0.0)[1]
    assert busy[Ctrl] == Ctrl(Mode.CLEAR_ACKNOWLEDGEMENT) and Comwdg in busy


def test_lines_are_numbered_on_and_sent_fifty_times_a_second():
    memory, numbers, datagrams = Memory(), [], 0
    for i in range(100):
        memory, sent, _ = Bridge().hear(memory, 0.01 * i, ())
        for one in sent:
            if one.channel == AT:
                numbers += [line.sequence for line in ardrone.decode(one.data)]
                datagrams += 1
    assert numbers == list(range(1, len(numbers) + 1))
    assert datagrams == 50


def test_robots_are_told_by_their_own_topics():
    said = (topics.drive("p3dx1"), twist(0.3, turn=-0.5)), (topics.drive("p3at"), twist(-0.1))
    _, _, robots = orders(Bridge(), Memory(), 0.0, *said)
    assert robots == (Told(1, 0.3, -0.5), Told(0, -0.1, 0.0))


@pytest.mark.parametrize("topic", HEARD)
@pytest.mark.parametrize("data", (b"", b"\xff" * 48, b"\0" * 47))
def test_rubbish_moves_nobody(topic, data):
    before = Memory(fly=True)
    memory, said, robots = orders(Bridge(), before, 0.0, (topic, data))
    if topic in (topics.TAKE_OFF, topics.LAND, topics.RESET) and data == b"":
        return  # that is the event itself
    assert robots == () and said[Pcmd] == Pcmd.hover() and memory.fly


@pytest.mark.parametrize("channel", ("vicon", "at", "navdata", "sticks", "/nobody/cmd_vel", "/joy"))
def test_other_channels_are_none_of_its_business(channel):
    _, said, robots = orders(Bridge(), Memory(), 0.0, (channel, twist(1.0)))
    assert robots == () and said[Pcmd] == Pcmd.hover()


def messages(bridge=Bridge(), memory=Memory(), t=1.0, epoch=1e9, shots=(), told=(), robots=(Robot(),) * 3):
    memory, said = bridge.say(memory, t, epoch, shots, told, robots)
    return memory, [(one.channel, topics.decode(one.channel, one.data)) for one in said]


def test_a_frame_becomes_a_pose_on_every_subjects_topic():
    places = {name: Vec3(0.1 * i, 0.2, 0.3) for i, name in enumerate(SUBJECTS)}
    frame = Frame(42, tuple(Object(name, place, Vec3(0.0, 0.0, pi / 2)) for name, place in places.items()))
    _, said = messages(shots=(Shot(0.994, frame),), memory=Memory(odometry=9.0))
    assert [topic for topic, _ in said] == [topics.pose(name) for name in SUBJECTS]
    for (_, message), (name, place) in zip(said, places.items(), strict=True):
        assert isinstance(message, TransformStamped)
        assert message.child == f"vicon/{name}/{name}" and message.header.number == 42
        assert message.header.stamp == pytest.approx(1e9 + 0.994, abs=1e-6)
        assert message.translation == place
        assert message.rotation.z == pytest.approx(Quat.from_yaw(pi / 2).z)


def test_navdata_are_passed_on_fifty_times_a_second():
    data, memory, passed = navdata.encode(navdata.Navdata(1, State(0), DEMO)), Memory(odometry=99.0), []
    for i in range(100):
        memory, said = messages(memory=memory, t=0.01 * i, told=(data, data))
        passed += said
    assert len(passed) == 50
    topic, message = passed[0]
    assert topic == topics.NAVDATA and isinstance(message, Navdata)
    assert message.demo.altitude == pytest.approx(1.5) and message.demo.control == ControlState.FLYING
    assert memory.seen.demo is not None


def test_robots_tell_where_they_think_they_are():
    robot = Robot(speed=0.3, turn=-0.2, odometry=(1.0, 2.0, pi / 2))
    memory, said = messages(robots=(robot,) * 3, memory=Memory(odometry=1.0))
    assert [topic for topic, _ in said] == [topics.odometry(name) for name in SUBJECTS[1:]]
    _, message = said[0]
    assert isinstance(message, Odometry)
    assert message.position == Vec3(1.0, 2.0, 0.0)
    assert (message.linear.x, message.angular.z) == (0.3, -0.2)
    assert message.attitude.z == pytest.approx(Quat.from_yaw(pi / 2).z)
    assert messages(memory=memory, t=1.05)[1] == []
    assert len(messages(memory=memory, t=1.1)[1]) == 3


def test_nothing_is_stamped_before_time_began():
    _, said = messages(t=0.0, epoch=-0.01)
    assert said[0][1].header.stamp == 0.0
