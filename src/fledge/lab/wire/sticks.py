"""What people say, from whatever they hold to the controller: JSON, one datagram each time, many times a second.

    {"sequence": 12, "stamp": 3.25, "operators": [
        {"command": [0.3, 0.0, 0.0, 0.0], "deflection": 0.3, "arm": 1}, {"arm": 1}, {"arm": 1}, {"arm": 1}]}

One operator per vehicle, the UAV first. `command` is what the sticks ask for: forward, left, up [m/s] and turn [rad/s];
`deflection` is a share of full deflection; all others are flags, 0 or 1, or false or true. What is 0 may be left out.
The sequence number counts up; the stamp is in seconds by the device's own clock, for logs.

Who reads an order to stop reads it strictly: an unknown or misspelt key is no frame, nor is a number that is not
finite.
"""

import json
from dataclasses import dataclass, fields
from math import isfinite
from typing import Any, NoReturn

from fledge.errors import OutOfRange
from fledge.lab import UINT32, Malformed, whole, within
from fledge.supervision.inputs import HOVER, Operator
from fledge.world import VelocityCommand

LONGEST = 8192
"""[bytes] of a datagram; chosen: four vehicles take 700, written out."""
MOST = 1e3
"""Largest number in a command, a deflection or a flag; chosen: beyond anything that flies, and far from overflow."""
FLAGS = tuple(field.name for field in fields(Operator) if field.name != "command")
"""And the deflection: all that is one number."""
KEYS = ("sequence", "stamp", "operators")


@dataclass(frozen=True, slots=True)
class Sticks:
    """What was said at one instant."""

    sequence: int
    stamp: float
    """By the device's clock [s]."""
    operators: tuple[Operator, ...]
    """One per vehicle, the UAV first."""


def encode(sticks: Sticks) -> bytes:
    """The datagram.

    Raises:
        OutOfRange: a number that is not finite or has no place here.
    """
    said = {
        "sequence": whole("sequence number", sticks.sequence, 0, UINT32),
        "stamp": within("stamp [s]", sticks.stamp, -1e12, 1e12),
        "operators": [_said(operator) for operator in sticks.operators],
    }
    data = json.dumps(said, separators=(",", ":")).encode()
    if len(data) > LONGEST:
        raise OutOfRange("length of what sticks say [bytes]", len(data), f"at most {LONGEST:,}")
    return data


def _said(operator: Operator) -> dict[str, Any]:
    numbers = {name: within(name, getattr(operator, name), -MOST, MOST) for name in FLAGS}
    said: dict[str, Any] = {name: number for name, number in numbers.items() if number != 0.0}
    if operator.command != HOVER:
        c = operator.command
        said["command"] = [
            within("command [m/s, rad/s]", x, -MOST, MOST) for x in (c.forward, c.left, c.up, c.turn)
        ]
    return said


def decode(data: bytes) -> Sticks | Malformed:
    """What a datagram says."""
    if len(data) > LONGEST:
        return Malformed(f"{len(data):,} bytes: valid is at most {LONGEST:,}")
    try:
        said = json.loads(data, parse_constant=_refuse)
        return _sticks(said)
    except RecursionError:
        return Malformed("brackets within brackets without end: valid is one object")
    except (ValueError, OverflowError) as error:  # no JSON, no UTF-8, or not what it has to say
        return Malformed(f"{str(error)[:200]}: valid is JSON with {', '.join(KEYS)}")


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is no number")


def _sticks(said: Any) -> Sticks:
    _check_keys("a datagram", said, KEYS)
    sequence, operators = said.get("sequence"), said.get("operators")
    if type(sequence) is not int or not 0 <= sequence <= UINT32:
        raise ValueError(f"sequence is {sequence!r:.40}")
    if type(operators) is not list:
        raise ValueError(f"operators is {operators!r:.40}")
    stamp = _number("stamp", said.get("stamp", 0.0), 1e12)
    return Sticks(sequence, stamp, tuple(_operator(one) for one in operators))


def _operator(said: Any) -> Operator:
    _check_keys("an operator", said, ("command", *FLAGS))
    flags = {name: _number(name, said[name], MOST) for name in FLAGS if name in said}
    axes = said.get("command", [0.0, 0.0, 0.0, 0.0])
    if type(axes) is not list or len(axes) != 4:
        raise ValueError(f"command is {axes!r:.40}")
    return Operator(VelocityCommand(*(_number("command", x, MOST) for x in axes)), **flags)


def _check_keys(what: str, said: Any, known: tuple[str, ...]) -> None:
    if type(said) is not dict:
        raise ValueError(f"{what} is {said!r:.40}")
    unknown = [key for key in said if key not in known]
    if unknown:
        raise ValueError(f"{what} has {unknown[0]!r:.40}")


def _number(what: str, got: Any, most: float) -> float:
    if type(got) not in (int, float, bool) or not isfinite(got) or abs(got) > most:
        raise ValueError(f"{what} is {got!r:.40}")
    return float(got)
