"""A pilot that flies to find out how its vehicle flies: what `fledge identify` has to have seen.

    drive, 0.4 to 1.8 s    the sticks jump, to their stops in a third of all jumps, each place held for 50 ms to 1 s
    rest, 1.3 s            hands off, until a vehicle stands

and so on, some 25 stops a minute, from all speeds, tilts and half-obeyed commands. Each drive has a strength of its
own. Whenever it is farther than `reach` from the middle of the UGVs, or from the height that suits them, the stick
that would lead on changes its sign; so it stays over them, in the middle of the room. It does not turn.

It takes no chance: what it does next follows from how many jumps there were, by fractions of multiples of irrational
numbers, which leave no gap for long (H. Weyl, "Über die Gleichverteilung von Zahlen mod. Eins", 1916), and from where
the UGVs were when it began, so that no flight is like another.
"""

from dataclasses import dataclass
from math import log, sqrt
from typing import NamedTuple

from fledge.observation import Action, Observation
from fledge.pilots.base import AbstractPilot, Noise
from fledge.scalars import Scalar, clip, exp, minimum, round_, where

STRIDES = (sqrt(2.0) - 1.0, sqrt(3.0) - 1.0, sqrt(5.0) - 2.0, sqrt(7.0) - 2.0)
"""Irrational, and independent over the rationals: forward, left, up, times."""
BEYOND = 1.5
"""Places are drawn up to this, and held at the stop from 1 on: a third of them each way."""
LONGEST = 20.0
"""Rows for which a place of the sticks is held at most."""
GRAIN = 10.0
"""[px] of the UGVs' place over which the beginning goes once through the pattern; chosen, well above a rounding."""


class Memory(NamedTuple):
    """Where it is in its pattern."""

    row: Scalar = 0.0
    """Of this drive, or of the rest after it."""
    left: Scalar = 0.0
    """Rows for which the sticks stay where they are."""
    drive: Scalar = 20.0
    """Rows of this drive."""
    chance: tuple[Scalar, Scalar, Scalar, Scalar] = (0.0, 0.0, 0.0, 0.0)
    """From 0 to 1: what the next jump depends on."""
    strength: Scalar = 1.0
    """Of this drive, as a share of full stick."""
    sticks: tuple[Scalar, Scalar, Scalar] = (0.0, 0.0, 0.0)
    begun: Scalar = 0.0
    """1 from the second row on."""


@dataclass(frozen=True, slots=True)
class Exciter(AbstractPilot):
    """Jumps between extremes, and lets go."""

    reach: float = 0.6  # [m] from the middle of the UGVs at which it turns back; chosen for a room of 5 m
    reach_up: float = 0.3  # [m] likewise, of height; chosen: below is the formation, above is the ceiling
    shortest: float = 8.0  # rows of a drive
    longest: float = 36.0  # rows; in 1.8 s a UAV gets as fast as it will
    rest: float = 26.0  # rows; a stop takes a second
    gentlest: float = 0.3  # share of full stick of the weakest drive; three in ten have all of it
    focal_px: float = 374.7  # Lens.focal_px
    name = "exciter"
    restless = True

    def init(self) -> Memory:
        """At the beginning of the pattern."""
        return Memory()

    def act(self, memory: Memory, observation: Observation, noise: Noise) -> tuple[Memory, Action]:
        """The next of its jumps, or none."""
        memory = self._turned_back(self._next(_begun(memory, observation)), observation)
        driving = memory.row < memory.drive
        forward, left, up = (where(driving, clip(stick, -1.0, 1.0), 0.0 * stick) for stick in memory.sticks)
        ended = memory.row + 1.0 >= memory.drive + self.rest
        after = memory._replace(row=where(ended, 0.0, memory.row + 1.0), left=memory.left - 1.0)
        return after, Action(forward, left, up, 0.0 * observation.forward)

    def _next(self, memory: Memory) -> Memory:
        """With a jump if one is due, and another strength and length if a drive begins."""
        begins, jumps = memory.row <= 0.0, (memory.left <= 0.0) | (memory.row <= 0.0)
        a, b, c, d = (
            where(jumps, _fraction(u + stride), u) for u, stride in zip(memory.chance, STRIDES, strict=True)
        )
        strength = where(begins, minimum(self.gentlest + _fraction(a + c), 1.0), memory.strength)
        drive = self.shortest + (self.longest - self.shortest) * _fraction(b + d)
        sticks = (
            where(jumps, clip(BEYOND * (2.0 * u - 1.0), -1.0, 1.0) * strength, stick)
            for u, stick in zip((a, b, c), memory.sticks, strict=True)
        )
        held = round_(exp(d * log(LONGEST)))
        return Memory(
            memory.row,
            where(jumps, held, memory.left),
            where(begins, round_(drive), memory.drive),
            (a, b, c, d),
            strength,
            tuple(sticks),  # pyright: ignore[reportArgumentType]
            memory.begun,
        )

    def _turned_back(self, memory: Memory, o: Observation) -> Memory:
        """With no stick that leads on where it is far enough already."""
        metres = o.altitude / self.focal_px
        ahead, aside = (o.centre_v - o.ugv_v) * metres, (o.centre_u - o.ugv_u) * metres
        above = (o.radius - o.ideal_radius) * o.altitude / o.ideal_radius
        forward, left, up = memory.sticks
        sticks = (
            _towards(forward, ahead, self.reach),
            _towards(left, aside, self.reach),
            _towards(up, above, self.reach_up),
        )
        return memory._replace(sticks=sticks)


def _begun(memory: Memory, o: Observation) -> Memory:
    """With a beginning of its own, in the first row."""
    u = clip(abs(o.ugv_u - o.centre_u), 0.0, 1e3) / GRAIN
    v = clip(abs(o.ugv_v - o.centre_v), 0.0, 1e3) / GRAIN
    own = (u, v, u + v, 2.0 * u + v)
    chance = (
        where(memory.begun > 0.0, c, start - round_(start - 0.5))
        for c, start in zip(memory.chance, own, strict=True)
    )
    return memory._replace(
        chance=tuple(clip(c, 0.0, 1.0) for c in chance),  # pyright: ignore[reportArgumentType]
        begun=1.0 + 0.0 * o.forward,
    )


def _towards(stick: Scalar, way: Scalar, reach: float) -> Scalar:
    """The stick, turned round if it leads away from where it should be and that is `way` [m] off."""
    astray = ((way > reach) & (stick < 0.0)) | ((way < -reach) & (stick > 0.0))
    return where(astray, -stick, stick)


def _fraction(x: Scalar) -> Scalar:
    """Of a number from 0 to 2, what is beyond the whole."""
    return where(x >= 1.0, x - 1.0, x)
