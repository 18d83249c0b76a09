"""Flights on disk: one MCAP file each, readable without fledge.

| where | what |
|---|---|
| metadata `fledge.flight` | format version, and all about the flight but its rows; each value is JSON |
| topic `/fledge/row` | one message per 20 Hz row: the fields of `Episode`, each leaf a number |
| topics `/fledge/frames`, `/fledge/scene` | for Foxglove's 3D panel; derived, never read back |
| metadata `fledge.end` | how many rows there are and of what dtype each leaf is |

Messages and schemas are JSON. A number is written so that it reads back as the same number: a flight comes
back bit for bit (but that a NaN is like any other). A file's time is the row's own, in nanoseconds since the
flight began, and never the clock's: same flight, same bytes.

What is known beforehand stands at the start and what is only known afterwards at the end, so a flight can be
written while it is flown (`FlightLog`). A file without its end is refused by `read_flight`; what of it is whole
`recover_flight` reads.
"""

import json
import os
from collections.abc import Container, Iterable, Iterator
from contextlib import suppress
from dataclasses import fields
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, get_type_hints

import numpy as np
from mcap.reader import make_reader
from mcap.records import Channel, Message, Metadata
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer

from fledge.episode import Episode, Flight
from fledge.errors import BadFile, FledgeError
from fledge.storage.atomic import AnyPath, reading, replacing
from fledge.storage.foxglove import poses, scene, schema, template, transforms
from fledge.storage.records import NON_FINITE, from_json, from_tree, shown, to_json, to_tree

FORMAT = "1"
"""Version of the layout above; a reader refuses every other."""

CHUNK = 65_536
"""[bytes] that wait in memory, about one second of flight: what a log loses when its writer is killed."""

FACTS, END = "fledge.flight", "fledge.end"
ROWS, FRAMES, SCENE = "/fledge/row", "/fledge/frames", "/fledge/scene"

NINE_DIGITS = "%.9g".__mod__
"""Enough for a float32 to come back (IEEE 754, 5.12.2), and half the work of its seventeen as a double."""

_WORDS = {python: f'"{word}"' for python, word in NON_FINITE.items()} | {
    "True": "true",
    "False": "false",
    "-0": "-0.0",
}
"""JSON for what Python says differently; as JSON, -0 would be a whole number and lose its sign."""

_EXAMPLES = {"b": False, "i": 0, "u": 0, "f": 0.0}
"""A value of each kind of number a leaf may be, by NumPy's letter."""

_WRITTEN_AS = {"b": "b", "i": "bi", "u": "biu", "f": "f"}
"""What kinds of number a column of some kind may have in the file: in a live log one row's truth may be the
next row's whole number."""


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
        facts, end, messages = _contents(file, _check_ends(file))
        rows, dtypes = json.loads(end["rows"]), json.loads(end["columns"])
        if not rows or [message.sequence for message in messages] != list(range(rows)):
            raise FledgeError(
                f"damaged: {len(messages)} rows, where its record says {rows}; valid is 1 or more"
            )

        def leaf(path: str, kind: Any, value: Any) -> Any:
            part, _, name = path.partition(".")
            if part == "episode":
                return _column(np.dtype(dtypes[name]), value)
            return from_json(kind, value, path)

        known = {name: json.loads(text) for name, text in facts.items() if name != "format"}
        return from_tree(Flight, {"episode": _rows(messages), **known}, leaf)


def read_facts(path: AnyPath) -> dict[str, Any]:
    """What a stored flight was, and how many `rows` it has, as JSON values; by the file's index, so it is quick.

    Raises:
        BadFile: missing, truncated, foreign, or of another format version; rows are not looked at.
    """
    with reading(path, "a flight"), open(path, "rb") as file:
        _check_ends(file)
        metadata = {one.name: one.metadata for one in make_reader(file).iter_metadata()}
        _check_facts(metadata)
        facts, rows = _checked_facts(metadata), json.loads(metadata[END]["rows"])
        known = {name: json.loads(text) for name, text in facts.items() if name != "format"}
        if sorted(known) != sorted(_fact_names()):
            raise FledgeError(f"the record has {', '.join(known)}: valid are {', '.join(_fact_names())}")
        kinds = get_type_hints(Flight)
        for name, value in known.items():
            from_json(kinds[name], value, name)
        if type(rows) is not int or rows < 1:
            raise FledgeError(f"damaged: its record says {shown(rows)} rows; valid is 1 or more")
        return known | {"rows": rows}


def recover_flight(path: AnyPath) -> Flight:
    """The flight in a file that was cut short, as far as it was written; every float is then a double.

    Raises:
        BadFile: missing, foreign, or no row of it is whole.
    """
    with reading(path, "a flight"), open(path, "rb") as file:
        metadata, messages = _whole_records(file)
        _check_facts({END, *metadata})
        facts = _checked_facts(metadata)
        if not messages or [message.sequence for message in messages] != list(range(len(messages))):
            raise FledgeError(
                f"cut short: {len(messages)} rows are whole; valid is 1 or more, from the first"
            )

        def leaf(path: str, kind: Any, value: Any) -> Any:
            if path.startswith("episode."):
                return np.array(value, dtype=int if all(type(one) is int for one in value) else float)
            return from_json(kind, value, path)

        known = {name: json.loads(text) for name, text in facts.items() if name != "format"}
        return from_tree(Flight, {"episode": _rows(messages), **known}, leaf)


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

    def __init__(self, stream: BinaryIO, about: Flight) -> None:
        """Write to `stream`, which stays open. Of `about` all is taken but its episode."""
        self._arena = about.arena
        self._rows = 0
        self._dtypes: dict[str, np.dtype] = {}
        self.writer = Writer(
            stream, chunk_size=CHUNK, compression=CompressionType.ZSTD, enable_data_crcs=True
        )
        """Of the whole file, for those who have more to say of a flight, on topics of their own."""
        self.writer.start(library="fledge")
        facts = {name: json.dumps(to_json(getattr(about, name))) for name in _fact_names()}
        self.writer.add_metadata(FACTS, {"format": FORMAT, **facts})

    def __enter__(self) -> "FlightLog":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        columns = {path: dtype.name for path, dtype in self._dtypes.items()}
        self.writer.add_metadata(END, {"rows": json.dumps(self._rows), "columns": json.dumps(columns)})
        self.writer.finish()

    def add(self, rows: Episode) -> None:
        """Append rows: leaves of shape (rows,), or plain numbers for one row.

        Raises:
            FledgeError: leaves that are not numbers, or not all of one such shape.
        """
        columns = _columns(rows)
        now = _nanoseconds(columns["world.t"])
        if not self._dtypes:
            self._begin(rows, columns, int(now[0]))
        if columns.keys() != self._dtypes.keys():
            raise FledgeError(f"{len(rows.world.ugvs)} UGVs: valid are as many as in the rows before")
        for path, column in columns.items():
            self._dtypes[path] = np.result_type(self._dtypes[path], column.dtype)
        texts = zip(*_texts(columns), strict=True)
        frames = poses(rows.world, now)
        shown = np.asarray(np.isfinite(frames).all(axis=1)).tolist()
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
        return self.writer.register_channel(
            topic, "json", self.writer.register_schema(name, "jsonschema", text.encode())
        )

    def _put(self, channel: int, t: int, text: str) -> None:
        self.writer.add_message(channel, t, text.encode(), publish_time=t, sequence=self._rows)


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
    """The numbers of each column as JSON; columns that are equal (sent as proposed) are worded once."""
    made: dict[tuple[str, bytes], list[str]] = {}
    texts = []
    for column in columns.values():
        key = column.dtype.str, column.tobytes()
        if key not in made:
            text_of = NINE_DIGITS if column.dtype == np.float32 else repr
            made[key] = [_WORDS.get(text, text) for text in map(text_of, column.tolist())]
        texts.append(made[key])
    return texts


def _nanoseconds(t: np.ndarray) -> np.ndarray:
    """Times [s] as MCAP has them, shape (rows,); 0 for what it cannot have: NaN, negative, centuries on."""
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
    """(facts, end, messages of the rows) of a flight; every checksum is compared on the way."""
    summary = make_reader(file).get_summary()
    if summary is not None:  # do not plough through gigabytes that are not ours
        _check_facts({index.name for index in summary.metadata_indexes})
    metadata, messages = _sorted_out(_records(file, size))
    _check_facts(metadata)
    return _checked_facts(metadata), metadata[END], messages


def _records(file: BinaryIO, size: int) -> Iterator[Any]:
    file.seek(0)
    return StreamReader(file, validate_crcs=True, record_size_limit=size).records


def _whole_records(file: BinaryIO) -> tuple[dict[str, dict[str, str]], list[Message]]:
    """(metadata by name, messages of the rows) up to where a file was cut short or is damaged."""

    def whole() -> Iterator[Any]:
        with suppress(Exception):  # the parser raises as it pleases
            yield from _records(file, size)

    size = file.seek(0, os.SEEK_END)
    return _sorted_out(whole())


def _sorted_out(records: Iterable[Any]) -> tuple[dict[str, dict[str, str]], list[Message]]:
    """(metadata by name, messages of the rows)."""
    metadata: dict[str, dict[str, str]] = {}
    messages: list[Message] = []
    channel = None
    for record in records:
        if isinstance(record, Metadata):
            metadata[record.name] = record.metadata
        elif isinstance(record, Channel) and record.topic == ROWS:
            channel = record.id
        elif isinstance(record, Message) and record.channel_id == channel:
            messages.append(record)
    return metadata, messages


def _checked_facts(metadata: dict[str, dict[str, str]]) -> dict[str, str]:
    facts = metadata[FACTS]
    if facts.get("format") != FORMAT:
        raise FledgeError(f"a flight of format {facts.get('format')!r}: this fledge reads {FORMAT!r}")
    return facts


def _check_facts(names: Container[str]) -> None:
    if FACTS not in names:
        raise FledgeError(f"an MCAP file without the record {FACTS!r}: valid is a flight stored by fledge")
    if END not in names:
        raise FledgeError(f"cut short: a flight without the record {END!r}")


def _rows(messages: list[Message]) -> Any:
    """The tree of an Episode, a list of values for each leaf."""
    return _transposed(json.loads(b"[" + b",".join(message.data for message in messages) + b"]"))


def _transposed(rows: list[Any]) -> Any:
    """A list of equal trees as one tree of lists."""
    if isinstance(rows[0], dict):
        return {name: _transposed([row[name] for row in rows]) for name in rows[0]}
    if isinstance(rows[0], list):
        return [_transposed(list(items)) for items in zip(*rows, strict=True)]
    return rows


def _column(dtype: np.dtype, values: list[Any]) -> np.ndarray:
    """The values of a leaf as they were; those that are not finite are strings."""
    column = np.array(values, dtype=float if dtype.kind == "f" else None)
    if column.dtype.kind not in _WRITTEN_AS.get(dtype.kind, ""):
        raise FledgeError(f"damaged: {column.dtype} where its record says {dtype}")
    return column.astype(dtype)
