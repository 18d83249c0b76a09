"""What stands between the twin's vehicles and ROS topics (`topics`): the drivers that a lab would run.

* *vicon_bridge*: every frame becomes a pose on each subject's topic, stamped with when it was taken.
* *ardrone_autonomy*, or with `velocity` *tum_simulator*: take-off, landing and reset are events, `/cmd_vel` says how to
  fly, in shares of what the drone allows or in m/s. Fifty times a second that becomes AT commands; navdata, which it
  configures to come 200 times a second, are passed on as often. Six zeros are the drone's own hover. A velocity
  becomes a tilt by a proportional loop on what the drone says of its speed.
* *rosaria*: `/<ugv>/cmd_vel` in m/s and rad/s goes to the robot's computer (`drivers`), its odometry comes back ten
  times a second.

One thing is unlike the original, and better. The real driver repeats the last twist for as long as it lives, so a
controller that dies in flight leaves a drone that flies on. This one holds a twist for `patience`, then hovers; and if
the last one was to move, it lands after `lost`. A real lab needs such a driver, too, or a watchdog before it.

References: src/teleop_twist.cpp and docs of github.com/AutonomyLab/ardrone_autonomy (commit d35607b);
src/vicon_bridge.cpp of github.com/ethz-asl/vicon_bridge; RosAria.cpp of github.com/amor-ros-pkg/rosaria.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from fledge.dynamics import GRAVITY
from fledge.geometry import Quat, Vec3
from fledge.lab.twin import drivers
from fledge.lab.twin.bodies import NAMES
from fledge.lab.twin.cameras import SUBJECTS, Shot
from fledge.lab.twin.firmware import Settings
from fledge.lab.wire import ardrone, messages, navdata, topics
from fledge.lab.wire.ardrone import Command, Comwdg, Config, Ctrl, Mode, Pcmd, Ref
from fledge.lab.wire.datagrams import AT, NAVDATA, Datagram
from fledge.lab.wire.messages import Empty, Header, Odometry, TransformStamped, Twist
from fledge.lab.wire.navdata import Navdata, State
from fledge.scalars import clip

STILL = Twist(Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.0))
PERIOD = 0.02
"""[s] between AT datagrams, and between navdata that are passed on: ardrone_autonomy's 50 Hz."""
ODOMETRY = 0.1
"""[s] between messages of odometry: a Pioneer reports so often."""
TINY = 1e-9


class Told(NamedTuple):
    """What a UGV is told: by its number, [m/s] and [rad/s]."""

    ugv: int
    speed: float
    turn: float


class Memory(NamedTuple):
    """What the drivers remember."""

    twist: Twist = STILL
    heard: float = inf
    """When it came [s]; infinite if none did since take-off."""
    fly: bool = False
    reset: bool = False
    """Was asked for, and is not on its way yet."""
    sequence: int = ardrone.FIRST
    """Of the next line."""
    seen: Navdata | None = None
    """The last of the drone's."""
    due: float = 0.0
    """When the next AT datagram is [s]."""
    passed: float = -inf
    """When navdata were last passed on [s]."""
    odometry: float = 0.0
    """When the next is due [s]."""
    number: int = 0
    """Of the next message of a drone or a robot."""


@dataclass(frozen=True, slots=True)
class Bridge:
    """How they are set up."""

    velocity: bool = False
    """Whether `/cmd_vel` is in m/s, as with tum_simulator."""
    patience: float = 0.15  # [s]; chosen: scripts that speak ten times a second are not interrupted
    lost: float = 2.0  # [s]; the drone's own
    gain: float = 2.0  # [1/s] of the loop from velocity to tilt; chosen
    settings: Settings = Settings()
    """What the drone allows, as it is configured when it is switched on."""

    def hear(
        self, memory: Memory, t: float, datagrams: Iterable[Datagram]
    ) -> tuple[Memory, tuple[Datagram, ...], tuple[Told, ...]]:
        """(memory, what goes to the drone's ports now, what UGVs are told); datagrams of other channels are skipped."""
        robots = []
        for datagram in datagrams:
            if not datagram.channel.startswith("/"):
                continue
            said = topics.decode(datagram.channel, datagram.data)
            name = datagram.channel[1:].partition("/")[0]
            if isinstance(said, Twist) and name in NAMES:
                robots.append(Told(NAMES.index(name), said.linear.x, said.angular.z))
            elif isinstance(said, Twist | Empty):
                memory = _ordered(memory, t, datagram.channel, said)
        if t < memory.due - TINY:
            return memory, (), tuple(robots)
        memory, commands = self._commands(memory, t)
        first = memory.sequence
        sent = (Datagram(NAVDATA, b"\\1"), Datagram(AT, ardrone.encode(first, *commands)))
        return memory._replace(sequence=first + len(commands), due=t + PERIOD), sent, tuple(robots)

    def _commands(self, memory: Memory, t: float) -> tuple[Memory, list[Command]]:
        """A datagram's lines, and what is left to be said after it."""
        silent = t - memory.heard  # negative where there was no twist yet
        if silent > self.lost and memory.twist != STILL:
            memory = memory._replace(fly=False)
        twist = STILL if silent > self.patience else memory.twist
        commands: list[Command] = [Ref(memory.fly, memory.reset), self._pcmd(twist, memory.seen)]
        state = memory.seen.state if memory.seen else State.BOOTSTRAP
        if State.BOOTSTRAP in state:
            commands.append(Config("general:navdata_demo", "FALSE"))
        if State.COMMAND_ACK in state:
            commands.append(Ctrl(Mode.CLEAR_ACKNOWLEDGEMENT))
        if State.COM_WATCHDOG in state:
            commands.append(Comwdg())
        return memory._replace(reset=False), commands

    def _pcmd(self, twist: Twist, seen: Navdata | None) -> Pcmd:
        if twist == STILL:
            return Pcmd.hover()
        ahead, left, up, turn = twist.linear.x, twist.linear.y, twist.linear.z, twist.angular.z
        if self.velocity:
            v = seen.demo.velocity if seen and seen.demo else Vec3(0.0, 0.0, 0.0)
            scale = self.gain / (GRAVITY * self.settings.euler_angle_max)
            ahead, left = scale * (ahead - v.x), scale * (left - v.y)
            up, turn = up / self.settings.control_vz_max, turn / self.settings.control_yaw
        shares = (-left, -ahead, up, -turn)
        return Pcmd(*(clip(share, -1.0, 1.0) for share in shares))

    def say(
        self,
        memory: Memory,
        t: float,
        epoch: float,
        shots: Sequence[Shot],
        told: Sequence[bytes],
        robots: Sequence[drivers.Memory],
    ) -> tuple[Memory, tuple[Datagram, ...]]:
        """(memory, messages): poses, navdata, odometry.

        Args:
            memory: What is remembered.
            t: Now [s].
            epoch: ROS time at 0 [s].
            shots: Frames that have arrived.
            told: Navdata that the drone has just sent.
            robots: The UGVs' computers.
        """
        said = [message for shot in shots for message in _poses(shot, epoch)]
        for data in told:
            heard = navdata.decode(data)
            memory = memory._replace(seen=heard) if isinstance(heard, Navdata) else memory
        if told and t >= memory.passed + PERIOD - TINY and memory.seen and memory.seen.demo:
            header = _header(t + epoch, "ardrone_base_link", memory.number)
            said.append(_datagram(topics.NAVDATA, messages.Navdata(header, memory.seen.demo)))
            memory = memory._replace(passed=t, number=memory.number + 1)
        if t >= memory.odometry - TINY:
            pairs = zip(NAMES, robots, strict=True)
            said += [_odometry(name, robot, t + epoch, memory.number) for name, robot in pairs]
            memory = memory._replace(odometry=memory.odometry + ODOMETRY, number=memory.number + 1)
        return memory, tuple(said)


HEARD = (topics.FLY, topics.TAKE_OFF, topics.LAND, topics.RESET, *map(topics.drive, NAMES))
"""The topics that the drivers hear."""

SAID = (topics.NAVDATA, *map(topics.pose, SUBJECTS), *map(topics.odometry, NAMES))
"""Those on which they speak."""


def _ordered(memory: Memory, t: float, topic: str, said: Twist | Empty) -> Memory:
    """An order to the drone."""
    if isinstance(said, Twist):
        return memory._replace(twist=said, heard=t) if topic == topics.FLY else memory
    if topic == topics.RESET:
        return memory._replace(reset=True, fly=False)
    fly = topic == topics.TAKE_OFF
    return (
        memory._replace(fly=fly, twist=STILL, heard=inf)
        if fly and not memory.fly
        else memory._replace(fly=fly)
    )


def _poses(shot: Shot, epoch: float) -> list[Datagram]:
    """A frame's subjects, each on its topic."""
    header = _header(shot.taken + epoch, "/vicon/world", shot.frame.number)
    return [
        _datagram(
            topics.pose(one.name),
            TransformStamped(header, f"vicon/{one.name}/{one.name}", one.position, one.attitude),
        )
        for one in shot.frame.objects
    ]


def _odometry(name: str, robot: drivers.Memory, stamp: float, number: int) -> Datagram:
    """Where a robot thinks it is, by its wheels."""
    x, y, heading = robot.odometry
    return _datagram(
        topics.odometry(name),
        Odometry(
            _header(stamp, f"{name}/odom", number),
            f"{name}/base_link",
            Vec3(x, y, 0.0),
            Quat.from_yaw(heading),
            Vec3(robot.speed, 0.0, 0.0),
            Vec3(0.0, 0.0, robot.turn),
        ),
    )


def _header(stamp: float, frame: str, number: int) -> Header:
    """A header; what was before time began counts as its beginning."""
    return Header.at(max(stamp, 0.0), frame, number)


def _datagram(topic: str, message: messages.Message) -> Datagram:
    return Datagram(topic, topics.encode(message))
