"""Motion capture as the twin has it: where the vehicles are, to the frames that say so.

A frame is taken every 10 ms, its number one higher than the last one's. What happens to it on its way is a `Sight`:
noise on every pose, frames that get lost, subjects that are hidden and then missing from the frame, two subjects
taken for each other, and the time it is under way. A sight may change for a while, during a `Spell`; with a shorter
delay after a longer one, frames overtake each other, as on a real network.

Chance comes in from outside. Poses are those of the vehicles' origins, in the world's frame [m, rad].
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from fledge.errors import FledgeError, OutOfRange, UnknownName
from fledge.geometry import Quat, Vec3
from fledge.lab.twin.bodies import NAMES, UAV_NAME
from fledge.lab.wire.vicon import Frame, Object, rotation_of

SUBJECTS = (UAV_NAME, *NAMES)

NORMALS = 6 * len(SUBJECTS)
"""Standard normal numbers that a frame takes, beside a uniform one."""

FARTHEST = 20.0
"""[m] from the origin, along any axis, beyond which no camera sees anything; chosen."""

NUMBERS = {"noise": 1.0, "angle_noise": 1.0, "dropout": 1.0, "latency": 10.0}
"""The most that each number of a sight may be; the least is 0."""

SPELLS = f"with WHAT one of {', '.join(NUMBERS)}, hidden=NAME[,NAME], swapped=NAME,NAME"


@dataclass(frozen=True, slots=True)
class Sight:
    """How well the cameras see; the defaults are a good day."""

    noise: float = 0.0005  # [m] standard deviation per axis
    angle_noise: float = 0.0005  # [rad] likewise
    dropout: float = 0.0  # share of the frames that get lost, each by itself
    latency: float = 0.005  # [s]
    hidden: tuple[str, ...] = ()
    """Subjects that no camera sees."""
    swapped: tuple[str, str] | None = None
    """Two subjects that are taken for each other."""

    def __post_init__(self) -> None:
        for name, most in NUMBERS.items():
            if not 0.0 <= getattr(self, name) <= most:
                raise OutOfRange(f"{name} of the cameras", getattr(self, name), f"0 to {most:g}")
        for name in (*self.hidden, *(self.swapped or ())):
            if name not in SUBJECTS:
                raise UnknownName("subject", name, SUBJECTS)


@dataclass(frozen=True, slots=True)
class Spell:
    """A while during which the cameras see otherwise."""

    begin: float
    """[s] of the twin's time."""
    end: float
    """[s]."""
    sight: Sight

    def __post_init__(self) -> None:
        if not 0.0 <= self.begin < self.end:
            raise FledgeError(
                f"a spell from {self.begin} to {self.end} s: valid is one that ends after it began"
            )

    @classmethod
    def read(cls, text: str) -> "Spell":
        """From "20:22:dropout=0.5": from when to when [s], and what is not as usual then.

        Raises:
            FledgeError: the text says no such thing.
        """
        begin, _, rest = text.partition(":")
        end, _, what = rest.partition(":")
        name, _, value = what.partition("=")
        names = tuple(value.split(","))
        known = name in NUMBERS or name == "hidden" or (name == "swapped" and len(names) == 2)
        change: dict[str, Any] | None
        try:
            change = {name: float(value) if name in NUMBERS else names} if known else None
            times = float(begin), float(end)
        except ValueError:
            change, times = None, (0.0, 1.0)
        if change is None:
            raise FledgeError(f"spell {text!r}: valid is BEGIN:END:WHAT=VALUE, in seconds, {SPELLS}")
        return cls(*times, Sight(**change))


class Shot(NamedTuple):
    """A frame."""

    taken: float
    """When [s]."""
    frame: Frame


class Memory(NamedTuple):
    """What the cameras remember."""

    number: int = 0
    """Of the last frame."""
    under_way: tuple[tuple[float, Shot], ...] = ()
    """What was taken, and when it arrives [s]."""


@dataclass(frozen=True, slots=True)
class Cameras:
    """How well they see, and when not."""

    usual: Sight = Sight()
    spells: tuple[Spell, ...] = ()
    """Of two at once, the later in this order counts."""

    def at(self, t: float) -> Sight:
        """How well they see at `t` [s]."""
        now = [spell.sight for spell in self.spells if spell.begin <= t < spell.end]
        return now[-1] if now else self.usual

    def shoot(
        self,
        memory: Memory,
        t: float,
        poses: Sequence[tuple[Vec3, Quat]],
        normal: Sequence[float],
        uniform: float,
    ) -> Memory:
        """Take a frame at `t` [s].

        Args:
            memory: What they remember.
            t: Now.
            poses: Position and world_from_body of each of `SUBJECTS`.
            normal: `NORMALS` standard normal numbers.
            uniform: One from 0 to 1.
        """
        sight, number = self.at(t), memory.number + 1
        if uniform < sight.dropout:
            return memory._replace(number=number)
        seen = (
            _seen(_called(name, sight), pose, sight, normal[6 * i : 6 * i + 6])
            for i, (name, pose) in enumerate(zip(SUBJECTS, poses, strict=True))
            if name not in sight.hidden and _within_sight(pose[0])
        )
        frame = Frame(number, tuple(seen))
        return Memory(number, (*memory.under_way, (t + sight.latency, Shot(t, frame))))

    def deliver(self, memory: Memory, t: float) -> tuple[Memory, tuple[Shot, ...]]:
        """The frames that have arrived by `t` [s], in the order of their arrival."""
        arrived = sorted((due, shot.taken, shot) for due, shot in memory.under_way if due <= t + 1e-9)
        left = tuple(one for one in memory.under_way if one[0] > t + 1e-9)
        return memory._replace(under_way=left), tuple(shot for _, _, shot in arrived)


def _called(name: str, sight: Sight) -> str:
    """What the cameras take a subject for."""
    if sight.swapped is None or name not in sight.swapped:
        return name
    a, b = sight.swapped
    return b if name == a else a


def _within_sight(position: Vec3) -> bool:
    return max(abs(position.x), abs(position.y), abs(position.z)) < FARTHEST


def _seen(name: str, pose: tuple[Vec3, Quat], sight: Sight, normal: Sequence[float]) -> Object:
    """A subject with noise on it; the noise on its attitude is a small turn about each of its axes."""
    (position, attitude), (a, b, c, d, e, f) = pose, normal
    turned = attitude.integrate(Vec3(d, e, f) * sight.angle_noise, 1.0)
    return Object(name, position + Vec3(a, b, c) * sight.noise, rotation_of(turned))
