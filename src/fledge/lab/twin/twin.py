"""The digital twin of the lab, one tick of 10 ms at a time: datagrams in, datagrams out.

    commands -> some milliseconds of network -> firmware -> loops -> rotors  \
    guidance -> drivers -> wheels                                             > MuJoCo -> cameras -> frames
    weather -> wind                                                          /         -> the drone's senses -> navdata

The world moves by 10 ms a tick, whatever the clock of whoever calls, in steps of 2 ms. MuJoCo changes in place, so a
`Twin` is an object with memory, the only one of the lab. All chance comes from its seed: the same seed and the same
datagrams in the same ticks give the same datagrams, byte for byte, on the same machine.

A frame is taken 4 ms into a tick; the cameras' shutter knows nothing of the drone's clock. What is ready when the tick
ends is handed over then, navdata first.
"""

from dataclasses import dataclass
from math import pi

import numpy as np

from fledge.camera import Lens
from fledge.formation import FormationControl
from fledge.geometry import Quat, Vec3
from fledge.lab import opening
from fledge.lab.twin import bridge, cameras, contacts, convoy, draught, drivers, senses
from fledge.lab.twin.bridge import Bridge
from fledge.lab.twin.cameras import Cameras, Shot
from fledge.lab.twin.contacts import FLOOR, Contact, Touch
from fledge.lab.twin.convoy import Convoy
from fledge.lab.twin.draught import Draught
from fledge.lab.twin.drivers import DRIVERS
from fledge.lab.twin.drone import Drone
from fledge.lab.twin.firmware import Phase
from fledge.lab.twin.plant import Place, Plant
from fledge.lab.twin.scene import TIMESTEP
from fledge.lab.wire import vicon
from fledge.lab.wire.datagrams import AT, NAVDATA, VICON, Datagram, Heard
from fledge.observation import IDEAL_RADIUS_PX, ROW_RATE
from fledge.world import Arena, WorldState

TICK = 0.01
"""[s]."""
STEPS = round(TICK / TIMESTEP)
SHUTTER, HALF = 2, 3
"""After how many steps of a tick a frame is taken, and navdata may go out that are not due at its end."""
TICKS_PER_ROW = round(1.0 / (ROW_RATE * TICK))
NORMALS = cameras.NORMALS + senses.NORMALS + draught.NORMALS


@dataclass(frozen=True, slots=True)
class Options:
    """What a day in the lab is like."""

    drone: Drone = Drone()
    cameras: Cameras = Cameras()
    draught: Draught = Draught()
    link_delay: float = 0.02
    """[s] from a command's arrival to the firmware; chosen, a hop over Wi-Fi and the drone's own scheduling."""
    aloft: bool = False
    """Begin above the formation at its ideal height, for studies of what comes then."""
    duration: float = 900.0
    """[s] that the UGVs' track lasts."""
    battery: float = 1.0
    """Charge at the start, as a share."""
    bridge: Bridge | None = None
    """The drivers between vehicles and ROS topics, if there are any. They have the drone to themselves, and the UGVs
    obey their topics alone."""


class Twin:
    """The lab's other end."""

    def __init__(self, arena: Arena, seed: int = 0, options: Options = Options()) -> None:
        """The lab in the morning.

        Raises:
            FledgeError: the arena has no room for the formation, or none for the UAV's pad.
        """
        self.t = 0.0
        """Time since the twin began [s]."""
        self.contacts: list[Contact] = []
        """Every touch so far, as it began."""
        self.epoch = 0.0
        """ROS time when `Heard.t` is 0 [s], for the stamps of messages; whoever has a clock sets it."""
        self._arena, self._options = arena, options
        self._rng = np.random.default_rng([seed, 1])
        self._convoy = _convoy(arena, seed, options)
        uav, ugvs = _places(self._convoy, arena, self._rng, options.aloft)
        airframe = options.drone.loops.airframe
        self._plant = Plant(arena, uav, ugvs, airframe)
        if options.aloft:
            self._plant.spin(0.25 * airframe.weight)
        birth = self._rng.standard_normal(senses.BIRTH_NORMALS).tolist()
        self._drone = options.drone.init(uav.heading, birth, options.aloft, options.battery)
        self._gust = options.draught.init()
        self._cameras = cameras.Memory()
        self._guided = convoy.Memory()
        self._driven = tuple(drivers.Memory() for _ in DRIVERS)
        self._bridged = bridge.Memory()
        self._under_way: list[tuple[float, bytes]] = []
        self._ticks = 0
        self._touching: set[Touch] = set()

    def tick(self, heard: Heard) -> tuple[Datagram, ...]:
        """10 ms with what came in; the twin has a time of its own, and `heard.t` only stamps messages."""
        normal = self._rng.standard_normal(NORMALS).tolist()
        self._hear(self._ordered(heard.datagrams), normal)
        self._drive()
        self._gust, wind = self._options.draught.step(self._gust, _last(normal), TICK)
        said: list[Datagram] = []
        for step in range(1, STEPS + 1):
            self._step(wind)
            now = self.t + step * TIMESTEP
            if step == SHUTTER:
                self._shoot(now, normal)
            if step in (HALF, STEPS):
                self._say(now, said)
        self._drone = self._options.drone.rest(self._drone, TICK)
        self._ticks += 1
        self.t = self._ticks * TICK
        self._look()
        self._cameras, shots = self._options.cameras.deliver(self._cameras, self.t)
        frames = (Datagram(VICON, vicon.encode(shot.frame)) for shot in shots)
        return (*self._told(heard.t, said, shots), *frames)

    def miss(self, ticks: int) -> None:
        """So many ticks are left out: the world stands still, but the cameras' counter goes on, as in a real lab."""
        self._cameras = self._cameras._replace(number=self._cameras.number + ticks)

    def world(self) -> WorldState:
        """The truth."""
        return self._plant.world(self.t)

    def poses(self) -> list[tuple[Vec3, Quat]]:
        """The truth: position [m] and world_from_body of every vehicle, the UAV first."""
        return self._plant.attitudes()

    @property
    def phase(self) -> Phase:
        """What the UAV's firmware is doing."""
        return self._drone.knows.phase

    @property
    def battery(self) -> float:
        """What is left of the UAV's, as a share."""
        return self._drone.knows.battery

    def _ordered(self, datagrams: tuple[Datagram, ...]) -> tuple[Datagram, ...]:
        """What reaches the drone's ports: everything, or what its driver makes of topics."""
        if self._options.bridge is None:
            return datagrams
        self._bridged, orders, robots = self._options.bridge.hear(self._bridged, self.t, datagrams)
        driven = list(self._driven)
        for i, speed, turn in robots:
            driven[i] = DRIVERS[i].hear(driven[i], self.t, speed, turn)
        self._driven = tuple(driven)
        return orders

    def _told(self, t: float, said: list[Datagram], shots: tuple[Shot, ...]) -> list[Datagram]:
        """What leaves beside the frames: navdata, or what the drivers make of everything."""
        if self._options.bridge is None:
            return said
        told = [datagram.data for datagram in said]
        epoch = self.epoch + t - self._ticks * TICK
        self._bridged, messages = self._options.bridge.say(
            self._bridged, self.t, epoch, shots, told, self._driven
        )
        return list(messages)

    def _hear(self, datagrams: tuple[Datagram, ...], normal: list[float]) -> None:
        """Commands that have come through to the drone by now."""
        asked = False
        for datagram in datagrams:
            if datagram.channel == AT:
                self._under_way.append((self.t + self._options.link_delay, datagram.data))
            asked = asked or datagram.channel == NAVDATA
        commands = [data for due, data in self._under_way if due <= self.t + 1e-9]
        self._under_way = [one for one in self._under_way if one[0] > self.t + 1e-9]
        self._drone = self._options.drone.hear(
            self._drone, self.t, commands, asked, self._plant.uav(), _for_senses(normal), TICK
        )

    def _drive(self) -> None:
        """The UGVs: guidance every 50 ms, unless topics guide them; their wheels every tick."""
        if self._options.bridge is None and self._ticks % TICKS_PER_ROW == 0:
            self._guided, told = self._convoy.step(self._guided, self.world())
            self._driven = tuple(
                driver.hear(memory, self.t, command.forward, command.turn)
                for driver, memory, command in zip(DRIVERS, self._driven, told, strict=True)
            )
        turned = [
            driver.step(memory, self.t, TICK) for driver, memory in zip(DRIVERS, self._driven, strict=True)
        ]
        self._driven = tuple(memory for memory, _ in turned)
        self._plant.drive([wheels for _, wheels in turned])

    def _step(self, wind: Vec3) -> None:
        self._drone, thrusts = self._options.drone.fly(self._drone, self._plant.uav(), TIMESTEP)
        self._plant.step(thrusts, wind)

    def _shoot(self, now: float, normal: list[float]) -> None:
        poses, uniform = self._plant.attitudes(), self._rng.random()
        self._cameras = self._options.cameras.shoot(
            self._cameras, now, poses, normal[: cameras.NORMALS], uniform
        )

    def _say(self, now: float, said: list[Datagram]) -> None:
        self._drone, data = self._options.drone.say(self._drone, now, self._plant.uav())
        if data is not None:
            said.append(Datagram(NAVDATA, data))

    def _look(self) -> None:
        """Note every touch that was not there a tick ago."""
        touching = contacts.physical(self._plant.touching()) | contacts.refereed(self._arena, self.world())
        if self.phase != Phase.FLYING:
            touching = {touch for touch in touching if touch[1] != FLOOR}
        for touch in sorted(touching - self._touching, key=str):
            self.contacts.append(Contact(self.t, *touch))
        self._touching = touching


def _convoy(arena: Arena, seed: int, options: Options) -> Convoy:
    """Who drives the UGVs, and where."""
    rows = max(round(options.duration * ROW_RATE), 2)
    formation = FormationControl()
    return Convoy(opening.draw(np.random.default_rng([seed, 0]), arena, rows, formation), formation)


def _places(
    team: Convoy, arena: Arena, rng: np.random.Generator, aloft: bool
) -> tuple[Place, tuple[Place, ...]]:
    """Where everybody is put; the UAV's nose points anywhere."""
    corners = team.corners()
    ugvs = tuple(Place(Vec3(x, y, 0.0), team.plan.orientation) for x, y in corners)
    heading, first = float(rng.uniform(-pi, pi)), team.target(0)
    if aloft:
        height = Lens().focal_px * first.spread / IDEAL_RADIUS_PX
        return Place(Vec3(first.x, first.y, height), heading), ugvs
    x, y = opening.pad(arena, corners)
    return Place(Vec3(x, y, Drone().loops.airframe.half_height), heading), ugvs


def _for_senses(normal: list[float]) -> list[float]:
    return normal[cameras.NORMALS : cameras.NORMALS + senses.NORMALS]


def _last(normal: list[float]) -> list[float]:
    """Those for the weather."""
    return normal[-draught.NORMALS :]
