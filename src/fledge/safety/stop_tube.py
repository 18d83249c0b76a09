"""The default net: a command passes only if the vehicle could still stop after it.

*The rule.* "This command until the vehicle's own watchdog would end it, then brake" must leave room before every
face (`tube`); else the vehicle brakes. A UAV that has slowed down then holds the point it is about to rest at, since
zero velocity is no hold: a steady push drifts through it. A UGV stands where it stands, and may turn there.

*Why it is sound.* By induction: at every tick the stop that begins now ends in free space. A command that passes is
one after which that holds again; if none passes, the stop that was found free before goes on. Whatever proposes the
commands, NaN included, nothing is touched as long as the `Contract` holds.

*Why it is live.* Where there is no room (a vehicle may be started there, or pushed there) a command passes if it leads
out, and if none does, the UAV's hold point itself moves out. A way in which every stop fits is never closed.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from fledge.dynamics import UGV_FLEET
from fledge.geometry import Vec3
from fledge.safety.base import AbstractNet, Halt
from fledge.safety.contract import Contract, UavStop, UgvStop
from fledge.safety.halts import halts
from fledge.safety.tube import Face, UgvProposal
from fledge.safety.turns import Memory, UavTurn, UgvTurn, begin, clear, in_turn, sent_instead
from fledge.scalars import Scalar, cond, maximum, minimum
from fledge.world import Arena, Commands, Verdict, WorldState


@dataclass(frozen=True, slots=True)
class StopTube(AbstractNet):
    """Lets a command through only if the vehicle could still stop after it."""

    contract: Contract = Contract()
    uav: UavStop = UavStop()
    ugvs: tuple[UgvStop, ...] = tuple(UgvStop.of(model) for model in UGV_FLEET)
    outwards: float = (
        0.15  # [m/s] a UAV's command must lead out with; above the drift that the contract allows
    )
    scale: float = 1.0
    """Share of the proven margin that is kept; less than 1 is for measuring how much of it is needed."""

    @property
    def reserve(self) -> float:
        """None: all of the room may be used."""
        return 0.0

    def init(self, arena: Arena, world: WorldState) -> Memory:
        """Nothing was sent yet."""
        return begin(self, arena, world)

    def filter(
        self, memory: Memory, world: WorldState, commands: Commands
    ) -> tuple[Memory, tuple[Verdict, ...]]:
        """The UAV decides first, then the UGVs in their order."""
        return in_turn(self, memory, world, commands)

    def decide_uav(self, turn: UavTurn) -> tuple[Scalar, Vec3]:
        """The command as it is, if it leaves room before every face, or leads out where there is none."""
        c, passes = turn.wanted, turn.known
        for face in turn.faces:
            room = self._kept(face, face.room)
            away = face.x * c.x + face.y * c.y + face.z * c.z
            left = room + minimum(away, 0.0) * self.uav.hold_over
            passes = passes & ((left >= 0.0) | ((room < 0.0) & (away >= self.outwards)))
        return passes, c

    def decide_ugv(self, stop: UgvStop, turn: UgvTurn) -> tuple[Scalar, Scalar]:
        """The command as it is, if it leaves room before every face, or leads no nearer where there is none."""
        rooms = [self._kept(face, left) for face, left in zip(turn.faces, turn.rooms, strict=True)]
        passes = turn.known & cond(clear(rooms), lambda: True, partial(self._may_go, turn, rooms))
        return passes, turn.proposal.forward

    def _may_go(self, turn: UgvTurn, rooms: Sequence[Scalar]) -> Scalar:
        """Whether the proposal leads no nearer to the faces without room, or leaves some as the UGV turns by and by."""
        passes, forward = True, turn.proposal.forward
        for face, (forwards, backwards), room in zip(turn.faces, turn.shares, rooms, strict=True):
            nearer = maximum(forward * forwards, -forward * backwards)
            passes = passes & cond(
                (room >= 0.0) | (nearer <= 0.0), lambda: True, partial(self._clears, face, turn.proposal)
            )
        return passes

    def _clears(self, face: Face, proposal: UgvProposal) -> Scalar:
        return self._kept(face, face.room - proposal.sweep.advance(-face.x, -face.y)) >= 0.0

    def overruled(self, memory: Memory, world: WorldState, instead: Commands) -> Memory:
        """What was really sent is what the next stop begins with."""
        return sent_instead(self, memory, world, instead)

    def halts(self, memory: Memory, world: WorldState) -> tuple[Halt, ...]:
        """By what it remembers having sent."""
        return halts(self, memory, world)

    def _kept(self, face: Face, room: Scalar) -> Scalar:
        return room if self.scale == 1.0 else face.gap - self.scale * (face.gap - room)
