"""The protocol of a safety net (the field says safety filter or run-time assurance).

A net sees the world and what every vehicle is about to be told, and answers with one verdict per vehicle: the
command really sent, and why. It may be reviewed without reading any learning code: this folder imports
nothing above `dynamics`.
"""

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

from fledge.scalars import Scalar
from fledge.world import Arena, Commands, Verdict, WorldState


class Halt(NamedTuple):
    """Where a vehicle would come to rest if it were told to stop now."""

    x: Scalar
    """[m]."""
    y: Scalar
    """[m]."""
    miss: Scalar
    """By how much the stop may miss that [m]."""


class AbstractNet(ABC):
    """A net holds parameters; its memory is passed."""

    @abstractmethod
    def init(self, arena: Arena, world: WorldState) -> Any:
        """The memory of a net that guards `arena`, at the start of a flight."""

    @abstractmethod
    def filter(self, memory: Any, world: WorldState, commands: Commands) -> tuple[Any, tuple[Verdict, ...]]:
        """(memory, verdicts): the UAV's verdict first, then one per UGV. Called at 100 Hz.

        A command that is no number asks for nothing: a net that steers brakes and holds.
        """

    def overruled(self, memory: Any, world: WorldState, instead: Commands) -> Any:
        """The memory once something else was sent than the last verdicts; NaN wherever they were obeyed."""
        return memory

    def halts(self, memory: Any, world: WorldState) -> tuple[Halt, ...]:
        """Those of all vehicles, the UAV's first, for people to look at; none from a net that predicts none."""
        return ()
