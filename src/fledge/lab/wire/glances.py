"""What a flight under way shows of itself to whoever asks: JSON, one datagram each time, thirty times a second.

Whoever wrote last to the port is told from then on; what they write is not read. Every glance says all there is to say,
so nothing is lost with one that is lost: where everybody is, who flies them and why, and what the flight is. Numbers
that are not finite are null. It is for eyes, and nothing is flown by it.
"""

import json
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from fledge.lab import UINT32, Malformed
from fledge.lab.wire.fields import (
    Reader,
    flag,
    listed,
    made,
    nested,
    number,
    of,
    or_null,
    plain,
    refuse,
    text,
    whole,
)
from fledge.supervision.modes import Mode
from fledge.world import Reason

LONGEST = 32_768
"""[bytes] of a datagram; chosen: four vehicles take 1,300, an obstacle 60."""


def _member(kind: type[IntEnum]) -> Reader:
    """The number of one of these."""

    def read(what: str, got: Any) -> int:
        return int(kind(whole(0, max(kind))(what, got)))

    return read


_NUMBER = or_null(number(-1e9, 1e9))
_WORD = text(200)


@dataclass(frozen=True, slots=True)
class Vehicle:
    """One vehicle; of a UGV, `z` is 0, `attitude` its heading about the vertical, `velocity` along its nose."""

    position: tuple[float | None, ...] = of(listed(_NUMBER, 3, 3))
    """World [m]."""
    attitude: tuple[float | None, ...] = of(listed(_NUMBER, 4, 4))
    """Quaternion world_from_body, scalar part first."""
    velocity: tuple[float | None, ...] = of(listed(_NUMBER, 3, 3))
    """World [m/s]."""
    mode: int = of(_member(Mode))
    reason: int = of(_member(Reason))
    """The verdict's."""
    intervened: bool = of(flag)
    clearance: float | None = of(_NUMBER)
    """[m]; null if the net does not look."""
    sent: tuple[float | None, ...] = of(listed(_NUMBER, 4, 4))
    """Forward, left, up [m/s], turn [rad/s]."""


@dataclass(frozen=True, slots=True)
class Glance:
    """A flight at one instant."""

    sequence: int = of(whole(0, UINT32))
    """Counts up."""
    t: float = of(number(0.0, 1e9))
    """Since it began [s]."""
    phase: str = of(_WORD)
    complaint: str = of(text(500))
    """What is missing, in one line for people."""
    pilot: str = of(_WORD)
    net: str = of(_WORD)
    axes: tuple[int, ...] = of(listed(whole(0, 3), 1, 4))
    """Of the pilot's actions, those that are in use."""
    subjects: tuple[str, ...] = of(listed(_WORD, 1, 64))
    """The vehicles' names, the UAV first."""
    room: tuple[float, ...] = of(listed(number(-1e6, 1e6), 5, 5))
    """The arena: x_min, x_max, y_min, y_max, ceiling [m]."""
    boxes: tuple[tuple[float, ...], ...] = of(listed(listed(number(-1e6, 1e6), 5, 5), 0, 64))
    """Obstacles: x_min, x_max, y_min, y_max, height [m]."""
    vehicles: tuple[Vehicle, ...] = of(listed(nested(Vehicle), 0, 64))
    """None until everybody was seen."""


def encode(glance: Glance) -> bytes:
    """The datagram."""
    return json.dumps(plain(glance), separators=(",", ":"), allow_nan=False).encode()


def decode(data: bytes) -> Glance | Malformed:
    """What a datagram shows."""
    if len(data) > LONGEST:
        return Malformed(f"{len(data):,} bytes: valid is at most {LONGEST:,}")
    try:
        return made(Glance, "a glance", json.loads(data, parse_constant=refuse))
    except RecursionError:
        return Malformed("brackets within brackets without end: valid is one object")
    except (ValueError, OverflowError) as error:
        return Malformed(" ".join(str(error).split())[:200])
