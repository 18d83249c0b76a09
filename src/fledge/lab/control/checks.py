"""What has to be so before a UAV may take off, and what is missing, in one line for people.

Each check looks for one thing that people get wrong: cables, names, units, frames, batteries, rooms. They are asked in
the order in which one would look, and the first that fails speaks. In flight the supervisor judges; then only a vehicle
that has fallen silent, or is not seen, is spoken of.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from math import hypot
from typing import NamedTuple

from fledge.errors import FledgeError
from fledge.geometry import Vec3
from fledge.lab.control.eyes import View
from fledge.lab.control.guidance import HEADROOM, LOWEST
from fledge.lab.control.hands import Holding
from fledge.lab.control.vehicle import Report
from fledge.scalars import clip
from fledge.world import Arena, WorldState, check_arena


class Findings(NamedTuple):
    """What a tick has, as far as it matters before take-off."""

    t: float
    """[s]."""
    view: View
    report: Report
    holding: Holding
    world: WorldState | None
    height: float
    """At which the formation would be followed [m]."""


@dataclass(frozen=True, slots=True)
class Checks:
    """Limits; all chosen."""

    arena: Arena
    subjects: tuple[str, ...]
    """Vehicles by the names that motion capture has for them, the UAV first."""
    unattended: bool = False
    battery: float = 0.25  # share; the supervisor lands at 0.2
    silence: float = 0.5  # [s] after which somebody counts as silent
    mute: float = 2.0  # [s] the same for a vehicle in flight
    far: float = 50.0  # [m] from the origin: no room is that large
    beside: float = 0.3  # [m] from each other: no two vehicles' middles come that near
    low: float = 0.5  # [m] where a UAV stands at most
    level: float = 0.8  # cosine of how far it may lean

    def missing(self, found: Findings) -> str:
        """The first thing that is missing before take-off, or nothing."""
        return next((complaint for complaint in self._complaints(found) if complaint), "")

    def within(self, height: float) -> float:
        """The height [m] at which a formation is followed, as far as the room allows."""
        return clip(height, LOWEST, self.arena.ceiling - HEADROOM)

    def in_flight(self, t: float, view: View, report: Report) -> str:
        """Who has fallen silent, or is not seen, in flight."""
        if t - report.heard > self.mute:
            return f"the vehicle has said nothing for over {self.mute:g} s"
        unseen = set(self.subjects).difference(view.lately(t))
        if unseen:
            return f"motion capture does not see {', '.join(sorted(unseen))}"
        return ""

    def _complaints(self, found: Findings) -> Iterator[str]:
        yield self._arena()
        yield self._poses(found)
        if found.world is not None:
            yield from self._places(found.world)
            yield self._height(found.height)
        yield self._vehicle(found.t, found.report)
        yield self._operator(found)

    def _arena(self) -> str:
        try:
            check_arena(self.arena)
        except FledgeError as error:
            return f"arena: {error}"
        return ""

    def _poses(self, found: Findings) -> str:
        view, ago = found.view, found.t - found.view.heard
        if ago > self.silence:
            since = "yet" if ago > 1e9 else f"for {ago:.1f} s"
            what = f": what comes is no frame, {view.trouble}" if view.trouble else ""
            return f"no poses from motion capture {since}{what}"
        names = view.lately(found.t)
        lost = [name for name in self.subjects if name not in names]
        if lost:
            return (
                f"motion capture does not see {', '.join(lost)}: "
                f"it names {', '.join(sorted(names)) or 'nobody'}, valid are {', '.join(self.subjects)}"
            )
        return "" if found.world is not None else "motion capture sees everybody, but not yet for long enough"

    def _places(self, world: WorldState) -> Iterator[str]:
        uav = world.uav.position
        places = (uav, *(Vec3(ugv.x, ugv.y, 0.0) for ugv in world.ugvs))
        named = list(zip(self.subjects, places, strict=True))
        yield from (self._far(*one) for one in named)
        yield from (self._beside(a, b) for a, b in combinations(named, 2))
        yield from (self._outside(*one) for one in named)
        _, _, up = world.uav.attitude.tilt()
        if not up >= self.level:
            yield f"{self.subjects[0]} leans, {up:.2f} of its axis is up: valid is level; do the axes agree?"

    def _far(self, name: str, p: Vec3) -> str:
        if abs(p.x) <= self.far and abs(p.y) <= self.far and abs(p.z) <= self.far:
            return ""
        near = f"valid is within {self.far:g} m of the origin"
        return f"{name} is at {_at(p)}: {near}; are these millimetres?"

    def _beside(self, one: tuple[str, Vec3], other: tuple[str, Vec3]) -> str:
        (a, p), (b, q) = one, other
        apart = hypot(p.x - q.x, p.y - q.y)
        if apart >= self.beside:
            return ""
        return (
            f"{a} and {b} are {apart:.3f} m apart: valid is {self.beside:g} m or more; "
            "are these metres read as millimetres, or two names for one body?"
        )

    def _outside(self, name: str, p: Vec3) -> str:
        b = self.arena.bounds
        if not b.distance(p.x, p.y) <= 0.0:
            return (
                f"{name} is outside the safe area, at {_at(p)}: "
                f"valid is x {b.x_min:g} to {b.x_max:g} m, y {b.y_min:g} to {b.y_max:g} m"
            )
        if not -self.low <= p.z <= self.low:
            return f"{name} is at a height of {p.z:.2f} m: valid is on the floor, below {self.low:g} m"
        return ""

    def _height(self, height: float) -> str:
        most = self.arena.ceiling - HEADROOM
        if LOWEST <= height <= most:
            return ""
        return (
            f"the UGVs stand so that they would be followed at {height:.2f} m: "
            f"valid is {LOWEST:g} to {most:g} m; bring them nearer together, or apart"
        )

    def _vehicle(self, t: float, report: Report) -> str:
        if not t - report.heard <= self.silence:
            return "the vehicle does not answer: no navdata; is it on, and is its address right?"
        if report.emergency:
            return "the vehicle reports an emergency, its motors are cut: it is being reset"
        if not report.configured:
            return "the vehicle has not taken its configuration yet"
        if report.control is None:
            return "the vehicle does not say what it is doing yet"
        if report.aloft:
            return f"the vehicle says that it is {report.control.name.lower()}: valid is on the floor"
        if not report.battery >= self.battery:
            return f"the battery is at {100.0 * report.battery:.0f} %: valid is {100.0 * self.battery:.0f} % or more"
        return ""

    def _operator(self, found: Findings) -> str:
        if self.unattended or found.t - found.holding.heard <= self.silence:
            return ""
        what = (
            f": what comes from the sticks is wrong, {found.holding.trouble}" if found.holding.trouble else ""
        )
        return f"no operator: nobody is heard from{what}"


def _at(p: Vec3) -> str:
    return f"({p.x:.2f}, {p.y:.2f}, {p.z:.2f}) m"
