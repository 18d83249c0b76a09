"""The UGVs of a lab that drives them itself: they wait on their corners, then follow a plan's track.

Over UDP nobody commands the UGVs but the twin. Their guidance is the study's (`formation`), on true poses, 20 times a
second. They wait until the UAV has been overhead for a second; while it is gone, or low, they stand, and the track
waits for them. After the track's last row they stand for good.

They stop by themselves, too: whoever would come nearer to anything than it can brake, by the referee's distances from
hull to hull, stands still until its guidance turns it away. Nothing is proved of that. In a real lab it would be the
robots' sonars and bumpers.
"""

from dataclasses import dataclass
from math import hypot
from typing import NamedTuple

from fledge.clearance import clearance
from fledge.dynamics import REAL_AR_DRONE
from fledge.formation import FormationControl
from fledge.geometry import Heading
from fledge.manoeuvres import FormationTrack, Plan
from fledge.world import VelocityCommand, WorldState

HOVER = VelocityCommand.hover()


class Memory(NamedTuple):
    """What is remembered."""

    row: int = 0
    """Of the track."""
    over: int = 0
    """For how many rows the UAV has been overhead."""
    going: bool = False


@dataclass(frozen=True, slots=True)
class Convoy:
    """Thresholds; all chosen."""

    plan: Plan
    """With plain numbers in lists (`listed`)."""
    formation: FormationControl = FormationControl()
    near: float = 0.3  # [m] from the middle of the UGVs at which the UAV is overhead; 40 px at 2.5 m
    far: float = 1.0  # [m] at which it no longer is
    low: float = 1.5  # [m] of altitude below which it is not
    rows: int = 20  # that it has to stay before they go
    braking: float = 1.0  # [m/s^2] counted on
    delay: float = 0.15  # [s] until it begins
    keep: float = 0.03  # [m] left over

    def step(self, memory: Memory, world: WorldState) -> tuple[Memory, tuple[VelocityCommand, ...]]:
        """(memory, what each UGV is told for the next 50 ms)."""
        memory = self._watched(memory, world)
        last = len(self.plan.track.x) - 1
        going = memory.going and memory.row < last
        target = self.target(memory.row, going)
        told = self.formation.commands(world.ugvs, target, self.plan.orientation, self.plan.arena)
        safe = tuple(self._stopped(world, i, command) for i, command in enumerate(told))
        return memory._replace(row=memory.row + going), safe

    def target(self, row: int, going: bool = False) -> FormationTrack:
        """Where the formation should be in a row, standing there or on its way."""
        track = self.plan.track
        spread = track.spread[row]
        if not going:
            return FormationTrack(track.x[row], track.y[row], 0.0, 0.0, spread, 0.0)
        return FormationTrack(
            track.x[row], track.y[row], track.vx[row], track.vy[row], spread, track.spread_rate[row]
        )

    def corners(self) -> tuple[tuple[float, float], ...]:
        """Where the UGVs wait [m]."""
        return tuple((x, y) for x, y, _, _ in self.formation.corners(self.target(0), self.plan.orientation))

    def _watched(self, memory: Memory, world: WorldState) -> Memory:
        p, n = world.uav.position, len(world.ugvs)
        off = hypot(p.x - sum(u.x for u in world.ugvs) / n, p.y - sum(u.y for u in world.ugvs) / n)
        if p.z < self.low or off > self.far:
            return memory._replace(over=0, going=False)
        over = memory.over + 1 if off < self.near else 0
        return memory._replace(over=over, going=memory.going or over >= self.rows)

    def _stopped(self, world: WorldState, i: int, command: VelocityCommand) -> VelocityCommand:
        """The command, or what is left of it where the robot has to stop."""
        nearest = clearance(self.plan.arena, world, REAL_AR_DRONE, self.formation.fleet, 1 + i)
        ugv = world.ugvs[i]
        nose = Heading.of(ugv.heading)
        towards = nose.cos * nearest.x + nose.sin * nearest.y
        fastest = max(ugv.speed * towards, command.forward * towards, 0.0)
        needs = fastest * self.delay + fastest * fastest / (2.0 * self.braking) + self.keep
        if nearest.gap >= needs or command.forward * towards <= 0.0:
            return command
        return VelocityCommand(0.0, 0.0, 0.0, command.turn)
