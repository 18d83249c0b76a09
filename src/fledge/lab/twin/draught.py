"""Air that moves in the twin's room: a mean, and gusts about it.

Gusts are an Ornstein-Uhlenbeck process per horizontal axis, stepped exactly. Both are chosen: doors and air
conditioning of a hall. Through the UAV's drag of 0.58 1/s they push it by 0.1 m/s^2 or so, well within the nets'
contract.
"""

from dataclasses import dataclass
from math import exp, sqrt

from fledge.geometry import Vec3

NORMALS = 2
"""Standard normal numbers that a step takes."""


@dataclass(frozen=True, slots=True)
class Draught:
    """How the air moves."""

    mean: Vec3 = Vec3(0.05, 0.03, 0.0)
    """[m/s]."""
    gust: float = 0.08  # [m/s] standard deviation per axis
    memory: float = 2.0  # [s] correlation time

    def init(self) -> Vec3:
        """No gust yet."""
        return Vec3(0.0, 0.0, 0.0)

    def step(self, gust: Vec3, normal: list[float], dt: float) -> tuple[Vec3, Vec3]:
        """(the gust `dt` [s] later, the wind then); `NORMALS` standard normal numbers."""
        keep = exp(-dt / self.memory)
        kick = self.gust * sqrt(1.0 - keep * keep)
        gust = Vec3(keep * gust.x + kick * normal[0], keep * gust.y + kick * normal[1], 0.0)
        return gust, self.mean + gust
