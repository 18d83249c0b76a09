"""The paper's net: its Eq. 1 to the letter, dead ends included.

*The rule.* A vehicle is a point. Where its command takes it within one period is predicted; if that place lies within
`margin` of an obstacle's rectangle, or of the arena's boundary, the UAV is told to hover and the UGV to stand still.
Eq. 1 has no "and" between its four lines and says "for all" obstacles; read are all four lines of any obstacle, since
nothing else means what the text says (D8). All else is as printed: the comparisons are strict, and only the end of the
step counts.

*What it does not do*, and what its tests show: brake in time, or let a vehicle out again that has overshot into a
margin (which is then absorbing: dead-lock); see what lies between two predictions; stop what is no number (every
comparison with NaN is false, and eta = 0 means safe); look at altitudes, at other vehicles or at a vehicle's size.
`paper_repaired` mends what can be mended without another rule, `stop_tube` is another rule.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from fledge.geometry import Box, Heading
from fledge.safety.base import AbstractNet
from fledge.scalars import Scalar, minimum, where
from fledge.world import Arena, Commands, Reason, VelocityCommand, Verdict, WorldState


class Step(NamedTuple):
    """What a vehicle is about to do."""

    x: Scalar
    """Where it is [m]."""
    y: Scalar
    to_x: Scalar
    """Where its command takes it [m]."""
    to_y: Scalar
    command: VelocityCommand


def steps(world: WorldState, commands: Commands, period: float) -> Iterator[Step]:
    """The next step of every vehicle, of `period` [s]: the UAV flies as it is told, a UGV drives along its nose."""
    uav, told = world.uav, commands.uav
    yield _step(uav.position.x, uav.position.y, uav.attitude.heading(), told, told.left, period)
    for ugv, told in zip(world.ugvs, commands.ugvs, strict=True):
        yield _step(ugv.x, ugv.y, Heading.of(ugv.heading), told, 0.0, period)


def _step(x: Scalar, y: Scalar, heading: Heading, told: VelocityCommand, left: Scalar, period: float) -> Step:
    vx, vy = heading.to_world(told.forward, left)
    return Step(x, y, x + vx * period, y + vy * period, told)


def halted(arena: Arena, step: Step, unsafe: Scalar, reason: Scalar) -> Verdict:
    """Stand still where that is unsafe; the clearance is that of the vehicle's centre."""
    told = step.command
    moves = (told.forward != 0.0) | (told.left != 0.0) | (told.up != 0.0) | (told.turn != 0.0)
    halt = unsafe & moves
    clearance = -arena.bounds.distance(step.x, step.y)
    for obstacle in arena.obstacles:
        clearance = minimum(clearance, obstacle.footprint.distance(step.x, step.y))
    return Verdict(
        where(halt, VelocityCommand.hover(), told),
        where(halt, 1.0, 0.0),
        where(halt, reason, float(Reason.NONE)),
        clearance,
    )


@dataclass(frozen=True, slots=True)
class PaperNet(AbstractNet):
    """Lets a command through unless its next step ends within the margin."""

    margin: float = 0.5  # [m], the paper's xi; chosen, it gives no number
    period: float = 0.01  # [s] between two calls of the net

    def init(self, arena: Arena, world: WorldState) -> Arena:
        """All it remembers is where it is."""
        return arena

    def filter(
        self, memory: Arena, world: WorldState, commands: Commands
    ) -> tuple[Arena, tuple[Verdict, ...]]:
        """Every vehicle on its own."""
        return memory, tuple(self._judge(memory, step) for step in steps(world, commands, self.period))

    def _judge(self, arena: Arena, step: Step) -> Verdict:
        wall = self._beyond(arena.bounds, step.to_x, step.to_y)
        unsafe = wall
        for obstacle in arena.obstacles:
            unsafe = unsafe | self._eta(obstacle.footprint, step.to_x, step.to_y)
        return halted(arena, step, unsafe, where(wall, float(Reason.WALL), float(Reason.OBSTACLE)))

    def _eta(self, obstacle: Box, x: Scalar, y: Scalar) -> Scalar:
        """Eq. 1."""
        xi = self.margin
        return (
            (x + xi > obstacle.x_min)
            & (x - xi < obstacle.x_max)
            & (y + xi > obstacle.y_min)
            & (y - xi < obstacle.y_max)
        )

    def _beyond(self, bounds: Box, x: Scalar, y: Scalar) -> Scalar:
        """The same margin "at four boundaries of the testing area"."""
        xi = self.margin
        return (
            (x - xi < bounds.x_min)
            | (x + xi > bounds.x_max)
            | (y - xi < bounds.y_min)
            | (y + xi > bounds.y_max)
        )
