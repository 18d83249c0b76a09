"""What ROS 1 makes of a message: bytes, by its definition alone.

A definition lists fields, a type and a name each. On the wire the fields follow each other, little-endian, and nothing
is aligned:

    uint8, int32, uint32, float32, float64
    time          uint32 seconds, uint32 nanoseconds
    string        uint32 length, then as many bytes of UTF-8
    T[]           uint32 count, then as many T
    T[n]          n of them
    a message     its fields

Two nodes talk only if they agree on a sum: MD5 of the lines `type name` without comments, where a field that is a
message has its own sum for a type. So a definition with one slip in it is refused by every real node.

Values come and go flat, in the order of the wire: a time is two numbers, T[n] is n, T[] is one tuple, `uint8[]` one
`bytes`, a message whatever its fields are.

References: wiki.ros.org/msg, wiki.ros.org/ROS/Connection Header; the sums in gentools.py of github.com/ros/genmsg.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from hashlib import md5
from itertools import groupby
from struct import Struct
from typing import Any

from fledge.lab import Malformed

NUMBERS = {"uint8": "B", "int32": "i", "uint32": "I", "float32": "f", "float64": "d", "time": "II"}
COUNT = Struct("<I")
ARRAY = re.compile(r"(\w+)\[(\d*)\]")
RULE = "=" * 80
"""Between the definitions of a message and of those in it, where they are sent along."""

Values = tuple[Any, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Kind:
    """A type of message; there is one of each, so they are compared, and looked up, by identity."""

    name: str
    """With its package: `geometry_msgs/Twist`."""
    definition: str
    """Types and names in turn, with any space between them."""
    parts: tuple["Kind", ...] = ()
    """The messages that the definition names."""

    @property
    def fields(self) -> tuple[tuple[str, str], ...]:
        """(type, name) of each."""
        words = self.definition.split()
        return tuple(zip(words[::2], words[1::2], strict=True))

    @property
    def md5(self) -> str:
        """What nodes compare before they talk."""
        sums = {part.name: part.md5 for part in self.parts}
        text = "\n".join(f"{sums.get(type_, type_)} {name}" for type_, name in self.fields)
        return md5(text.encode(), usedforsecurity=False).hexdigest()

    @property
    def full_text(self) -> str:
        """The definition, and those of all messages in it: what a recorder keeps, to read the bytes by."""
        texts = [self._text(), *(f"MSG: {part.name}\n{part._text()}" for part in _inner(self))]
        return f"{RULE}\n".join(texts)

    def _text(self) -> str:
        return "".join(f"{type_} {name}\n" for type_, name in self.fields)


def pack(kind: Kind, *values: Any) -> bytes:
    """The bytes of a message; whoever calls has seen to it that every value fits its field."""
    rest = iter(values)
    return b"".join(part.pack(rest) for part in _layout(kind))


def unpack(kind: Kind, data: bytes) -> Values | Malformed:
    """The values of a message."""
    values, at = (), 0
    for part in _layout(kind):
        found = part.unpack(data, at)
        if isinstance(found, Malformed):
            return Malformed(f"a {kind.name} of {len(data)} bytes: {found.why}")
        some, at = found
        values += some
    if at != len(data):
        return Malformed(f"a {kind.name} of {len(data)} bytes: valid is {at}")
    return values


@dataclass(frozen=True, slots=True)
class Numbers:
    """Numbers whose count is known."""

    struct: Struct
    count: int

    def pack(self, rest: Iterator[Any]) -> bytes:
        """The next numbers of `rest`."""
        return self.struct.pack(*(next(rest) for _ in range(self.count)))

    def unpack(self, data: bytes, at: int) -> tuple[Values, int] | Malformed:
        """(numbers, where they end)."""
        end = at + self.struct.size
        if end > len(data):
            return Malformed(f"valid is at least {end}")
        return self.struct.unpack_from(data, at), end


@dataclass(frozen=True, slots=True)
class Bytes:
    """A string, or raw bytes."""

    text: bool

    def pack(self, rest: Iterator[Any]) -> bytes:
        """The next value of `rest`."""
        value = next(rest)
        raw = value.encode() if self.text else value
        return COUNT.pack(len(raw)) + raw

    def unpack(self, data: bytes, at: int) -> tuple[Values, int] | Malformed:
        """(the one value, where it ends)."""
        found = _span(data, at, 1)
        if isinstance(found, Malformed):
            return found
        start, _, end = found
        raw = data[start:end]
        if not self.text:
            return (raw,), end
        try:
            return (raw.decode(),), end
        except UnicodeDecodeError:
            return Malformed(f"{raw[:40]!r} is no text: valid is UTF-8")


@dataclass(frozen=True, slots=True)
class Many:
    """Numbers whose count goes before them."""

    code: str

    def pack(self, rest: Iterator[Any]) -> bytes:
        """The next value of `rest`."""
        numbers = next(rest)
        return COUNT.pack(len(numbers)) + Struct(f"<{len(numbers)}{self.code}").pack(*numbers)

    def unpack(self, data: bytes, at: int) -> tuple[Values, int] | Malformed:
        """(the one tuple, where it ends)."""
        found = _span(data, at, Struct(f"<{self.code}").size)
        if isinstance(found, Malformed):
            return found
        start, count, end = found
        return (Struct(f"<{count}{self.code}").unpack_from(data, start),), end


def _span(data: bytes, at: int, size: int) -> tuple[int, int, int] | Malformed:
    """(start, count, end) of what follows a count, `size` bytes each."""
    start = at + COUNT.size
    if start > len(data):
        return Malformed(f"valid is at least {start}")
    (count,) = COUNT.unpack_from(data, at)
    end = start + count * size
    return (start, count, end) if end <= len(data) else Malformed(f"valid is at least {end}")


@cache
def _layout(kind: Kind) -> tuple[Numbers | Bytes | Many, ...]:
    """How to read and write a message; numbers that follow each other are one."""
    parts = []
    for fixed, group in groupby(_codes(kind), key=lambda code: isinstance(code, str)):
        codes = list(group)
        if fixed:
            struct = Struct("<" + "".join(map(str, codes)))
            parts.append(Numbers(struct, len(struct.unpack(bytes(struct.size)))))
        else:
            parts += codes
    return tuple(parts)


def _codes(kind: Kind) -> Iterator[str | Bytes | Many]:
    """Of each field: its letters for `struct`, or how else it is read."""
    inner = {part.name: part for part in kind.parts}
    for type_, _ in kind.fields:
        array = ARRAY.fullmatch(type_)
        if type_ in inner:
            yield from _codes(inner[type_])
        elif type_ in ("string", "uint8[]"):
            yield Bytes(type_ == "string")
        elif array:
            yield array[2] + NUMBERS[array[1]] if array[2] else Many(NUMBERS[array[1]])
        else:
            yield NUMBERS[type_]


def _inner(kind: Kind) -> tuple[Kind, ...]:
    """Every message in a message, once, those nearest first."""
    found = dict.fromkeys(kind.parts)
    for part in kind.parts:
        found |= dict.fromkeys(_inner(part))
    return tuple(found)
