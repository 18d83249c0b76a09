r"""The AR.Drone's AT commands: lines of text, in datagrams to its port 5556.

    AT*NAME=<sequence>[,<argument>...]\r

A datagram holds whole lines, at most 1,024 characters. Numbers are int32 in decimal; PCMD's four shares are
the bits of a float32, read as such an integer: 0.2 is 1045220557. Text stands in double quotes.

    REF     bits        9 fly (unset: land), 8 emergency; 18, 20, 22, 24, 28 are always set
    PCMD    flags, roll, pitch, gaz, yaw
    FTRIM               the drone stands level: do so before take-off
    CONFIG  key, value
    CTRL    mode, 0     4 send the configuration, 5 clear the acknowledgement
    COMWDG              the answer to navdata that report a communication watchdog

The drone obeys a line only if its sequence number is larger than the last (`accepts`). Lines ought to come
every 30 ms: after 50 ms without one it reports its watchdog and counts from the start, after 2 s it holds the
link for lost.

References: Parrot, AR.Drone Developer Guide 2.0, sections on AT commands; lib/control of
github.com/felixge/node-ar-drone. The guide ends lines with a line feed, the drone's clients with a carriage
return; both are read here.
"""

import re
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from struct import Struct

from fledge.errors import OutOfRange
from fledge.lab import Malformed, whole, within

PORT = 5556
LONGEST = 1024
"""[characters] of a datagram."""
FIRST = 1
"""The sequence number to begin with, and to begin anew with."""
INT32 = 2**31 - 1

REF_ALWAYS = 1 << 18 | 1 << 20 | 1 << 22 | 1 << 24 | 1 << 28
REF_FLY = 1 << 9
REF_EMERGENCY = 1 << 8

FLOAT = Struct("<f")
BITS = Struct("<i")
LINE = re.compile(r"AT\*([A-Z_]+)=(\d{1,10})(?:,(.*))?", re.ASCII)
NUMBERS = re.compile(r"-?\d{1,10}(,-?\d{1,10})*", re.ASCII)
TEXT = r"[ !#-~]"  # printable ASCII without the double quote
TEXTS = re.compile(f'"({TEXT}+)","({TEXT}*)"')


@dataclass(frozen=True, slots=True)
class Ref:
    """Take off and stay in the air, or land and stay on the ground."""

    fly: bool
    emergency: bool = False
    """Cuts the motors when it becomes set; set anew once they are cut, it makes the drone ready again."""


class Flag(IntFlag):
    """How to read a PCMD."""

    PROGRESSIVE = 1
    """Obey the four shares; without it they mean nothing, and the drone hovers."""
    COMBINED_YAW = 2
    ABSOLUTE = 4


MOST_FLAGS = sum(Flag)


@dataclass(frozen=True, slots=True)
class Pcmd:
    """How to fly: four shares of what the drone's configuration allows, from -1 to 1, with the wire's signs.

    Roll and pitch are shares of a tilt, not of a speed: how fast the drone then flies is left to the air.
    """

    roll: float
    """Right [share of `euler_angle_max`]."""
    pitch: float
    """Back [share of `euler_angle_max`]."""
    gaz: float
    """Up [share of `control_vz_max`]."""
    yaw: float
    """Clockwise from above [share of `control_yaw`]."""
    flags: Flag = Flag.PROGRESSIVE

    @classmethod
    def hover(cls) -> "Pcmd":
        """Hold the place, by the drone's own bottom camera."""
        return cls(0.0, 0.0, 0.0, 0.0, Flag(0))


@dataclass(frozen=True, slots=True)
class Ftrim:
    """The drone stands level."""


@dataclass(frozen=True, slots=True)
class Config:
    """Set one entry of the configuration."""

    key: str
    """Such as `general:navdata_demo`; printable ASCII without double quotes, as the value."""
    value: str


class Mode(IntEnum):
    """What a CTRL asks for."""

    SEND_CONFIGURATION = 4
    CLEAR_ACKNOWLEDGEMENT = 5


@dataclass(frozen=True, slots=True)
class Ctrl:
    """Talk about the configuration."""

    mode: Mode


@dataclass(frozen=True, slots=True)
class Comwdg:
    """I am still here."""


Command = Ref | Pcmd | Ftrim | Config | Ctrl | Comwdg
NAMES = "REF, PCMD, FTRIM, CONFIG, CTRL, COMWDG"


@dataclass(frozen=True, slots=True)
class Line:
    """A command as it arrived."""

    sequence: int
    command: Command


def accepts(last: int, sequence: int) -> bool:
    """Whether the drone obeys a line, if the last that it obeyed had the number `last`; 0 if there was none.

    Number 1 is always obeyed, so that a client can start anew. An old 1 that arrives late is obeyed as well:
    the protocol cannot tell them apart.
    """
    return sequence == FIRST or sequence > last


def encode(first: int, *commands: Command) -> bytes:
    """One datagram of commands, numbered on from `first`.

    Raises:
        OutOfRange: a number that the protocol has no room for, text that cannot be quoted, too many commands.
    """
    whole("sequence number", first, FIRST, INT32 + 1 - len(commands))
    lines = [_line(sequence, command) for sequence, command in enumerate(commands, start=first)]
    data = "".join(lines).encode()
    if len(data) > LONGEST:
        raise OutOfRange(
            "length of AT commands [characters]", len(data), f"at most {LONGEST:,} in one datagram"
        )
    return data


def _line(sequence: int, command: Command) -> str:
    name, arguments = type(command).__name__.upper(), _arguments(command)
    return f"AT*{name}={','.join(map(str, (sequence, *arguments)))}\r"


def _arguments(command: Command) -> tuple[int | str, ...]:
    match command:
        case Ref(fly, emergency):
            return (REF_ALWAYS | REF_FLY * bool(fly) | REF_EMERGENCY * bool(emergency),)
        case Pcmd(roll, pitch, gaz, yaw, flags):
            shares = (("roll", roll), ("pitch", pitch), ("gaz", gaz), ("yaw", yaw))
            flags = whole("PCMD flags", int(flags), 0, MOST_FLAGS)
            return flags, *(_bits(f"share of {name}", share) for name, share in shares)
        case Config(key, value):
            text = f'"{key}","{value}"'
            if not TEXTS.fullmatch(text):
                raise OutOfRange("configuration", text, "printable ASCII without double quotes, and a key")
            return (text,)
        case Ctrl(mode):
            return int(mode), 0
        case Ftrim() | Comwdg():
            return ()


def _bits(what: str, share: float) -> int:
    return BITS.unpack(FLOAT.pack(within(what, share, -1.0, 1.0)))[0]


def decode(data: bytes) -> tuple[Line | Malformed, ...]:
    """Every line of a datagram, each by itself: one that is unknown here does not take its neighbours along.

    What follows the last line's end may be a number cut short, so it is no line.
    """
    *lines, rest = re.split("[\r\n]", data.decode("latin-1"))
    read = [_read(line) for line in lines if line]
    if rest:
        read.append(Malformed(f"{rest[:40]!r} has no end: valid is a carriage return"))
    return tuple(read)


def _read(line: str) -> Line | Malformed:
    match = LINE.fullmatch(line)
    if len(line) >= LONGEST or not match or int(match[2]) > INT32:
        return Malformed(
            f"{line[:40]!r}: valid is AT*NAME=sequence, then arguments, in {LONGEST:,} characters"
        )
    command = _command(match[1], match[3] or "")
    if command is None:
        return Malformed(f"{line[:40]!r}: valid are {NAMES}, with their arguments, in range")
    return Line(int(match[2]), command)


def _command(name: str, arguments: str) -> Command | None:
    if name == "CONFIG":
        texts = TEXTS.fullmatch(arguments)
        return Config(texts[1], texts[2]) if texts else None
    match name, _numbers(arguments):
        case "REF", (bits,):
            # Some clients leave out the bits that are always set, and drones fly all the same.
            return Ref(bool(bits & REF_FLY), bool(bits & REF_EMERGENCY))
        case "PCMD", (flags, *bits) if len(bits) == 4 and 0 <= flags <= MOST_FLAGS:
            shares = [FLOAT.unpack(BITS.pack(share))[0] for share in bits]
            return Pcmd(*shares, flags=Flag(flags)) if all(-1.0 <= share <= 1.0 for share in shares) else None
        case "CTRL", (mode, 0) if mode in tuple(Mode):
            return Ctrl(Mode(mode))
        case "FTRIM", ():
            return Ftrim()
        case "COMWDG", ():
            return Comwdg()
    return None


def _numbers(arguments: str) -> tuple[int, ...] | None:
    """Decimal int32 numbers; none at all are fine, as in clients that end a bare command with a comma."""
    if not arguments:
        return ()
    if not NUMBERS.fullmatch(arguments):
        return None
    numbers = tuple(map(int, arguments.split(",")))
    return numbers if all(-INT32 - 1 <= number <= INT32 for number in numbers) else None
