"""Real processes: `fledge twin` and `fledge fly` from a test, what they log, and somebody at the sticks."""

import json
import multiprocessing
import os
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from itertools import count

from mcap.exceptions import EndOfFile
from mcap.records import Message
from mcap.stream_reader import StreamReader

from fledge.lab.shell.udp import UdpPort, Wire
from fledge.lab.wire.datagrams import STICKS, Datagram
from fledge.lab.wire.sticks import Sticks, encode
from fledge.supervision.inputs import Operator


@contextmanager
def process(*arguments, cwd=None, **environment):
    """`fledge` with some arguments, and its end."""
    command = [sys.executable, "-c", "from fledge.cli import main; main()", *map(str, arguments)]
    running = subprocess.Popen(
        command,
        cwd=cwd,
        env={**os.environ, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield running
    finally:
        running.kill()
        running.communicate()


def until(running, words):
    """Wait for a line with these words on standard error."""
    assert any(words in line for line in running.stderr), words


def wires(host):
    return "--mocap", f"vicon://{host}", "--vehicle", f"ardrone://{host}", "--no-operator"


def ticks_of(path):
    """The ticks in a log that may still be written, so far."""
    found = []
    with suppress(OSError, EndOfFile), open(path, "rb") as file:
        for record in StreamReader(file).records:
            if isinstance(record, Message) and record.data.startswith(b'{"tick":'):
                found.append(json.loads(record.data))
    return found


def phases(path):
    """Those in a log that is being written, so far."""
    return [tick["phase"] for tick in ticks_of(path)]


def flown_to(phase, path, within=60.0):
    """Wait until a flight has got there."""
    end = time.monotonic() + within
    while phase not in phases(path)[-1:]:
        assert time.monotonic() < end, phases(path)[-1:]
        time.sleep(0.5)


def wait_for(condition, within=60.0):
    end = time.monotonic() + within
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.2)


def modes(path):
    """The UAV's, in a log that is being written."""
    return [tick["said"][0]["mode"] for tick in ticks_of(path) if tick["said"]] or [""]


@contextmanager
def beside(target, *arguments):
    """Our end of a line to a function in a process of its own, which says a word when it is ready and ends on None.

    What keeps time does not share a process with a test: one that reads a log would keep its threads waiting.
    """
    spawn = multiprocessing.get_context("spawn")
    line, other = spawn.Pipe()
    running = spawn.Process(target=target, args=(other, *arguments), daemon=True)
    running.start()
    assert line.poll(30.0), f"{target.__name__} did not start"
    line.recv()
    try:
        yield line
    finally:
        line.send(None)
        running.join()


@contextmanager
def sticks(address):
    """Somebody with a wire: a function that says how all operators are from now on, fifty times a second."""
    with beside(_talk, address) as line:
        yield line.send


def _talk(line, address):
    mouth, uav = UdpPort(Wire(STICKS, there=address)), Operator()
    line.send("ready")
    for number in count():
        if line.poll(0.02) and (uav := line.recv()) is None:
            break
        others = Operator(arm=uav.arm, land=uav.land, hand_back=uav.hand_back)
        said = encode(Sticks(number, time.monotonic(), (uav, others, others, others)))
        mouth.send(Datagram(STICKS, said))
    mouth.close()
