"""A process with a ROS port, for tests: moved by lines on its standard input, it answers each with a line of JSON.

rospy has one node a process, once, and leaves sockets for Python to sweep up, so none shall live in a process of tests.

    stream          from now on poses and navdata, 100 a second each; answers at once
    heard           what came since the last time: [time of arrival, topic, bytes] of each
    wait            the same, once the topic that wakes was heard
    send TOPIC HEX  whether it is on its way
    listeners TOPIC how many hear it
    offset          from this machine's monotonic clock to ROS time, as measured
    complaint       what is wrong with ROS
    again           what is said to whoever wants a second port
    close           how long that took
"""

import json
import select
import sys
import threading
import time

from fledge.errors import FledgeError
from fledge.geometry import Quat, Vec3
from fledge.lab.shell import ros
from fledge.lab.wire import topics
from fledge.lab.wire.datagrams import Datagram
from fledge.lab.wire.messages import Header, Navdata, TransformStamped
from fledge.lab.wire.navdata import ControlState, Demo

POSE, STEERING = topics.pose("ardrone"), topics.drive("p3at")
LEVEL = Quat(1.0, 0.0, 0.0, 0.0)
ROLLED = Demo(ControlState.FLYING, 0.5, 0.125, 0.0, 0.0, 1.0, Vec3(0.0, 0.0, 0.0))


def pose(number: int) -> Datagram:
    """A pose whose number is where it is [mm]."""
    header = Header(time.time_ns(), "/vicon/world", number)
    place = Vec3(number / 1e3, -0.5, 0.8)
    return Datagram(POSE, topics.encode(TransformStamped(header, "vicon/ardrone/ardrone", place, LEVEL)))


def stream(port: ros.RosPort, stop: threading.Event) -> None:
    """At 100 Hz, until it is stopped."""
    number, began = 0, time.monotonic()
    while not stop.wait(max(began + 0.01 * number - time.monotonic(), 0.0)):
        number += 1
        port.send(pose(number))
        port.send(Datagram(topics.NAVDATA, topics.encode(Navdata(Header(time.time_ns()), ROLLED))))


def heard(port: ros.RosPort) -> list:
    return [[one.at, one.datagram.channel, one.datagram.data.hex()] for one in port.receive()]


def woken(port: ros.RosPort) -> list:
    select.select([port], (), (), 20.0)
    return heard(port)


def refused() -> str:
    try:
        ros.RosPort((), ())
    except FledgeError as error:
        return str(error)
    return ""


def closed(port: ros.RosPort) -> float:
    began = time.monotonic()
    port.close()
    return time.monotonic() - began


def main() -> None:
    port = ros.RosPort((topics.FLY, topics.JOY), (POSE, topics.NAVDATA, STEERING), wakes=topics.FLY)
    stop = threading.Event()
    thread = threading.Thread(target=stream, args=(port, stop))
    answers = {
        "stream": thread.start,
        "heard": lambda: heard(port),
        "wait": lambda: woken(port),
        "send": lambda topic, data="": port.send(Datagram(topic, bytes.fromhex(data))),
        "listeners": port.listeners,
        "offset": lambda: port.offset,
        "complaint": lambda: port.complaint,
        "again": refused,
        "close": lambda: closed(port),
    }
    for line in sys.stdin:
        name, *arguments = line.split()
        print(json.dumps(answers[name](*arguments)), flush=True)
    stop.set()
    if thread.ident:
        thread.join()
    port.close()


if __name__ == "__main__":
    main()
