"""Pictures of the twin: who gets them, what becomes of the process that draws them, and a stranger who subscribes."""

import json
import os
import subprocess
import sys
import threading
import time
from contextlib import closing, contextmanager
from pathlib import Path

import debian
import drawing
import numpy as np
import pytest
from drawing import gone, middle, needs_egl, runs

from fledge.geometry import Quat, Vec3
from fledge.lab.twin.picture import FRAME, RATE, Pictures, screening
from fledge.lab.wire import topics
from fledge.lab.wire.messages import Image
from fledge.world import Arena

LEVEL = Quat.from_yaw(0.0)
AWAY = (Vec3(9.0, 9.0, 0.0), LEVEL)
OVER = (Vec3(0.0, 0.0, 2.5), LEVEL)


def scene(x):
    """One UGV, that far ahead."""
    return (OVER, (Vec3(x, 0.0, 0.0), LEVEL), AWAY, AWAY)


@contextmanager
def moving(pictures):
    """A twin of sorts: at t [s] one UGV is 0.1 t m ahead, shown 100 times a second to those who watch."""
    stop = threading.Event()

    def play():
        began = time.monotonic()
        while not stop.wait(0.01):
            if pictures.watched:
                t = time.monotonic() - began
                pictures.show(t, scene(0.1 * t))

    thread = threading.Thread(target=play)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()
        pictures.close()


class Topic:
    """A ROS port of sorts, with so many listeners."""

    def __init__(self):
        self.count, self.sent = 0, []

    def listeners(self, topic):
        assert topic == topics.PICTURES
        return self.count

    def send(self, datagram):
        self.sent.append(datagram)
        return True


def until(true, patience=20.0):
    late = time.monotonic() + patience
    while not true() and time.monotonic() < late:
        time.sleep(0.01)
    return true()


def drawers():
    return drawing.drawers(os.getpid())


@needs_egl
@pytest.mark.slow
def test_a_viewer_sees_what_is_shown_and_takes_its_process_along():
    pictures, before = Pictures(Arena.lab()), drawers()
    with moving(pictures):
        time.sleep(0.1)
        assert not pictures.watched and drawers() == before
        with closing(pictures.frames()) as frames:
            seen = [next(frames) for _ in range(10)]
            (pid,) = set(drawers()) - set(before)
            assert pictures.watched
        assert not pictures.watched
        assert gone(pid)
        stamps = [frame.stamp for frame in seen]
        assert stamps == sorted(set(stamps))
        assert (
            stamps[-1] - stamps[0] > 8 / RATE - 0.02
        )  # the first may be late, and poses come 100 times a second
        for frame in seen:
            shot = np.frombuffer(frame.pixels, np.uint8).reshape(frame.height, frame.width, 3)
            _, v = middle(shot, "p3at")  # 0.28 m high, seen from 2.5 m less the half of a hull
            assert v == pytest.approx(180.0 - 374.7 * 0.1 * frame.stamp / 2.15, abs=6.0)


@needs_egl
@pytest.mark.slow
def test_two_viewers_see_all_of_it():
    pictures = Pictures(Arena.lab())
    with moving(pictures), closing(pictures.frames()) as one, closing(pictures.frames()) as other:
        assert len([next(one) for _ in range(3)]) == len([next(other) for _ in range(3)]) == 3
        one.close()
        assert pictures.watched
        assert next(other).pixels


@needs_egl
@pytest.mark.slow
def test_whoever_closes_it_ends_everything_even_for_those_who_wait():
    pictures, found = Pictures(Arena.lab()), []
    viewer = threading.Thread(target=lambda: found.extend(pictures.frames()))
    viewer.start()  # nobody shows anything
    assert until(lambda: pictures.watched)
    (pid,) = drawers()
    pictures.close()
    viewer.join(timeout=10.0)
    assert not viewer.is_alive() and found == []
    assert gone(pid)
    assert list(pictures.frames()) == []


@needs_egl
@pytest.mark.slow
def test_a_process_that_dies_is_told_of_and_not_begun_anew():
    told = []
    pictures = Pictures(Arena.lab(), tell=told.append)
    with moving(pictures), closing(pictures.frames()) as frames:
        next(frames)
        os.kill(drawers()[0], 9)
        list(frames)
        assert len(told) == 1 and "the process that draws them has died" in told[0]
        assert list(pictures.frames()) == [] and drawers() == []
    assert len(told) == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("variable", "value"), (("MUJOCO_GL", "oil"), ("__EGL_VENDOR_LIBRARY_FILENAMES", "/dev/null"))
)
def test_where_nothing_can_be_drawn_one_line_says_so(monkeypatch, variable, value):
    monkeypatch.setenv(variable, value)
    told, port = [], Topic()
    pictures = Pictures(Arena.lab(), tell=told.append)
    port.count = 1
    with moving(pictures), screening(pictures, port):
        assert until(lambda: told)
        assert until(lambda: not pictures.watched)
        time.sleep(0.5)
        assert not pictures.watched and drawers() == []
    assert len(told) == 1 and "\n" not in told[0]
    assert told[0].startswith("no pictures of the bottom camera (")
    assert told[0].endswith("valid is EGL (apt-get install libegl1 libgl1), or another way in MUJOCO_GL")
    assert port.sent == []


@needs_egl
@pytest.mark.slow
def test_a_topic_is_served_for_as_long_as_it_has_listeners():
    pictures, port = Pictures(Arena.lab()), Topic()
    with moving(pictures):
        with screening(pictures, port):
            time.sleep(0.3)
            assert not pictures.watched
            port.count = 1
            assert until(lambda: len(port.sent) >= 3)
            port.count = 0
            assert until(lambda: not pictures.watched)
            port.count = 2
            before = len(port.sent)
            assert until(lambda: len(port.sent) >= before + 3)
        assert not pictures.watched and drawers() == []
    images = [topics.decode(one.channel, one.data) for one in port.sent]
    assert all(isinstance(image, Image) for image in images)
    assert [image.header.number for image in images] == list(range(len(images)))
    assert {(image.header.frame, image.width, image.height) for image in images} == {(FRAME, 640, 360)}


ORPHAN = """
import os, sys, threading, time
sys.path.insert(0, sys.argv[1])
from test_picture import moving
from fledge.lab.twin.picture import Pictures
from fledge.world import Arena
pictures = Pictures(Arena.lab())
with moving(pictures):
    for i, frame in enumerate(pictures.frames()):
        if i == 2:
            print(pictures._running[0].pid, flush=True)
"""


@needs_egl
@pytest.mark.slow
def test_a_twin_that_is_killed_takes_the_process_along():
    here = os.path.dirname(__file__)
    path = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    twin = subprocess.Popen([sys.executable, "-c", ORPHAN, here], stdout=subprocess.PIPE, text=True, env=path)
    try:
        pid = int(twin.stdout.readline())
        assert runs(pid)
        twin.kill()
        assert gone(pid)
    finally:
        twin.kill()
        twin.communicate()


WATCHER = """
import json, sys, time
from pathlib import Path
import rospy
from sensor_msgs.msg import Image

def drawers():
    paths = Path("/proc/%s/task" % sys.argv[1]).glob("*/children")
    return [int(child) for path in paths for child in path.read_text().split()]

rospy.init_node("watcher", anonymous=True)
found = []
def seen(m):
    age = rospy.get_time() - m.header.stamp.to_sec()
    found.append((m.width, m.height, m.encoding, m.step, len(m.data), m.header.frame_id, age))
before = drawers()
rospy.Subscriber("/ardrone/bottom/image_raw", Image, seen, queue_size=1)
while len(found) < 20:
    time.sleep(0.05)
print(json.dumps([before, drawers(), found]))
"""


@needs_egl
@debian.needs_ros
@pytest.mark.slow
def test_a_script_that_knows_rospy_alone_gets_pictures(tmp_path):
    with debian.core(tmp_path) as core:
        arguments = ["twin", "--ros", "shares", "--duration", "90"]
        code = "from fledge.cli import main; main()"
        twin = subprocess.Popen(
            [sys.executable, "-c", code, *arguments], env={**os.environ, **core.variables}
        )
        try:
            for _ in range(2):  # who comes back is served again
                before, during, found = json.loads(
                    debian.run(WATCHER, str(twin.pid), timeout=60.0, **core.variables)
                )
                assert before == [] and len(during) == 1
                assert {tuple(one[:6]) for one in found} == {(640, 360, "rgb8", 1920, 691200, FRAME)}
                ages = sorted(one[6] for one in found)
                assert 0.0 < ages[len(ages) // 2] < 0.5
                assert gone(during[0])
            twin.terminate()
            assert twin.wait(timeout=20) == 0
        finally:
            twin.kill()
            twin.wait()
