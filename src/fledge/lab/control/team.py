"""The UGVs where the controller drives them, over ROS: guidance of the formation along a plan's track.

They go to their corners as soon as they are armed and wait there until the UAV flies by its pilot; whenever it does
not, the track waits, and they stand on their places in it. While it lands, and after the track's last row, they stand.

*Restless* ones stop as hard as they can every now and then, and hurry after the track, which has not waited: what
`fledge identify` has to have seen of them.

Whether a command gets through is the net's to say, as for every vehicle.
"""

from dataclasses import dataclass
from typing import NamedTuple

from fledge.formation import FormationControl
from fledge.lab.control.phases import Phase
from fledge.manoeuvres import FormationTrack, Plan
from fledge.supervision.inputs import HOVER
from fledge.world import UgvState, VelocityCommand

GO, HALT = 60, 24
"""Rows that restless UGVs drive, and stand, in turn; chosen: a stop takes less than 0.5 s."""


class Led(NamedTuple):
    """What is remembered."""

    row: int = 0
    """Of the track."""
    told: tuple[VelocityCommand, ...] = ()
    """What each UGV was told last."""
    rows: int = 0
    """That were decided, the track going or not."""


@dataclass(frozen=True, slots=True)
class Team:
    """Where they go; `plan` has plain numbers in its lists."""

    plan: Plan
    formation: FormationControl = FormationControl()
    restless: bool = False

    def init(self) -> Led:
        """On their corners, or on the way there."""
        return Led(told=(HOVER,) * len(self.formation.fleet))

    def decide(self, memory: Led, phase: Phase, flown: bool, ugvs: tuple[UgvState, ...]) -> Led:
        """After a decision, 20 times a second; `flown` is whether the pilot flies the UAV."""
        if phase in (Phase.LAND, Phase.OVER):
            return memory._replace(told=(HOVER,) * len(ugvs))
        rows = memory.rows + 1
        last = len(self.plan.track.x) - 1
        going = flown and phase is Phase.FLY and memory.row < last
        target = self._target(memory.row, going)
        told = self.formation.commands(ugvs, target, self.plan.orientation, self.plan.arena)
        if self.restless and phase is Phase.FLY and rows % (GO + HALT) >= GO:
            told = (HOVER,) * len(ugvs)
        return Led(memory.row + going, told, rows)

    def _target(self, row: int, going: bool) -> FormationTrack:
        track = self.plan.track
        pace = (track.vx[row], track.vy[row], track.spread_rate[row]) if going else (0.0, 0.0, 0.0)
        return FormationTrack(track.x[row], track.y[row], pace[0], pace[1], track.spread[row], pace[2])
