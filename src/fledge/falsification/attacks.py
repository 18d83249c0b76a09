"""Adversaries against a safety net: what a policy could do at its worst.

A family says, at 100 Hz and knowing the truth, where a vehicle should be driven: a vector in world axes in shares of
full speed, each within [-1, 1]. `Attacker` gives every vehicle its share and turns it into commands. New family: one
function, and its name in `FAMILIES`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from fledge.clearance import Nearest
from fledge.dynamics import Pioneer
from fledge.geometry import Heading, Vec3
from fledge.observation import StickScale
from fledge.scalars import Scalar, atan2, clip, cos, sqrt, where
from fledge.world import Arena, Commands, UgvState, VelocityCommand, WorldState

SEGMENTS = 8
"""Of a script: what the searching adversary writes."""


class Nature(NamedTuple):
    """What an attack keeps for a whole flight; drawn once."""

    family: Scalar
    """Index into `FAMILIES`."""
    stuck: Vec3
    """Each in [-1, 1]."""
    trigger: Scalar
    """Gap [m] at which a late reverse turns round."""
    pace: Scalar
    """How long [s] something random is held, or a bang-bang lasts."""
    script: tuple[Vec3, ...]
    """Along the way to the nearest thing, across it, and up; one vector per segment."""
    length: Scalar
    """Of the attack [s]."""


class Chance(NamedTuple):
    """Drawn for every vehicle and tick."""

    uniform: Vec3
    """Each in [-1, 1]."""
    normal: Vec3
    """Standard normal."""
    odds: Scalar
    """In [0, 1]."""


class Mood(NamedTuple):
    """What an attack remembers of a vehicle."""

    held: Vec3
    """The random vector of the moment."""
    drift: Vec3
    """An Ornstein-Uhlenbeck process."""
    late: Vec3
    """Where the nearest thing was when the random vector was drawn."""
    fleeing: Scalar
    """1 on the way back of a late reverse."""


class Sight(NamedTuple):
    """What an attack sees of a vehicle: everything, exactly."""

    t: Scalar
    x: Scalar
    y: Scalar
    near: Nearest
    middle: tuple[Scalar, Scalar]
    """Of the arena [m]."""
    target: tuple[Scalar, Scalar]
    """The middle of the UGVs [m]."""


Family = Callable[[Nature, Mood, Sight, Chance], Vec3]


def _random(nature: Nature, mood: Mood, sight: Sight, chance: Chance) -> Vec3:
    return mood.held


def _ornstein_uhlenbeck(nature: Nature, mood: Mood, sight: Sight, chance: Chance) -> Vec3:
    return mood.drift


def _nearest(nature: Nature, mood: Mood, sight: Sight, chance: Chance) -> Vec3:
    """Full speed at the nearest thing."""
    return Vec3(sight.near.x, sight.near.y, sight.near.z)


def _corner(nature: Nature, mood: Mood, sight: Sight, chance: Chance) -> Vec3:
    """Bang-bang into the nearest corner of the arena: one wall, then the other, then both, then back a little."""
    x = where(sight.x > sight.middle[0], 1.0, -1.0)
    y = where(sight.y > sight.middle[1], 1.0, -1.0)
    turn = (sight.t / nature.pace) % 4.0
    return Vec3(
        where(turn < 1.0, x, where(turn < 2.0, 0.0 * x, where(turn < 3.0, x, -x))),
        where(turn < 1.0, 0.0 * y, where(turn < 3.0, y, -y)),
        where(turn < 2.0, 0.0 * x, -1.0 + 0.0 * x),
    )


def _sign_flipped(nature: Nature, mood: Mood, sight: Sight, chance: Chance) -> Vec3:
    """A policy that follows the UGVs, with its signs wrong: it flees from what it should keep in view."""
    dx, dy = sight.x - sight.target[0], sight.y - sight.target[1]
    return Vec3(clip(2.0 * dx, -1.0, 1.0), clip(2.0 * dy, -1.0, 1.0), -0.3 + 0.0 * dx)


def _late_reverse(nature: Nature, mood: Mood, sight: Sight, chance: Chance) -> Vec3:
    """Full speed at the nearest thing, full speed back when it is near, and again."""
    sign = where(mood.fleeing > 0.0, -1.0, 1.0)
    return Vec3(sign * sight.near.x, sign * sight.near.y, sign * sight.near.z)


def _delayed(nature: Nature, mood: Mood, sight: Sight, chance: Chance) -> Vec3:
    """At where the nearest thing was, up to seconds ago."""
    return mood.late


def _garbage(nature: Nature, mood: Mood, sight: Sight, chance: Chance) -> Vec3:
    """NaN, infinities and 1e30 between sane commands at the nearest thing."""
    n, odds = sight.near, chance.odds
    bad = where(odds < 0.2, float("nan"), where(odds < 0.4, float("inf"), where(odds < 0.6, -1e30, 1e30)))
    x = where(odds < 0.8, bad, n.x)
    return Vec3(x, where((odds > 0.3) & (odds < 0.7), bad, n.y), n.z)


def _stuck(nature: Nature, mood: Mood, sight: Sight, chance: Chance) -> Vec3:
    """One output for ever."""
    return nature.stuck


def _script(nature: Nature, mood: Mood, sight: Sight, chance: Chance) -> Vec3:
    """What the searching adversary wrote."""
    segment = SEGMENTS * sight.t / nature.length
    now = nature.script[-1]
    for i in range(SEGMENTS - 2, -1, -1):
        now = where(segment < i + 1.0, nature.script[i], now)
    n = sight.near
    return Vec3(now.x * n.x - now.y * n.y, now.x * n.y + now.y * n.x, now.z)


FAMILIES: dict[str, Family] = {
    "random": _random,
    "ornstein-uhlenbeck": _ornstein_uhlenbeck,
    "nearest-wall": _nearest,
    "corner": _corner,
    "sign-flipped": _sign_flipped,
    "late-reverse": _late_reverse,
    "delayed": _delayed,
    "garbage": _garbage,
    "stuck": _stuck,
    "search": _script,
}
RAW = ("random", "garbage", "stuck")
"""Families that give a UGV its speed and turn rate directly; the others give it a direction to go."""


@dataclass(frozen=True, slots=True)
class Attacker:
    """Attacks with every vehicle at once."""

    sticks: StickScale
    fleet: tuple[Pioneer, ...]
    period: float
    """Between two decisions [s]."""

    def init(self, zero: Scalar) -> tuple[Mood, ...]:
        """Calm."""
        still = Vec3(zero, zero, zero)
        return (Mood(still, still, still, zero),) * (1 + len(self.fleet))

    def act(
        self,
        moods: tuple[Mood, ...],
        nature: Nature,
        arena: Arena,
        world: WorldState,
        near: tuple[Nearest, ...],
        chance: tuple[Chance, ...],
    ) -> tuple[tuple[Mood, ...], Commands]:
        """(moods, what every vehicle is told)."""
        b, n = arena.bounds, len(world.ugvs)
        middle = (0.5 * (b.x_min + b.x_max), 0.5 * (b.y_min + b.y_max))
        target = (sum(ugv.x for ugv in world.ugvs) / n, sum(ugv.y for ugv in world.ugvs) / n)
        p = world.uav.position
        places = ((p.x, p.y), *((ugv.x, ugv.y) for ugv in world.ugvs))
        changed, wanted = [], []
        for (x, y), nearest, mood, luck in zip(places, near, moods, chance, strict=True):
            sight = Sight(world.t, x, y, nearest, middle, target)
            mood = self._next(nature, mood, sight, luck)
            changed.append(mood)
            wanted.append(_chosen(nature, mood, sight, luck))
        raw = self._is_raw(nature)
        told = tuple(
            drive(model, ugv, want, raw)
            for model, ugv, want in zip(self.fleet, world.ugvs, wanted[1:], strict=True)
        )
        return tuple(changed), Commands(self._fly(world, wanted[0], nature, changed[0]), told)

    def _next(self, nature: Nature, mood: Mood, sight: Sight, chance: Chance) -> Mood:
        near = sight.near
        anew = chance.odds < self.period / nature.pace
        keep = 1.0 - self.period / nature.pace
        fleeing = where(
            near.gap < nature.trigger, 1.0, where(near.gap > nature.trigger + 0.7, 0.0, mood.fleeing)
        )
        return Mood(
            where(anew, chance.uniform, mood.held),
            mood.drift * keep + chance.normal * sqrt(1.0 - keep * keep),
            where(anew, Vec3(near.x, near.y, near.z), mood.late),
            fleeing,
        )

    def _fly(self, world: WorldState, want: Vec3, nature: Nature, mood: Mood) -> VelocityCommand:
        forward, left = world.uav.attitude.heading().from_world(want.x, want.y)
        s = self.sticks
        return VelocityCommand(
            s.horizontal * _full(forward),
            s.horizontal * _full(left),
            s.vertical * _full(want.z),
            # One turn for ever, or full turns that jump: the lags of a turning vehicle turn with it.
            s.turn * where(nature.stuck.x > 0.0, where(mood.held.z > 0.0, 1.0, -1.0), nature.stuck.z),
        )

    @staticmethod
    def _is_raw(nature: Nature) -> Scalar:
        names = list(FAMILIES)
        raw = nature.family == names.index(RAW[0])
        for name in RAW[1:]:
            raw = raw | (nature.family == names.index(name))
        return raw


def _full(share: Scalar) -> Scalar:
    """Shares stay within full speed; garbage stays garbage."""
    return where(abs(share) < 1e6, clip(share, -1.0, 1.0), share)


def _chosen(nature: Nature, mood: Mood, sight: Sight, chance: Chance) -> Vec3:
    """What the flight's own family wants."""
    wanted = Vec3(*(0.0 * sight.x,) * 3)
    for i, family in enumerate(FAMILIES.values()):
        wanted = where(nature.family == i, family(nature, mood, sight, chance), wanted)
    return wanted


def drive(model: Pioneer, ugv: UgvState, want: Vec3, raw: Scalar = False) -> VelocityCommand:
    """A UGV's command for a direction, nose or tail first; if raw, for (speed, turn rate). In shares of full."""
    nose = Heading.of(ugv.heading)
    along, across = nose.from_world(want.x, want.y)
    way = where(along >= 0.0, 1.0, -1.0)
    error = atan2(way * across, way * along + 1e-9)
    size = sqrt(want.x * want.x + want.y * want.y)
    zero = 0.0 * ugv.heading
    forward = where(raw, want.x, way * size * cos(error))
    turn = where(raw, want.y * model.max_turn_rate, 4.0 * error)
    return VelocityCommand(forward * model.max_speed, zero, zero, turn)
