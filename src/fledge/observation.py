"""What a pilot sees and what it may say: the paper's 11-vector (Table 2) and its four actions.

Symbols: the paper's (x^A, y^A) is `centre_u, centre_v`; (x^G, y^G) is `ugv_u, ugv_v`; z^A is `altitude`. The
text and Table 2 swap nu and nu-hat; here `ideal_radius` is the set-point and `radius` what is seen (D3). The
paper's actions phi (pitch), chi (roll), psi (altitude), omega (yaw) are `forward`, `left`, `up`, `turn`, in
that order, each in [-1, 1] (D1).

`Action` has no unit and `VelocityCommand` has: they are different types on purpose.
"""

from dataclasses import dataclass, fields

from fledge.camera import Lens, look
from fledge.errors import OutOfRange
from fledge.scalars import Scalar, clip
from fledge.world import VelocityCommand, WorldState

IDEAL_RADIUS_PX = 108.0
"""The radius the UGVs should have in the image [px]. Not given in the paper; 0.6 of half the short side (D3)."""

ROW_RATE = 20.0
"""[Hz] at which pilots decide and rows are stored: the paper's "approximately 0.05 s" (D4)."""


@dataclass(frozen=True, slots=True)
class Observation:
    """The state of Table 2, in its order."""

    centre_u: Scalar
    """Image centre, where the UAV is in its own picture [px]."""
    centre_v: Scalar
    """[px]."""
    ugv_u: Scalar
    """Centre of mass of the UGVs in the image, to the right [px]."""
    ugv_v: Scalar
    """Downwards [px]."""
    altitude: Scalar
    """Of the UAV above the floor [m]."""
    ideal_radius: Scalar
    """Radius the UGVs should have in the image [px]."""
    radius: Scalar
    """Distance from their centre of mass to the farthest UGV in the image [px]."""
    forward: Scalar
    """Velocity of the UAV in its heading frame [m/s]."""
    left: Scalar
    """[m/s]."""
    up: Scalar
    """[m/s]."""
    turn: Scalar
    """Yaw rate [rad/s]."""


OBSERVATION_NAMES = tuple(field.name for field in fields(Observation))
OBSERVATION_UNITS = ("px",) * 4 + ("m", "px", "px", "m/s", "m/s", "m/s", "rad/s")
VELOCITY_INPUTS = (7, 8, 9, 10)
"""The entries that nearly repeat the last action (the copycat trap, D15)."""


def observe(world: WorldState, lens: Lens, ideal_radius: Scalar = IDEAL_RADIUS_PX) -> Observation:
    """The 11 numbers of Table 2, exact: no noise, no delay."""
    picture = look(lens, world)
    uav = world.uav
    forward, left = uav.attitude.heading().from_world(uav.velocity.x, uav.velocity.y)
    zero = 0.0 * picture.u
    u, v = lens.centre
    return Observation(
        zero + u,
        zero + v,
        picture.u,
        picture.v,
        uav.position.z,
        zero + ideal_radius,
        picture.radius,
        forward,
        left,
        uav.velocity.z,
        uav.rates.z,
    )


@dataclass(frozen=True, slots=True)
class Action:
    """What a pilot says: stick deflections in [-1, 1]."""

    forward: Scalar
    left: Scalar
    up: Scalar
    turn: Scalar

    def only(self, axes: "Axes") -> "Action":
        """The same with the inactive axes at zero."""
        return Action(
            self.forward * axes.forward,
            self.left * axes.left,
            self.up * axes.up,
            self.turn * axes.turn,
        )


@dataclass(frozen=True, slots=True)
class Axes:
    """Which actions are in use: 1 or 0 each. A sub-task uses some; the lab flies without `up` and `turn`."""

    forward: Scalar = 1.0
    left: Scalar = 1.0
    up: Scalar = 1.0
    turn: Scalar = 0.0

    @classmethod
    def of(cls, indices: tuple[int, ...]) -> "Axes":
        """From action indices: 0 forward, 1 left, 2 up, 3 turn."""
        return cls(*(1.0 if i in indices else 0.0 for i in range(4)))


ACTION_NAMES = tuple(field.name for field in fields(Action))


@dataclass(frozen=True, slots=True)
class StickScale:
    """What full stick means."""

    horizontal: float = 1.0  # [m/s]; chosen, half of what tum_simulator's loop accepts
    vertical: float = 0.5  # [m/s]; the published limit of the vertical loop
    turn: float = 1.0  # [rad/s]; chosen below the published limit of 1.5

    def __post_init__(self) -> None:
        for name in ("horizontal", "vertical", "turn"):
            if not 0.0 < getattr(self, name) <= 10.0:
                raise OutOfRange(f"full-stick {name} speed", getattr(self, name), "above 0, to 10")

    def command(self, action: Action) -> VelocityCommand:
        """The velocity an action asks for; sticks beyond their stop count as at the stop."""
        return VelocityCommand(
            self.horizontal * clip(action.forward, -1.0, 1.0),
            self.horizontal * clip(action.left, -1.0, 1.0),
            self.vertical * clip(action.up, -1.0, 1.0),
            self.turn * clip(action.turn, -1.0, 1.0),
        )

    def action(self, command: VelocityCommand) -> Action:
        """The sticks that ask for a velocity; at their stop for one that none can ask for."""
        return Action(
            clip(command.forward / self.horizontal, -1.0, 1.0),
            clip(command.left / self.horizontal, -1.0, 1.0),
            clip(command.up / self.vertical, -1.0, 1.0),
            clip(command.turn / self.turn, -1.0, 1.0),
        )
