"""What people say, as far as it counts in this phase of a flight.

* Arming counts on the ground only, and only if it was seen unset while nothing was missing: whoever arms too early, or
  while something is wrong, has to arm again.
* Where nobody attends, arming is done here, once everybody is ready. As soon as somebody speaks, they attend.
* A flight whose time is up, or whose vehicle came down by itself, is told to land.
* After a flight nobody arms anything: a run is one flight.
* Over UGVs that are not ours to command nobody has a say.
"""

from dataclasses import dataclass, replace
from math import inf

from fledge.lab.control.hands import Holding
from fledge.lab.control.phases import Phase
from fledge.supervision.inputs import Operator
from fledge.supervision.modes import Mode
from fledge.supervision.posts import Memory as Supervision


@dataclass(frozen=True, slots=True)
class Arming:
    """Who has a say."""

    unattended: bool = False
    """Whether a flight may begin with nobody there."""
    ugvs: bool = False
    """Whether the UGVs are ours to command."""

    def cleared(self, before: bool, complaint: str, holding: Holding) -> bool:
        """Whether arming counts from now on, if it did, or did not, `before`."""
        armed = any(operator.arm > 0.5 for operator in holding.operators)
        return not complaint and (before or not armed)

    def operators(
        self, holding: Holding, cleared: bool, phase: Phase, supervision: Supervision, t: float
    ) -> tuple[tuple[Operator, ...], float]:
        """(one operator per vehicle, when the last was heard [s])."""
        uav, *ugvs = self._said(holding, phase, supervision)
        if phase is Phase.OVER or (phase is Phase.WAIT and not cleared):
            uav, ugvs = replace(uav, arm=0.0), [replace(one, arm=0.0) for one in ugvs]
        if phase is Phase.LAND and supervision.posts[0].mode != Mode.LAND:
            uav = replace(uav, land=1.0)
        if not self.ugvs:
            ugvs = [Operator()] * len(ugvs)
        return (uav, *ugvs), t if self._alone(holding) else holding.heard

    def _alone(self, holding: Holding) -> bool:
        return self.unattended and holding.heard == -inf

    def _said(self, holding: Holding, phase: Phase, supervision: Supervision) -> tuple[Operator, ...]:
        if not self._alone(holding):
            return holding.operators
        ready = phase is not Phase.WAIT or all(post.mode != Mode.INIT for post in supervision.posts)
        return (Operator(arm=1.0 if ready else 0.0),) * len(holding.operators)
