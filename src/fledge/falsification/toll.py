"""What attacks on a net have come to: counts by family, and the flights that should not have happened.

A contact is a flight in which something was touched; a vehicle whose place is no number has touched something.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields
from math import inf
from typing import Any, NamedTuple

import numpy as np

from fledge.falsification.scenarios import Draw
from fledge.falsification.sorties import Outcome
from fledge.simulation import TICK

KEPT = 2
"""Violations of one kind that are kept of every family."""


class Salvo(NamedTuple):
    """Flights that were in the air at once, and what came of them."""

    numbers: Sequence[int]
    families: Sequence[str]
    pilot: str | None
    """The policy that flew the UAV, if one did."""
    draws: Sequence[Draw]
    outcome: Outcome
    retreat: float
    """When the retreat began [s]."""

    @property
    def gaps(self) -> np.ndarray:
        """The smallest of every vehicle [m], shape (vehicles, flights)."""
        gaps = np.stack(self.outcome.tally.least)
        return np.where(np.isnan(gaps), 0.0, gaps)


@dataclass(frozen=True, slots=True)
class Violation:
    """A flight that a net should not have let happen."""

    flight: int
    family: str
    pilot: str | None
    kind: str
    """contact or deadlock."""
    vehicle: int
    """That touched something, or could not be led away; 0 is the UAV."""
    time_s: float
    """Of the first contact, or of the beginning of the retreat."""
    gap_m: float
    """The vehicle's smallest."""
    draw: Draw


@dataclass(frozen=True, slots=True)
class Count:
    """What came of some flights."""

    flights: int = 0
    contacts: int = 0
    """Flights in which something was touched,"""
    uav_contacts: int = 0
    """by the UAV,"""
    ugv_contacts: int = 0
    """by a UGV."""
    breaches: int = 0
    """Flights in which a centre came nearer to something than the paper's margin."""
    retreats: int = 0
    """Flights at whose end there was a way out for the vehicle in focus,"""
    deadlocks: int = 0
    """and those in which it could not be led away."""
    interventions: int = 0
    """Vehicle ticks in which the net changed a command."""
    alarms: int = 0
    """Interventions that were followed without the net,"""
    false_alarms: int = 0
    """and those after which nothing was touched."""
    uav_gap_m: float = inf
    """Smallest from hull to hull."""
    ugv_gap_m: float = inf

    @classmethod
    def of(cls, salvo: Salvo, family: str) -> "Count":
        """Of a family's flights in a salvo."""
        chosen = np.array(salvo.families) == family
        gaps, tally = salvo.gaps[:, chosen], salvo.outcome.tally

        def total(flags: Any) -> int:
            return int(np.sum(flags[chosen]))

        return cls(
            flights=int(chosen.sum()),
            contacts=int((gaps <= 0.0).any(axis=0).sum()),
            uav_contacts=int((gaps[0] <= 0.0).sum()),
            ugv_contacts=int((gaps[1:] <= 0.0).any(axis=0).sum()),
            breaches=total(tally.breached),
            retreats=total(salvo.outcome.way),
            deadlocks=total(salvo.outcome.deadlock),
            interventions=total(tally.interventions),
            alarms=total(tally.alarms),
            false_alarms=total(tally.false_alarms),
            uav_gap_m=float(gaps[0].min(initial=inf)),
            ugv_gap_m=float(gaps[1:].min(initial=inf)),
        )

    def __add__(self, other: "Count") -> "Count":
        pairs = {f.name: (getattr(self, f.name), getattr(other, f.name)) for f in fields(self)}
        return Count(**{name: (min if name.endswith("_m") else sum)(pair) for name, pair in pairs.items()})


@dataclass(frozen=True, slots=True)
class Toll:
    """What all attacks so far have come to."""

    families: dict[str, Count] = field(default_factory=dict)
    rejected: int = 0
    """Arenas the generator drew in vain."""
    near: int = 0
    """Vehicles that started near a wall or an obstacle."""
    violations: tuple[Violation, ...] = ()
    """The first few of every family and kind."""

    @property
    def total(self) -> Count:
        """Over all families."""
        return sum(self.families.values(), Count())

    def after(self, salvo: Salvo) -> "Toll":
        """With a further salvo."""
        counts = {family: Count.of(salvo, family) for family in dict.fromkeys(salvo.families)}
        kept = list(self.violations)
        for one in violations(salvo):
            alike = [other for other in kept if (other.family, other.kind) == (one.family, one.kind)]
            kept += [one] * (len(alike) < KEPT)
        return Toll(
            self.families
            | {name: self.families.get(name, Count()) + count for name, count in counts.items()},
            self.rejected + sum(draw.rejected for draw in salvo.draws),
            self.near + sum(draw.near for draw in salvo.draws),
            tuple(kept),
        )


def violations(salvo: Salvo) -> Iterator[Violation]:
    """Every contact and every dead-lock, flight by flight."""
    gaps, first, deadlock = salvo.gaps, salvo.outcome.tally.first, salvo.outcome.deadlock
    for i in np.flatnonzero((gaps <= 0.0).any(axis=0) | (deadlock > 0.0)).tolist():
        contact = bool((gaps[:, i] <= 0.0).any())
        draw = salvo.draws[i]
        vehicle = int(gaps[:, i].argmin()) if contact else int(draw.scenario.focus)
        yield Violation(
            flight=salvo.numbers[i],
            family=salvo.families[i],
            pilot=salvo.pilot,
            kind="contact" if contact else "deadlock",
            vehicle=vehicle,
            time_s=round(float(first[i]) * TICK if contact else salvo.retreat, 2),
            gap_m=float(gaps[vehicle, i]),
            draw=draw,
        )
