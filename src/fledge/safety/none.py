"""No net at all: the baseline. Every command passes."""

from dataclasses import dataclass

from fledge.safety.base import AbstractNet
from fledge.world import Arena, Commands, Verdict, WorldState


@dataclass(frozen=True, slots=True)
class NoNet(AbstractNet):
    """Lets everything through."""

    def init(self, arena: Arena, world: WorldState) -> tuple[()]:
        """Nothing to remember."""
        return ()

    def filter(
        self, memory: tuple[()], world: WorldState, commands: Commands
    ) -> tuple[tuple[()], tuple[Verdict, ...]]:
        """The commands as they came."""
        zero = 0.0 * world.t
        return memory, tuple(
            Verdict(command, zero, zero, zero + float("inf")) for command in (commands.uav, *commands.ugvs)
        )
