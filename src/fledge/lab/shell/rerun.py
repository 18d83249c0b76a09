"""The log of a lab flight, read back, and flown once more: the same datagrams into a fresh controller.

A controller is a pure function of what it hears, so on the machine that flew it, it says the same again, byte for byte.
If it does not, something entered that flight that is not in its log.

A log that was cut short, since its process was killed, say, is read as far as it goes.
"""

import json
import os
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from mcap.exceptions import EndOfFile, McapError
from mcap.reader import make_reader
from mcap.records import Attachment, Channel, Message, Metadata
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC

from fledge.errors import FledgeError
from fledge.lab.shell.logs import END, FORMAT, LAB, TICKS
from fledge.lab.wire.datagrams import Datagram, Heard
from fledge.storage.atomic import AnyPath, reading


class Replayed(Protocol):
    """A controller, as far as a replay goes."""

    def init(self) -> Any:
        """The memory at the start."""
        ...

    def step(self, memory: Any, heard: Heard) -> tuple[Any, Any]:
        """(memory, what is said)."""
        ...


class Logged(NamedTuple):
    """One tick of a log."""

    number: int
    heard: Heard
    said: tuple[Datagram, ...]


@dataclass(frozen=True, slots=True)
class Opening:
    """What stands at the beginning of a log."""

    brief: Mapping[str, Any]
    """What the controller was made of."""
    files: Mapping[str, bytes]
    """Those it was made of, by name."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """What came of a replay."""

    ticks: int
    """How many were the same."""
    difference: str = ""
    """Where the first one was that was not, and how; empty if there was none."""
    missing: str = ""
    """What of the flight the log does not have; empty if it has all."""


def is_log(path: AnyPath) -> bool:
    """Whether a file is the log of a lab flight, as far as its beginning tells."""
    try:
        read_opening(path)
    except FledgeError:
        return False
    return True


def read_opening(path: AnyPath) -> Opening:
    """What a log says of its flight before the first tick.

    Raises:
        BadFile: missing, damaged, no log of a lab flight, or of another format version.
    """
    with reading(path, "a log"):
        metadata: dict[str, dict[str, str]] = {}
        files: dict[str, bytes] = {}
        for record in _records(Path(path)):
            if isinstance(record, Metadata):
                metadata[record.name] = record.metadata
            elif isinstance(record, Attachment):
                files[record.name] = record.data
            elif isinstance(record, Message):
                break
        if LAB not in metadata:
            raise FledgeError(f"an MCAP file without the record {LAB!r}: valid is the log of a lab flight")
        if metadata[LAB].get("format") != FORMAT:
            got = metadata[LAB].get("format")
            raise FledgeError(f"a log of format {got!r}: this fledge reads {FORMAT!r}")
        return Opening(json.loads(metadata[LAB]["brief"]), files)


def read_ticks(path: AnyPath) -> Iterator[Logged]:
    """The ticks of a log, one by one, up to where it ends or was cut short.

    Raises:
        BadFile: missing, damaged, or no log of a lab flight.
    """
    with reading(path, "a log"):
        channels: dict[int, Channel] = {}
        tick = _Tick(-1)
        for record in _records(Path(path)):
            if isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Message):
                channel = channels[record.channel_id]
                if channel.topic != TICKS and "way" not in channel.metadata:
                    continue  # a row of the flight, or what is derived from it
                if record.sequence != tick.number:
                    yield from tick.whole()
                    tick = _Tick(record.sequence)
                tick.add(channel, record.data)
            elif isinstance(record, Metadata) and record.name == END:
                yield from tick.whole()  # the last of a log that was cut short may not be


def replay(path: AnyPath, controller: Replayed, see: Callable[[Any], None] = lambda said: None) -> Comparison:
    """Fly a log once more, and compare every byte said; `see` is given what is said now, tick by tick.

    Raises:
        BadFile: missing, damaged, or no log of a lab flight.
    """
    memory, same, missing = controller.init(), 0, ""
    for logged in read_ticks(path):
        if logged.number != same:
            missing = f"ticks {same:,} to {logged.number - 1:,} were not logged"
            break
        memory, said = controller.step(memory, logged.heard)
        difference = _difference(logged.said, said.datagrams)
        if difference:
            return Comparison(same, f"tick {logged.number:,}, {logged.heard.t:.2f} s: {difference}")
        same += 1
        see(said)
    return Comparison(same, "", missing or _missing(path))


def length(path: AnyPath) -> int:
    """How many ticks a log has; 0 if it was cut short, so that nobody knows."""
    return json.loads(_end(path).get("ticks", "0"))


class _Tick:
    """A tick of which more is to come."""

    def __init__(self, number: int) -> None:
        self.number = number
        self._t: float | None = None
        self._ways: dict[str, list[Datagram]] = {"in": [], "out": []}

    def add(self, channel: Channel, data: bytes) -> None:
        """One message of it."""
        if channel.topic == TICKS:
            self._t = json.loads(data)["t"]
        else:
            self._ways[channel.metadata["way"]].append(Datagram(channel.metadata["channel"], data))

    def whole(self) -> Iterator[Logged]:
        """The tick, if there was any."""
        if self._t is not None:
            heard = Heard(self._t, tuple(self._ways["in"]))
            yield Logged(self.number, heard, tuple(self._ways["out"]))


def _records(path: Path) -> Iterator[Any]:
    """All there are, up to where the file is cut short."""
    with open(path, "rb") as file:
        size = path.stat().st_size
        try:
            yield from StreamReader(file, validate_crcs=True, record_size_limit=max(size, 1)).records
        except (EndOfFile, struct.error, zlib.error, McapError):
            # The last record is not whole. What was damaged elsewhere shows as a checksum that is wrong.
            if not file.read(1) == b"":
                raise


def _missing(path: AnyPath) -> str:
    """What of the flight is not in the log."""
    end = _end(path)
    lost = json.loads(end.get("lost", "0"))
    return f"{lost:,} ticks were not logged" if lost else "" if end else "cut short: its end is missing"


def _end(path: AnyPath) -> dict[str, str]:
    """What a log says of itself at its end; nothing if it was cut short."""
    with reading(path, "a log"), open(path, "rb") as file:
        file.seek(-len(MCAP0_MAGIC), os.SEEK_END)
        if file.read() != MCAP0_MAGIC:
            return {}
        file.seek(0)
        return next((one.metadata for one in make_reader(file).iter_metadata() if one.name == END), {})


def _difference(logged: tuple[Datagram, ...], said: tuple[Datagram, ...]) -> str:
    """The first difference, in words; empty if there is none."""
    for before, now in zip(logged, said, strict=False):
        if before != now:
            return f"{before.channel} {_shown(before.data)} then, {now.channel} {_shown(now.data)} now"
    if len(logged) != len(said):
        return f"{len(logged)} datagrams then, {len(said)} now"
    return ""


def _shown(data: bytes) -> str:
    text = repr(data)
    return text if len(text) <= 100 else f"{text[:97]}..."
