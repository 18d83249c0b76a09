"""The ROS port, in a process of its own: heard and seen by Debian's tools through a real master, which then dies."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import debian
import pytest

from fledge.geometry import Vec3
from fledge.lab.wire import topics
from fledge.lab.wire.messages import Twist

pytestmark = pytest.mark.slow

STILL = Vec3(0.0, 0.0, 0.0)
POSE, STEERING = topics.pose("ardrone"), topics.drive("p3at")

SPEAKER = """
import sys, time
import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import Joy
rospy.init_node("speaker", anonymous=True)
steer = rospy.Publisher("/cmd_vel", Twist, queue_size=10)
joy = rospy.Publisher("/joy", Joy, queue_size=10)
while min(steer.get_num_connections(), joy.get_num_connections()) < 1:
    time.sleep(0.01)
twist, sticks = Twist(), Joy(axes=[0.5, -0.25], buttons=[0, 1])
began = time.monotonic()
for i in range(int(sys.argv[1])):
    time.sleep(max(began + 0.01 * i - time.monotonic(), 0.0))
    now = time.monotonic_ns()
    twist.linear.x = i / 10
    sticks.header.stamp = rospy.Time(now // 10**9, now % 10**9)
    steer.publish(twist)
    joy.publish(sticks)
time.sleep(0.2)
"""
"""A node that knows nothing of fledge: Twist and Joy at 100 Hz, the latter with the time at which it was sent."""

READER = """
import json, sys
import rosbag
rows = []
with rosbag.Bag(sys.argv[1]) as bag:
    kinds = {topic: info.msg_type for topic, info in bag.get_type_and_topic_info()[1].items()}
    for topic, message, _ in bag.read_messages():
        seen = message.transform.translation.x if hasattr(message, "transform") else message.rotX
        rows.append((topic, message.header.stamp.to_nsec(), seen))
print(json.dumps([kinds, rows]))
"""

MUTE = """
import sys
from fledge.errors import FledgeError
from fledge.lab.shell import ros
for name, value in zip(sys.argv[1::2], sys.argv[2::2]):
    setattr(ros, name, ros.Path(value))
try:
    ros.RosPort((), ())
except FledgeError as error:
    print(error)
"""


def refusal(*changed: object, **variables: str) -> str:
    """What is said where a port cannot be had."""
    done = subprocess.run(
        [sys.executable, "-c", MUTE, *map(str, changed)],
        capture_output=True,
        text=True,
        timeout=60,
        env=debian.environment(**variables),
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


class Puppet:
    """A process with a port."""

    def __init__(self, core: debian.Core) -> None:
        self.process = subprocess.Popen(
            [sys.executable, str(Path(__file__).parents[2] / "puppet.py")],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=debian.environment(**core.variables),
        )

    def __call__(self, *command: str):
        """Its answer."""
        self.process.stdin.write(" ".join(command) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        assert line, self.process.communicate()[1]
        return json.loads(line)

    def gather(self, enough, patience: float = 20.0) -> list:
        """Everything it heard, (time, topic, message) each, until that is enough."""
        found, late = [], time.monotonic() + patience
        while not enough(found):
            assert time.monotonic() < late, f"{len(found)} messages in {patience} s"
            found += [
                (at, topic, topics.decode(topic, bytes.fromhex(data))) for at, topic, data in self("heard")
            ]
            time.sleep(0.02)
        return found

    def end(self) -> tuple[float, str]:
        """(how long it took to leave, its last words)."""
        began = time.monotonic()
        _, errors = self.process.communicate(timeout=30)
        assert self.process.returncode == 0, errors
        return time.monotonic() - began, errors


@contextmanager
def puppet_of(core: debian.Core) -> Iterator[Puppet]:
    puppet = Puppet(core)
    try:
        yield puppet
        if puppet.process.poll() is None:
            puppet.end()
    finally:
        puppet.process.kill()
        puppet.process.communicate()


@contextmanager
def running(core: debian.Core, *command: str) -> Iterator[subprocess.Popen]:
    """A program that knows nothing of fledge."""
    process = subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=debian.environment(**core.variables, PYTHONUNBUFFERED="1"),
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def interrupted(process: subprocess.Popen) -> str:
    """What a program printed until it was told to stop."""
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=10)
    return out


@pytest.fixture(scope="module")
def core(tmp_path_factory):
    with debian.core(tmp_path_factory.mktemp("ros")) as running:
        yield running


@pytest.fixture(scope="module")
def puppet(core):
    with puppet_of(core) as one:
        one("stream")
        yield one


# Without ROS


def test_where_there_is_no_ros_it_says_what_to_type(tmp_path):
    assert refusal("FOLDER", tmp_path) == (
        "ROS 1 is not installed: valid is Debian's python3-rospy "
        "(apt-get install --no-install-recommends python3-rospy)"
    )


def test_ros_for_another_python_is_refused(tmp_path):
    (tmp_path / "rospy").mkdir()
    (tmp_path / "python3").symlink_to("python3.9")
    ours = f"python{sys.version_info.major}.{sys.version_info.minor}"
    assert refusal("FOLDER", tmp_path, "PYTHON", tmp_path / "python3") == (
        f"ROS 1 in {tmp_path} is for python3.9, this is {ours}: "
        f"valid is an environment made by `{tmp_path}/python3 -m venv`, or by another python3.9"
    )


def test_broken_ros_is_refused(tmp_path):
    (tmp_path / "rospy").mkdir()
    (tmp_path / "rospy" / "__init__.py").write_text("import nothing_of_that_name")
    (tmp_path / "python3").symlink_to(Path(sys.executable).resolve())
    said = refusal("FOLDER", tmp_path, "PYTHON", tmp_path / "python3")
    assert said.startswith("ROS 1 is broken (No module named 'nothing_of_that_name'): valid is ")


# With it


@debian.needs_ros
def test_what_the_environment_has_itself_still_wins():
    code = (
        "import sys; from fledge.lab.shell import ros; before = list(sys.path); ros.load(); import numpy, rospy;"
        "assert sys.path == [*before, str(ros.FOLDER)]; print(numpy.__file__); print(rospy.__file__)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=debian.environment()
    )
    numpy, rospy = done.stdout.split()
    assert numpy.startswith(sys.prefix)
    assert rospy.startswith("/usr/lib/python3/dist-packages")
    assert not done.stderr


@debian.needs_ros
@pytest.mark.parametrize("address", ("http://127.0.0.1:9", "http://", "nonsense"))
def test_without_a_master_it_says_so_at_once(address):
    began = time.monotonic()
    said = refusal(ROS_MASTER_URI=address)
    assert said.startswith(f"no ROS master answers at {address} (")
    assert said.endswith("valid is the address of one in ROS_MASTER_URI; `roscore` starts one")
    assert time.monotonic() - began < 5.0


@debian.needs_ros
def test_a_tool_measures_the_rate(core, puppet):
    with running(core, "rostopic", "hz", "-w", "200", POSE) as tool:
        time.sleep(6.0)
        out = interrupted(tool)
    rates = [float(rate) for rate in re.findall(r"average rate: ([\d.]+)", out)]
    assert rates[-1] == pytest.approx(100.0, abs=1.0)


@debian.needs_ros
def test_a_tool_sees_the_message(core, puppet):
    with running(core, "rostopic", "echo", "-n1", POSE) as tool:
        out, errors = tool.communicate(timeout=20)
    assert re.search(r'frame_id: "/vicon/world"\nchild_frame_id: "vicon/ardrone/ardrone"\n', out), errors
    assert re.search(r"x: [\d.e-]+\n    y: -0.5\n    z: 0.8\n  rotation: \n    x: 0.0", out)


@debian.needs_ros
def test_a_recorder_keeps_what_was_sent(core, puppet, tmp_path):
    bag = tmp_path / "flight.bag"
    with running(core, "rosbag", "record", "-l", "200", "-O", str(bag), POSE, topics.NAVDATA) as recorder:
        _, errors = recorder.communicate(timeout=30)
    assert bag.exists(), errors
    kinds, rows = json.loads(debian.run(READER, str(bag)))
    assert kinds == {POSE: "geometry_msgs/TransformStamped", topics.NAVDATA: "ardrone_autonomy/Navdata"}
    poses = [(stamp, round(1e3 * x)) for topic, stamp, x in rows if topic == POSE]
    numbers = [number for _, number in poses]
    assert numbers == list(range(numbers[0], numbers[0] + 200))
    assert (poses[-1][0] - poses[0][0]) / 199 == pytest.approx(1e7, rel=0.01)
    assert {round(x, 3) for topic, _, x in rows if topic == topics.NAVDATA} == {7.162}


@debian.needs_ros
def test_what_a_stranger_says_is_here_within_50_ms(core, puppet):
    puppet("heard")
    with running(core, debian.PYTHON, "-c", SPEAKER, "200") as speaker:
        found = puppet.gather(lambda some: len(some) >= 400)
        _, errors = speaker.communicate(timeout=10)
    assert speaker.returncode == 0, errors
    assert [at for at, _, _ in found] == sorted(at for at, _, _ in found)
    twists = [(at, twist) for at, topic, twist in found if topic == topics.FLY]
    joys = [(at, joy) for at, topic, joy in found if topic == topics.JOY]
    assert [twist.linear.x for _, twist in twists] == [i / 10 for i in range(200)]
    assert {(joy.axes, joy.buttons) for _, joy in joys} == {((0.5, -0.25), (0, 1))}
    delays = [(at - joy.header.stamp_ns) / 1e9 for at, joy in joys]
    assert 0.0 < min(delays) and max(delays) < 0.05
    beside = [abs(twist - joy) / 1e9 for (twist, _), (joy, _) in zip(twists, joys, strict=True)]
    assert max(beside) < 0.05


@debian.needs_ros
def test_what_came_while_it_could_not_listen_is_dropped_but_for_the_newest(core, puppet):
    puppet("heard")
    with running(core, debian.PYTHON, "-c", SPEAKER, "300") as speaker:
        puppet.gather(lambda some: len(some) >= 20)
        os.kill(puppet.process.pid, signal.SIGSTOP)
        speaker.communicate(timeout=20)
        os.kill(puppet.process.pid, signal.SIGCONT)
        found = puppet.gather(lambda some: some and last(some) == 29.9)
    numbers = [round(10 * twist.linear.x) for _, topic, twist in found if topic == topics.FLY]
    assert numbers == sorted(numbers)
    assert len(numbers) < 100


def last(found: list) -> float:
    """What the last twist asks for."""
    return max((message.linear.x for _, topic, message in found if topic == topics.FLY), default=0.0)


@debian.needs_ros
def test_one_topic_wakes(core, puppet):
    puppet("heard")
    with running(core, debian.PYTHON, "-c", SPEAKER, "50") as speaker:
        assert topics.FLY in {topic for _, topic, _ in puppet("wait")}
        speaker.communicate(timeout=10)


@debian.needs_ros
def test_a_topic_of_another_type_is_not_heard(core, puppet):
    puppet("heard")
    with running(
        core, "rostopic", "pub", "-r", "50", topics.FLY, "std_msgs/String", "data: forward"
    ) as other:
        time.sleep(3.0)
        interrupted(other)
    assert puppet("heard") == []


@debian.needs_ros
def test_ros_time_leads_to_our_own(puppet):
    assert time.time_ns() - time.monotonic_ns() == pytest.approx(puppet("offset"), abs=5e6)


@debian.needs_ros
def test_what_nobody_hears_is_lost(puppet):
    assert not puppet("send", STEERING, topics.encode(Twist(STILL, STILL)).hex())
    assert not puppet("send", topics.JOY)
    assert not puppet("send", "vicon")


@debian.needs_ros
def test_it_counts_who_listens(core, puppet):
    assert puppet("listeners", POSE) == puppet("listeners", STEERING) == puppet("listeners", topics.JOY) == 0
    with running(core, "rostopic", "hz", POSE):
        late = time.monotonic() + 20.0
        while not puppet("listeners", POSE):
            assert time.monotonic() < late
        assert puppet("listeners", POSE) == 1 and puppet("listeners", STEERING) == 0
    while puppet("listeners", POSE):
        assert time.monotonic() < late


@debian.needs_ros
def test_a_second_port_is_refused(puppet):
    assert puppet("again") == "this process has had a ROS port: valid is one, once, as rospy has it"


@debian.needs_ros
def test_simulated_time_is_refused(tmp_path):
    with debian.core(tmp_path) as core:
        with running(core, "rosparam", "set", "/use_sim_time", "true") as tool:
            tool.communicate(timeout=20)
        assert refusal(**core.variables).startswith("/use_sim_time is set: valid is false")


@debian.needs_ros
def test_when_the_master_dies_those_connected_go_on_and_it_is_said(tmp_path):
    with debian.core(tmp_path) as core, puppet_of(core) as puppet:
        with running(core, debian.PYTHON, "-c", SPEAKER, "500"):
            puppet.gather(lambda some: len(some) >= 100)
            assert puppet("complaint") == ""
            os.kill(core.master, signal.SIGKILL)
            died = time.monotonic_ns()
            found = puppet.gather(lambda some: some and some[-1][0] > died + 2e9)
        after = [at for at, topic, _ in found if topic == topics.FLY and died < at <= died + 2e9]
        assert len(after) == pytest.approx(200, abs=5)
        said = r"the ROS master at http://127\.0\.0\.1:\d+ does not answer \(.*\): nobody new will be found"
        assert re.fullmatch(said, puppet("complaint"))
        assert puppet("close") < 2.0
        assert not puppet("send", POSE)
        seconds, errors = puppet.end()
        assert seconds < 2.0
        assert not errors


@debian.needs_ros
def test_a_master_that_was_started_anew_knows_nobody(tmp_path):
    with debian.core(tmp_path) as core, puppet_of(core) as puppet:
        assert puppet("complaint") == ""
        core.end()
        with debian.core(tmp_path, core.port):
            time.sleep(1.5)
            assert puppet("complaint").startswith(
                "the ROS master was started anew, and does not know this node"
            )


@debian.needs_ros
def test_a_master_that_hangs_holds_up_nobody(tmp_path):
    with debian.core(tmp_path) as core, puppet_of(core) as puppet:
        puppet("stream")
        os.kill(core.master, signal.SIGSTOP)
        time.sleep(2.0)
        assert "does not answer (timed out)" in puppet("complaint")
        assert puppet("close") < 2.0
        assert puppet.end()[0] < 2.0


@debian.needs_ros
def test_a_port_that_is_closed_in_peace_leaves_at_once(tmp_path):
    with debian.core(tmp_path) as core, puppet_of(core) as puppet:
        puppet("stream")
        with running(core, debian.PYTHON, "-c", SPEAKER, "1000"):
            puppet.gather(lambda some: len(some) >= 10)
            assert puppet("close") < 1.0
            seconds, errors = puppet.end()
        assert seconds < 1.0
        assert not errors
