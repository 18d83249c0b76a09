"""The course of a flight, from the pad back to the floor, as one function of what is so.

    WAIT -> TAKE_OFF -> CLIMB -> JOIN -> FLY -> LAND -> OVER

| phase | what happens | it ends |
|---|---|---|
| WAIT | on the pad; something is missing, or the operator has not armed | with the supervisor's leave to fly |
| TAKE_OFF | trimmed, then the firmware takes off by itself | when it says that it flies |
| CLIMB | to the height at which the formation has its ideal radius, holding the place | there, and calm |
| JOIN | a servo leads it over the formation | when the centroid is near the middle of the image |
| FLY | the pilot flies | in JOIN, if the formation gets out of sight; in LAND, when the time is up |
| LAND | down through the net; near the floor, or blind, the firmware lands, for good | on the floor |
| OVER | motors off, for good: a run is one flight | |

Modes (`modes`) say who flies a vehicle, and go first: a person's hand in any phase of the air leads back to CLIMB, so
that a flight handed back finds its height and its formation anew; an order to land, or a vehicle that is found on the
ground, leads to LAND; whoever disarms on the pad waits again.
"""

from dataclasses import dataclass
from enum import StrEnum
from math import inf
from typing import NamedTuple

from fledge.geometry import Heading, Vec3
from fledge.lab.control.vehicle import Report
from fledge.supervision.modes import Mode
from fledge.world import UavState


class Phase(StrEnum):
    """Where a flight is in its course."""

    WAIT = "wait"
    TAKE_OFF = "take-off"
    CLIMB = "climb"
    JOIN = "join"
    FLY = "fly"
    LAND = "land"
    OVER = "over"


P, M = Phase, Mode
ALOFT = (P.CLIMB, P.JOIN, P.FLY)
IDLE = (M.INIT, M.READY)
NOWHERE = Vec3(0.0, 0.0, 0.0)


class Course(NamedTuple):
    """What is remembered of the flight's course."""

    phase: Phase = P.WAIT
    since: float = 0.0
    """When that began [s]."""
    place: Vec3 = NOWHERE
    """Which place CLIMB holds; before, the pad [m]."""
    heading: Heading = Heading(1.0, 0.0)
    """Which heading is kept."""
    touching: bool = False
    """Whether the firmware was told to land."""


class Sight(NamedTuple):
    """What a tick finds, as far as the course depends on it."""

    t: float
    """[s]."""
    mode: float
    """The UAV's, after this tick."""
    uav: UavState
    """As far as it can be believed."""
    report: Report
    height: float
    """At which the formation has its ideal radius [m]."""
    distance: float
    """Of the formation's centroid from the middle of the image [px]."""


@dataclass(frozen=True, slots=True)
class Phases:
    """When one phase becomes the next; all chosen."""

    trimming: float = 0.1  # [s] of telling it that it stands level: ten datagrams, so that one arrives
    patience: float = 10.0  # [s] for a take-off; firmwares give up after some five
    near: float = 0.1  # [m] from the height
    calm: float = 0.15  # [m/s] there
    joined: float = 40.0  # [px] a third of the ideal radius
    lost: float = 250.0  # [px] some formation is still in the image at 180
    floor: float = 0.3  # [m] at which the firmware lands
    blind: float = 1.0  # [s] without a pose after which it lands from wherever it is
    unheard: float = 1.0  # [s] without a report after which it counts for nothing
    duration: float = inf  # [s] of FLY

    def init(self) -> Course:
        """On the pad."""
        return Course()

    def step(self, course: Course, sight: Sight) -> Course:
        """The course after a tick."""
        phase = self._next(course, sight)
        held = phase is P.CLIMB and self._flown_by_hand(sight)
        if phase is not course.phase:
            course = course._replace(phase=phase, since=sight.t)
            held = held or phase in (P.TAKE_OFF, P.CLIMB)
        if phase is P.WAIT or held:
            course = course._replace(place=sight.uav.position, heading=sight.uav.attitude.heading())
        touching = phase is P.LAND and (course.touching or self._near_floor(sight))
        return course._replace(touching=touching)

    def _next(self, course: Course, s: Sight) -> Phase:
        phase = course.phase
        if phase is P.OVER or s.mode == M.TERMINATED:
            return P.OVER
        if phase is P.WAIT:
            return P.WAIT if s.mode in IDLE else P.TAKE_OFF
        if s.mode in IDLE:
            return P.WAIT if phase is P.TAKE_OFF else P.OVER
        if s.mode == M.LAND or course.touching or self._down(course, s):
            return P.LAND
        if phase is P.TAKE_OFF:
            return P.CLIMB if s.report.steady else phase
        if self._flown_by_hand(s):
            return P.CLIMB
        return self._along(course, s)

    def _along(self, course: Course, s: Sight) -> Phase:
        """CLIMB to FLY, and what ends it."""
        there = abs(s.uav.position.z - s.height) <= self.near and abs(s.uav.velocity.z) <= self.calm
        if course.phase is P.CLIMB and there:
            return P.JOIN
        if course.phase is P.JOIN and s.distance <= self.joined:
            return P.FLY
        if course.phase is P.FLY and s.t - course.since >= self.duration:
            return P.LAND
        if course.phase is P.FLY and s.distance > self.lost:
            return P.JOIN
        return course.phase

    def _flown_by_hand(self, s: Sight) -> bool:
        return s.mode == M.MANUAL

    def _down(self, course: Course, s: Sight) -> bool:
        """Whether it comes down by itself, or never took off."""
        if course.phase is P.TAKE_OFF:
            return s.t - course.since > self.patience
        told = s.t - s.report.heard <= self.unheard
        return course.phase in ALOFT and told and not s.report.steady

    def _near_floor(self, s: Sight) -> bool:
        return s.uav.position.z <= self.floor or s.t - s.uav.stamp > self.blind
