"""What one flight leaves behind.

An `Episode` is the flight row by row, at 20 Hz: the spine's own records, each field an array over rows. A
`Flight` adds what the flight was: enough to fly it again. Simulated and real flights end in the same records,
so every table and figure serves both.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from fledge.camera import Lens
from fledge.observation import IDEAL_RADIUS_PX, Action, Observation, StickScale
from fledge.scalars import maximum, minimum, where
from fledge.world import Arena, Commands, Reason, Verdict, WorldState


@dataclass(frozen=True, slots=True)
class Episode:
    """One flight; every leaf has shape (rows,)."""

    world: WorldState
    """The vehicles as they really were when the row began."""
    observation: Observation
    """What the pilot saw: delayed, noisy."""
    action: Action
    """What the pilot said."""
    proposed: Commands
    """What that, and the UGVs' own controller, asked for."""
    verdicts: tuple[Verdict, ...]
    """What was sent and why: the UAV's verdict, then one per UGV; each `over` the row's five."""
    ideal_spread: Any
    """Circumradius the formation was told to have [m]."""


def over(ticks: Sequence[Verdict]) -> Verdict:
    """One vehicle's verdicts of a row as one: what was sent last, whether and why first it was not what was proposed.

    That a person flew is a reason only if there is no other: else nobody would know that a net stopped the person.
    The clearance is the smallest.
    """
    whole, *later = ticks
    for tick in later:
        stays = (whole.intervened > 0.0) & (whole.reason != float(Reason.TAKE_OVER))
        whole = Verdict(
            tick.command,
            maximum(whole.intervened, tick.intervened),
            where(stays, whole.reason, tick.reason),
            minimum(whole.clearance, tick.clearance),
        )
    return whole


@dataclass(frozen=True, slots=True)
class Flight:
    """An episode and what it was."""

    episode: Episode
    manoeuvre: str
    pilot: str
    net: str
    seed: int
    case: int
    """The flight is a pure function of the names above, the seed and the case."""
    axes: tuple[int, ...]
    """Indices of the actions that were in use."""
    arena: Arena
    lens: Lens = field(default_factory=Lens)
    sticks: StickScale = field(default_factory=StickScale)
    ideal_radius: float = IDEAL_RADIUS_PX

    @property
    def rows(self) -> int:
        """How many rows there are."""
        return len(self.episode.world.t)
