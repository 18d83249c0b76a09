"""How a flight uses up the contract's bounds: what the net sees, when it sees and acts, and what pushes the vehicles.

Everything is a share of a bound of the net's `Contract`. A malicious error points the worst way: things seem farther
away, and vehicles slower, than they are.
"""

from dataclasses import replace
from typing import Any, NamedTuple

from fledge.clearance import Nearest
from fledge.dynamics import Pioneer
from fledge.geometry import Quat, Vec3
from fledge.safety import Contract, UavStop, UgvStop
from fledge.scalars import Scalar, maximum, where
from fledge.world import UavState, UgvState, VelocityCommand, WorldState

WEAKEST = 0.1
"""[m/s^2] a UGV can always brake with, however far the contract is overstepped."""


class Trouble(NamedTuple):
    """How badly a flight uses the contract's bounds."""

    age: Scalar
    """Of what the net sees [ticks]."""
    latency: Scalar
    """Of what it sends [ticks]."""
    share: Scalar
    """Of errors and disturbance."""
    malice: Scalar
    """1: errors and push always point the worst way; 0: a fixed random way."""
    way: Vec3
    """That way, a unit vector."""
    cut: Scalar
    """1: when the net first steps in, a vehicle's link is lost, the worst moment for it; 0: links last."""

    def towards(self, worst: Vec3) -> Vec3:
        """Where errors and push point, and their share of the bounds as length."""
        return where(self.malice > 0.0, worst, self.way) * self.share


def measured(
    contract: Contract, trouble: Trouble, world: WorldState, near: tuple[Nearest, ...], t: Scalar
) -> WorldState:
    """What the net sees at time `t` [s] of a world in which those things are near."""
    ugvs = zip(world.ugvs, near[1:], strict=True)
    return WorldState(
        t,
        _measured_uav(contract, trouble, world.uav, near[0]),
        tuple(_measured_ugv(contract, trouble, ugv, nearest) for ugv, nearest in ugvs),
    )


def _measured_uav(contract: Contract, trouble: Trouble, uav: UavState, near: Nearest) -> UavState:
    """Away from what is near, slower towards it, a little tilted."""
    error = trouble.towards(Vec3(-near.x, -near.y, -near.z))
    half, q = 0.5 * contract.angle_error * trouble.share, uav.attitude
    return UavState(
        uav.position + error * contract.position_error,
        uav.velocity + error * contract.velocity_error,
        Quat(q.w, q.x + half * trouble.way.x, q.y + half * trouble.way.y, q.z),
        uav.rates + trouble.way * (contract.rate_error * trouble.share),
        uav.stamp,
    )


def _measured_ugv(contract: Contract, trouble: Trouble, ugv: UgvState, near: Nearest) -> UgvState:
    error = trouble.towards(Vec3(-near.x, -near.y, -near.z))
    slower = where(ugv.speed * trouble.malice > 0.0, -1.0, 1.0) * trouble.share
    return UgvState(
        ugv.x + error.x * contract.position_error,
        ugv.y + error.y * contract.position_error,
        ugv.heading + trouble.way.x * trouble.share * contract.angle_error,
        ugv.speed + slower * contract.velocity_error,
        ugv.turn_rate + trouble.way.y * trouble.share * contract.rate_error,
        ugv.stamp,
    )


def push(contract: Contract, trouble: Trouble, near: Nearest) -> Vec3:
    """The disturbance of the UAV [m/s^2]; at its worst towards what is nearest."""
    return trouble.towards(Vec3(near.x, near.y, near.z)) * contract.disturbance


def weakened(fleet: tuple[Pioneer, ...], contract: Contract, trouble: Trouble) -> tuple[Pioneer, ...]:
    """UGVs as they speed up and brake against the disturbance."""
    loss = contract.disturbance * trouble.share
    return tuple(replace(model, acceleration=maximum(model.acceleration - loss, WEAKEST)) for model in fleet)


class Link(NamedTuple):
    """A vehicle's link, which is lost at most once in a flight."""

    silent: Scalar
    """For how long [s] ago it was lost; 0 before."""
    last: VelocityCommand
    """What the vehicle had heard last."""

    def then(
        self, lost: Scalar, told: VelocityCommand, stop: UavStop | UgvStop, period: float
    ) -> tuple["Link", VelocityCommand]:
        """(the link one period later, what the vehicle does): as told; or, in silence, as told last, then nothing."""
        silent = where(lost | (self.silent > 0.0), self.silent + period, self.silent)
        alone = (silent > 0.0) & (silent < stop.silence)
        own = where(silent < stop.hold_over, self.last, self.last.scaled(0.0))
        return Link(silent, where(alone, self.last, told)), where(alone, own, told)


class Line(NamedTuple):
    """Things on their way: the newest first."""

    items: tuple[Any, ...]

    @classmethod
    def full_of(cls, item: Any, length: int) -> "Line":
        """Nothing has happened yet."""
        return cls((item,) * length)

    def then(self, item: Any) -> "Line":
        """One tick later."""
        return Line((item, *self.items[:-1]))

    def late(self, ticks: Scalar) -> Any:
        """What entered so many ticks ago."""
        found = self.items[-1]
        for i in range(len(self.items) - 2, -1, -1):
            found = where(ticks == float(i), self.items[i], found)
        return found
