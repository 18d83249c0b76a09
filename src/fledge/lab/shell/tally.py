"""What comes of a lab flight, counted tick by tick: in view, errors, interventions, take-overs, contacts.

* *Errors* and *in view* are those of the study (`evaluation`), while the pilot flies.
* *Interventions* are counted from the climb to the order to land, by layer: the net's, the watchdog's, people's. One
  begins when a vehicle is held back for a reason for which it was not, half a second before.
* *Needed* is how often a person would have been needed: a vehicle stopped for a fault, or held for `patience` on end,
  or brought down by an alarm.
* *Contacts*, each counted as it begins, and *least gaps* are the referee's (`clearance`), hull to hull, of whatever
  world it is shown: the truth in a twin, and else where motion capture sees the vehicles. A UAV may touch the floor
  while it takes off or lands.

Views, errors and gaps are taken every fifth tick, at the rate of the study's rows.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import hypot, inf, sqrt
from typing import Any, NamedTuple

from fledge.camera import Lens, look
from fledge.clearance import clearances, from_things
from fledge.dynamics import REAL_AR_DRONE, UGV_FLEET, Pioneer, Quadrotor
from fledge.lab.control.phases import ALOFT, Phase
from fledge.lab.control.tick import Said
from fledge.observation import IDEAL_RADIUS_PX
from fledge.supervision.modes import Mode
from fledge.supervision.posts import Decision
from fledge.world import Arena, Reason, WorldState

LAYERS = {
    **{reason: "net" for reason in Reason if Reason.WALL <= reason <= Reason.NOT_FINITE},
    **{reason: "watchdog" for reason in Reason if Reason.STALE <= reason <= Reason.CLOCK},
    **dict.fromkeys((Reason.TAKE_OVER, Reason.STOPPED, Reason.TERMINATED), "people"),
}
"""Who held a vehicle back. To wait on the floor, to land as ordered and to fade back are no interventions."""

Held = Mapping[tuple[int, int], tuple[int, float]]
"""By vehicle and reason: how often, and when last [s]."""


class Count(NamedTuple):
    """What is remembered."""

    ticks: int = 0
    flown: float = 0.0
    """For how long the pilot flew [s]."""
    t: float = inf
    """Of the last tick [s]."""
    looks: int = 0
    in_view: int = 0
    distance: float = 0.0
    """Sum of squared distances [px^2]."""
    radius: float = 0.0
    """Sum of squared radius errors [px^2]."""
    held: Held = {}
    modes: tuple[Mode, ...] = ()
    since: tuple[float, ...] = ()
    """When each vehicle came into its mode [s]."""
    takeovers: int = 0
    needed: int = 0
    gaps: tuple[float, ...] = ()
    """Least so far [m], the UAV's first."""
    touching: tuple[bool, ...] = ()
    contacts: int = 0


@dataclass(frozen=True, slots=True)
class Tally:
    """How it is counted."""

    arena: Arena
    lens: Lens = Lens()
    ideal_radius: float = IDEAL_RADIUS_PX
    uav: Quadrotor = REAL_AR_DRONE
    fleet: tuple[Pioneer, ...] = UGV_FLEET
    apart: float = 0.5  # [s] between two interventions for one reason; chosen, as the supervisor's `shown`
    patience: float = 10.0  # [s] of HOLD after which a person would be needed; chosen, as for a lost link
    every: int = 5
    """Ticks from one look to the next."""

    def init(self) -> Count:
        """Nothing yet."""
        return Count()

    def step(self, count: Count, t: float, said: Said, world: WorldState | None = None) -> Count:
        """After a tick at time `t` [s]; `world` is what the referee sees, by default what the controller sees."""
        passed = max(t - count.t, 0.0)
        world = world or said.world
        if said.decisions:
            count = self._judge(count, t, said)
        if world is not None and count.ticks % self.every == 0:
            count = self._referee(self._look(count, said, world), said, world)
        flown = count.flown + passed if said.phase is Phase.FLY else count.flown
        return count._replace(ticks=count.ticks + 1, t=t, flown=flown)

    def _judge(self, count: Count, t: float, said: Said) -> Count:
        modes = tuple(Mode(int(decision.mode)) for decision in said.decisions)
        before, since = count.modes or modes, count.since or (t,) * len(modes)
        entered = tuple(mode is not last for mode, last in zip(modes, before, strict=True))
        if said.phase in ALOFT:
            waited = (
                mode is Mode.HOLD and count.t - start < self.patience <= t - start
                for mode, start in zip(modes, since, strict=True)
            )
            held = self._held(count.held, t, said.decisions)
            count = count._replace(held=held, needed=count.needed + sum(waited))
        fell = sum(new and _unbidden(decision) for new, decision in zip(entered, said.decisions, strict=True))
        taken = sum(new and mode is Mode.MANUAL for new, mode in zip(entered, modes, strict=True))
        since = tuple(t if new else start for new, start in zip(entered, since, strict=True))
        return count._replace(
            modes=modes, since=since, takeovers=count.takeovers + taken, needed=count.needed + fell
        )

    def _held(self, held: Held, t: float, decisions: tuple[Decision, ...]) -> Held:
        for vehicle, (_, verdict, _) in enumerate(decisions):
            if verdict.intervened > 0.5 and Reason(int(verdict.reason)) in LAYERS:
                key = (vehicle, int(verdict.reason))
                times, last = held.get(key, (0, -inf))
                held = {**held, key: (times + (t - last > self.apart), t)}
        return held

    def _look(self, count: Count, said: Said, world: WorldState) -> Count:
        if said.phase is not Phase.FLY:
            return count
        picture, (u, v) = look(self.lens, world), self.lens.centre
        return count._replace(
            looks=count.looks + 1,
            in_view=count.in_view + bool(picture.all_in_view),
            distance=count.distance + hypot(picture.u - u, picture.v - v) ** 2,
            radius=count.radius + (picture.radius - self.ideal_radius) ** 2,
        )

    def _referee(self, count: Count, said: Said, world: WorldState) -> Count:
        uav, *ugvs = (near.gap for near in clearances(self.arena, world, self.uav, self.fleet))
        if said.phase not in ALOFT:
            uav = from_things(self.arena, world, self.uav, self.fleet)[0].gap
        gaps = (uav, *ugvs)
        touching = tuple(gap <= 0.0 for gap in gaps)
        before = count.touching or (False,) * len(gaps)
        new = any(now and not was for now, was in zip(touching, before, strict=True))
        least = tuple(map(min, gaps, count.gaps or gaps))
        return count._replace(gaps=least, touching=touching, contacts=count.contacts + new)


def _unbidden(decision: Decision) -> bool:
    """Whether a vehicle that has just come into its mode waits for a person, or lands, and nobody ordered it."""
    reason = int(decision.verdict.reason)
    return (decision.mode == Mode.STOPPED and reason != Reason.STOPPED) or (
        decision.mode == Mode.LAND and reason != Reason.LANDING
    )


def summary(count: Count) -> dict[str, Any]:
    """In plain JSON values; None where there was nothing to count."""
    by_layer: dict[str, dict[str, int]] = {layer: {} for layer in dict.fromkeys(LAYERS.values())}
    for (_, number), (times, _) in count.held.items():
        reason = Reason(number)
        found = by_layer[LAYERS[reason]]
        found[reason.name.lower()] = found.get(reason.name.lower(), 0) + times
    looks = count.looks
    return {
        "flown_s": round(count.flown, 2),
        "in_view": count.in_view / looks if looks else None,
        "distance_rmse_px": sqrt(count.distance / looks) if looks else None,
        "radius_rmse_px": sqrt(count.radius / looks) if looks else None,
        "interventions": by_layer,
        "takeovers": count.takeovers,
        "human_interventions_needed": count.needed,
        "contacts": count.contacts,
        "least_gap_m": {"uav": count.gaps[0], "ugv": min(count.gaps[1:])} if count.gaps else None,
    }
