"""The log of a lab flight: one MCAP file, written while it is flown.

| where | what |
|---|---|
| metadata `fledge.lab` | the format, and what the controller was made of, as JSON |
| attachments | files it was made of: a policy |
| topics `/in/...`, `/out/...` | every datagram that was heard or said, one topic for each channel; bytes as they were |
| topic `/fledge/tick` | every tick: time, how long it took, phase, complaint, what was seen and said of each vehicle |
| metadata `fledge.flight`, topic `/fledge/row`, ... | the flight, row by row, as `storage.flights` stores it |
| metadata `fledge.log` | at the end: how many ticks were logged, and how many were not |

A message's sequence number is its tick's, and its time is the tick's own. So what went in and what came out of every
tick can be told apart later, and fed to a controller once more (`rerun`).

**A log never holds up a flight.** A tick is put on a queue; a thread writes it at once, in the pause that follows the
tick, and hands the file to the system every half a second, so that a process that is killed loses at most its last
second. The queue is bounded: if the disk stands still for longer than it holds, ticks are dropped and counted. If the
disk refuses, being full, say, the log ends there, as if the process had been killed, and `problem` says so; the flight
goes on without.
"""

import json
import os
import time
from collections import deque
from collections.abc import Mapping, Sequence
from threading import Event, Thread
from typing import Any, NamedTuple

from fledge.episode import Episode, Flight
from fledge.errors import BadFile
from fledge.lab.control.tick import Said
from fledge.lab.shell.rows import Rows, together
from fledge.lab.wire.datagrams import Datagram, Heard
from fledge.storage import FlightLog
from fledge.storage.atomic import AnyPath
from fledge.storage.foxglove import schema
from fledge.storage.records import to_json
from fledge.supervision.modes import Mode
from fledge.supervision.posts import Decision
from fledge.world import Reason, UavState, UgvState

FORMAT = "1"
"""Version of the layout above; a reader refuses every other."""
LAB, END = "fledge.lab", "fledge.log"
TICKS = "/fledge/tick"

EXAMPLE = {
    "tick": 0,
    "t": 0.0,
    "took_us": 0,
    "phase": "",
    "complaint": "",
    "wires": "",
    "seen": [{"x": 0.0, "y": 0.0, "z": 0.0, "stamp": 0.0}],
    "said": [
        {
            "mode": "",
            "reason": "",
            "alarm": "",
            "severity": 0,
            "intervened": False,
            "clearance": 0.0,
            "command": {"forward": 0.0, "left": 0.0, "up": 0.0, "turn": 0.0},
        }
    ],
}
"""A tick, for its schema."""

EVERY = 0.1
"""[s] between two visits of the thread to the queue, at most."""
FLUSH = 0.5
"""[s] between two times that the file is handed to the system."""
MOST = 3_000
"""Ticks that the queue holds: half a minute, some ten megabytes."""
PATIENCE = 10.0
"""[s] that the disk may take for what is left when the flight is over; chosen."""


class Entry(NamedTuple):
    """One tick."""

    number: int
    heard: Heard
    said: Said
    took_us: int
    """From what was heard to what was said [us]."""
    wires: str = ""
    """What is wrong with a transport itself."""


class Log:
    """A log being written: a context, which ends it."""

    def __init__(
        self,
        path: AnyPath,
        about: Flight,
        brief: Mapping[str, Any],
        files: Mapping[str, bytes] | None = None,
    ) -> None:
        """Begin a new file; of `about` all is taken but its episode, and `brief` has to be plain JSON.

        Raises:
            BadFile: it is there already, or cannot be written.
        """
        self.path = path
        self.lost = 0
        """How many ticks are not in it."""
        self.problem = ""
        """Why the log ended before the flight, if it did."""
        self._queue: deque[Entry] = deque()
        self._more, self._ending = Event(), False
        self._bug: Exception | None = None
        self._channels: dict[tuple[str, str], int] = {}
        self._logged = self._safe = 0
        self._rows = Rows()
        self._row = self._rows.init()
        self._episodes: list[Episode] = []
        try:
            self._stream = open(path, "xb")
            self._flights = FlightLog(self._stream, about)
            self._writer = self._flights.writer
            self._writer.add_metadata(LAB, {"format": FORMAT, "brief": json.dumps(brief)})
            for name, data in (files or {}).items():
                self._writer.add_attachment(0, 0, name, "application/octet-stream", data)
            self._writer.flush()
        except FileExistsError as error:
            raise BadFile(path, "is there already: valid is the name of a new file") from error
        except OSError as error:
            raise BadFile(path, f"cannot be written: {error.strerror or error}") from error
        self._thread = Thread(target=self._run, name="log", daemon=True)

    def __enter__(self) -> "Log":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ending = True
        self._more.set()
        self._thread.join(PATIENCE)
        if self._thread.is_alive():
            self.problem = f"the disk did not take the end of it within {PATIENCE:g} s"
        self.lost += self._logged - self._safe + len(self._queue)
        if self._bug is not None:
            raise self._bug

    def tick(self, entry: Entry) -> None:
        """Have it logged; returns at once, whatever the disk does."""
        if self.problem or len(self._queue) >= MOST:
            self.lost += 1
        else:
            self._queue.append(entry)
            self._more.set()

    # The thread's part.

    def _run(self) -> None:
        try:
            with self._stream:
                with self._flights:
                    self._write_all()
                self._stream.flush()
                os.fsync(self._stream.fileno())
        except OSError as error:
            self.problem = f"cannot be written any more: {error.strerror or error}"
        except Exception as error:  # a bug of ours must not end the flight, but shall be seen after it
            self.problem, self._bug = f"{type(error).__name__}: {error}", error

    def _write_all(self) -> None:
        flushed = time.monotonic()
        while not self._ending:
            self._more.wait(EVERY)
            self._more.clear()
            self._write_queue()
            if time.monotonic() - flushed >= FLUSH:
                self._flush()
                flushed = time.monotonic()
        self._write_queue()
        self._flush()
        self._writer.add_metadata(END, {"ticks": json.dumps(self._logged), "lost": json.dumps(self.lost)})

    def _write_queue(self) -> None:
        while self._queue:
            self._write(self._queue.popleft())

    def _write(self, entry: Entry) -> None:
        number, heard, said = entry[:3]
        self._logged += 1
        ns = max(round(heard.t * 1e9), 0)
        self._put("in", heard.datagrams, number, ns)
        record = json.dumps(_tick(entry), separators=(",", ":"), allow_nan=False).encode()
        self._writer.add_message(self._tick_channel(), ns, record, ns, number)
        self._put("out", said.datagrams, number, ns)
        self._row, row = self._rows.step(self._row, said)
        if row is not None:
            self._episodes.append(row)

    def _put(self, way: str, datagrams: Sequence[Datagram], number: int, ns: int) -> None:
        for datagram in datagrams:
            key = (way, datagram.channel)
            if key not in self._channels:
                topic = f"/{way}/{datagram.channel.lstrip('/')}"
                about = {"way": way, "channel": datagram.channel}
                self._channels[key] = self._writer.register_channel(topic, "", 0, about)
            self._writer.add_message(self._channels[key], ns, datagram.data, ns, number)

    def _tick_channel(self) -> int:
        key = ("", TICKS)
        if key not in self._channels:
            text = json.dumps(schema("fledge.Tick", EXAMPLE), separators=(",", ":"))
            kind = self._writer.register_schema("fledge.Tick", "jsonschema", text.encode())
            self._channels[key] = self._writer.register_channel(TICKS, "json", kind)
        return self._channels[key]

    def _flush(self) -> None:
        """Rows go to the file some at a time, which is several times faster than one by one."""
        if self._episodes:
            self._flights.add(together(self._episodes))
            self._episodes = []
        self._writer.flush()
        self._safe = self._logged


def _tick(entry: Entry) -> dict[str, Any]:
    """A tick for people and their tools, in plain JSON."""
    number, heard, said, took_us, wires = entry
    seen = () if said.world is None else (said.world.uav, *said.world.ugvs)
    return {
        "tick": number,
        "t": heard.t,
        "took_us": took_us,
        "phase": said.phase.value,
        "complaint": said.complaint,
        "wires": wires,
        "seen": [_seen(state) for state in seen],
        "said": [_decided(decision) for decision in said.decisions],
    }


def _seen(state: UavState | UgvState) -> dict[str, Any]:
    if isinstance(state, UgvState):
        return {"x": _number(state.x), "y": _number(state.y), "z": 0.0, "stamp": _number(state.stamp)}
    p = state.position
    return {"x": _number(p.x), "y": _number(p.y), "z": _number(p.z), "stamp": _number(state.stamp)}


def _decided(decision: Decision) -> dict[str, Any]:
    verdict, alarm = decision.verdict, decision.alarm
    return {
        "mode": Mode(int(decision.mode)).name,
        "reason": Reason(int(verdict.reason)).name,
        "alarm": Reason(int(alarm.reason)).name,
        "severity": int(alarm.severity),
        "intervened": bool(verdict.intervened > 0.5),
        "clearance": _number(verdict.clearance),
        "command": to_json(verdict.command),
    }


def _number(value: Any) -> Any:
    return to_json(float(value))
