"""Whom motion capture sees, over either wire."""

import pytest

from fledge.geometry import Quat, Vec3
from fledge.lab.control.estimator import Pose
from fledge.lab.control.eyes import FORGOTTEN, TopicEyes, ViconEyes
from fledge.lab.wire import topics, vicon
from fledge.lab.wire.datagrams import NAVDATA, VICON, Datagram
from fledge.lab.wire.messages import Header, TransformStamped
from fledge.lab.wire.vicon import Frame, Object

NAMES = ("ardrone", "p3at", "p3dx1")
EYES = ViconEyes(NAMES)
TOPICS = TopicEyes(NAMES)
TURNED = Quat.from_yaw(0.5)


def body(name, x) -> Object:
    return Object(name, Vec3(x, 0.0, 1.0), Vec3(0.0, 0.0, 0.5))


def frame(number, *objects) -> Datagram:
    return Datagram(VICON, vicon.encode(Frame(number, objects)))


def transform(name, x, stamp, place=None) -> Datagram:
    message = TransformStamped(Header.at(stamp, "world"), name, Vec3(x, 0.0, 1.0), TURNED)
    return Datagram(place or topics.pose(name), topics.encode(message))


def test_a_frame_is_everybody_in_the_vehicles_order_at_one_stamp():
    objects = [body("wand", 9.0), *(body(name, float(i)) for i, name in reversed(list(enumerate(NAMES))))]
    view, poses = EYES.look(EYES.init(), 5.0, frame(1, *objects))
    assert [who for who, _ in poses] == [0, 1, 2]
    assert [pose.position.x for _, pose in poses] == pytest.approx([0.0, 1.0, 2.0])
    assert {pose.stamp for _, pose in poses} == {5.0 - EYES.clock.least}
    q = poses[0][1].attitude
    assert (q.w, q.z) == pytest.approx((TURNED.w, TURNED.z))
    assert set(view.lately(5.0)) == {"wand", *NAMES}


def test_who_is_lost_has_no_pose_and_after_a_while_no_name():
    view, _ = EYES.look(EYES.init(), 5.0, frame(1, *(body(name, 1.0) for name in NAMES)))
    view, poses = EYES.look(view, 5.01, frame(2, body("p3at", 1.0)))
    assert [who for who, _ in poses] == [1]
    assert set(view.lately(5.01)) == set(NAMES)
    assert view.lately(5.005 + FORGOTTEN) == ("p3at",)
    assert view.lately(5.02 + FORGOTTEN) == ()
    view, _ = EYES.look(view, 9.0, frame(400, body("p3dx1", 1.0)))
    assert [name for name, _ in view.names] == ["p3dx1"]


def test_stamps_follow_frame_numbers_however_late_a_datagram_is():
    view, _ = EYES.look(EYES.init(), 5.0, frame(100, body("p3at", 1.0)))
    view, poses = EYES.look(view, 5.21, frame(101, body("p3at", 1.0)))
    assert poses[0][1].stamp == pytest.approx(5.01 - EYES.clock.least, abs=1e-4)


def test_what_is_no_frame_is_said_and_changes_nothing_else():
    before, _ = EYES.look(EYES.init(), 5.0, frame(1, body("p3at", 1.0)))
    after, poses = EYES.look(before, 5.5, Datagram(VICON, b"\x01"))
    assert poses == () and "bytes" in after.trouble
    assert after._replace(trouble="") == before
    after, _ = EYES.look(after, 5.51, frame(2, body("p3at", 1.0)))
    assert after.trouble == ""


def test_other_wires_show_nothing():
    for eyes in (EYES, TOPICS):
        data = frame(1, body("p3at", 1.0)).data
        assert eyes.look(eyes.init(), 5.0, Datagram(NAVDATA, data)) == (eyes.init(), ())
    assert EYES.look(EYES.init(), 5.0, transform("p3at", 1.0, 1.7e9)) == (EYES.init(), ())
    assert TOPICS.look(TOPICS.init(), 5.0, frame(1, body("p3at", 1.0))) == (TOPICS.init(), ())


def test_over_topics_everybody_comes_alone_stamped_by_the_sender():
    view, seen = TOPICS.init(), {}
    for i in range(10):
        for k, name in enumerate(NAMES):
            datagram = transform(name, float(k), 1.7e9 + 0.01 * i)
            view, poses = TOPICS.look(view, 5.0 + 0.01 * i + 0.001 * k, datagram)
            seen |= dict(poses)
    assert sorted(seen) == [0, 1, 2]
    assert seen[2] == Pose(pytest.approx(5.09 - TOPICS.clock.least, abs=1e-4), Vec3(2.0, 0.0, 1.0), TURNED)
    assert len({round(pose.stamp, 4) for pose in seen.values()}) == 1
    assert set(view.lately(5.1)) == set(NAMES)


def test_topics_of_others_and_messages_that_are_none_show_nothing():
    assert TOPICS.look(TOPICS.init(), 5.0, transform("wand", 1.0, 1.7e9))[1] == ()
    view, poses = TOPICS.look(TOPICS.init(), 5.0, Datagram(topics.pose("p3at"), b"short"))
    assert poses == () and view.trouble
    assert view.lately(5.0) == ()
