"""A flight of `fledge fly`, joined from outside: sticks go to it, glances come back; both are datagrams.

It is another process's flight, so here it can be neither paused nor begun anew, and is not recorded: it logs itself.
What happens to the cockpit delays no tick of it; if the cockpit falls silent, the flight's own supervisor sees that.
"""

import time
from dataclasses import dataclass
from math import atan2, inf, nan
from typing import Any, NamedTuple, cast

from fledge.camera import look
from fledge.cockpit.scene import Shown, commander
from fledge.cockpit.seat import Spoken
from fledge.episode import Flight
from fledge.errors import FledgeError
from fledge.geometry import Box, Quat, Vec3
from fledge.lab import Malformed
from fledge.lab.control.phases import Phase
from fledge.lab.shell.udp import Address, UdpPort, Wire, glances_at, opened
from fledge.lab.wire import glances, sticks
from fledge.lab.wire.datagrams import GLANCES, STICKS, Datagram
from fledge.lab.wire.glances import Glance, Vehicle
from fledge.safety import AbstractNet, Halt, NoNet
from fledge.supervision.modes import Mode
from fledge.supervision.posts import Decision
from fledge.supervision.watchdog import TICK, Alarm
from fledge.world import Arena, Obstacle, Reason, UavState, UgvState, VelocityCommand, Verdict, WorldState

ASKING = 50
"""Ticks from one time that the flight is asked to show itself to the next."""
STALE = 0.5
"""[s] after which people are told that nothing is seen any more."""
PATIENCE, EVERY = 3.0, 0.1
"""[s] for a flight to show itself, and between two times of asking; chosen."""
UNSEEN = Vehicle(
    (0.0,) * 3,
    (1.0, 0.0, 0.0, 0.0),
    (0.0,) * 3,
    int(Mode.INIT),
    int(Reason.NOT_READY),
    True,
    None,
    (0.0,) * 4,
)
ASK = Datagram(GLANCES, b"\x01")
NOWHERE = "nothing is heard of the flight: valid is `fledge fly ... --operator ws` at that address"


class Memory(NamedTuple):
    """The newest that was seen."""

    glance: Glance
    seen: float
    """When that was [s]."""
    ticks: int = 0


@dataclass(frozen=True, slots=True)
class Attached:
    """One flight: the wires to it, and what it said it is."""

    told: UdpPort
    shown: UdpPort
    first: Glance

    @classmethod
    def open(cls, there: Address, patience: float = PATIENCE) -> "Attached":
        """The flight whose sticks are there.

        Raises:
            FledgeError: there is no such host, or no flight that can be seen.
        """
        told, shown = opened((Wire(STICKS, there=there), Wire(GLANCES, there=glances_at(there))))
        end = time.monotonic() + patience
        while time.monotonic() < end:
            shown.send(ASK)
            time.sleep(EVERY)
            found = _newest(shown)
            if found is not None:
                return cls(told, shown, found)
        told.close()
        shown.close()
        raise FledgeError(f"{there[0]}:{there[1]}: {NOWHERE}")

    @property
    def about(self) -> Flight:
        """What the flight is; there is no episode."""
        x_min, x_max, y_min, y_max, ceiling = self.first.room
        obstacles = tuple(Obstacle(Box(*box[:4]), box[4]) for box in self.first.boxes)
        arena = Arena(Box(x_min, x_max, y_min, y_max), ceiling, obstacles)
        f = self.first
        return Flight(cast(Any, None), "lab", f.pilot, f.net, 0, 0, f.axes, arena)

    @property
    def net(self) -> AbstractNet:
        """It is at the other end; nothing is known of it here but its name."""
        return NoNet()

    def init(self) -> Memory:
        """As it was seen first."""
        return Memory(glance=self.first, seen=time.monotonic())

    def tick(self, memory: Memory, spoken: Spoken) -> tuple[Memory, Shown]:
        """What came of it meanwhile; what people say goes there, as often as they say it."""
        if memory.ticks % ASKING == 0:
            self.shown.send(ASK)
        if spoken.silent <= TICK:
            said = sticks.Sticks(memory.ticks, memory.ticks * TICK, spoken.operators)
            self.told.send(Datagram(STICKS, sticks.encode(said)))
        self.told.receive()  # nothing is answered there, but the system's word that nobody listens
        now, newest = time.monotonic(), _newest(self.shown)
        if newest is not None:
            memory = memory._replace(glance=newest, seen=now)
        silent = now - memory.seen > STALE
        return memory._replace(ticks=memory.ticks + 1), _shown(memory.glance, self.about, silent)

    def halts(self, memory: Memory) -> tuple[Halt, ...]:
        """It does not say."""
        return ()

    def close(self) -> None:
        """The wires."""
        self.told.close()
        self.shown.close()


def _newest(port: UdpPort) -> Glance | None:
    """The last that came, of those that are any."""
    found = [glances.decode(arrival.datagram.data) for arrival in port.receive()]
    return next((one for one in reversed(found) if not isinstance(one, Malformed)), None)


def _shown(glance: Glance, about: Flight, silent: bool) -> Shown:
    vehicles = glance.vehicles or (UNSEEN,) * len(glance.subjects)
    uav, *ugvs = (_floats(one.position) for one in vehicles)
    q, v, t = Quat(*_floats(vehicles[0].attitude)), Vec3(*_floats(vehicles[0].velocity)), glance.t
    headings = (Quat(*_floats(one.attitude)).heading() for one in vehicles[1:])
    world = WorldState(
        t,
        UavState(Vec3(*uav), v, q, Vec3(0.0, 0.0, 0.0), t),
        tuple(
            UgvState(x, y, atan2(heading.sin, heading.cos), 0.0, 0.0, t)
            for (x, y, _), heading in zip(ugvs, headings, strict=True)
        ),
    )
    decisions = tuple(map(_decision, vehicles))
    note = NOWHERE if silent else glance.complaint or glance.phase
    return Shown(
        world,
        decisions,
        tuple(
            commander(i, decision, False, glance.phase != Phase.FLY) for i, decision in enumerate(decisions)
        ),
        look(about.lens, world),
        row=None,
        flown=False,
        over=glance.phase == Phase.OVER,
        armable=not glance.complaint,
        note=note,
    )


def _decision(vehicle: Vehicle) -> Decision:
    clearance = inf if vehicle.clearance is None else vehicle.clearance
    command = VelocityCommand(*_floats(vehicle.sent))
    verdict = Verdict(command, float(vehicle.intervened), float(vehicle.reason), clearance)
    return Decision(float(vehicle.mode), verdict, Alarm(0.0, 0.0))


def _floats(numbers: tuple[float | None, ...]) -> list[float]:
    return [nan if one is None else one for one in numbers]
