"""Formation control and obstacle avoidance of the three UGVs.

Each UGV chases its corner of the triangle: the corner's velocity plus a proportional pull. Before a wall, a box
or another UGV, its approach speed is limited in proportion to the free distance, and what is taken away turns
into sliding along the edge: the formation is squeezed or stretched, as the paper describes ("shrunk or
extended"), and comes back. A unicycle follows the wanted velocity by turning to it, nose or tail first.

This is guidance, not a safety net: nothing is proved here. But it drives as the nets' contract would have it (D10): a
UGV whose link is lost goes on with its last command for 0.6 s before it brakes, turning as it did, so it may approach
nothing faster, by whatever way its nose may swing, than it could still stop; and of two that approach each other, the
one that is told later makes allowance for what the other was told.
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
class Nearby:
    """Something that a UGV must not touch, as it sees it."""

    x: Scalar
    """Unit vector away from its nearest point."""
    y: Scalar
    wanted: Scalar
    """Speed at which it may be approached by choice [m/s]; negative where it is too near already."""
    allowed: Scalar
    """Speed at which it may be approached at all [m/s]."""
    middle_x: Scalar
    """Vector from its middle to the UGV [m]."""
    middle_y: Scalar


@dataclass(frozen=True, slots=True)
class FormationControl:
    """Gains of the guidance; all chosen."""

    fleet: tuple[Pioneer, ...] = UGV_FLEET
    pull: float = 0.8  # [1/s] towards the corner
    max_speed: float = 0.6  # [m/s] above the fastest corner, so that a UGV can catch up
    approach: float = 0.85  # [1/s] approach speed per free distance; a stop from 0.6 m/s takes 0.77 m
    clearance: float = 0.1  # [m] kept between hulls
    apart: float = 0.05  # [m] kept between two UGVs beyond that: neither is quite where it is seen
    slide: float = 1.0  # share of the speed taken away that turns into sliding
    turning: float = 3.0  # [1/s] turn rate per heading error
    max_turn: float = 1.5  # [rad/s]; every Pioneer obeys it, so no net need cut it
    foresight: float = 0.9  # [s] for which a turn may go on
    sway: float = 0.02  # [rad] by which a nose may be off, turning or not

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
        told = []
        for i, (ugv, corner) in enumerate(zip(ugvs, self.corners(target, orientation), strict=True)):
            x, y, vx, vy = corner
            ux, uy = vx + self.pull * (x - ugv.x), vy + self.pull * (y - ugv.y)
            ux, uy = _shorten(ux, uy, self.max_speed)
            speeds = [command.forward for command in told] + [other.speed for other in ugvs[i:]]
            near = self._surroundings(i, ugvs, speeds, arena)
            for thing in near:
                ux, uy = self._slide(thing, ux, uy)
            told.append(self._steer(ugv, near, ux, uy))
        return tuple(told)

    def _surroundings(
        self, i: int, ugvs: tuple[UgvState, ...], speeds: list[Scalar], arena: Arena
    ) -> list[Nearby]:
        """Everything that UGV `i` must not touch, the UGVs being about to have these speeds [m/s].

        What stands still comes last, and has the last word on sliding.
        """
        me, radius, b = ugvs[i], self.fleet[i].radius, arena.bounds
        zero = 0.0 * me.x
        things, still = [], (zero, zero)
        for j, other in enumerate(ugvs):
            if j != i:
                gap = (me.x - other.x, me.y - other.y)
                velocity = Heading.of(other.heading).to_world(speeds[j], zero)
                # The first UGV has the right of way: the others make room for it, it does not for them.
                keep = self.clearance if j < i else 0.5 * self.clearance
                things.append((gap, gap, radius + self.fleet[j].radius + self.apart, keep, velocity))
        # Of two opposite walls only the nearer one can be in the way.
        east, north = me.x + me.x > b.x_min + b.x_max, me.y + me.y > b.y_min + b.y_max
        across = me.x - where(east, b.x_max, b.x_min)
        along = me.y - where(north, b.y_max, b.y_min)
        for gap in ((across, zero), (zero, along)):
            things.append((gap, (me.x, me.y), radius, self.clearance, still))
        for obstacle in arena.obstacles:
            box = obstacle.footprint
            middle = (me.x - 0.5 * (box.x_min + box.x_max), me.y - 0.5 * (box.y_min + box.y_max))
            things.append((box.gap(me.x, me.y), middle, radius, self.clearance, still))
        return [self._nearby(*thing) for thing in things]

    def _nearby(
        self,
        gap: tuple[Scalar, Scalar],
        middle: tuple[Scalar, Scalar],
        radius: Scalar,
        keep: Scalar,
        velocity: tuple[Scalar, Scalar],
    ) -> Nearby:
        """From the vectors to the UGV from a thing's nearest point and from its middle, and the clearance to keep.

        `velocity` is the thing's own.
        """
        dx, dy = gap
        far = sqrt(dx * dx + dy * dy) + TINY
        free = far - radius
        # Sliding keeps the whole clearance, holding half of it: on the sliding line there is room to turn.
        aim, hold = free - keep, maximum(free - 0.5 * self.clearance, 0.0)
        x, y = dx / far, dy / far
        closing = maximum(velocity[0] * x + velocity[1] * y, 0.0)
        allowed = maximum(self.approach * hold - closing, 0.0)
        return Nearby(x, y, self.approach * aim, allowed, *middle)

    def _slide(self, near: Nearby, ux: Scalar, uy: Scalar) -> tuple[Scalar, Scalar]:
        """The velocity with its approach held to what is wanted, and the excess turned into sliding.

        The UGV slides to the side of the thing on which it is already, seen along its way: the choice confirms
        itself and never dithers.
        """
        excess = maximum(-near.wanted - (ux * near.x + uy * near.y), 0.0)
        side = where(uy * near.middle_x - ux * near.middle_y >= 0.0, self.slide, -self.slide)
        return (
            ux + excess * (near.x - side * near.y),
            uy + excess * (near.y + side * near.x),
        )

    def _steer(self, ugv: UgvState, near: list[Nearby], ux: Scalar, uy: Scalar) -> VelocityCommand:
        """Follow a velocity with a unicycle, in reverse when that is nearer.

        A unicycle moves along its nose, not along the velocity it wants, and sliding off one thing may lead into
        another: so its real motion, wherever its turning may yet lead it, is held to every limit once more.
        """
        nose = Heading.of(ugv.heading)
        along, across = nose.from_world(ux, uy)
        way = where(along >= 0.0, 1.0, -1.0)
        error = atan2(way * across, way * along + TINY)
        speed = sqrt(ux * ux + uy * uy + TINY)
        # At a crawl the direction means little: do not spin after it.
        turn = clip(self.turning * error * speed / (speed + 0.05), -self.max_turn, self.max_turn)
        swing = abs(turn) * self.foresight + self.sway
        forward = clip(along, -self.max_speed, self.max_speed)
        for thing in near:
            towards = -way * (nose.cos * thing.x + nose.sin * thing.y)
            aside = abs(nose.cos * thing.y - nose.sin * thing.x)
            approach = abs(forward) * clip(towards + aside * swing, 0.0, 1.0)
            share = thing.allowed / maximum(approach, TINY)
            forward = forward * where(approach > thing.allowed, share, 1.0)
        zero = 0.0 * along
        return VelocityCommand(forward, zero, zero, turn)


def _shorten(ux: Scalar, uy: Scalar, limit: Scalar) -> tuple[Scalar, Scalar]:
    speed = sqrt(ux * ux + uy * uy + TINY)
    scale = where(speed > limit, limit / speed, 1.0)
    return ux * scale, uy * scale
