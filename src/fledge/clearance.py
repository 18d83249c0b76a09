"""How far every vehicle's hull is from what it must not touch: the referee's view, exact and without margins.

A UAV is an upright cylinder, a UGV a disc of some height, an obstacle a box on the floor. Safety nets do not use this
module, nor it theirs: whether something was touched is judged by other lines of code than those that prevent it.
"""

from typing import NamedTuple

from fledge.dynamics import Pioneer, Quadrotor
from fledge.scalars import Scalar, maximum, minimum, sqrt, where
from fledge.world import Arena, UgvState, WorldState

TINY = 1e-9


class Nearest(NamedTuple):
    """What is nearest to a vehicle."""

    gap: Scalar
    """From hull to hull [m]; at most 0 when they touch."""
    x: Scalar
    """Unit vector from the vehicle towards it."""
    y: Scalar
    z: Scalar


def clearances(
    arena: Arena, world: WorldState, uav: Quadrotor, fleet: tuple[Pioneer, ...]
) -> tuple[Nearest, ...]:
    """The nearest thing of every vehicle: the UAV's first, then the UGVs'."""
    return tuple(clearance(arena, world, uav, fleet, i) for i in range(1 + len(fleet)))


def from_things(
    arena: Arena, world: WorldState, uav: Quadrotor, fleet: tuple[Pioneer, ...]
) -> tuple[Nearest, ...]:
    """The nearest wall or obstacle of every vehicle, whatever else is nearer: the UAV's first, then the UGVs'."""
    ugvs = zip(world.ugvs, fleet, strict=True)
    return (_things_of_uav(arena, world, uav), *(_things_of_ugv(arena, ugv, model) for ugv, model in ugvs))


def clearance(
    arena: Arena, world: WorldState, uav: Quadrotor, fleet: tuple[Pioneer, ...], vehicle: int
) -> Nearest:
    """The nearest thing of one vehicle; 0 is the UAV."""
    if vehicle == 0:
        return _of_uav(arena, world, uav, fleet)
    return _of_ugv(arena, world, uav, fleet, vehicle - 1)


def _of_uav(arena: Arena, world: WorldState, uav: Quadrotor, fleet: tuple[Pioneer, ...]) -> Nearest:
    p = world.uav.position
    nearest = _things_of_uav(arena, world, uav)
    low, zero = p.z - uav.half_height, 0.0 * p.x
    nearest = _nearer(nearest, Nearest(low, zero, zero, zero - 1.0))
    nearest = _nearer(nearest, Nearest(arena.ceiling - p.z - uav.half_height, zero, zero, zero + 1.0))
    for ugv, model in zip(world.ugvs, fleet, strict=True):
        reach = uav.radius + model.radius
        nearest = _nearer(nearest, _beside_or_above(p.x - ugv.x, p.y - ugv.y, reach, low - model.height))
    return nearest


def _of_ugv(arena: Arena, world: WorldState, uav: Quadrotor, fleet: tuple[Pioneer, ...], i: int) -> Nearest:
    me, radius, zero = world.ugvs[i], fleet[i].radius, 0.0 * world.ugvs[i].x
    nearest = _things_of_ugv(arena, me, fleet[i])
    for j, other in enumerate(world.ugvs):
        if j != i:
            nearest = _nearer(nearest, _beside(me.x - other.x, me.y - other.y, radius + fleet[j].radius))
    p = world.uav.position
    above = p.z - uav.half_height - fleet[i].height
    over = _beside_or_above(me.x - p.x, me.y - p.y, radius + uav.radius, above)
    return _nearer(nearest, over._replace(z=zero))


def _things_of_uav(arena: Arena, world: WorldState, uav: Quadrotor) -> Nearest:
    p = world.uav.position
    nearest = _walls(arena, p.x, p.y, uav.radius)
    for obstacle in arena.obstacles:
        dx, dy = obstacle.footprint.gap(p.x, p.y)
        above = p.z - uav.half_height - obstacle.height
        nearest = _nearer(nearest, _beside_or_above(dx, dy, uav.radius, above))
    return nearest


def _things_of_ugv(arena: Arena, ugv: UgvState, model: Pioneer) -> Nearest:
    nearest = _walls(arena, ugv.x, ugv.y, model.radius)
    for obstacle in arena.obstacles:
        nearest = _nearer(nearest, _beside(*obstacle.footprint.gap(ugv.x, ugv.y), model.radius))
    return nearest


def _walls(arena: Arena, x: Scalar, y: Scalar, radius: float) -> Nearest:
    b, zero = arena.bounds, 0.0 * x
    east = b.x_max - x < x - b.x_min
    north = b.y_max - y < y - b.y_min
    across = minimum(b.x_max - x, x - b.x_min) - radius
    along = minimum(b.y_max - y, y - b.y_min) - radius
    return _nearer(
        Nearest(across, where(east, 1.0 + zero, zero - 1.0), zero, zero),
        Nearest(along, zero, where(north, 1.0 + zero, zero - 1.0), zero),
    )


def _beside(dx: Scalar, dy: Scalar, reach: Scalar) -> Nearest:
    """Something whose nearest point is (dx, dy) behind the vehicle."""
    far = sqrt(dx * dx + dy * dy)
    return Nearest(far - reach, -dx / (far + TINY), -dy / (far + TINY), 0.0 * far)


def _beside_or_above(dx: Scalar, dy: Scalar, reach: Scalar, above: Scalar) -> Nearest:
    """Likewise, of a thing whose top is `above` below the vehicle's belly."""
    side = _beside(dx, dy, reach)
    out, up = maximum(side.gap, 0.0), maximum(above, 0.0)
    far = sqrt(out * out + up * up)
    # Both within reach and below its top: they touch, by as much as would part them.
    gap = where(far > 0.0, far, maximum(side.gap, above))
    share = out / (far + TINY)
    return Nearest(gap, side.x * share, side.y * share, -up / (far + TINY))


def _nearer(a: Nearest, b: Nearest) -> Nearest:
    return where(a.gap <= b.gap, a, b)
