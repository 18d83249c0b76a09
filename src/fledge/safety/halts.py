"""Where every vehicle would come to rest if it were told to stop now, for people to look at; nothing decides by it."""

from fledge.safety.base import Halt
from fledge.safety.contract import UgvStop
from fledge.safety.tube import UgvMotion, UgvSent, uav_tube
from fledge.safety.turns import Deciding, Memory
from fledge.scalars import Scalar, maximum, where
from fledge.world import UgvState, WorldState


def halts(net: Deciding, memory: Memory, world: WorldState) -> tuple[Halt, ...]:
    """Those of all vehicles, the UAV's first, by the contract of a net and what it remembers having sent."""
    uav, sent = world.uav, memory.uav
    tube = uav_tube(net.contract, net.uav, uav, sent.sent, sent.pace, world.t - uav.stamp)
    first = Halt(uav.position.x + tube.late.x, uav.position.y + tube.late.y, tube.error)
    others = zip(net.ugvs, world.ugvs, memory.ugvs, strict=True)
    return (first, *(_ugv(net, stop, ugv, one, world.t) for stop, ugv, one in others))


def _ugv(net: Deciding, stop: UgvStop, ugv: UgvState, sent: UgvSent, t: Scalar) -> Halt:
    """In the middle between the shortest and the longest way to rest."""
    c, v = net.contract, ugv.speed
    tube = UgvMotion.of(c, stop, ugv, sent, t - ugv.stamp).told(0.0, 0.0)
    surely = maximum(abs(v) - c.velocity_error, 0.0)
    least = surely * surely / (2.0 * (stop.acceleration + c.disturbance))
    ahead, astern = tube.ahead, tube.astern
    x, y = tube.nose.to_world(0.5 * (ahead - astern + where(v < 0.0, -least, least)), 0.0)
    aside = maximum(*tube.turn) * maximum(ahead, astern)
    miss = 0.5 * (ahead + astern - least) + aside
    return Halt(ugv.x + x, ugv.y + y, miss + c.position_error)
