"""Contracts on disk: what a safety net relies on in a lab, as TOML with the units in the names.

`fledge identify` writes it, `fledge fly --contract FILE` flies by it. In short:

    name = "ar-drone-2"        # for people; may be left out

    [contract]                 # what data and world are like; fields and meanings as in `safety.contract.Contract`
    period_s = 0.01
    ...

    [uav]                      # how the UAV stops: `safety.contract.UavStop`
    speed_s = 0.29
    ...

    [[ugv]]                    # how each UGV stops: `safety.contract.UgvStop`, in the order of the vehicles
    acceleration_m_s2 = 1.0
    ...

    [found]                    # where the numbers come from; for people, nobody reads it

Vehicles fly by what stands here, so a file is read strictly: a key that is unknown, misspelt or missing is an error,
and so is a number outside of what any vehicle has.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from fledge.errors import FledgeError, OutOfRange
from fledge.safety.contract import Contract, UavStop, UgvStop
from fledge.safety.terms import Terms
from fledge.storage.atomic import AnyPath, reading, write
from fledge.storage.records import check_keys, shown

UNITS = {
    **{name: "s" for name in ("period", "age", "latency", "hold_over", "silence", "lag")},
    **{
        name: "m"
        for name in ("position_error", "radius", "half_height", "height", "error", "error_up", "hold")
    },
    **{name: "m_s" for name in ("velocity_error", "most", "most_up")},
    **{name: "s" for name in ("speed", "speed_up", "followed", "followed_up", "error_speed")},
    **{"angle_error": "rad", "rate_error": "rad_s", "most_turn": "rad_s", "tilt": "m_rad"},
    **{"rate": "m_s_rad", "error_turn": "s2_rad", "disturbance": "m_s2", "acceleration": "m_s2"},
    "turn_acceleration": "rad_s2",
}
"""By a field's name: the end of its key."""
LEAST, MOST = -1.0, 50.0
"""What any number here may be, chosen: no vehicle of a lab needs more."""
SIGNED = ("tilt", "rate", "followed", "followed_up")
"""Coefficients that may be negative; nothing else may."""
PARTS: dict[str, type] = {"contract": Contract, "uav": UavStop, "ugv": UgvStop}


def read_contract(path: AnyPath) -> Terms:
    """The terms in a file.

    Raises:
        BadFile: missing, not TOML, or no contract.
    """
    with reading(path, "a contract"):
        file = tomllib.loads(Path(path).read_bytes().decode())
        check_keys("a contract", file, tuple(PARTS), ("name", "found"))
        if not isinstance(file["ugv"], list):
            raise FledgeError(f"ugv is {shown(file['ugv'])}: valid is a table under [[ugv]] for each")
        ugvs = tuple(_record(UgvStop, f"ugv {i}", one) for i, one in enumerate(file["ugv"], start=1))
        terms = Terms(
            _record(Contract, "contract", file["contract"]), _record(UavStop, "uav", file["uav"]), ugvs
        )
        _check(terms)
        return terms


def write_contract(path: AnyPath, terms: Terms, name: str, found: Mapping[str, Any], about: str = "") -> None:
    """Write them: `found` for people, `about` as a comment at the top.

    Raises:
        BadFile: it cannot be written.
    """
    lines = [f"# {line}".rstrip() for line in about.splitlines()]
    lines += [
        f"name = {_said(name)}",
        "",
        "[contract]",
        *_lines(terms.contract),
        "",
        "[uav]",
        *_lines(terms.uav),
    ]
    for ugv in terms.ugvs:
        lines += ["", "[[ugv]]", *_lines(ugv)]
    lines += ["", "[found]", *(f"{key} = {_said(value)}" for key, value in found.items())]
    write(path, ("\n".join(lines) + "\n").encode())


def _key(name: str) -> str:
    return f"{name}_{UNITS[name]}"


def _lines(record: Any) -> list[str]:
    """A record, field by field, to four digits; bounds that end on a digit are as good."""
    return [f"{_key(field.name)} = {_said(getattr(record, field.name))}" for field in fields(record)]


def _said(value: Any) -> str:
    """As TOML has it."""
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_said(one) for one in value) + "]"
    if isinstance(value, int):
        return str(value)
    return (
        f"{float(value):.4g}" if "." in f"{float(value):.4g}" or "n" in f"{value}" else f"{float(value):.1f}"
    )


def _record(kind: Any, name: str, table: Any) -> Any:
    """A record of its table."""
    names = [field.name for field in fields(kind)]
    check_keys(name, table, tuple(_key(one) for one in names))
    return kind(**{one: _number(name, one, table[_key(one)]) for one in names})


def _number(table: str, field: str, value: Any) -> float:
    least = LEAST if field in SIGNED else 0.0
    if type(value) not in (int, float) or not least <= value <= MOST:
        raise OutOfRange(f"{_key(field)} of {table}", shown(value), f"a number from {least:g} to {MOST:g}")
    return float(value)


def _check(terms: Terms) -> None:
    """What a net divides by, or could not fly with."""
    for i, ugv in enumerate(terms.ugvs, start=1):
        if not ugv.acceleration > terms.contract.disturbance or not ugv.turn_acceleration > 0.0:
            raise FledgeError(
                f"ugv {i} brakes at {ugv.acceleration:g} m/s^2: valid is more than the disturbance, "
                f"{terms.contract.disturbance:g}; and more than 0 rad/s^2 for its turns"
            )
    c = terms.contract
    if not (0.0 < c.period <= c.age + c.latency and terms.uav.lag > 0.0):
        raise FledgeError(
            f"a period of {c.period:g} s and a lag of {terms.uav.lag:g} s: valid is more than 0, the period "
            "no longer than age and latency together"
        )
