"""The kinds of options: how each looks in the help, and what is refused before any work begins."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

from tyro.conf import FlagCreatePairsOff, Positional, arg
from tyro.constructors import PrimitiveConstructorSpec

from fledge.errors import BadFile, OutOfRange, UnknownName
from fledge.lab.shell.udp import STICKS_PORT
from fledge.lab.wire import ardrone, vicon

LEAST_STEPS = 24_000
"""Every family of attacks flies at least once."""

LARGEST_SEED = 2**32 // 1000 - 1
"""The key of a training is 1000 seed + its number, in 32 bits."""

MOST_CASES = 10_000
"""All flights of an evaluation are in the air at once: about 3 GB."""


def _kind(metavar: str, read: Callable[[str], Any]) -> PrimitiveConstructorSpec[Any]:
    """An option of one word."""
    return PrimitiveConstructorSpec(
        nargs=1,
        metavar=metavar,
        instance_from_str=lambda words: read(words[0]),
        is_instance=lambda value: True,
        str_from_instance=lambda value: [str(value)],
    )


def _number(name: str, kind: type, least: float, most: float) -> PrimitiveConstructorSpec[Any]:
    """A number within bounds."""

    def read(word: str) -> Any:
        try:
            number = kind(word)
        except ValueError:
            number = None
        if number is None or not least <= number <= most:
            whole = "a whole number from " if kind is int else ""
            raise OutOfRange(name, word, f"{whole}{least:,} to {most:,}")
        return number

    return _kind("N", read)


def _file(word: str) -> Path:
    """A file that can be written when all work is done, as far as can be told before."""
    path = Path(word)
    if path.is_dir() or not path.parent.is_dir():
        raise BadFile(path, "cannot be written: valid is a file in a folder that exists")
    return path


def _address(port: int) -> PrimitiveConstructorSpec[Any]:
    """HOST[:PORT], with this port where none is given."""
    return PrimitiveConstructorSpec(
        nargs=1,
        metavar="HOST[:PORT]",
        instance_from_str=lambda words: _endpoint(words[0], port),
        is_instance=lambda value: True,
        str_from_instance=lambda value: [f"{value[0]}:{value[1]}" if value else "none"],
    )


def _endpoint(word: str, port: int) -> tuple[str, int]:
    host, colon, given = word.rpartition(":") if ":" in word else (word, "", "")
    number = int(given) if given.isdecimal() else 0 if colon else port
    if not host or not 0 < number < 2**16:
        raise OutOfRange("address", repr(word), "HOST or HOST:PORT, with a port from 1 to 65535")
    return host, number


def _wire(scheme: str, port: int) -> PrimitiveConstructorSpec[Any]:
    """scheme://HOST[:PORT], or ros, which is None."""

    def read(word: str) -> tuple[str, int] | None:
        if word == "ros":
            return None
        if not word.startswith(f"{scheme}://"):
            raise OutOfRange("wire", repr(word), f"{scheme}://HOST, {scheme}://HOST:PORT, or ros")
        return _endpoint(word.removeprefix(f"{scheme}://"), port)

    return PrimitiveConstructorSpec(
        nargs=1,
        metavar=f"{scheme}://HOST[:PORT]|ros",
        instance_from_str=lambda words: read(words[0]),
        is_instance=lambda value: True,
        str_from_instance=lambda value: [f"{scheme}://{value[0]}" if value else "ros"],
    )


def _hands(word: str) -> tuple[str, tuple[str, int] | None]:
    """Who sits at the sticks, and where they are heard if that is an address."""
    if word in ("keyboard", "joy"):
        return word, None
    name, _, address = word.partition("://")
    if name not in ("udp", "ws"):
        raise UnknownName(
            "operator", word, ("keyboard", "joy", "udp", "ws", "udp://HOST:PORT", "ws://HOST:PORT")
        )
    return name, _endpoint(address or "127.0.0.1", STICKS_PORT)


SILENT = arg(help_behavior_hint="")
"""The help says in words what happens by default."""

Flag = Annotated[bool, FlagCreatePairsOff, SILENT]
Seed = Annotated[int, _number("seed", int, 0, LARGEST_SEED)]
Cases = Annotated[int, _number("cases", int, 2, MOST_CASES)]
Flights = Annotated[int, _number("flights", int, 1, MOST_CASES)]
Episodes = Annotated[int | None, _number("episodes", int, 1, 1000), SILENT]
Epochs = Annotated[int | None, _number("epochs", int, 1, 1_000_000), SILENT]
Steps = Annotated[int, _number("steps", int, LEAST_STEPS, 10**10)]
Factor = Annotated[float, _number("factor", float, 0.0, 5.0)]
Speed = Annotated[float, _number("speed", float, 0.01, 50.0)]
Seconds = Annotated[float | None, _number("duration", float, 0.1, 1e6), SILENT]
Lasting = Annotated[float, _number("seconds", float, 1.0, 600.0)]
Jobs = Annotated[int | None, _number("jobs", int, 1, 1000), SILENT]
Port = Annotated[int, _number("port", int, 0, 2**16 - 1)]
PemFile = Annotated[Path | None, _kind("FILE", Path), SILENT]
Attach = Annotated[tuple[str, int] | None, _address(STICKS_PORT), SILENT]
Mocap = Annotated[tuple[str, int], _address(vicon.PORT)]
Vehicle = Annotated[tuple[str, int], _address(ardrone.PORT)]
Poses = Annotated[tuple[str, int] | None, _wire("vicon", vicon.PORT)]
Drone = Annotated[tuple[str, int] | None, _wire("ardrone", ardrone.PORT)]
Hands = Annotated[tuple[str, tuple[str, int] | None], _kind("keyboard|joy|udp|ws", _hands), SILENT]
Maybe = Annotated[str | None, _kind("NAME", str), SILENT]
PolicyFile = Annotated[Path | None, Positional, _kind("POLICY", Path), SILENT]
Words = Annotated[tuple[str, ...], arg(metavar="WORD ...", help_behavior_hint="")]
Minutes = Annotated[float | None, _number("minutes", float, 0.1, 60.0), SILENT]
Name = Annotated[str, arg(metavar="NAME")]
Axis = Literal["forward", "left", "up", "turn"]
Axes = Annotated[tuple[Axis, ...], arg(metavar="forward|left|up|turn ...", help_behavior_hint="")]
Logs = Annotated[tuple[Path, ...], Positional, arg(metavar="FLIGHT ...", help_behavior_hint="")]
Hall = Annotated[str | None, _kind("NAME|FILE", str), SILENT]
Files = Annotated[tuple[Path, ...], arg(metavar="FILE ...", help_behavior_hint="")]
Names = Annotated[tuple[str, ...], arg(metavar="NAME ...", help_behavior_hint="")]
Contestants = Annotated[tuple[str, ...], Positional, arg(metavar="FILE|PILOT ...", help_behavior_hint="")]
Contestant = Annotated[str, Positional, arg(metavar="FILE|PILOT")]
Folder = Annotated[Path, arg(metavar="FOLDER")]
File = Annotated[Path, arg(metavar="FILE")]
NewFile = Annotated[Path | None, _kind("FILE", _file), SILENT]
