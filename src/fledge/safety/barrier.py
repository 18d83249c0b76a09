"""A control-barrier filter: the smallest change to a command that keeps every barrier, instead of a stop.

The barrier of a face is its room: what remains free after a stop that begins now (`tube`). A command may use up at
most a share of it per second: with a face's unit normal n and a velocity c, n . c >= -room / pace; where there is no
room, it must lead out. What is sent is the nearest command that does so for every face:

* For the UAV the height is clipped. In the plane the three faces that the proposal offends most are kept by exact
  projection, the best of seven candidates (itself, three projections, three corners); should a fourth one be offended
  by that, the UAV brakes.
* A UGV's command is one speed along its nose, and every face clips an interval of speeds, by the inverse of the stop
  distance.

`pace` is longer than the time a command is held over, so what passes here passes the default net's rule as well, and
the same induction makes it sound.
"""

from dataclasses import dataclass
from typing import NamedTuple

from fledge.dynamics import UGV_FLEET
from fledge.geometry import Vec3
from fledge.safety.base import AbstractNet, Halt
from fledge.safety.contract import Contract, UavStop, UgvStop
from fledge.safety.halts import halts
from fledge.safety.tube import FREE
from fledge.safety.turns import RETREAT, Memory, UavTurn, UgvTurn, begin, in_turn, sent_instead
from fledge.scalars import Scalar, clip, maximum, minimum, sqrt, where
from fledge.world import Arena, Commands, Verdict, WorldState

NEVER = -1e3
"""[m/s] a bound that nothing offends."""
TINY = 1e-6


class HalfPlane(NamedTuple):
    """Velocities (x, y) with x nx + y ny >= least."""

    nx: Scalar
    ny: Scalar
    least: Scalar

    def lacks(self, x: Scalar, y: Scalar) -> Scalar:
        """By how much a velocity offends it [m/s]; negative if it does not."""
        return self.least - (self.nx * x + self.ny * y)


@dataclass(frozen=True, slots=True)
class Barrier(AbstractNet):
    """Changes a command as little as it must."""

    contract: Contract = Contract()
    uav: UavStop = UavStop()
    ugvs: tuple[UgvStop, ...] = tuple(UgvStop.of(model) for model in UGV_FLEET)
    pace: float = 0.4
    """[s] in which a UAV may use up its room; chosen above the lag of its loops, or it would overshoot."""
    reserve: float = 0.05
    """[m] of room that a UGV does not use up head-on; without any it could not even turn away along the face."""

    def init(self, arena: Arena, world: WorldState) -> Memory:
        """Nothing was sent yet."""
        return begin(self, arena, world)

    def filter(
        self, memory: Memory, world: WorldState, commands: Commands
    ) -> tuple[Memory, tuple[Verdict, ...]]:
        """The UAV decides first, then the UGVs in their order."""
        return in_turn(self, memory, world, commands)

    def overruled(self, memory: Memory, world: WorldState, instead: Commands) -> Memory:
        """What was really sent is what the next stop begins with."""
        return sent_instead(self, memory, world, instead)

    def halts(self, memory: Memory, world: WorldState) -> tuple[Halt, ...]:
        """By what it remembers having sent."""
        return halts(self, memory, world)

    def decide_uav(self, turn: UavTurn) -> tuple[Scalar, Vec3]:
        """The nearest velocity that keeps every barrier."""
        c = turn.wanted
        low, high, h = 0.0 * c.z - self.uav.most_up, 0.0 * c.z + self.uav.most_up, turn.heading
        # What the UAV obeys is a square that turns with its heading.
        axes = ((h.cos, h.sin), (-h.cos, -h.sin), (-h.sin, h.cos), (h.sin, -h.cos))
        planes = [HalfPlane(x, y, -self.uav.most) for x, y in axes]
        for face in turn.faces:
            least = minimum(-face.room / self.pace, RETREAT)
            low = maximum(low, where(face.z > 0.5, least, -self.uav.most_up))
            high = minimum(high, where(face.z < -0.5, -least, self.uav.most_up))
            flat = face.z * face.z < 0.5
            planes.append(HalfPlane(face.x, face.y, where(flat, least, NEVER)))
        x, y = nearest(c.x, c.y, planes)
        kept = low <= high
        for plane in planes:
            kept = kept & (plane.lacks(x, y) <= TINY)
        return turn.known & kept, Vec3(x, y, clip(c.z, low, high))

    def decide_ugv(self, stop: UgvStop, turn: UgvTurn) -> tuple[Scalar, Scalar]:
        """The nearest speed after which the UGV could still stop."""
        fastest, slowest, halt = stop.most, -stop.most, turn.proposal.slower(0.0)
        for face, (forwards, backwards) in zip(turn.faces, turn.shares, strict=True):
            room = maximum(face.room - halt.along((forwards, backwards)), 0.0)
            fastest = minimum(fastest, self._speed(room, forwards, stop))
            slowest = maximum(slowest, -self._speed(room, backwards, stop))
        return turn.known, clip(turn.proposal.forward, slowest, fastest)

    def _speed(self, room: Scalar, share: Scalar, stop: UgvStop) -> Scalar:
        """The speed [m/s] whose holding over and braking, of which `share` leads to a face, uses up the room [m]."""
        braking = stop.acceleration - self.contract.disturbance
        # A share that is no number is not a share of nothing.
        way = where(share <= TINY, FREE, maximum(room - self.reserve * share, 0.0) / maximum(share, TINY))
        return braking * (sqrt(stop.hold_over**2 + 2.0 * way / braking) - stop.hold_over)


def nearest(x: Scalar, y: Scalar, planes: list[HalfPlane]) -> tuple[Scalar, Scalar]:
    """The velocity nearest to (x, y) within the three half-planes that (x, y) offends most."""
    worst = _worst(x, y, planes)
    candidates = [(x, y)] + [_onto(x, y, plane) for plane in worst]
    candidates += [_corner(worst[i], worst[j]) for i, j in ((0, 1), (0, 2), (1, 2))]
    best_x, best_y, best = x, y, 0.0 * x + 1e6
    for cx, cy in candidates:
        inside = True
        for plane in worst:
            inside = inside & (plane.lacks(cx, cy) <= TINY)
        far = (cx - x) * (cx - x) + (cy - y) * (cy - y)
        better = inside & (far < best)
        best_x, best_y, best = where(better, cx, best_x), where(better, cy, best_y), where(better, far, best)
    return best_x, best_y


def _worst(x: Scalar, y: Scalar, planes: list[HalfPlane]) -> list[HalfPlane]:
    """The three that (x, y) offends most."""
    none = HalfPlane(0.0 * x, 0.0 * x, NEVER + 0.0 * x)
    found, lacks = [none] * 3, [NEVER + 0.0 * x] * 3
    for plane in planes:
        new, lack = plane, plane.lacks(x, y)
        for i in range(3):
            more = lack > lacks[i]
            (found[i], new), (lacks[i], lack) = (
                (where(more, new, found[i]), where(more, found[i], new)),
                (where(more, lack, lacks[i]), where(more, lacks[i], lack)),
            )
    return found


def _onto(x: Scalar, y: Scalar, plane: HalfPlane) -> tuple[Scalar, Scalar]:
    """The nearest velocity on the edge of a half-plane."""
    lack = plane.lacks(x, y)
    return x + plane.nx * lack, y + plane.ny * lack


def _corner(a: HalfPlane, b: HalfPlane) -> tuple[Scalar, Scalar]:
    """Where two edges meet; far away if they are parallel."""
    det = a.nx * b.ny - a.ny * b.nx
    inverse = 1.0 / where(abs(det) < TINY, TINY, det)
    return (a.least * b.ny - b.least * a.ny) * inverse, (b.least * a.nx - a.least * b.nx) * inverse
