"""A lab made of point masses, which speaks in the real bytes: what the tests of the controller fly against.

It shares nothing with the twin but the wires: an airframe that tilts with a second-order lag and is pushed along by its
tilt, a firmware that takes off, obeys and lands, UGVs that slide along a circle, cameras that are late and noisy.
"""

from dataclasses import dataclass, field, fields, replace
from math import cos, pi, sin

import numpy as np

from fledge.dynamics import UGV_FLEET
from fledge.geometry import Heading, Quat, Vec3
from fledge.lab.wire import ardrone, messages, navdata, topics, vicon
from fledge.lab.wire.ardrone import Comwdg, Config, Ctrl, Flag, Ftrim, Line, Pcmd, Ref
from fledge.lab.wire.datagrams import AT, NAVDATA, VICON, Datagram
from fledge.lab.wire.messages import Header, TransformStamped, Twist
from fledge.lab.wire.navdata import ControlState, Demo, Navdata, State
from fledge.manoeuvres import FixedAltitude, FormationTrack, Plan
from fledge.world import Arena, UgvState, VelocityCommand

TICK = 0.01
STEPS = 5
SUBJECTS = ("ardrone", "p3at", "p3dx1", "p3dx2")
FLOOR = 0.06
"""[m] at which the UAV stands."""


@dataclass
class Airframe:
    """A point mass under a thrust that tilts."""

    bandwidth: float = 10.0  # [rad/s] of the attitude
    damping: float = 0.8
    drag: float = 0.3  # [1/s]
    climb_lag: float = 0.2  # [s]
    delay: int = 3  # ticks from a command's sending to its effect
    most_tilt: float = 0.21
    most_up: float = 0.7
    most_turn: float = 1.75
    position: Vec3 = Vec3(0.0, 0.0, 2.0)
    velocity: Vec3 = Vec3(0.0, 0.0, 0.0)
    yaw: float = 0.0
    lean: tuple[float, float] = (0.0, 0.0)  # forward, left [rad]
    swing: tuple[float, float] = (0.0, 0.0)
    pending: list[Pcmd] = field(default_factory=list)

    def fly(self, told: Pcmd, push: Vec3 = Vec3(0.0, 0.0, 0.0)) -> None:
        """10 ms with a command, and an acceleration nobody commanded [m/s^2, world]."""
        self.pending.append(told)
        now = self.pending.pop(0) if len(self.pending) > self.delay else Pcmd.hover()
        if Flag.PROGRESSIVE not in now.flags:
            vf, vl = self.heading.from_world(self.velocity.x, self.velocity.y)
            now = Pcmd(clip(2.0 * vl), clip(2.0 * vf), 0.0, 0.0)  # holds still by itself
        for _ in range(STEPS):
            self._step(now, push, TICK / STEPS)

    def _step(self, now: Pcmd, push: Vec3, dt: float) -> None:
        w, z = self.bandwidth, self.damping
        aims = (-now.pitch * self.most_tilt, -now.roll * self.most_tilt)
        self.swing = tuple(
            q + (w * w * (aim - a) - 2.0 * z * w * q) * dt
            for q, a, aim in zip(self.swing, self.lean, aims, strict=True)
        )
        self.lean = tuple(a + q * dt for a, q in zip(self.lean, self.swing, strict=True))
        ax, ay = self.heading.to_world(*(9.81 * sin(a) for a in self.lean))
        v = self.velocity
        up = (now.gaz * self.most_up - v.z) / self.climb_lag
        self.velocity = v + (Vec3(ax - self.drag * v.x, ay - self.drag * v.y, up) + push) * dt
        self.position = self.position + self.velocity * dt
        self.yaw -= now.yaw * self.most_turn * dt

    @property
    def heading(self) -> Heading:
        return Heading.of(self.yaw)

    @property
    def attitude(self) -> Quat:
        """Turned by yaw, then pitch (nose down), then roll (left side up)."""
        pitch, roll = self.lean[0], -self.lean[1]
        cy, sy = cos(0.5 * self.yaw), sin(0.5 * self.yaw)
        cp, sp = cos(0.5 * pitch), sin(0.5 * pitch)
        cr, sr = cos(0.5 * roll), sin(0.5 * roll)
        return Quat(
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        )


def clip(x: float) -> float:
    return max(-1.0, min(1.0, x))


@dataclass
class Lab:
    """All that is on the other side of the wires. Change what you like while it runs."""

    seed: int = 0
    noise: float = 0.0003  # [m] at most
    latency: int = 1  # ticks
    battery: float = 0.9
    push: Vec3 = Vec3(0.0, 0.0, 0.0)
    speed: float = 0.2  # [m/s] of the UGVs' middle
    speaks: bool = True
    """Whether the drone does."""
    sees: bool = True
    """Whether the cameras do."""
    spoil: object = None
    """What becomes of a frame: a function of it, or nothing."""

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.seed)
        self.t = 0.0
        self.frame = 1000
        self.air = Airframe(position=Vec3(-2.5, -1.7, FLOOR), yaw=0.7)
        self.control = ControlState.LANDED
        self.since = 0.0
        self.emergency, self.cut = False, False
        self.ack, self.demo, self.awake = False, False, False
        self.last, self.told, self.silent = 0, Pcmd.hover(), 0
        self.stubborn = False
        self.ref = Ref(fly=False)
        self.number = 0
        self.due = 0.0
        self.way = 0.0
        self.under_way: list[bytes] = []
        self.heard: list[Line] = []
        self.configured: dict[str, str] = {}

    def tick(self, datagrams: tuple[Datagram, ...]) -> tuple[Datagram, ...]:
        """10 ms with these commands."""
        self.silent += 1
        for datagram in datagrams:
            self._hear(datagram)
        if self.silent > 5:  # its watchdog: it holds still by itself
            self.told = Pcmd.hover()
        self._obey()
        self.t = round(self.t + TICK, 9)
        self._drive()
        return (*self._say(), *self._look())

    def _hear(self, datagram: Datagram) -> None:
        if datagram.channel == NAVDATA:
            self.awake = True
        if datagram.channel != AT:
            return
        for line in ardrone.decode(datagram.data):
            assert isinstance(line, Line), line
            assert ardrone.accepts(self.last, line.sequence)
            self.last = line.sequence
            self.heard.append(line)
            self._take(line.command)

    def _take(self, command: ardrone.Command) -> None:
        match command:
            case Pcmd():
                self.told, self.silent = command, 0
            case Ref(_, emergency):
                if emergency and not self.cut:
                    self.emergency = not self.emergency
                self.cut, self.ref = emergency, command
            case Config(key, value):
                assert not self.ack, "one entry after the other"
                self.configured[key] = value
                self.ack = True
                self.demo = self.demo or key == "general:navdata_demo"
            case Ctrl():
                self.ack = False
            case Ftrim():
                assert self.control is ControlState.LANDED
            case Comwdg():
                pass

    def _obey(self) -> None:
        C, low = ControlState, self.air.position.z <= FLOOR + 0.01
        fly = self.ref.fly
        if self.emergency:
            self._fall()
            return self._become(C.DEFAULT)
        match self.control:
            case C.DEFAULT:
                self._become(C.LANDED)
            case C.LANDED if not fly:
                self.stubborn = False
            case C.LANDED if not self.stubborn:
                self._become(C.TAKING_OFF)
            case C.TAKING_OFF:
                self._lift(1.0)
                if not fly:
                    self._become(C.LANDING)
                elif self.air.position.z > 0.95:
                    self._become(C.HOVERING)
            case C.HOVERING:
                self.air.fly(self.told, self.push)
                if not fly:
                    self._become(C.LANDING)
            case C.LANDING:
                self._lift(FLOOR - 0.1)
                if low:
                    self.air.velocity = Vec3(0.0, 0.0, 0.0)
                    self._become(C.LANDED)

    def give_up(self) -> None:
        """It lands of its own accord, and has to be told to before it takes off again."""
        self.stubborn = True
        self._become(ControlState.LANDING)

    def _become(self, control: ControlState) -> None:
        if control is not self.control:
            self.control, self.since = control, self.t

    def _lift(self, height: float) -> None:
        climb = max(-0.4, min(0.6, 2.0 * (height - self.air.position.z)))
        self.air.fly(replace(Pcmd.hover(), gaz=climb / self.air.most_up, flags=Flag.PROGRESSIVE))

    def _fall(self) -> None:
        self.air.velocity = Vec3(0.0, 0.0, 0.0)
        z = max(FLOOR, self.air.position.z - 2.0 * TICK)
        self.air.position = replace(self.air.position, z=z)

    def _drive(self) -> None:
        p = self.air.position
        x, y = self.middle
        if p.z > 1.5 and (p.x - x) ** 2 + (p.y - y) ** 2 < 0.09:
            self.way += self.speed * TICK

    @property
    def middle(self) -> tuple[float, float]:
        """Of the UGVs [m]: on a circle of 0.6 m."""
        return 0.6 * cos(self.way / 0.6) - 0.2, 0.6 * sin(self.way / 0.6)

    @property
    def ugvs(self) -> list[tuple[float, float]]:
        """Where they are [m]."""
        x, y = self.middle
        return [(x + 0.75 * cos(a), y + 0.75 * sin(a)) for a in (0.3, 0.3 + 2 * pi / 3, 0.3 + 4 * pi / 3)]

    def _say(self) -> list[Datagram]:
        if not self.awake or not self.speaks or self.t < self.due:
            return []
        self.due = self.t + 1.0 / 15.0
        self.number += 1
        state = (State.COMMAND_ACK if self.ack else State(0)) | (
            State.EMERGENCY if self.emergency else State(0)
        )
        if not self.demo:
            return [Datagram(NAVDATA, navdata.encode(Navdata(self.number, state | State.BOOTSTRAP)))]
        demo = Demo(self.control, self.battery, 0.0, 0.0, 0.0, self.air.position.z, Vec3(0.0, 0.0, 0.0))
        return [Datagram(NAVDATA, navdata.encode(Navdata(self.number, state, demo)))]

    def _look(self) -> list[Datagram]:
        self.frame += 1
        bodies = [(self.air.position, self.air.attitude)]
        angle = self.way / 0.6 + 0.5 * pi
        bodies += [(Vec3(x, y, 0.2), Quat.from_yaw(angle)) for x, y in self.ugvs]
        objects = tuple(
            vicon.Object(
                name,
                position + Vec3(*self.rng.uniform(-self.noise, self.noise, 3).tolist()),
                vicon.rotation_of(q),
            )
            for name, (position, q) in zip(SUBJECTS, bodies, strict=True)
        )
        frame = vicon.Frame(self.frame, objects)
        frame = self.spoil(frame) if callable(self.spoil) else frame
        self.under_way.append(vicon.encode(frame) if frame is not None else b"")
        data = self.under_way.pop(0) if len(self.under_way) > self.latency else b""
        return [Datagram(VICON, data)] if data and self.sees else []


ROWS = 400


def lateral(seed: int = 3) -> Plan:
    """A plan of `ROWS` rows for UGVs in the paper's flying room, its numbers in lists."""
    drawn = FixedAltitude(spread=0.75, reach=0.7, arena=Arena.lab()).plan(np.random.default_rng(seed), ROWS)
    lists = [getattr(drawn.track, one.name).tolist() for one in fields(FormationTrack)]
    return Plan(drawn.arena, FormationTrack(*lists), float(drawn.orientation))


WALL_CLOCK = 1.7e9
"""[s] by which the senders' clocks are ahead."""


@dataclass
class RosLab(Lab):
    """The same over ROS topics, with UGVs that do as they are told."""

    places: tuple[tuple[float, float, float], ...] = ()
    """x, y, heading of each UGV in the beginning."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self.robots = [UgvState(x, y, heading, 0.0, 0.0, 0.0) for x, y, heading in self.places]
        self.driven = [VelocityCommand.hover()] * 3
        self.awake = self.demo = True

    def _hear(self, datagram: Datagram) -> None:
        message = topics.decode(datagram.channel, datagram.data)
        match datagram.channel:
            case topics.FLY:
                self._steer(message)
            case topics.TAKE_OFF:
                self.ref = Ref(fly=True)
            case topics.LAND:
                self.ref = Ref(fly=False)
            case topics.RESET:
                self.emergency, self.ref = not self.emergency, Ref(fly=False)
            case topic:
                which = [topics.drive(name) for name in SUBJECTS[1:]].index(topic)
                self.driven[which] = VelocityCommand(message.linear.x, 0.0, 0.0, message.angular.z)

    def _steer(self, twist: Twist) -> None:
        v, w = twist.linear, twist.angular
        self.silent = 0
        hover = (v.x, v.y, v.z, w.x, w.y, w.z) == (0.0,) * 6
        self.told = Pcmd.hover() if hover else Pcmd(-v.y, -v.x, v.z, -w.z)

    def _drive(self) -> None:
        self.robots = [
            model.step(robot, command, TICK)
            for model, robot, command in zip(UGV_FLEET, self.robots, self.driven, strict=True)
        ]

    @property
    def ugvs(self) -> list[tuple[float, float]]:
        """Where they are [m]."""
        return [(robot.x, robot.y) for robot in self.robots]

    def _say(self) -> list[Datagram]:
        said = super()._say()
        demo = navdata.decode(said[0].data).demo if said else None
        if demo is None:
            return []
        control = ControlState.DEFAULT if self.emergency else demo.control
        message = messages.Navdata(Header.at(WALL_CLOCK + self.t), replace(demo, control=control))
        return [Datagram(topics.NAVDATA, topics.encode(message))]

    def _look(self) -> list[Datagram]:
        found = []
        for datagram in super()._look():
            frame = vicon.decode(datagram.data)
            stamp = Header.at(WALL_CLOCK + 0.01 * frame.number, "world", frame.number)
            for i, one in enumerate(frame.objects):
                turned = one.attitude if i == 0 else Quat.from_yaw(self.robots[i - 1].heading)
                message = TransformStamped(stamp, one.name, one.position, turned)
                found.append(Datagram(topics.pose(one.name), topics.encode(message)))
        return found
