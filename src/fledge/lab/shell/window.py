"""A window into a flight, for a cockpit in a process of its own: what a tick came to, thirty times a second.

It is shown after the tick, by a datagram that nobody waits for: whoever looks, or stops looking, delays nothing.
"""

from math import isfinite
from typing import Any

from fledge.geometry import Heading, Quat, Vec3
from fledge.lab.control.outfit import Outfit
from fledge.lab.shell.link import Port
from fledge.lab.shell.runtime import Now
from fledge.lab.wire import glances
from fledge.lab.wire.datagrams import GLANCES, Datagram
from fledge.supervision.posts import Decision
from fledge.world import UgvState

EVERY = 3
"""Ticks from one glance to the next."""


class Window:
    """Of one flight."""

    def __init__(self, made: Outfit, port: Port | None) -> None:
        """`port` is where it is asked for; None: nobody can look."""
        room = made.arena.bounds
        self._port = port
        self._facts: dict[str, Any] = {
            "pilot": made.pilot,
            "net": made.net,
            "axes": made.axes,
            "subjects": made.subjects,
            "room": (room.x_min, room.x_max, room.y_min, room.y_max, made.arena.ceiling),
            "boxes": tuple(
                (box.x_min, box.x_max, box.y_min, box.y_max, height)
                for box, height in ((one.footprint, one.height) for one in made.arena.obstacles)
            ),
        }
        self._ticks = 0

    def show(self, now: Now) -> None:
        """What a tick came to."""
        self._ticks += 1
        if self._port is None or self._ticks % EVERY:
            return
        said = now.said
        states = (said.world.uav, *said.world.ugvs) if said.world is not None and said.decisions else ()
        glance = glances.Glance(
            sequence=self._ticks,
            t=now.t,
            phase=said.phase.value,
            complaint=(said.complaint or now.wires)[:500],
            vehicles=tuple(map(_vehicle, states, said.decisions)),
            **self._facts,
        )
        self._port.send(Datagram(GLANCES, glances.encode(glance)))


def _vehicle(state: Any, decision: Decision) -> glances.Vehicle:
    if isinstance(state, UgvState):
        heading = Heading.of(state.heading)
        position, attitude = Vec3(state.x, state.y, 0.0), Quat.from_yaw(state.heading)
        velocity = Vec3(*heading.to_world(state.speed, 0.0), 0.0)
    else:
        position, attitude, velocity = state.position, state.attitude, state.velocity
    verdict, c = decision.verdict, decision.verdict.command
    return glances.Vehicle(
        _finite(position.x, position.y, position.z),
        _finite(attitude.w, attitude.x, attitude.y, attitude.z),
        _finite(velocity.x, velocity.y, velocity.z),
        int(decision.mode),
        int(verdict.reason),
        bool(verdict.intervened > 0.5),
        _finite(verdict.clearance)[0],
        _finite(c.forward, c.left, c.up, c.turn),
    )


def _finite(*numbers: float) -> tuple[float | None, ...]:
    return tuple(float(one) if isfinite(one) else None for one in numbers)
