"""What page and server say to each other: JSON text, one message a frame, each with its `kind`.

    page -> server    sticks seat fly pause resume reset keep discard train cancel      (`asks`)
    server -> page    welcome flight frame seat harvest stored lesson notice            (`tells`)

What is no message comes back as `Malformed`, which says why in one line; nothing that arrives raises.
"""

import json
from collections.abc import Mapping
from typing import Any

from fledge.cockpit.asks import Cancel, Discard, Fly, Keep, Pause, Reset, Resume, Seat, Sticks, Train
from fledge.cockpit.tells import Flight, Frame, Harvest, Lesson, Notice, Seating, Stored, Welcome
from fledge.errors import FledgeError
from fledge.lab import Malformed
from fledge.lab.wire.fields import made, plain, refuse

LONGEST_HEARD = 2_048
"""[bytes] of a message from a page; chosen: sticks take 250."""
LONGEST_SAID = 65_536
"""[bytes] of one to a page; chosen: a frame of four vehicles takes 2,000, a flight with 64 obstacles 8,000."""

FROM_PAGE: Mapping[str, type] = {
    "sticks": Sticks,
    "seat": Seat,
    "fly": Fly,
    "pause": Pause,
    "resume": Resume,
    "reset": Reset,
    "keep": Keep,
    "discard": Discard,
    "train": Train,
    "cancel": Cancel,
}
TO_PAGE: Mapping[str, type] = {
    "welcome": Welcome,
    "flight": Flight,
    "frame": Frame,
    "seat": Seating,
    "harvest": Harvest,
    "stored": Stored,
    "lesson": Lesson,
    "notice": Notice,
}

Ask = Sticks | Seat | Fly | Pause | Resume | Reset | Keep | Discard | Train | Cancel
Tell = Welcome | Flight | Frame | Seating | Harvest | Stored | Lesson | Notice
_KINDS = {kind: name for table in (FROM_PAGE, TO_PAGE) for name, kind in table.items()}


def encode(message: Ask | Tell) -> str:
    """The text of a message.

    Raises:
        FledgeError: a value that has no place in it; it says which.
    """
    kind = type(message)
    try:
        said = plain(message)
        made(kind, _KINDS[kind], said)
        line = json.dumps({"kind": _KINDS[kind], **said}, separators=(",", ":"), allow_nan=False)
    except ValueError as error:
        raise FledgeError(str(error)) from error
    longest = LONGEST_HEARD if kind in FROM_PAGE.values() else LONGEST_SAID
    if len(line) > longest:
        raise FledgeError(f"{_KINDS[kind]} has {len(line):,} characters: valid are up to {longest:,}")
    return line


def decode(data: str | bytes) -> Ask | Malformed:
    """What a page said, or why it is nothing that a page says."""
    return _decoded(data, FROM_PAGE, LONGEST_HEARD)


def decode_told(data: str | bytes) -> Tell | Malformed:
    """What a server said: for those who fly without a page."""
    return _decoded(data, TO_PAGE, LONGEST_SAID)


def _decoded(data: str | bytes, kinds: Mapping[str, type], longest: int) -> Any:
    if len(data) > longest:
        return Malformed(f"{len(data):,} bytes: valid are up to {longest:,}")
    try:
        said = json.loads(data, parse_constant=refuse)
        if type(said) is not dict:
            raise ValueError(f"{said!r:.40}: valid is an object")
        kind = said.pop("kind", None)
        if type(kind) is not str or kind not in kinds:
            raise ValueError(f"kind is {kind!r:.40}: valid are {', '.join(kinds)}")
        return made(kinds[kind], kind, said)
    except RecursionError:
        return Malformed("brackets within brackets without end: valid is one object")
    except (ValueError, OverflowError) as error:  # no JSON, no UTF-8, or not what it has to say
        return Malformed(" ".join(str(error).split())[:200])
