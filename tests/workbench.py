"""The twin's vehicles on a bench: bodies that are told what to do, and a client that flies the twin by AT commands."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from fledge.geometry import Box, Vec3
from fledge.lab.twin.loops import RESTED, Inside, Loops, Wish
from fledge.lab.twin.plant import Place, Plant
from fledge.lab.twin.scene import TIMESTEP
from fledge.lab.twin.senses import Errors, Sensed, Senses
from fledge.lab.twin.twin import TICK, Options, Twin
from fledge.lab.wire import ardrone, navdata, vicon
from fledge.lab.wire.ardrone import Command, Config, Pcmd, Ref
from fledge.lab.wire.datagrams import AT, NAVDATA, VICON, Datagram, Heard
from fledge.lab.wire.navdata import Navdata
from fledge.lab.wire.vicon import Frame
from fledge.world import Arena

HALL = Arena(Box(-50.0, 50.0, -50.0, 50.0), 30.0)
CALM = Vec3(0.0, 0.0, 0.0)
EXACT = Errors(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
PARKED = (
    Place(Vec3(5.0, 0.0, 0.0), 0.0),
    Place(Vec3(-5.0, 5.0, 0.0), 0.0),
    Place(Vec3(-5.0, -5.0, 0.0), 0.0),
)
HOVER = Pcmd.hover()


def room(
    uav: tuple[float, float, float] = (0.0, 0.0, 5.0),
    ugvs: Sequence[Place] = PARKED,
    arena: Arena = HALL,
    heading: float = 0.0,
) -> Plant:
    """The UAV there, its rotors carrying it."""
    plant = Plant(arena, Place(Vec3(*uav), heading), ugvs)
    plant.spin(0.25 * plant.airframe.weight)
    return plant


@dataclass
class Bench:
    """A UAV in the air under its own loops, with sensors that do not err."""

    loops: Loops = Loops()
    plant: Plant = field(default_factory=room)
    inside: Inside = RESTED
    wind: Vec3 = CALM
    most_tilt: float = 0.21

    def fly(self, wish: Wish, seconds: float) -> list[Sensed]:
        """What it sensed at every step, 2 ms apart."""
        seen = []
        for _ in range(round(seconds / TIMESTEP)):
            seen.append(Senses().sense(EXACT, self.plant.uav()))
            self.inside, thrusts = self.loops.step(self.inside, wish, seen[-1], self.most_tilt, TIMESTEP)
            self.plant.step(thrusts, self.wind)
        return seen


Script = Callable[[float], Sequence[Command]]
"""The time since the client began [s] -> what it sends."""


@dataclass
class Client:
    """Somebody who flies a twin over its wires, a datagram of commands every 30 ms."""

    twin: Twin
    every: int = 3
    """Ticks from one datagram to the next."""
    sequence: int = 1
    ticks: int = 0
    navdata: list[Navdata] = field(default_factory=list)
    frames: list[Frame] = field(default_factory=list)
    heights: list[float] = field(default_factory=list)

    def run(self, seconds: float, script: Script) -> "Client":
        """Go on for so long."""
        for _ in range(round(seconds / TICK)):
            self.tick(script)
        return self

    def tick(self, script: Script) -> tuple[Datagram, ...]:
        """One tick; a client asks for navdata with its first datagram."""
        sent = [Datagram(NAVDATA, b"\1")] if self.ticks == 0 else []
        commands = script(self.ticks * TICK) if self.ticks % self.every == 0 else ()
        if commands:
            sent.append(Datagram(AT, ardrone.encode(self.sequence, *commands)))
            self.sequence += len(commands)
        said = self.twin.tick(Heard(self.twin.t, tuple(sent)))
        self.ticks += 1
        for datagram in said:
            if datagram.channel == VICON:
                self.frames.append(vicon.decode(datagram.data))
            elif datagram.channel == NAVDATA:
                self.navdata.append(navdata.decode(datagram.data))
        self.heights.append(self.twin.world().uav.position.z)
        return said


def steady(command: Pcmd = HOVER, fly: bool = True) -> Script:
    """The same all the time, after a second of introductions."""

    def script(t: float) -> Sequence[Command]:
        if t < 1.0:
            return Ref(fly), command, Config("general:navdata_demo", "TRUE")
        return Ref(fly), command

    return script


def aloft(arena: Arena | None = None, seed: int = 0, **options) -> Client:
    """A client of a twin that begins in the air."""
    return Client(Twin(arena or Arena.lab(), seed, Options(aloft=True, duration=60.0, **options)))
