"""What a page says to the server: a record for each kind of message.

Who reads an order to stop reads it strictly: see `fields`. A field may be left out where the record has a default.
Stamps are in milliseconds by the page's own clock, and only ever come back to it. Flags are true or false.
"""

from dataclasses import dataclass

from fledge.lab import UINT32
from fledge.lab.wire.fields import flag, listed, number, of, one_of, or_null, text, whole

LONGEST_NAME = 200
"""[characters]."""
MOST_VEHICLES = 64
LARGEST_SEED = 2**32 // 1000 - 1
"""As on the command line: a training's key is 1000 seed + its number, in 32 bits."""
RECORDS = ("nothing", "demonstration", "flight")
WORLDS = ("simulator", "twin", "attached")

NAME = text(LONGEST_NAME)
STAMP = number(-1e15, 1e15)


@dataclass(frozen=True, slots=True)
class Sticks:
    """What a person says about one vehicle, many times a second; flags are those of `supervision.inputs.Operator`."""

    sequence: int = of(whole(0, UINT32))
    """Counts up."""
    stamp: float = of(STAMP)
    """[ms]."""
    vehicle: int = of(whole(0, MOST_VEHICLES - 1))
    """0 is the UAV, then come the UGVs."""
    axes: tuple[float, ...] = of(listed(number(-1.0, 1.0), 4, 4))
    """Forward, left, up, turn."""
    switch: bool = of(flag, False)
    hand_back: bool = of(flag, False)
    stop: bool = of(flag, False)
    dead_man: bool = of(flag, False)
    arm: bool = of(flag, False)
    """Of all vehicles."""
    land: bool = of(flag, False)
    terminate: bool = of(flag, False)


@dataclass(frozen=True, slots=True)
class Seat:
    """I want the operator's seat, or I give it up."""

    want: bool = of(flag)


@dataclass(frozen=True, slots=True)
class Fly:
    """A new flight."""

    manoeuvre: str = of(NAME)
    pilot: str = of(NAME)
    """A name, or "person"."""
    net: str = of(NAME)
    speed: float = of(number(0.1, 4.0), 1.0)
    """Flight time over real time."""
    seed: int = of(whole(0, LARGEST_SEED), 0)
    record: str = of(one_of(*RECORDS), "nothing")
    world: str = of(one_of(*WORLDS), "simulator")


@dataclass(frozen=True, slots=True)
class Pause:
    """Time stands still."""


@dataclass(frozen=True, slots=True)
class Resume:
    """It goes on."""


@dataclass(frozen=True, slots=True)
class Reset:
    """The same flight from its start."""


@dataclass(frozen=True, slots=True)
class Keep:
    """What was recorded is stored."""


@dataclass(frozen=True, slots=True)
class Discard:
    """What was recorded is thrown away."""


@dataclass(frozen=True, slots=True)
class Train:
    """A network learns from what was recorded."""

    setup: str = of(NAME)
    epochs: int | None = of(or_null(whole(1, 100_000)), None)
    """Other than the recipe's."""
    takeovers: bool = of(flag, False)
    """Whether it learns from what people did who took over, too."""


@dataclass(frozen=True, slots=True)
class Cancel:
    """No more of that."""
