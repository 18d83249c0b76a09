"""What a page is shown of a tick: places, picture, and of each vehicle who flies it, what it was sent and why."""

from collections.abc import Sequence
from math import atan2, isfinite

from fledge.cockpit.scene import Shown
from fledge.cockpit.tells import FAR, Frame, Picture, Vehicle
from fledge.episode import Flight
from fledge.safety import Halt
from fledge.supervision.modes import Mode
from fledge.supervision.posts import Decision
from fledge.world import Reason


def frame(shown: Shown, about: Flight, halts: Sequence[Halt] = ()) -> Frame:
    """What a page is shown of a tick, but for what only the server knows: rows recorded, latency."""
    world, picture = shown.world, shown.picture
    uav = world.uav.position
    heading = world.uav.attitude.heading()
    places = [(uav.x, uav.y, uav.z, atan2(heading.sin, heading.cos))]
    places += [(ugv.x, ugv.y, 0.0, ugv.heading) for ugv in world.ugvs]
    stops = halts or ((),) * len(places)
    each = zip(places, shown.decisions, shown.commanders, stops, strict=True)
    vehicles = tuple(_vehicle(*one) for one in each)
    u, v, radius = _drawn(picture.u, picture.v, picture.radius)
    marks = tuple(_drawn(*about.lens.project(world.uav, ugv.x, ugv.y)) for ugv in world.ugvs)
    return Frame(
        world.t,
        vehicles,
        Picture(u, v, radius, about.ideal_radius, marks),
        over=shown.over,
        armable=shown.armable,
        battery=shown.battery,
        note=shown.note,
    )


def _vehicle(
    place: tuple[float, ...], decision: Decision, commander: str, halt: tuple[float, ...]
) -> Vehicle:
    x, y, z, heading = _drawn(*place)
    verdict, sent = decision.verdict, decision.verdict.command
    return Vehicle(
        x,
        y,
        z,
        heading,
        Mode(int(decision.mode)).name,
        Reason(int(verdict.reason)).name,
        commander,
        _drawn(sent.forward, sent.left, sent.up, sent.turn),
        float(verdict.clearance) if isfinite(verdict.clearance) else None,
        tuple(halt) if all(map(isfinite, halt)) else (),
    )


def _drawn(*numbers: float) -> tuple[float, ...]:
    """Pixels and places as they can be said: what is wild, or no number, is far out of sight."""
    return tuple(min(max(float(one), -FAR), FAR) if isfinite(one) else FAR for one in numbers)
