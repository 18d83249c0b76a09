"""ROS 1 as a transport: a port that carries the bytes of topics (`topics`), by rospy. The only file that imports it.

ROS 1 comes with Debian 12 (`INSTALL`), and its modules lie where Debian's Python looks. A virtual environment does not
look there, so `load` appends that folder to `sys.path`, behind everything else: what the environment has itself, NumPy
say, still wins. Nothing is appended, and nothing of ROS imported, until somebody asks for a port; fledge works without.

Messages stay as they are on the wire. To the others this is a node like any: it names type, sum and definition of what
it publishes, so that `rostopic echo` and `rosbag record` see proper messages, and it refuses topics of another type.

**Stamps** are ROS time, a machine's time of day, and a process here counts from its own start. `RosPort.offset` leads
from one to the other, measured once, when the port opens: whoever publishes stamps by it, and on the same machine it
makes of a stamp that came in a time of one's own. Of another machine's clock it knows nothing; `clock` finds that out
from the messages themselves. Simulated time (`/use_sim_time`) is refused.

**The master** is needed for two nodes to find each other, and for nothing else. When it dies, those that are connected
go on; nobody new is found, `complaint` says so, and nothing here waits for it. A master that was started anew does not
know this node, which `complaint` says as well.

rospy has one node a process, once: so there is one port a process, and none after it was closed.

References: wiki.ros.org/ROS/Technical Overview, wiki.ros.org/ROS/Master_API; clients/rospy of github.com/ros/ros_comm.
"""

import logging
import os
import socket
import sys
import time
import warnings
from collections import deque
from collections.abc import Iterable
from contextlib import suppress
from http.client import HTTPConnection, HTTPException
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from threading import Event, Thread
from typing import Any
from xmlrpc.client import Error, ServerProxy, Transport

from fledge.errors import FledgeError
from fledge.lab.shell.link import Arrival
from fledge.lab.wire import topics
from fledge.lab.wire.datagrams import Datagram
from fledge.lab.wire.rosmsg import Kind

FOLDER = Path("/usr/lib/python3/dist-packages")
"""Where Debian keeps its Python packages."""
PYTHON = Path("/usr/bin/python3")
"""The Python they are for; its real name has the version in it."""
INSTALL = "apt-get install --no-install-recommends python3-rospy"

WAITING = 10
"""Messages of a topic that wait to be sent, or to be read, before the oldest are dropped: 0.1 s at 100 Hz; chosen."""
MOST = 1024
"""Messages that wait for `receive`, before the oldest are dropped; chosen: a second of everything."""
PATIENCE = 0.5
"""[s] that the master may take to answer, and between two questions; chosen."""

SILENT = (OSError, HTTPException, Error)
"""What it looks like when nobody sensible answers."""


def load() -> Any:
    """The module `rospy`.

    Raises:
        FledgeError: it is not installed, or not for this Python; says what to type.
    """
    if find_spec("rospy") is None:
        if not (FOLDER / "rospy").is_dir():
            raise FledgeError(f"ROS 1 is not installed: valid is Debian's python3-rospy ({INSTALL})")
        theirs, ours = PYTHON.resolve().name, f"python{sys.version_info.major}.{sys.version_info.minor}"
        if theirs != ours:
            raise FledgeError(
                f"ROS 1 in {FOLDER} is for {theirs}, this is {ours}: "
                f"valid is an environment made by `{PYTHON} -m venv`, or by another {theirs}"
            )
        sys.path.append(str(FOLDER))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Debian's modules are older than this Python's wishes
        try:
            return import_module("rospy")
        except ImportError as error:
            raise FledgeError(f"ROS 1 is broken ({error}): valid is a whole one ({INSTALL})") from error


class RosPort:
    """A node that hears some topics and speaks on others: a `Port` of a `Link`."""

    def __init__(
        self, hears: Iterable[str], says: Iterable[str], wakes: str = "", name: str = "fledge"
    ) -> None:
        """Register with the master that ROS_MASTER_URI names.

        Args:
            hears: Topics to be received.
            says: Topics to be sent.
            wakes: The one of those heard for which a tick should begin; none if it is empty.
            name: What the node is called; a number is added.

        Raises:
            FledgeError: no ROS 1, no master, a topic that is none of a lab's, or a second port in this process.
        """
        heard, said = ({topic: topics.kind(topic) for topic in some} for some in (hears, says))
        self.channels = frozenset((*heard, *said))
        """What is heard or said; what is not said cannot be sent."""
        self._rospy = load()
        self._master = _reached()
        self._name = _started(self._rospy, name)
        self._complaint = ""
        self._inbox: deque[Arrival] = deque(maxlen=MOST)
        self._bell, self._ringer = socket.socketpair()
        self._bell.setblocking(False)
        self._ringer.setblocking(False)
        self.offset = _offset()
        """[ns] from `time.monotonic_ns` to ROS time."""
        self._kinds = {topic: _raw(self._rospy, kind) for topic, kind in (heard | said).items()}
        self._publishers = {topic: self._publisher(topic) for topic in said}
        for topic in heard:
            self._subscribe(topic, ring=topic == wakes)
        self._closing = Event()
        self._watch = Thread(target=self._keep_watch, daemon=True, name="ROS master")
        self._watch.start()

    @property
    def complaint(self) -> str:
        """What is wrong with ROS itself, for people, at most two seconds old; empty where nothing is."""
        return self._complaint

    def fileno(self) -> int:
        """Can be read as soon as something came on the topic that wakes."""
        return self._bell.fileno()

    def receive(self) -> list[Arrival]:
        """What came since the last call, in the order of its arrival."""
        with suppress(BlockingIOError):
            self._bell.recv(MOST)
        return [self._inbox.popleft() for _ in range(len(self._inbox))]

    def send(self, datagram: Datagram) -> bool:
        """To everybody who hears this topic; lost if nobody does."""
        publisher = self._publishers.get(datagram.channel)
        if publisher is None or self._closing.is_set():
            return False
        message = self._kinds[datagram.channel]()
        message._buff = datagram.data
        try:
            publisher.publish(message)
        except self._rospy.ROSException:  # the node was ended while this was under way
            return False
        return publisher.get_num_connections() > 0

    def listeners(self, topic: str) -> int:
        """How many nodes hear a topic; none if nothing is said on it."""
        publisher = self._publishers.get(topic)
        return publisher.get_num_connections() if publisher else 0

    def close(self) -> None:
        """Leave, within two seconds, whatever has become of the master."""
        if self._closing.is_set():
            return
        self._closing.set()
        before = socket.getdefaulttimeout()
        socket.setdefaulttimeout(PATIENCE)  # rospy has none, and says goodbye even to a master that hangs
        try:
            self._rospy.core.xmlrpcapi(_address())("close")()  # a connection of before has no timeout either
            self._rospy.signal_shutdown("closed")
        finally:
            socket.setdefaulttimeout(before)
        self._watch.join()
        self._master("close")()
        self._bell.close()
        self._ringer.close()

    def _publisher(self, topic: str) -> Any:
        return self._rospy.Publisher(topic, self._kinds[topic], queue_size=WAITING, tcp_nodelay=True)

    def _subscribe(self, topic: str, ring: bool) -> None:
        def heard(message: Any) -> None:
            """Called in a thread of rospy's."""
            self._inbox.append(Arrival(time.monotonic_ns(), Datagram(topic, message._buff)))
            if ring:
                with suppress(OSError):  # it has been rung often enough, or the port is closed
                    self._ringer.send(b"!")

        self._rospy.Subscriber(topic, self._kinds[topic], heard, queue_size=WAITING, tcp_nodelay=True)

    def _keep_watch(self) -> None:
        """In a thread of its own: ask the master for this node, again and again."""
        while not self._closing.wait(PATIENCE):
            self._complaint = self._examined()

    def _examined(self) -> str:
        if self._rospy.is_shutdown():
            return "ROS has ended this node: somebody else asked for that"
        try:
            code, _, _ = self._master.lookupNode(self._name, self._name)
        except SILENT as error:
            return f"the ROS master at {_address()} does not answer ({error}): nobody new will be found"
        known = "the ROS master was started anew, and does not know this node: nobody new will be found"
        return "" if code == 1 else known


class _Impatient(Transport):
    """HTTP that does not wait for ever."""

    def make_connection(self, host: Any) -> HTTPConnection:
        """With a timeout."""
        connection = super().make_connection(host)
        connection.timeout = PATIENCE
        return connection


def _address() -> str:
    """The master's, as ROS has it."""
    return os.environ.get("ROS_MASTER_URI") or "http://localhost:11311"


def _reached() -> Any:
    """The master, if it answers and has no simulated time."""
    try:
        master = ServerProxy(_address(), _Impatient())
        code, _, simulated = master.getParam("/fledge", "/use_sim_time")  # pyright: ignore
    except SILENT as error:
        raise FledgeError(
            f"no ROS master answers at {_address()} ({error}): "
            "valid is the address of one in ROS_MASTER_URI; `roscore` starts one"
        ) from error
    if code == 1 and simulated:
        raise FledgeError("/use_sim_time is set: valid is false, since a flight is in real time")
    return master


def _started(rospy: Any, name: str) -> str:
    """The full name of this process's node."""
    if rospy.core.is_initialized():
        raise FledgeError("this process has had a ROS port: valid is one, once, as rospy has it")
    rospy.init_node(name, argv=[name], anonymous=True, disable_signals=True, disable_rosout=True)
    # What rospy would print on the terminal stands in its log file as well.
    logging.getLogger("rosout").handlers.clear()
    return rospy.get_name()


def _raw(rospy: Any, kind: Kind) -> Any:
    """A class of messages that are what they are on the wire, and that others take for the kind they are."""
    described = {"_type": kind.name, "_md5sum": kind.md5, "_full_text": kind.full_text}
    return type(kind.name.replace("/", "_"), (rospy.AnyMsg,), described)


def _offset() -> int:
    """[ns] from `time.monotonic_ns` to ROS time: of ten readings the one that was least interrupted."""
    readings = []
    for _ in range(10):
        before, now, after = time.monotonic_ns(), time.time_ns(), time.monotonic_ns()
        readings.append((after - before, now - (before + after) // 2))
    return min(readings)[1]
