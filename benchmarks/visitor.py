"""A cockpit's server as a process, and somebody at its WebSocket: what the cockpit's benchmarks share."""

import json
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Thread
from typing import Any

from websockets.sync.client import ClientConnection, connect

from fledge.cockpit.asks import Fly, Seat, Sticks
from fledge.cockpit.messages import decode_told, encode
from fledge.cockpit.tells import Flight, Frame

REST = (0.0, 0.0, 0.0, 0.0)


class Server:
    """A cockpit under way in a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        fledge = str(Path(sys.executable).with_name("fledge"))
        command = [fledge, "cockpit", "--port", "0", "--json", "found.json"]
        self._process = subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, text=True)
        assert self._process.stderr
        self.url = next(line.split()[1] for line in self._process.stderr if line.startswith("open "))
        self.pid = self._process.pid

    @property
    def memory(self) -> float:
        """Resident [MB]."""
        status = Path(f"/proc/{self.pid}/status").read_text()
        return next(int(line.split()[1]) for line in status.splitlines() if line.startswith("VmRSS")) / 1e3

    def stop(self) -> dict[str, Any]:
        """What it found."""
        self._process.send_signal(signal.SIGINT)
        self._process.wait(30)
        return json.loads((self._folder / "found.json").read_text())


class Visitor:
    """Has the seat, and says sticks."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket, self._sequence = socket, 0
        self.frame: Frame | None = None
        self.flight: Flight | None = None
        self.told: list[Any] = []
        self.frames = 0
        Thread(target=self._listen, daemon=True).start()
        self.say(Seat(True))

    def say(self, message: Any) -> None:
        """To the server."""
        self._socket.send(encode(message))

    def sticks(self, axes: tuple[float, ...] = REST, **flags: bool) -> None:
        """Say how they are."""
        self._sequence += 1
        self.say(Sticks(self._sequence, 1e3 * time.monotonic(), 0, axes, **flags))

    def begin(self, fly: Fly) -> None:
        """Start a flight, and arm once it may be."""
        self.frame = None
        self.say(fly)
        for wanted, arm in (("READY", False), ("AUTO", True)):
            while self.frame is None or self.frame.vehicles[0].mode != wanted:
                self.sticks(arm=arm)
                time.sleep(0.02)

    def _listen(self) -> None:
        for message in self._socket:
            told = decode_told(message)
            if isinstance(told, Frame):
                self.frame = told
                self.frames += 1
            else:
                self.told.append(told)
                self.flight = told if isinstance(told, Flight) else self.flight


@contextmanager
def visiting(server: Server) -> Iterator[Visitor]:
    """Somebody at the server's WebSocket."""
    site = server.url.removesuffix("/fly")
    with connect(site.replace("http", "ws", 1) + "/ws", origin=site) as socket:  # type: ignore[arg-type]
        yield Visitor(socket)
