"""A lab flight in rows, as a simulated one: from what a controller said, tick by tick, to an `Episode`.

A row begins with a decision of the pilot's and has all ticks for which it stood, five as a rule. There are rows only
while the pilot flies: not on the way up or down, nor while somebody else flies.

The world is as it was estimated from motion capture, time as the controller counts it, and the circumradius is what was
measured, since nobody told the formation's own to the controller.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, is_dataclass
from math import hypot
from typing import Any, NamedTuple

import numpy as np

from fledge.episode import Episode, over
from fledge.lab.control.phases import Phase
from fledge.lab.control.tick import Said
from fledge.observation import Action
from fledge.world import WorldState


class Memory(NamedTuple):
    """The row of which more may come."""

    ticks: tuple[Said, ...] = ()
    action: Action | None = None
    """The last decision, whoever's it was."""


@dataclass(frozen=True, slots=True)
class Rows:
    """How ticks become rows."""

    most: int = 10
    """Ticks of a row; a decision that stands for longer, since poses are missing, has several rows."""

    def init(self) -> Memory:
        """No row yet."""
        return Memory()

    def step(self, memory: Memory, said: Said) -> tuple[Memory, Episode | None]:
        """(memory, the row that is over with this tick, if one is); its leaves are numbers."""
        ticks, decided = memory.ticks, said.action is not memory.action
        if said.phase is not Phase.FLY or said.world is None:
            return Memory((), said.action), _row(ticks) if ticks else None
        if decided or len(ticks) == self.most:
            begins = (said,) if decided or ticks else ()
            return Memory(begins, said.action), _row(ticks) if ticks else None
        return Memory((*ticks, said) if ticks else (), said.action), None


def together(rows: Sequence[Episode]) -> Episode:
    """Rows as one episode, leaves of shape (rows,)."""
    return _stacked(rows)


def _row(ticks: tuple[Said, ...]) -> Episode:
    first = ticks[0]
    assert first.world is not None and first.observation is not None
    assert first.action is not None and first.proposed is not None
    vehicles = zip(*(said.decisions for said in ticks), strict=True)
    verdicts = tuple(over([decision.verdict for decision in decisions]) for decisions in vehicles)
    return Episode(
        first.world, first.observation, first.action, first.proposed, verdicts, spread(first.world)
    )


def spread(world: WorldState) -> float:
    """From the middle of the UGVs to the farthest of them [m]."""
    n = len(world.ugvs)
    x, y = sum(ugv.x for ugv in world.ugvs) / n, sum(ugv.y for ugv in world.ugvs) / n
    return max(hypot(ugv.x - x, ugv.y - y) for ugv in world.ugvs)


def _stacked(records: Sequence[Any]) -> Any:
    first = records[0]
    if is_dataclass(first) and not isinstance(first, type):
        parts = (_stacked([getattr(record, field.name) for record in records]) for field in fields(first))
        return type(first)(*parts)
    if isinstance(first, tuple):
        return tuple(_stacked(parts) for parts in zip(*records, strict=True))
    return np.array([float(number) for number in records])
