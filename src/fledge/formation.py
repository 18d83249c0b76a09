"""Formation control and obstacle avoidance of the three UGVs.

Each UGV chases its corner of the triangle: the corner's velocity plus a proportional pull. Before a wall, a box
or another UGV, its approach speed is limited in proportion to the free distance, and what is taken away turns
into sliding along the edge: the formation is squeezed or stretched, as the paper describes ("shrunk or
extended"), and comes back. A unicycle follows the wanted velocity by turning to it, nose or tail first.

This is guidance, not a safety net: nothing is proved here.
"""

from dataclasses import dataclass
from math import pi

from fledge.dynamics import UGV_FLEET, Pioneer
from fledge.geometry import Heading
from fledge.manoeuvres.base import FormationTrack
from fledge.scalars import Scalar, atan2, clip, cos, maximum, sin, sqrt, where
from fledge.world import Arena, UgvState, VelocityCommand

TINY = 1e-9


@dataclass(frozen=True, slots=True)
class FormationControl:
    """Gains of the guidance; all chosen."""

    fleet: tuple[Pioneer, ...] = UGV_FLEET
    pull: float = 0.8  # [1/s] towards the corner
    max_speed: float = 0.6  # [m/s] above the fastest corner, so that a UGV can catch up
    approach: float = 1.2  # [1/s] approach speed per free distance
    clearance: float = 0.1  # [m] kept between hulls
    slide: float = 0.8  # share of the speed taken away that turns into sliding
    turning: float = 3.0  # [1/s] turn rate per heading error

    def corners(
        self, target: FormationTrack, orientation: Scalar
    ) -> tuple[tuple[Scalar, Scalar, Scalar, Scalar], ...]:
        """(x, y, vx, vy) of each UGV's place in the triangle."""
        places = []
        for i in range(len(self.fleet)):
            angle = orientation + 2.0 * pi * i / len(self.fleet)
            c, s = cos(angle), sin(angle)
            places.append((
                target.x + target.spread * c,
                target.y + target.spread * s,
                target.vx + target.spread_rate * c,
                target.vy + target.spread_rate * s,
            ))
        return tuple(places)

    def commands(
        self,
        ugvs: tuple[UgvState, ...],
        target: FormationTrack,
        orientation: Scalar,
        arena: Arena,
    ) -> tuple[VelocityCommand, ...]:
        """What each UGV is told, given where all of them are."""
        wanted = []
        for i, (ugv, corner) in enumerate(zip(ugvs, self.corners(target, orientation), strict=True)):
            x, y, vx, vy = corner
            ux, uy = vx + self.pull * (x - ugv.x), vy + self.pull * (y - ugv.y)
            ux, uy = _shorten(ux, uy, self.max_speed)
            ux, uy = self._avoid(i, ugvs, arena, ux, uy)
            wanted.append(self._steer(ugv, ux, uy))
        return tuple(wanted)

    def _avoid(
        self, i: int, ugvs: tuple[UgvState, ...], arena: Arena, ux: Scalar, uy: Scalar
    ) -> tuple[Scalar, Scalar]:
        """The wanted velocity with its approach to everything limited."""
        me, radius, b = ugvs[i], self.fleet[i].radius, arena.bounds
        for j, other in enumerate(ugvs):
            if j != i:
                dx, dy = me.x - other.x, me.y - other.y
                ux, uy = self._limit((dx, dy), (dx, dy), radius + self.fleet[j].radius, ux, uy)
        for obstacle in arena.obstacles:
            box = obstacle.footprint
            middle = (me.x - 0.5 * (box.x_min + box.x_max), me.y - 0.5 * (box.y_min + box.y_max))
            ux, uy = self._limit(box.gap(me.x, me.y), middle, radius, ux, uy)
        zero = 0.0 * me.x
        for gap in (
            (me.x - b.x_min, zero),
            (me.x - b.x_max, zero),
            (zero, me.y - b.y_min),
            (zero, me.y - b.y_max),
        ):
            ux, uy = self._limit(gap, (me.x, me.y), radius, ux, uy)
        return ux, uy

    def _limit(
        self,
        gap: tuple[Scalar, Scalar],
        middle: tuple[Scalar, Scalar],
        radius: Scalar,
        ux: Scalar,
        uy: Scalar,
    ) -> tuple[Scalar, Scalar]:
        """The velocity with its approach held to the free distance, and the excess turned into sliding.

        `gap` points to the UGV from the nearest point of what is in the way, `middle` from its middle. The UGV slides
        to the side on which it is already, seen along its way: the choice confirms itself and never dithers.
        """
        dx, dy = gap
        far = sqrt(dx * dx + dy * dy) + TINY
        nx, ny = dx / far, dy / far
        free = far - radius - self.clearance
        excess = maximum(-self.approach * free - (ux * nx + uy * ny), 0.0)
        side = where(uy * middle[0] - ux * middle[1] >= 0.0, self.slide, -self.slide)
        return ux + excess * (nx - side * ny), uy + excess * (ny + side * nx)

    def _steer(self, ugv: UgvState, ux: Scalar, uy: Scalar) -> VelocityCommand:
        """Follow a velocity with a unicycle, in reverse when that is nearer."""
        along, across = Heading.of(ugv.heading).from_world(ux, uy)
        way = where(along >= 0.0, 1.0, -1.0)
        error = atan2(way * across, way * along + TINY)
        speed = sqrt(ux * ux + uy * uy + TINY)
        # At a crawl the direction means little: do not spin after it.
        turn = self.turning * error * speed / (speed + 0.05)
        zero = 0.0 * along
        return VelocityCommand(clip(along, -self.max_speed, self.max_speed), zero, zero, turn)


def _shorten(ux: Scalar, uy: Scalar, limit: Scalar) -> tuple[Scalar, Scalar]:
    speed = sqrt(ux * ux + uy * uy + TINY)
    scale = where(speed > limit, limit / speed, 1.0)
    return ux * scale, uy * scale
