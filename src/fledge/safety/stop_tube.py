"""The default net: a command passes only if the vehicle could still stop after it.

*The rule.* "This command until the vehicle's own watchdog would end it, then brake" must leave room before every
face (`tube`); else the vehicle brakes. A UAV that has slowed down then holds the point it is about to rest at, since
zero velocity is no hold: a steady push drifts through it. A UGV stands where it stands, and may turn there.

*Why it is sound.* By induction: at every tick the stop that begins now ends in free space. A command that passes is
one after which that holds again; if none passes, the stop that was found free before goes on. Whatever proposes the
commands, NaN included, nothing is touched as long as the `Contract` holds. Vehicles decide in a fixed order, the UAV
first, each against what the others have committed to.

*Why it is live.* Where there is no room (a vehicle may be started there, or pushed there) a command passes if it leads
out, and if none does, the UAV's hold point itself moves out. A way in which every stop fits is never closed.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

from fledge.dynamics import UGV_FLEET
from fledge.geometry import Heading, Vec3
from fledge.safety.base import AbstractNet
from fledge.safety.contract import Contract, UavStop, UgvStop
from fledge.safety.tube import (
    Face,
    Sent,
    UavTube,
    UgvTube,
    filter_share,
    uav_faces,
    uav_tube,
    ugv_faces,
    ugv_tube,
)
from fledge.scalars import Scalar, clip, isfinite, maximum, minimum, negate, where
from fledge.world import Arena, Commands, Reason, UavState, UgvState, VelocityCommand, Verdict, WorldState


class UavMemory(NamedTuple):
    """Of the UAV: what it was sent along the world's axes, and the point it holds."""

    sent: tuple[Sent, Sent, Sent]
    holding: Scalar
    """1 while it holds a point."""
    point: Vec3
    """[m]."""


class UgvMemory(NamedTuple):
    """Of a UGV: what it was sent."""

    sent: Sent
    turn: Scalar
    """[rad/s] last."""


class Memory(NamedTuple):
    """What the net remembers."""

    arena: Arena
    uav: UavMemory
    ugvs: tuple[UgvMemory, ...]


class Room(NamedTuple):
    """What a vehicle's faces come to for one command."""

    free: Scalar
    """Whether the command may pass."""
    gap: Scalar
    """To the nearest thing [m]."""
    tightest: Face
    """The face with least room."""


@dataclass(frozen=True, slots=True)
class StopTube(AbstractNet):
    """Lets a command through only if the vehicle could still stop after it."""

    contract: Contract = Contract()
    uav: UavStop = UavStop()
    ugvs: tuple[UgvStop, ...] = tuple(UgvStop.of(model) for model in UGV_FLEET)
    slow: float = 0.3  # [m/s] at which a braking UAV begins to hold; above the drift that the contract allows
    pull: float = 1.5  # [1/s] towards the point it holds; chosen, 60 degrees of phase margin
    retreat: float = 0.2  # [m/s] at which a hold point moves out of where there is no room
    lead: float = 0.25  # [m] it may be ahead of the UAV
    outwards: float = 0.15  # [m/s] a command must lead out with; above the drift that the contract allows
    scale: float = 1.0
    """Share of the proven margin that is kept; less than 1 is for measuring how much of it is needed."""

    def init(self, arena: Arena, world: WorldState) -> Memory:
        """Nothing was sent yet."""
        zero = 0.0 * world.t
        still = Sent.nothing(self.contract, zero)
        uav = UavMemory((still, still, still), zero, world.uav.position)
        return Memory(arena, uav, tuple(UgvMemory(still, zero) for _ in world.ugvs))

    def filter(
        self, memory: Memory, world: WorldState, commands: Commands
    ) -> tuple[Memory, tuple[Verdict, ...]]:
        """The UAV decides first, then the UGVs in their order, each against what the others have committed to."""
        age = world.t - world.uav.stamp
        tube = uav_tube(self.contract, self.uav, world.uav, memory.uav.sent, age)
        committed = [
            self._committed(stop, ugv, remembered, world.t)
            for stop, ugv, remembered in zip(self.ugvs, world.ugvs, memory.ugvs, strict=True)
        ]
        around = tuple(zip(self.ugvs, world.ugvs, committed, strict=True))
        faces = uav_faces(self.contract, self.uav, memory.arena, world.uav, tube, around)
        faces = [face._replace(room=self._kept(face, face.room)) for face in faces]
        uav, verdict = self._uav(memory.uav, world, commands.uav, tube, faces)
        tube = self._uav_committed(tube, verdict.command, world.uav)
        remembered, verdicts = [], [verdict]
        for i, stop in enumerate(self.ugvs):
            others = tuple(zip(self.ugvs, world.ugvs, committed, strict=True))
            others = others[:i] + others[i + 1 :]
            faces = ugv_faces(
                self.contract, stop, memory.arena, world.ugvs[i], others, (self.uav, world.uav, tube)
            )
            one, verdict = self._ugv(stop, memory.ugvs[i], world.ugvs[i], world.t, commands.ugvs[i], faces)
            committed[i] = self._committed(stop, world.ugvs[i], one, world.t)
            remembered.append(one)
            verdicts.append(verdict)
        return Memory(memory.arena, uav, tuple(remembered)), tuple(verdicts)

    def _kept(self, face: Face, room: Scalar) -> Scalar:
        return room if self.scale == 1.0 else face.gap - self.scale * (face.gap - room)

    def _fresh(self, age: Scalar) -> Scalar:
        return (age >= -self.contract.period) & (age <= self.contract.age + 0.5 * self.contract.period)

    # The UAV.

    def _uav(
        self, memory: UavMemory, world: WorldState, proposed: VelocityCommand, tube: UavTube, faces: list[Face]
    ) -> tuple[UavMemory, Verdict]:
        uav, age = world.uav, world.t - world.uav.stamp
        heading = uav.attitude.heading()
        wanted = VelocityCommand(
            clip(proposed.forward, -self.uav.most, self.uav.most),
            clip(proposed.left, -self.uav.most, self.uav.most),
            clip(proposed.up, -self.uav.most_up, self.uav.most_up),
            proposed.turn,
        )
        known = isfinite(wanted.forward + wanted.left + wanted.up + wanted.turn)
        x, y = heading.to_world(wanted.forward, wanted.left)
        room = self._uav_room(faces, x, y, wanted.up)
        passes = known & self._fresh(age) & room.free
        memory, held = self._hold(memory, uav, age, tube, room.tightest, passes, heading)
        sent = where(passes, wanted, held)
        x, y = heading.to_world(sent.forward, sent.left)
        share = filter_share(self.contract, self.uav)
        axes = tuple(axis.then(value, share) for axis, value in zip(memory.sent, (x, y, sent.up), strict=True))
        reason = where(known, where(self._fresh(age), room.tightest.reason, Reason.STALE), Reason.NOT_FINITE)
        return memory._replace(sent=axes), _verdict(proposed, sent, passes, reason, room.gap)

    def _uav_room(self, faces: list[Face], x: Scalar, y: Scalar, up: Scalar) -> Room:
        """Whether a command, in world axes [m/s], leaves room before every face, or leads out where there is none."""
        free, tightest, gap = True, faces[0], faces[0].gap
        for face in faces:
            away = face.x * x + face.y * y + face.z * up
            left = face.room + minimum(away, 0.0) * self.uav.hold_over
            free = free & ((left >= 0.0) | ((face.room < 0.0) & (away >= self.outwards)))
            tightest, gap = _tighter(tightest, face), minimum(gap, face.gap)
        return Room(free, gap, tightest)

    def _hold(
        self,
        memory: UavMemory,
        uav: UavState,
        age: Scalar,
        tube: UavTube,
        tightest: Face,
        passes: Scalar,
        heading: Heading,
    ) -> tuple[UavMemory, VelocityCommand]:
        """Brake; once slow, hold the point of rest. Where there is no room hold on at once, and move that point out."""
        p, v = uav.position, uav.velocity
        slow = v.x * v.x + v.y * v.y + v.z * v.z < self.slow**2
        holding = negate(passes) & ((memory.holding > 0.0) | slow | (tightest.room < 0.0))
        tight = tightest.room < 0.0
        rest = where(tight, p, p + tube.late)
        point = where(memory.holding > 0.0, memory.point, rest)
        step = where(tight, self.retreat * self.contract.period, 0.0)
        point = point + Vec3(tightest.x, tightest.y, tightest.z) * step
        dx, dy, dz = (
            clip(to - at, -self.lead, self.lead)
            for to, at in ((point.x, p.x), (point.y, p.y), (point.z, p.z))
        )
        point = Vec3(p.x + dx, p.y + dy, p.z + dz)
        forward, left = heading.from_world(self.pull * dx, self.pull * dy)
        held = VelocityCommand(forward, left, self.pull * dz, 0.0 * forward)
        # What is not known, or too old, is nothing to hold by.
        seen = isfinite(forward + left + held.up) & (age <= self.contract.age * 2.0)
        hover = VelocityCommand(*(0.0 * memory.holding,) * 4)
        keep = holding & seen
        memory = memory._replace(
            holding=where(keep, 1.0 + 0.0 * memory.holding, 0.0 * memory.holding),
            point=where(keep, point, where(isfinite(p.x + p.y + p.z), p, memory.point)),
        )
        return memory, where(keep, held, hover)

    def _uav_committed(self, tube: UavTube, sent: VelocityCommand, uav: UavState) -> UavTube:
        """The tube once the command is on its way."""
        x, y = uav.attitude.heading().to_world(sent.forward, sent.left)
        more = Vec3(x, y, sent.up) * self.uav.hold_over
        return tube._replace(early=tube.early + more, late=tube.late + more)

    # The UGVs.

    def _committed(self, stop: UgvStop, ugv: UgvState, memory: UgvMemory, t: Scalar) -> UgvTube:
        last = memory.sent.newest[0]
        return ugv_tube(self.contract, stop, ugv, memory.sent, t - ugv.stamp, last, memory.turn)

    def _ugv(
        self,
        stop: UgvStop,
        memory: UgvMemory,
        ugv: UgvState,
        t: Scalar,
        proposed: VelocityCommand,
        faces: list[Face],
    ) -> tuple[UgvMemory, Verdict]:
        age = t - ugv.stamp
        forward = clip(proposed.forward, -stop.most, stop.most)
        turn = clip(proposed.turn, -stop.most_turn, stop.most_turn)
        known = isfinite(forward + turn)
        tube = ugv_tube(self.contract, stop, ugv, memory.sent, age, forward, turn)
        room = self._ugv_room(faces, tube, forward)
        passes = known & self._fresh(age) & room.free
        # Its hull is a disc: as long as it stands it may turn.
        stands = abs(ugv.speed) <= self.contract.velocity_error
        zero = 0.0 * memory.turn
        forward = where(passes, forward, zero)
        turn = where(passes | (known & stands), turn, zero)
        sent = VelocityCommand(forward, zero, zero, turn)
        reason = where(known, where(self._fresh(age), room.tightest.reason, Reason.STALE), Reason.NOT_FINITE)
        return UgvMemory(memory.sent.then(forward, 1.0), turn), _verdict(
            replace(proposed, left=zero, up=zero), sent, passes, reason, room.gap
        )

    def _ugv_room(self, faces: list[Face], tube: UgvTube, forward: Scalar) -> Room:
        """Whether a command leaves room before every face, or does not lead nearer where there is none."""
        free, tightest, gap = True, faces[0], faces[0].gap
        for face in faces:
            left = self._kept(face, face.room - tube.advance(-face.x, -face.y))
            nearer = tube._replace(
                ahead=maximum(forward, 0.0), astern=maximum(-forward, 0.0)
            ).advance(-face.x, -face.y)
            free = free & ((left >= 0.0) | (nearer <= 0.0))
            tightest, gap = _tighter(tightest, face._replace(room=left)), minimum(gap, face.gap)
        return Room(free, gap, tightest)


def _tighter(a: Face, b: Face) -> Face:
    """The face with less room; NaN is least."""
    return where(a.room <= b.room, a, b)


def _verdict(
    proposed: VelocityCommand, sent: VelocityCommand, passes: Scalar, reason: Scalar, gap: Scalar
) -> Verdict:
    same = (
        (proposed.forward == sent.forward)
        & (proposed.left == sent.left)
        & (proposed.up == sent.up)
        & (proposed.turn == sent.turn)
    )
    intervened = where(same, 0.0 * sent.forward, 1.0 + 0.0 * sent.forward)
    return Verdict(sent, intervened, where(passes, 0.0 * sent.forward, reason + 0.0 * sent.forward), gap)
