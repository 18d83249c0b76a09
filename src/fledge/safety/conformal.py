"""The stop tube with a margin that was learnt: the paper's "internal soft constraint".

`UavStop.miss` bounds how far a stop may miss its predicted end; it was fitted to one vehicle in one kind of flight.
This net enlarges it by what flown stops of the vehicle at hand have shown. It never shrinks it: where the learnt margin
is nothing, or wrong, what the stop tube proves still holds, since a larger bound is a bound as well.

*How it is learnt.* Split-conformal prediction (Vovk, Gammerman and Shafer, Algorithmic Learning in a Random World,
2005): an episode's score is by how much the worst of its stops overran the bound; `delta` is the
ceil((n + 1)(1 - alpha))-th smallest score of n episodes. If a further episode is exchangeable with those, no stop of it
overruns the enlarged bound with a probability of at least 1 - alpha, whatever the distribution; and of at most
1 - alpha + 1 / (n + 1) if no two scores are alike.

*What that does not say.* Exchangeable means drawn like the episodes flown: with the same vehicle, battery and restless
commands. A policy that seeks out bad stops is not, nor is a vehicle that has aged; for them there is the proven bound
only. And the probability is over calibrations, too: what a single one covers scatters by about sqrt(alpha / n).
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fledge.errors import FledgeError, OutOfRange
from fledge.safety.base import AbstractNet, Halt
from fledge.safety.stop_tube import StopTube
from fledge.world import Arena, Commands, Verdict, WorldState


@dataclass(frozen=True, slots=True)
class Overruns:
    """What flown stops have shown."""

    delta: float
    """How far stops go beyond their bound [m], but for a share `alpha` of episodes; negative if they stay within."""
    alpha: float
    episodes: int
    """How many were flown to learn that."""

    @classmethod
    def learnt(cls, overruns: np.ndarray, alpha: float) -> "Overruns":
        """From how far each stop went beyond its bound [m]; shape (episodes, stops).

        Raises:
            FledgeError: too few episodes for that alpha, or an overrun that is no number.
        """
        n = len(overruns)
        if not 0.0 < alpha < 1.0:
            raise OutOfRange("alpha", alpha, "between 0 and 1")
        if not np.isfinite(overruns).all():
            raise FledgeError("an overrun is no number: valid is a finite distance [m] for every stop")
        # Rounding must not make one more of a whole number.
        rank = math.ceil((n + 1) * (1.0 - alpha) - 1e-9)
        if rank > n:
            raise OutOfRange(
                "number of episodes", n, f"at least {math.ceil(1.0 / alpha - 1e-9) - 1} for alpha {alpha:g}"
            )
        return cls(float(np.sort(overruns.max(axis=1))[rank - 1]), alpha, n)


AR_DRONE = Overruns(delta=-0.014, alpha=0.01, episodes=999)
"""Of `REAL_AR_DRONE`, beyond the default `UavStop`: `overruns.fly_stops(REAL_AR_DRONE, (0,), 999)`."""


@dataclass(frozen=True, slots=True)
class Conformal(AbstractNet):
    """The stop tube, its bound on the UAV's stops enlarged by what was learnt; UGVs stop as proven."""

    proven: StopTube = StopTube()
    overruns: Overruns = AR_DRONE

    def enlarged(self) -> StopTube:
        """The stop tube that decides."""
        more, stop = max(0.0, self.overruns.delta), self.proven.uav
        return replace(self.proven, uav=replace(stop, error=stop.error + more, error_up=stop.error_up + more))

    def init(self, arena: Arena, world: WorldState) -> Any:
        """As the stop tube's."""
        return self.enlarged().init(arena, world)

    def filter(self, memory: Any, world: WorldState, commands: Commands) -> tuple[Any, tuple[Verdict, ...]]:
        """As the stop tube decides, with the larger bound."""
        return self.enlarged().filter(memory, world, commands)

    def overruled(self, memory: Any, world: WorldState, instead: Commands) -> Any:
        """As the stop tube remembers it."""
        return self.enlarged().overruled(memory, world, instead)

    def halts(self, memory: Any, world: WorldState) -> tuple[Halt, ...]:
        """As the stop tube predicts them."""
        return self.enlarged().halts(memory, world)
