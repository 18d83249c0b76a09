"""What a flight in the cockpit is, whoever moves the vehicles: a scene that goes on by 10 ms with what people said.

memory = scene.init()
memory, shown = scene.tick(memory, spoken)
"""

from typing import Any, NamedTuple, Protocol

from fledge.camera import Picture
from fledge.cockpit.seat import Spoken
from fledge.episode import Episode, Flight
from fledge.safety import AbstractNet, Halt
from fledge.supervision.modes import Mode
from fledge.supervision.posts import Decision
from fledge.world import Reason, WorldState

PERSON = "person"
"""The pilot that is whoever sits in the cockpit, and the commander of a vehicle that is flown by hand."""
PILOTS_OWN = (Mode.AUTO, Mode.SHIELDED)
FLOWN = (*PILOTS_OWN, Mode.RECOVER, Mode.MANUAL)
"""Modes in which somebody flies."""
NET_REASONS = (
    *(Reason.WALL, Reason.OBSTACLE, Reason.VEHICLE),
    *(Reason.FLOOR, Reason.CEILING, Reason.NOT_FINITE),
)
"""What layer one says of a command that it changed."""


class Shown(NamedTuple):
    """What a tick comes to, for people and tapes."""

    world: WorldState
    decisions: tuple[Decision, ...]
    """One per vehicle, the UAV first."""
    commanders: tuple[str, ...]
    """Who flies each: "pilot", "guidance", "person", "net" or "nobody"."""
    picture: Picture
    row: Episode | None
    """The row that is over with this tick; its leaves are numbers."""
    flown: bool
    """Whether that was the pilot's."""
    over: bool
    """Whether the manoeuvre is."""
    armable: bool = True
    """Whether arming counts, as far as it is not the supervisor's to say."""
    battery: float | None = None
    """What is left, as a share; None if nobody knows."""
    note: str = ""
    """What is missing or wrong, in one line for people."""


class Scene(Protocol):
    """One flight: what stays as it is during it."""

    @property
    def about(self) -> Flight:
        """What the flight is, for its file; there is no episode yet."""
        ...

    @property
    def net(self) -> AbstractNet:
        """Behind which it is flown."""
        ...

    def init(self) -> Any:
        """Before anybody said anything."""
        ...

    def tick(self, memory: Any, spoken: Spoken) -> tuple[Any, Shown]:
        """10 ms later, with what people said."""
        ...

    def halts(self, memory: Any) -> tuple[Halt, ...]:
        """Where vehicles would come to rest; none if the net does not say."""
        ...

    def close(self) -> None:
        """Give back what is not memory."""
        ...


def commander(vehicle: int, decision: Decision, by_person: bool, leads: bool = False) -> str:
    """Who flies a vehicle: `by_person` says whether a person is the UAV's pilot, `leads` whether guidance flies it."""
    mode, verdict = decision.mode, decision.verdict
    if mode not in FLOWN:
        return "nobody"
    by_net = verdict.reason in NET_REASONS if mode == Mode.MANUAL else verdict.intervened > 0.5
    if by_net and mode != Mode.RECOVER:
        return "net"
    if mode == Mode.MANUAL:
        return PERSON
    if vehicle or leads:
        return "guidance"
    return PERSON if by_person else "pilot"
