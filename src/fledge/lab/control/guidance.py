"""Where the UAV is led in each phase of a flight, before the net has a look.

    TAKE_OFF   nowhere: the firmware takes off
    CLIMB      up, over the place
    JOIN       a servo, in x and y
    FLY        the pilot, on its own axes
    LAND       nowhere: the supervisor leads down

What the pilot does not use, height or heading, is held here: by slow proportional loops, at the height at which the
formation has its ideal radius in the image, h = focal_px spread / ideal_radius, and at the heading of the take-off. The
spread is measured: from the middle of the UGVs to the farthest of them.

Decisions fall 20 times a second, as in the study; the loops run with the net.
"""

from dataclasses import dataclass
from math import atan2, hypot
from typing import Any, NamedTuple

from fledge.camera import Lens
from fledge.geometry import Heading, Vec3
from fledge.lab.control.phases import Course, Phase
from fledge.observation import IDEAL_RADIUS_PX, Action, Axes, Observation, StickScale, observe
from fledge.pilots import AbstractPilot, Servo
from fledge.scalars import clip
from fledge.world import UavState, VelocityCommand, WorldState

NO_CHANCE = (0.0, 0.0, 0.0, 0.0)
"""What a pilot gets that would use chance: in the lab there is enough of it."""
HANDS_OFF = Action(0.0, 0.0, 0.0, 0.0)
LOWEST = 1.0
"""[m] at which a flight is led at least; chosen, the firmware's own take-off height."""
HEADROOM = 0.5
"""[m] that are left below the ceiling; chosen: the nets ask for 0.1 m and the way of a stop."""


class Guided(NamedTuple):
    """What is remembered."""

    pilot: Any
    """The pilot's memory."""
    observation: Observation | None = None
    """What was last seen."""
    action: Action = HANDS_OFF
    """What was last said."""


@dataclass(frozen=True, slots=True)
class Guidance:
    """Who flies on which axes, what it looks through, and the loops for the rest."""

    pilot: AbstractPilot
    axes: Axes = Axes(up=0.0)
    lens: Lens = Lens()
    sticks: StickScale = StickScale()
    ideal_radius: float = IDEAL_RADIUS_PX
    p_height: float = 1.0  # [1/s]; chosen slow: the firmware's climb loop has its own lag
    p_place: float = 0.8  # [1/s]; likewise
    p_heading: float = 1.0  # [1/s]; likewise
    most: float = 0.3  # [m/s, rad/s] of each of them; chosen

    def init(self) -> Guided:
        """Nothing was decided yet."""
        return Guided(self.pilot.init())

    def decide(self, memory: Guided, phase: Phase, world: WorldState) -> Guided:
        """After a decision on what is seen now."""
        seen = observe(world, self.lens, self.ideal_radius)
        if phase is Phase.FLY:
            pilot, action = self.pilot.act(memory.pilot, seen, NO_CHANCE)
            return Guided(pilot, seen, action.only(self.axes))
        if phase is Phase.JOIN:
            servo = Servo(focal_px=self.lens.focal_px, sticks=self.sticks)
            _, action = servo.act((), seen, NO_CHANCE)
            return Guided(self.pilot.init(), seen, action.only(Axes(up=0.0)))
        return Guided(self.pilot.init(), seen)

    def propose(self, memory: Guided, course: Course, uav: UavState, height: float) -> VelocityCommand:
        """The command that comes of the last decision, for the UAV as it is now; `height` [m] is to be held."""
        if course.phase is Phase.CLIMB:
            forward, left = self._to_place(course.place, uav)
            return VelocityCommand(forward, left, self._to_height(height, uav), self._to_heading(course, uav))
        if course.phase not in (Phase.JOIN, Phase.FLY):
            return VelocityCommand.hover()
        command = self.sticks.command(memory.action)
        flies = self.axes if course.phase is Phase.FLY else Axes(up=0.0)
        up = command.up if flies.up else self._to_height(height, uav)
        turn = command.turn if flies.turn else self._to_heading(course, uav)
        return VelocityCommand(command.forward, command.left, up, turn)

    def distance(self, observation: Observation) -> float:
        """Of the formation's centroid from the middle of the image [px]."""
        o = observation
        return hypot(o.ugv_u - o.centre_u, o.ugv_v - o.centre_v)

    def height(self, world: WorldState) -> float:
        """At which the formation, as it stands, has its ideal radius [m]."""
        n = len(world.ugvs)
        x, y = sum(ugv.x for ugv in world.ugvs) / n, sum(ugv.y for ugv in world.ugvs) / n
        spread = max(hypot(ugv.x - x, ugv.y - y) for ugv in world.ugvs)
        return self.lens.focal_px * spread / self.ideal_radius

    def _to_place(self, place: Vec3, uav: UavState) -> tuple[float, float]:
        p, most = uav.position, self.most
        x, y = (
            clip(self.p_place * (place.x - p.x), -most, most),
            clip(self.p_place * (place.y - p.y), -most, most),
        )
        return uav.attitude.heading().from_world(x, y)

    def _to_height(self, height: float, uav: UavState) -> float:
        return clip(self.p_height * (height - uav.position.z), -self.most, self.most)

    def _to_heading(self, course: Course, uav: UavState) -> float:
        return clip(self.p_heading * _between(uav.attitude.heading(), course.heading), -self.most, self.most)


def _between(now: Heading, wanted: Heading) -> float:
    """From one heading to the other, the short way [rad]."""
    return atan2(now.cos * wanted.sin - now.sin * wanted.cos, now.cos * wanted.cos + now.sin * wanted.sin)
