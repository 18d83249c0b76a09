"""What comes in from outside during one tick: poses, the policy's wish, the operator, and what is left to fly with.

Flags are numbers, set above one half. A flag that is not finite is not set, and whoever reads it sees that the record
around it is broken (`sane`).
"""

from dataclasses import dataclass
from math import inf

from fledge.scalars import Scalar, where
from fledge.world import Commands, VelocityCommand, WorldState

HOVER = VelocityCommand.hover()


@dataclass(frozen=True, slots=True)
class Operator:
    """What a person says about one vehicle."""

    command: VelocityCommand = HOVER
    """What the sticks ask for."""
    deflection: Scalar = 0.0
    """How far the sticks are from their middle, the farthest one, as a share of full deflection."""
    switch: Scalar = 0.0
    """The take-over switch: I fly."""
    hand_back: Scalar = 0.0
    """Held: the policy may fly again."""
    stop: Scalar = 0.0
    """Brake, hold, and wait for me."""
    dead_man: Scalar = 0.0
    """Held: my commands do not pass the net."""
    arm: Scalar = 0.0
    """Set as long as the vehicle may move; it must have been seen unset before."""
    land: Scalar = 0.0
    """Come down. A UGV stops, and has to be armed again."""
    terminate: Scalar = 0.0
    """Motors off, for good."""


@dataclass(frozen=True, slots=True)
class Inputs:
    """All of it; tuples have the UAV first, then the UGVs."""

    seen: WorldState
    """`seen.t` is now; each vehicle's stamp says when it was measured."""
    proposed: Commands
    """What the policy, or the guidance of the UGVs, wants."""
    decided: Scalar
    """When it decided so [s]."""
    operators: tuple[Operator, ...]
    heard: Scalar
    """When the operator's link was last heard [s]."""
    batteries: tuple[Scalar, ...]
    """What is left, as a share."""
    airborne: Scalar
    """Whether the UAV is off the ground; a flag."""

    @classmethod
    def unattended(cls, seen: WorldState, proposed: Commands) -> "Inputs":
        """A tick of a flight that lacks nothing: the operator arms once it has begun, then sits still."""
        one = 1.0 + 0.0 * seen.t
        operator = Operator(arm=where(seen.t > 0.0, one, 0.0))
        vehicles = 1 + len(seen.ugvs)
        return cls(seen, proposed, seen.t, (operator,) * vehicles, seen.t, (one,) * vehicles, one)


def said(flag: Scalar) -> Scalar:
    """Whether a flag is set."""
    return (flag > 0.5) & (flag < inf)


def finite(command: VelocityCommand) -> Scalar:
    """Whether a command consists of numbers."""
    return abs(command.forward + command.left + command.up + command.turn) < inf


def sane(operator: Operator) -> Scalar:
    """Whether all that an operator says are numbers."""
    o = operator
    flags = o.switch + o.hand_back + o.stop + o.dead_man + o.arm + o.land + o.terminate
    return finite(o.command) & (abs(o.deflection + flags) < inf)
