"""The lab: what motion capture and a real vehicle say on the wire, as functions of bytes.

A codec is a module with two verbs. `encode` makes bytes of records, and refuses what has no place on that
wire. `decode` makes records of bytes and never raises: anything may arrive at a port, so what is no frame
comes back as a value, `Malformed`, that says why. Records are in SI units, whatever the wire uses.

A decoder judges form alone. A pose that is no number is still a frame, and whether to believe it is
`tracking`'s to say; only what a vehicle would obey at once, a command, has to make sense here.

Nothing in the codecs opens a socket or reads a clock.
"""

from dataclasses import dataclass
from typing import Any

from fledge.errors import OutOfRange

UINT32 = 2**32 - 1
"""The largest number that fits."""


@dataclass(frozen=True, slots=True)
class Malformed:
    """Bytes that are no frame."""

    why: str
    """For people: what was found, and what would have been valid."""


def within(what: str, got: float, low: float, high: float) -> float:
    """The number itself, if it lies from `low` to `high`; NaN does not."""
    if not low <= got <= high:
        raise OutOfRange(what, got, f"{low:g} to {high:g}")
    return got


def whole(what: str, got: Any, low: int, high: int) -> int:
    """The number itself, if it is whole and lies from `low` to `high`."""
    if type(got) is not int or not low <= got <= high:
        raise OutOfRange(what, got, f"a whole number from {low:,} to {high:,}")
    return got
