"""The paper's net with what can be mended without another rule.

Mended: a step is unsafe unless it lies beyond one of the rectangle's edges as a whole, its margin included. So to touch
the margin is to be in it, a step that jumps over a wall is stopped, and what is no number is never safe. Edges are
sorted first: the paper's "upper edge" below the "lower edge" belongs to images, and in a world whose y points up its
rule is silent about everything higher than two margins.

Not mended, since it is the rule: one period of foresight is no brake, so vehicles overshoot into the margin, and there
every command predicts a place in the margin, so they stay for good. Altitude, size and other vehicles are as unseen.
"""

from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from fledge.geometry import Box
from fledge.safety.base import AbstractNet
from fledge.safety.paper import Step, halted, steps
from fledge.scalars import Scalar, isfinite, maximum, minimum, negate, where
from fledge.world import Arena, Commands, Obstacle, Reason, Verdict, WorldState


@dataclass(frozen=True, slots=True)
class RepairedPaperNet(AbstractNet):
    """Lets a command through only if its whole next step stays out of the margin."""

    margin: float = 0.5  # [m], as `PaperNet.margin`
    period: float = 0.01  # [s] between two calls of the net

    def init(self, arena: Arena, world: WorldState) -> Arena:
        """The arena, upright."""
        return Arena(
            upright(arena.bounds),
            arena.ceiling,
            tuple(Obstacle(upright(one.footprint), one.height) for one in arena.obstacles),
        )

    def filter(
        self, memory: Arena, world: WorldState, commands: Commands
    ) -> tuple[Arena, tuple[Verdict, ...]]:
        """Every vehicle on its own."""
        vehicles = zip((world.uav, *world.ugvs), steps(world, commands, self.period), strict=True)
        return memory, tuple(
            self._judge(memory, step, known(vehicle) & known(step) & isfinite(world.t))
            for vehicle, step in vehicles
        )

    def _judge(self, arena: Arena, step: Step, known: Scalar) -> Verdict:
        way = upright(Box(step.x, step.to_x, step.y, step.to_y))
        inside = self._within(way, arena.bounds)
        safe = known & inside
        for obstacle in arena.obstacles:
            safe = safe & self._beyond(way, obstacle.footprint)
        reason = where(inside, float(Reason.OBSTACLE), float(Reason.WALL))
        reason = where(known, reason, float(Reason.NOT_FINITE))
        return halted(arena, step, negate(safe), reason)

    def _beyond(self, way: Box, obstacle: Box) -> Scalar:
        """What Eq. 1 forbids, turned round and closed: all of the step lies beyond one of the edges."""
        xi = self.margin
        return (
            (way.x_max + xi < obstacle.x_min)
            | (way.x_min - xi > obstacle.x_max)
            | (way.y_max + xi < obstacle.y_min)
            | (way.y_min - xi > obstacle.y_max)
        )

    def _within(self, way: Box, bounds: Box) -> Scalar:
        xi = self.margin
        return (
            (way.x_min - xi > bounds.x_min)
            & (way.x_max + xi < bounds.x_max)
            & (way.y_min - xi > bounds.y_min)
            & (way.y_max + xi < bounds.y_max)
        )


def upright(box: Box) -> Box:
    """The same rectangle, its lower edges first."""
    return Box(
        minimum(box.x_min, box.x_max),
        maximum(box.x_min, box.x_max),
        minimum(box.y_min, box.y_max),
        maximum(box.y_min, box.y_max),
    )


def known(record: Any) -> Scalar:
    """Whether every number in a record is one."""
    if is_dataclass(record):
        record = tuple(getattr(record, field.name) for field in fields(record))
    if not isinstance(record, tuple):
        return isfinite(record)
    every = True
    for part in record:
        every = every & known(part)
    return every
