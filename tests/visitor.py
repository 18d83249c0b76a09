"""A cockpit's server as a process, and a visitor by WebSocket in place of a page: says sticks, keeps what is told."""

import json
import signal
import time
from contextlib import ExitStack, contextmanager
from threading import Event, Thread
from urllib.error import HTTPError
from urllib.request import Request, urlopen

from processes import process
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from fledge.cockpit.asks import Seat, Sticks
from fledge.cockpit.messages import decode_told, encode
from fledge.cockpit.tells import Frame

RATE = 60.0
"""Sticks a second, as a browser sends them."""


class Cockpit:
    """A server, and its address."""

    def __init__(self, running, url, folder):
        self.process, self.folder = running, folder
        self.url, _, self.query = url.removesuffix("/fly").partition("/fly?")
        self.url = self.url.removesuffix("/fly")

    def get(self, path, **headers):
        """(status, body, headers) of a page."""
        try:
            with urlopen(Request(self.url + path, headers=headers), timeout=20) as answer:
                return answer.status, answer.read(), answer.headers
        except HTTPError as error:
            return error.code, error.read(), error.headers

    def stop(self):
        """As Ctrl-C does; what it found."""
        self.process.send_signal(signal.SIGINT)
        _, err = self.process.communicate(timeout=30)
        assert self.process.returncode == 0, err
        return json.loads((self.folder / "out.json").read_text())


@contextmanager
def cockpit(folder, *arguments, port=0):
    """A server in a folder, ready; it is ended with the block."""
    with process("cockpit", "--port", port, "--json", "out.json", *arguments, cwd=folder) as running:
        said = []
        for line in running.stderr:
            said.append(line)
            if line.startswith("open "):
                yield Cockpit(running, line.split()[1], folder)
                return
        raise AssertionError("".join(said))


class Visitor:
    """Somebody who joined."""

    def __init__(self, url, origin=None, **options):
        self.told, self.frames, self.pictures, self.closed = [], [], [], None
        self._stack = ExitStack()
        address = url.replace("http", "ws", 1) + "/ws"
        self._socket = self._stack.enter_context(connect(address, origin=origin or url, **options))
        self._over, self._sequence, self._sticks = Event(), 0, None
        self._threads = [Thread(target=self._listen), Thread(target=self._talk)]
        for thread in self._threads:
            thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._over.set()
        self._stack.close()
        for thread in self._threads:
            thread.join()

    @property
    def frame(self):
        """The newest."""
        return self.frames[-1][1]

    @property
    def uav(self):
        return self.frame.vehicles[0]

    def last(self, kind):
        """The newest message of a kind."""
        return next((one for one in reversed(self.told) if isinstance(one, kind)), None)

    def say(self, message):
        self._socket.send(message if isinstance(message, (str, bytes)) else encode(message))

    def hold(self, axes=(0.0, 0.0, 0.0, 0.0), vehicle=0, **flags):
        """From now on these sticks are said."""
        self._sticks = vehicle, axes, flags

    def let_go(self):
        """Nothing is said any more."""
        self._sticks = None

    def until(self, condition, within=20.0):
        """Wait; `condition` may look at anything here."""
        end = time.monotonic() + within
        while not condition():
            assert time.monotonic() < end, (self.told[-5:], self.frames[-1:])
            time.sleep(0.01)

    def sits(self):
        """Ask for the seat, and get it."""
        self.say(Seat(True))
        self.until(lambda: any(getattr(one, "seat", "") == "mine" for one in self.told))
        return self

    def begins(self, fly, armed=True):
        """Start a flight; with nobody's hands on the sticks, armed once it may be."""
        self.hold(arm=False)
        known = len(self.frames)
        self.say(fly)
        self.until(lambda: len(self.frames) > known and self.uav.mode == "READY" and self.frame.t < 60.0)
        if armed:
            self.until(self._arms)
        return self

    def _arms(self):
        """As a page does: armed from READY on; where that was too early, anew."""
        self.hold(arm=self.uav.mode != "INIT")
        return self.uav.mode not in ("INIT", "READY")

    def _listen(self):
        try:
            for message in self._socket:
                if isinstance(message, bytes):
                    self.pictures.append(message)
                    continue
                told = decode_told(message)
                if isinstance(told, Frame):
                    self.frames.append((time.monotonic(), told))
                else:
                    self.told.append(told)
            self.closed = self._socket.protocol.close_code
        except ConnectionClosed as error:
            self.closed = error.rcvd and error.rcvd.code

    def _talk(self):
        while not self._over.wait(1.0 / RATE):
            if self._sticks is None:
                continue
            vehicle, axes, flags = self._sticks
            self._sequence += 1
            try:
                self.say(Sticks(self._sequence, time.monotonic() * 1e3, vehicle, axes, **flags))
            except ConnectionClosed:
                return
