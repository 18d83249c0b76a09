"""A script that knows rospy and nothing of fledge sees and steers the twin, through a real master."""

import json
import os
import subprocess
import sys
from math import hypot

import debian
import pytest

SCRIPT = """
import json, time
import rospy
from geometry_msgs.msg import TransformStamped, Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import Empty

rospy.init_node("somebody", anonymous=True)
poses, ages, odometry = [], [], []

def seen(message):
    p = message.transform.translation
    ages.append(rospy.get_time() - message.header.stamp.to_sec())
    poses.append((time.monotonic(), p.x, p.y, p.z))

rospy.Subscriber("/vicon/ardrone/ardrone", TransformStamped, seen, queue_size=100)
rospy.Subscriber("/p3dx1/odom", Odometry, lambda m: odometry.append(m.twist.twist.linear.x), queue_size=100)
take_off = rospy.Publisher("/ardrone/takeoff", Empty, queue_size=1)
land = rospy.Publisher("/ardrone/land", Empty, queue_size=1)
fly = rospy.Publisher("/cmd_vel", Twist, queue_size=1)
drive = rospy.Publisher("/p3dx1/cmd_vel", Twist, queue_size=1)
while not poses or min(p.get_num_connections() for p in (take_off, land, fly, drive)) < 1:
    time.sleep(0.02)

marks = {}
def mark(name):
    marks[name] = poses[-1]

def go_on(seconds, publisher=None, **linear):
    ends = time.monotonic() + seconds
    while time.monotonic() < ends:
        if publisher:
            message = Twist()
            for axis, value in linear.items():
                setattr(message.linear, axis, value)
            publisher.publish(message)
        time.sleep(0.05)

mark("rest")
take_off.publish(Empty())
go_on(8.0)
mark("up")
go_on(0.8, fly, x=0.4)
go_on(2.0, fly)
mark("moved")
go_on(1.0, drive, x=0.3)
driven = max(odometry)
go_on(1.5)
land.publish(Empty())
go_on(8.0)
mark("down")
count = len(poses) / (poses[-1][0] - poses[0][0])
print(json.dumps(dict(marks=marks, rate=count, driven=driven, last=odometry[-1], ages=sorted(ages))))
"""


@debian.needs_ros
@pytest.mark.slow
def test_a_script_takes_off_flies_drives_and_lands(tmp_path):
    with debian.core(tmp_path) as core:
        outcome = tmp_path / "twin.json"
        arguments = ["twin", "--ros", "shares", "--duration", "90", "--json", str(outcome)]
        code = "from fledge.cli import main; main()"
        twin = subprocess.Popen(
            [sys.executable, "-c", code, *arguments], env={**os.environ, **core.variables}
        )
        try:
            told = json.loads(debian.run(SCRIPT, timeout=80.0, **core.variables))
        finally:
            twin.terminate()
            twin.wait(timeout=20)
    rest, up, moved, down = (told["marks"][name][1:] for name in ("rest", "up", "moved", "down"))
    assert told["rate"] == pytest.approx(100.0, rel=0.1)
    assert up[2] - rest[2] == pytest.approx(1.0, abs=0.25)
    assert hypot(moved[0] - up[0], moved[1] - up[1]) > 0.15
    assert down[2] == pytest.approx(rest[2], abs=0.02)
    assert told["driven"] == pytest.approx(0.3, rel=0.05) and told["last"] == 0.0
    median = told["ages"][len(told["ages"]) // 2]
    assert 0.0 < median < 0.05  # its stamps are those of the moments at which it was seen
    found = json.loads(outcome.read_text())
    assert found["phase"] == "landed" and found["contacts"] == []
