"""Vehicles decide in turn, each against what the others have committed to: what the stop-tube nets share.

The UAV decides first, then the UGVs in their order. A vehicle's commitment is its stop after whichever of the commands
it was sent was the last that it heard: to be told to stop is no proof of having heard it. Whoever decides later finds
every earlier decision, and of those yet to decide the one before. All commitments are disjoint at every moment; that is
the whole argument for several vehicles.

A net says what is sent to one vehicle, given its faces (`Deciding`); here is the order, the memory, the braking and
holding that every decision can fall back on, and the verdict.
"""

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple, Protocol

from fledge.geometry import Heading, Vec3
from fledge.safety.contract import Contract, UavStop, UgvStop
from fledge.safety.tube import (
    FREE,
    Around,
    Face,
    Pace,
    Sent,
    UavCommitment,
    UavTube,
    UgvCommitment,
    UgvMotion,
    UgvProposal,
    UgvSent,
    UgvTube,
    around_uav,
    around_ugv,
    filter_share,
    uav_error,
    uav_tube,
)
from fledge.scalars import Scalar, clip, cond, isfinite, maximum, minimum, negate, surely, where
from fledge.world import Arena, Commands, Reason, UavState, VelocityCommand, Verdict, WorldState

SLOW = 0.3
"""[m/s] at which a braking UAV begins to hold; above the drift that the contract allows."""
PULL = 1.5
"""[1/s] towards the point it holds; chosen, 60 degrees of phase margin."""
RETREAT = 0.2
"""[m/s] at which a hold point moves out of where there is no room."""
DRIFT = 0.1
"""[m/s] with which the contract's disturbance drives a UAV that is told to hover; in the simulator 0.06."""
BLIND = 2.0
"""[s] for which a UAV is kept off things that it no longer sees; chosen, then it should have been landed."""
CALMING = 1.0
"""[s] in which the pace of the UAV stops to matter; a few of its lags, and half of that was too short."""
AHEAD = 2.0
"""[s] at full speed: a UAV with more room before it is not kept from anything; far above any net's horizon."""
LEAD = 0.2
"""[m] it may be ahead of the UAV."""
STANDS = 0.1
"""[m/s] up to which a UGV counts as standing; chosen, it then comes to rest within 2 cm."""


class UavMemory(NamedTuple):
    """Of the UAV: what it was sent along the world's axes, and the point it holds."""

    sent: tuple[Sent, Sent, Sent]
    pace: Pace
    holding: Scalar
    """1 while it holds a point."""
    point: Vec3
    """[m]."""


class Memory(NamedTuple):
    """What a net remembers."""

    arena: Arena
    uav: UavMemory
    ugvs: tuple[UgvSent, ...]


class UavTurn(NamedTuple):
    """What the UAV's decision is made from."""

    wanted: Vec3
    """The proposed velocity in world axes, within what the UAV obeys [m/s]."""
    known: Scalar
    """Whether it is a number, and what is known of the UAV is fresh."""
    faces: list[Face]
    heading: Heading


class UgvTurn(NamedTuple):
    """What a UGV's decision is made from."""

    proposal: UgvProposal
    """Within what the UGV obeys. Where `rooms` are too small for it, they may yet be enough for its sweep."""
    known: Scalar
    """Whether it is numbers, and what is known of the UGV is fresh."""
    faces: list[Face]
    """Their room does not count the UGV's own way yet."""
    shares: tuple[tuple[Scalar, Scalar], ...]
    """Which share of its way forwards, and in reverse, leads to each face."""
    rooms: tuple[Scalar, ...]
    """What the proposal leaves before each face [m]."""


class Deciding(Protocol):
    """A net, as this module sees it."""

    @property
    def contract(self) -> Contract:
        """What it relies on."""
        ...

    @property
    def uav(self) -> UavStop:
        """How the UAV stops."""
        ...

    @property
    def ugvs(self) -> tuple[UgvStop, ...]:
        """How each UGV stops."""
        ...

    @property
    def reserve(self) -> float:
        """Room that a UGV leaves unused [m]."""
        ...

    def decide_uav(self, turn: UavTurn) -> tuple[Scalar, Vec3]:
        """(whether something may be sent, what: a velocity in world axes); else the UAV brakes and holds."""
        ...

    def decide_ugv(self, stop: UgvStop, turn: UgvTurn) -> tuple[Scalar, Scalar]:
        """(whether something may be sent, what: a speed, no faster than proposed); else the UGV stops."""
        ...


def begin(net: Deciding, arena: Arena, world: WorldState) -> Memory:
    """Nothing was sent yet."""
    # A broken clock must not break the memory.
    zero = where(isfinite(world.t), 0.0 * world.t, 0.0)
    still = Sent.nothing(net.contract, zero)
    uav = UavMemory((still, still, still), Pace(zero, zero), zero, world.uav.position)
    return Memory(arena, uav, (UgvSent.nothing(zero),) * len(world.ugvs))


def in_turn(
    net: Deciding, memory: Memory, world: WorldState, commands: Commands
) -> tuple[Memory, tuple[Verdict, ...]]:
    """(memory, verdicts), the UAV's first."""
    age = world.t - world.uav.stamp
    tube = uav_tube(net.contract, net.uav, world.uav, memory.uav.sent, memory.uav.pace, age)
    motions = [
        UgvMotion.of(net.contract, stop, ugv, sent, world.t - ugv.stamp)
        for stop, ugv, sent in zip(net.ugvs, world.ugvs, memory.ugvs, strict=True)
    ]
    commitments = [UgvCommitment(motion) for motion in motions]
    reach = AHEAD * net.uav.most
    around = around_uav(net.contract, net.uav, reach, memory.arena, world.uav, tube, commitments)
    uav, commitment, verdict = _uav(net, memory.uav, world, commands.uav, tube, around)
    # A UAV that was not seen for long may have been told to land: nobody drives under it.
    commitment = commitment.sinking(where(age <= 2.0 * net.contract.age, 0.0 * age, FREE))
    remembered, verdicts = [], [verdict]
    for i, motion in enumerate(motions):
        others = [*commitments[:i], *commitments[i + 1 :]]
        stop, ugv, proposed = motion.stop, motion.ugv, commands.ugvs[i]
        reach = motion.reach(minimum(abs(proposed.forward), stop.most)) + net.reserve
        around = around_ugv(
            net.contract, motion, reach, memory.arena, others, (net.uav, world.uav, commitment)
        )
        sent, verdict = _ugv(net, motion, reach, world.t, proposed, around)
        if i + 1 < len(motions):  # who comes last is minded by nobody
            commitments[i] = UgvCommitment(UgvMotion.of(net.contract, stop, ugv, sent, world.t - ugv.stamp))
        remembered.append(sent)
        verdicts.append(verdict)
    return Memory(memory.arena, uav, tuple(remembered)), tuple(verdicts)


def sent_instead(net: Deciding, memory: Memory, world: WorldState, instead: Commands) -> Memory:
    """What was really sent is what the next stop begins with; a UAV that was sent elsewhere holds no point."""
    c, uav = instead.uav, memory.uav
    x, y = world.uav.attitude.heading().to_world(c.forward, c.left)
    level, up, turn = isfinite(x + y), isfinite(c.up), isfinite(c.turn)
    along_x, along_y, along_z = uav.sent
    axes = (
        where(level, along_x.instead(x), along_x),
        where(level, along_y.instead(y), along_y),
        where(up, along_z.instead(c.up), along_z),
    )
    zero = 0.0 * uav.holding
    pace = uav.pace.then(where(level, x, zero), where(level, y, zero), where(turn, c.turn, zero))
    uav = UavMemory(axes, pace, where(level, zero, uav.holding), uav.point)
    ugvs = tuple(
        where(isfinite(c.forward + c.turn), sent.then(net.contract, stop, c.forward, c.turn, 0.0), sent)
        for stop, sent, c in zip(net.ugvs, memory.ugvs, instead.ugvs, strict=True)
    )
    return Memory(memory.arena, uav, ugvs)


def clear(rooms: Sequence[Scalar]) -> Scalar:
    """Whether there is room before every face."""
    every = True
    for room in rooms:
        every = every & (room >= 0.0)
    return every


def _fresh(contract: Contract, age: Scalar) -> Scalar:
    return (age >= -contract.period) & (age <= contract.age + 0.5 * contract.period)


def _uav(
    net: Deciding,
    memory: UavMemory,
    world: WorldState,
    proposed: VelocityCommand,
    tube: UavTube,
    around: Around,
) -> tuple[UavMemory, UavCommitment, Verdict]:
    """(memory, what the UAV is committed to now, verdict)."""
    stop, age = net.uav, world.t - world.uav.stamp
    heading = world.uav.attitude.heading()
    forward, left = clip(proposed.forward, -stop.most, stop.most), clip(proposed.left, -stop.most, stop.most)
    x, y = heading.to_world(forward, left)
    wanted = Vec3(x, y, clip(proposed.up, -stop.most_up, stop.most_up))
    turn = clip(proposed.turn, -stop.most_turn, stop.most_turn)
    number = isfinite(wanted.x + wanted.y + wanted.z + turn)
    fresh = _fresh(net.contract, age)
    faces = around.faces
    tightest = _tightest(faces, [face.room for face in faces])
    known = number & fresh & _whole(world.uav)
    fades = net.contract.period / CALMING
    quicker = memory.pace.then(x, y, turn, fades)
    passes, chosen = net.decide_uav(
        UavTurn(wanted, known, _after(net, world.uav, quicker, tube, faces), heading)
    )
    memory, back = _hold(net.contract, memory, world.uav, age, tube, tightest, passes)
    seen = age <= 2.0 * net.contract.age
    held = cond(seen, lambda: back, lambda: _adrift(faces, age))
    same = passes & (chosen.x == wanted.x) & (chosen.y == wanted.y) & (chosen.z == wanted.z)
    zero = 0.0 * memory.holding
    sent = _within(stop, where(passes, chosen, held), heading)
    forward, left, up = where(same, (forward, left, wanted.z), (sent.forward, sent.left, sent.up))
    sent = VelocityCommand(forward, left, up, where(passes, turn, zero))
    x, y = heading.to_world(sent.forward, sent.left)
    velocity = where(isfinite(x + y), Vec3(x, y, sent.up), Vec3(zero, zero, zero))
    share = filter_share(net.contract, stop)
    along_x, along_y, along_z = memory.sent
    axes = (
        along_x.then(velocity.x, share),
        along_y.then(velocity.y, share),
        along_z.then(velocity.z, share),
    )
    pace = memory.pace.then(velocity.x, velocity.y, sent.turn, fades)
    reason = where(number, where(fresh, tightest.reason, Reason.STALE), Reason.NOT_FINITE)
    memory = memory._replace(sent=axes, pace=pace)
    tube = tube._replace(error=uav_error(net.contract, stop, world.uav, pace))
    commitment = UavCommitment.of(tube, axes, net.contract.period, stop.hold_over)
    return memory, commitment, _verdict(proposed, sent, reason, around.gap)


def _after(net: Deciding, uav: UavState, pace: Pace, tube: UavTube, faces: list[Face]) -> list[Face]:
    """The faces, with the room that is left if the UAV goes at a pace: the stop after that misses by more."""
    more = maximum(uav_error(net.contract, net.uav, uav, pace) - tube.error, 0.0)
    if surely(more == 0.0):
        return faces
    return [face.closer(more * (1.0 - face.z * face.z)) for face in faces]


def _whole(uav: UavState) -> Scalar:
    """Whether all that is known of the UAV is a number."""
    p, v, q, w = uav.position, uav.velocity, uav.attitude, uav.rates
    return isfinite(p.x + p.y + p.z + v.x + v.y + v.z + q.w + q.x + q.y + q.z + w.x + w.y + w.z)


def _within(stop: UavStop, velocity: Vec3, heading: Heading) -> VelocityCommand:
    """A velocity in world axes as a command, shortened to what the UAV obeys; hover if it is no number."""
    forward, left = heading.from_world(velocity.x, velocity.y)
    share = minimum(1.0, stop.most / maximum(maximum(abs(forward), abs(left)), 0.01))
    up = clip(velocity.z, -stop.most_up, stop.most_up)
    zero = 0.0
    known = isfinite(forward + left + up)
    return where(
        known,
        VelocityCommand(forward * share, left * share, up, zero),
        VelocityCommand(zero, zero, zero, zero),
    )


def _hold(
    contract: Contract,
    memory: UavMemory,
    uav: UavState,
    age: Scalar,
    tube: UavTube,
    tightest: Face,
    passes: Scalar,
) -> tuple[UavMemory, Vec3]:
    """Brake; once slow, hold the point of rest. Where there is no room hold on at once, and move that point out."""
    p, v = uav.position, uav.velocity
    slow = v.x * v.x + v.y * v.y + v.z * v.z < SLOW * SLOW
    tight = tightest.room < 0.0
    already = memory.holding > 0.0
    point = where(already, memory.point, where(tight, p, p + tube.late))
    step = where(tight, RETREAT * contract.period, 0.0)
    ahead = point + Vec3(tightest.x, tightest.y, tightest.z) * step - p
    ahead = Vec3(clip(ahead.x, -LEAD, LEAD), clip(ahead.y, -LEAD, LEAD), clip(ahead.z, -LEAD, LEAD))
    # What is not known, or too old, is nothing to hold by.
    seen = isfinite(ahead.x + ahead.y + ahead.z) & (age <= 2.0 * contract.age)
    holding = negate(passes) & (already | slow | tight) & seen
    zero = 0.0 * memory.holding
    known = isfinite(p.x + p.y + p.z)
    memory = memory._replace(
        holding=where(holding, 1.0 + zero, zero),
        point=where(holding, p + ahead, where(known, p, memory.point)),
    )
    return memory, where(holding, ahead * PULL, Vec3(zero, zero, zero))


def _adrift(faces: list[Face], age: Scalar) -> Vec3:
    """What a UAV does whose pose is too old to hold by: it goes against whatever a push may be driving it into."""
    x = y = z = 0.0 * age
    for face in faces:
        push = where((face.room < DRIFT * age) & (age <= BLIND), DRIFT, 0.0)
        x, y, z = x + face.x * push, y + face.y * push, z + face.z * push
    return Vec3(clip(x, -DRIFT, DRIFT), clip(y, -DRIFT, DRIFT), clip(z, -DRIFT, DRIFT))


def _ugv(
    net: Deciding,
    motion: UgvMotion,
    reach: Scalar,
    t: Scalar,
    proposed: VelocityCommand,
    around: Around,
) -> tuple[UgvSent, Verdict]:
    stop, ugv, memory = motion.stop, motion.ugv, motion.sent
    age = t - ugv.stamp
    forward = clip(proposed.forward, -stop.most, stop.most)
    turn = clip(proposed.turn, -stop.most_turn, stop.most_turn)
    number, fresh = isfinite(forward + turn), _fresh(net.contract, age)
    known = number & fresh & motion.known
    zero = 0.0 * memory.left.most
    faces = around.faces

    def swept(turn: Scalar) -> tuple[Scalar, tuple[tuple[Scalar, Scalar], ...], tuple[Scalar, ...]]:
        go = motion.told(forward, turn)
        shares = tuple(
            # Nothing that it may be told leads farther.
            cond(face.room > reach, lambda: (zero, zero), partial(go.shares, -face.x, -face.y))
            for face in faces
        )
        return turn, shares, _rooms(faces, shares, go)

    turning = swept(turn)
    # Its hull is a disc: as long as it stands it may turn. One that moves may swing its way into something; it turns as
    # far whether it stops or goes, and goes no farther if it stops.
    stands = number & (abs(ugv.speed) <= STANDS)
    may_turn = cond(
        stands | clear(turning[2]),
        lambda: True,
        lambda: clear(_rooms(faces, turning[1], motion.told(0.0, turn))),
    )
    turn, shares, rooms = cond(may_turn, lambda: turning, lambda: swept(0.0 * turn))
    tightest = _tightest(faces, rooms)
    proposal = UgvProposal(motion, forward, turn)
    passes, chosen = net.decide_ugv(stop, UgvTurn(proposal, known, faces, shares, rooms))
    passes = passes & isfinite(chosen)
    speed = where(passes, chosen, zero)
    turned = where(passes | stands, turn, zero)
    reason = where(number, where(fresh, tightest.reason, Reason.STALE), Reason.NOT_FINITE)
    proposed = VelocityCommand(proposed.forward, zero, zero, proposed.turn)
    verdict = _verdict(proposed, VelocityCommand(speed, zero, zero, turned), reason, around.gap)
    return memory.then(net.contract, stop, speed, turned, net.contract.period), verdict


def _rooms(faces: list[Face], shares: tuple[tuple[Scalar, Scalar], ...], tube: UgvTube) -> tuple[Scalar, ...]:
    """What a UGV's way leaves before each face [m]."""
    return tuple(face.room - tube.along(share) for face, share in zip(faces, shares, strict=True))


def _tightest(faces: list[Face], rooms: Sequence[Scalar]) -> Face:
    """The face with least room, NaN being least."""
    least = rooms[0], faces[0]
    for room, face in zip(rooms[1:], faces[1:], strict=True):
        still = (least[0] <= room) | (least[0] != least[0])
        least = where(still, least, (room, face))
    return least[1]


def _verdict(proposed: VelocityCommand, sent: VelocityCommand, reason: Scalar, gap: Scalar) -> Verdict:
    same = (proposed.forward == sent.forward) & (proposed.turn == sent.turn)
    same = same & (proposed.left == sent.left) & (proposed.up == sent.up)
    zero = 0.0 * sent.forward
    return Verdict(sent, where(same, zero, 1.0 + zero), where(same, zero, reason + zero), gap)
