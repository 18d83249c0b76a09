"""A visual servo: proportional-derivative control in the image, the classical reference.

It knows what no demonstration taught: the camera's focal length and that a pixel at altitude z is z / f metres.
If it beats the learned pilots, the tables say so: it bounds what imitation could reach.
"""

from dataclasses import dataclass, field

from fledge.observation import Action, Observation, StickScale
from fledge.pilots.base import AbstractPilot, Noise
from fledge.scalars import clip


@dataclass(frozen=True, slots=True)
class Servo(AbstractPilot):
    """u = P error - D own velocity, per axis, in metres."""

    p: float = 2.0  # [1/s]; chosen on development flights for the lowest error without ringing
    d: float = 0.5  # [1]; likewise
    p_up: float = 2.0  # [1/s]; likewise
    focal_px: float = 374.7  # Lens.focal_px
    sticks: StickScale = field(default=StickScale(), metadata={"static": True})
    name = "servo"

    def act(self, memory: tuple[()], observation: Observation, noise: Noise) -> tuple[tuple[()], Action]:
        """Straight from the picture."""
        o = observation
        metres = o.altitude / self.focal_px
        forward = self.p * (o.centre_v - o.ugv_v) * metres - self.d * o.forward
        left = self.p * (o.centre_u - o.ugv_u) * metres - self.d * o.left
        up = self.p_up * (o.radius - o.ideal_radius) * o.altitude / o.ideal_radius
        return memory, Action(
            clip(forward / self.sticks.horizontal, -1.0, 1.0),
            clip(left / self.sticks.horizontal, -1.0, 1.0),
            clip(up / self.sticks.vertical, -1.0, 1.0),
            0.0 * forward,
        )
