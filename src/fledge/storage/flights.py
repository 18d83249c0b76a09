"""Flights on disk: one MCAP file each, readable without fledge.

| where | what |
|---|---|
| metadata `fledge.flight` | format version and everything about the flight but its rows, each value as JSON |
| topic `/fledge/row` | one message per 20 Hz row: the fields of `Episode`, each leaf a number |
| topics `/fledge/frames`, `/fledge/scene` | for Foxglove's 3D panel; derived, never read back (see `foxglove.py`) |
| metadata `fledge.end` | how many rows there are and of what dtype each leaf is |

Messages and schemas are JSON. A number is written as the shortest text that reads back as the same double, so
a flight comes back bit for bit (a NaN comes back as a NaN; its payload is not kept). A file's time is the
row's own, in nanoseconds since the flight began, and never the clock's: same flight, same bytes.

What is known beforehand stands at the start and what is only known afterwards at the end, so a flight can be
written while it is flown (`FlightLog`). A file without its end is refused here; MCAP's own tools can recover it.
"""

import json
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO

import numpy as np
from mcap.reader import make_reader
from mcap.records import Channel, Message, Metadata
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer

from fledge.episode import Episode, Flight
from fledge.errors import BadFile, FledgeError
from fledge.storage.atomic import AnyPath, reading, replacing
from fledge.storage.foxglove import poses, scene, schema, template, transforms
from fledge.storage.records import NON_FINITE, from_json, from_tree, to_json, to_tree

FORMAT = "1"
"""Version of the layout above; a reader refuses every other."""

FACTS, END = "fledge.flight", "fledge.end"
ROWS, FRAMES, SCENE = "/fledge/row", "/fledge/frames", "/fledge/scene"

_WORDS = {python: f'"{word}"' for python, word in NON_FINITE.items()} | {"True": "true", "False": "false"}
"""JSON for what Python's `repr` says differently."""

_EXAMPLES = {"b": False, "i": 0, "u": 0, "f": 0.0}
"""A value of each kind of number a leaf may be, by NumPy's letter."""


def write_flight(path: AnyPath, flight: Flight) -> None:
    """Store a flight.

    Raises:
        BadFile: the file cannot be written.
        FledgeError: the episode's leaves are not numbers of one shape (rows,), or there are none.
    """
    with replacing(path) as file, FlightLog(file, flight) as log:
        log.add(flight.episode)


def read_flight(path: AnyPath) -> Flight:
    """The flight as it was stored.

    Raises:
        BadFile: missing, truncated, damaged, foreign, or of another format version.
    """
    with reading(path, "a flight"), open(path, "rb") as file:
        size = _check_ends(file)
        facts, end, messages = _contents(file, size)
        known = {name: json.loads(text) for name, text in facts.items() if name != "format"}
        rows, dtypes = json.loads(end["rows"]), json.loads(end["columns"])
        if [message.sequence for message in messages] != list(range(rows)) or not rows:
            raise FledgeError(f"damaged: it holds {len(messages)} rows and its record says {rows}")
        return _flight(known, _episode(messages, dtypes))


def list_flights(folder: AnyPath) -> list[Path]:
    """The flights in a folder, by name.

    Raises:
        BadFile: there is no such folder.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise BadFile(folder, "there is no such folder; valid is a folder with flights (*.mcap)")
    return sorted(path for path in folder.glob("*.mcap") if not path.name.startswith("."))


class FlightLog:
    """A flight being written: facts first, rows as they come, the end on leaving the `with` block.

    Leaving it by an error ends the file just as well: the log of a flight that went wrong is the one to keep.
    """

    def __init__(self, stream: BinaryIO, about: Flight):
        """Write to `stream`, which stays open. Of `about` all is taken but its episode."""
        self._arena = about.arena
        self._rows = 0
        self._dtypes: dict[str, np.dtype] = {}
        self._writer = Writer(stream, compression=CompressionType.ZSTD, enable_data_crcs=True)
        self._writer.start(library="fledge")
        facts = {name: json.dumps(to_json(getattr(about, name))) for name in _fact_names()}
        self._writer.add_metadata(FACTS, {"format": FORMAT, **facts})

    def __enter__(self) -> "FlightLog":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        columns = {path: dtype.name for path, dtype in self._dtypes.items()}
        self._writer.add_metadata(END, {"rows": json.dumps(self._rows), "columns": json.dumps(columns)})
        self._writer.finish()

    def add(self, rows: Episode) -> None:
        """Append rows: leaves of shape (rows,), or plain numbers for one row.

        Raises:
            FledgeError: leaves that are not numbers, or not all of one such shape.
        """
        columns = _columns(rows)
        now = _nanoseconds(columns["world.t"])
        if not self._dtypes:
            self._begin(rows, columns, int(now[0]))
        for path, column in columns.items():
            self._dtypes[path] = np.result_type(self._dtypes[path], column.dtype)
        texts = zip(*_texts(columns), strict=True)
        frames = poses(rows.world, now)
        shown = np.isfinite(frames).all(axis=1).tolist()
        for t, text, frame, show in zip(now.tolist(), texts, frames.tolist(), shown, strict=True):
            self._put(self._row_channel, t, self._row_template % text)
            if show:
                self._put(self._frames_channel, t, self._frames_template % tuple(frame))
            self._rows += 1

    def _begin(self, rows: Episode, columns: dict[str, np.ndarray], t: int) -> None:
        """Channels and the scene: what depends on how many vehicles there are."""
        ugvs = len(rows.world.ugvs)
        self._dtypes = {path: column.dtype for path, column in columns.items()}
        self._row_template = template(to_tree(rows, lambda path, leaf: "%s"))
        self._frames_template = template(transforms(ugvs))
        shown = scene(self._arena, ugvs, t)
        example = to_tree(rows, lambda path, leaf: _EXAMPLES[self._dtypes[path].kind])
        self._row_channel = self._channel(ROWS, "fledge.Row", example)
        self._frames_channel = self._channel(FRAMES, "foxglove.FrameTransforms", transforms(ugvs, 0.0, 0))
        scene_channel = self._channel(SCENE, "foxglove.SceneUpdate", shown)
        self._put(scene_channel, t, json.dumps(shown, separators=(",", ":"), allow_nan=False))

    def _channel(self, topic: str, name: str, example: Any) -> int:
        text = json.dumps(schema(name, example), separators=(",", ":"))
        return self._writer.register_channel(
            topic, "json", self._writer.register_schema(name, "jsonschema", text.encode())
        )

    def _put(self, channel: int, t: int, text: str) -> None:
        self._writer.add_message(channel, t, text.encode(), publish_time=t, sequence=self._rows)


def _columns(rows: Episode) -> dict[str, np.ndarray]:
    """The leaves by their paths, each of shape (rows,)."""
    columns: dict[str, np.ndarray] = {}
    to_tree(rows, lambda path, leaf: columns.setdefault(path, np.atleast_1d(np.asarray(leaf))))
    shape = columns["world.t"].shape
    for path, column in columns.items():
        if column.dtype.kind not in _EXAMPLES or column.dtype.itemsize > 8:
            raise FledgeError(f"{path} is of dtype {column.dtype}: valid are numbers of at most 64 bits")
        if column.shape != shape or len(shape) != 1 or not shape[0]:
            raise FledgeError(
                f"{path} has shape {column.shape} and world.t has {shape}: "
                "valid is one shape (rows,) for all, with at least one row"
            )
    return columns


def _texts(columns: dict[str, np.ndarray]) -> list[list[str]]:
    """The numbers of each column as JSON. Many columns are equal (sent as proposed): their text is made once."""
    made: dict[tuple[str, bytes], list[str]] = {}
    texts = []
    for column in columns.values():
        key = column.dtype.str, column.tobytes()
        if key not in made:
            made[key] = [_WORDS.get(text, text) for text in map(repr, column.tolist())]
        texts.append(made[key])
    return texts


def _nanoseconds(t: np.ndarray) -> np.ndarray:
    """Times [s] as MCAP has them, shape (rows,); 0 for what it cannot have: before the start, NaN, centuries on."""
    t = t.astype(float)
    return np.round(np.where((t >= 0.0) & (t < 9e9), t, 0.0) * 1e9).astype(np.int64)


def _fact_names() -> list[str]:
    return [field.name for field in fields(Flight) if field.name != "episode"]


def _check_ends(file: BinaryIO) -> int:
    """The size of a file that begins and ends as an MCAP does."""
    head = file.read(len(MCAP0_MAGIC))
    size = file.seek(0, os.SEEK_END)
    file.seek(max(size - len(MCAP0_MAGIC), 0))
    tail = file.read()
    file.seek(0)
    if not head or not MCAP0_MAGIC.startswith(head):
        raise FledgeError(f"not an MCAP file, it begins with {head!r}: valid is a flight stored by fledge")
    if tail != MCAP0_MAGIC or size < 2 * len(MCAP0_MAGIC):
        raise FledgeError(f"cut short: an MCAP file whose end is missing after {size} bytes")
    return size


def _contents(file: BinaryIO, size: int) -> tuple[dict[str, str], dict[str, str], list[Message]]:
    """(facts, end, messages of the rows), every checksum compared."""
    summary = make_reader(file).get_summary()
    topics: list[str] = [] if summary is None else [channel.topic for channel in summary.channels.values()]
    indexed = summary is not None and {index.name for index in summary.metadata_indexes}
    if indexed is not False and FACTS not in indexed
