"""The AR.Drone's firmware as the twin has it: what comes in over its port, and what it does about it.

    LANDED -> SPINNING -> TAKING_OFF -> FLYING -> LANDING -> LANDED, and from anywhere EMERGENCY -> LANDED

*Commands.* REF with bit 9 starts the motors and takes off to about a metre; PCMD is obeyed once it is there; REF
without it lands. A landing is completed once it has begun. After one of the drone's own accord and after an
emergency, REF has to say "land" once before it says "fly" again. REF with bit 8, when it becomes set, cuts the
motors, and set anew makes the drone ready again. PCMD holds until the next one: flag bit 0 unset is hover. Lines are
obeyed in the order of their numbers (`ardrone.accepts`).

*Silence.* Without a line for 50 ms the drone reports its communication watchdog, counts lines from the start and
hovers by itself; the report goes when COMWDG comes. After 2 s it holds the link for lost, and lands.

*Configuration.* Every CONFIG is acknowledged (state bit 6) until CTRL 5. Honoured are `general:navdata_demo`, for
`telemetry`, and, in the units of the protocol, `control:euler_angle_max`, `control_vz_max`, `control_yaw`,
`altitude_max`; others are acknowledged, no more.

*Battery.* It empties with what the rotors draw. Below 5 % the drone lands.

What is not modelled: flight animations, video, absolute control, ultrasound dropouts, the configuration file (CTRL 4).
What Parrot's guide leaves open is said where it is decided. References: `ardrone`, `navdata`; Developer Guide 2.0,
sections on the communication watchdog and on initialisation; time-outs in ardrone_common_config.h.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from math import inf
from typing import NamedTuple

from fledge.lab import Malformed
from fledge.lab.twin.loops import Wish
from fledge.lab.twin.senses import Sensed
from fledge.lab.wire import ardrone
from fledge.lab.wire.ardrone import Comwdg, Config, Ctrl, Flag, Ftrim, Mode, Pcmd, Ref


class Phase(Enum):
    """What the drone is doing."""

    LANDED = "landed"
    SPINNING = "spinning"
    TAKING_OFF = "taking off"
    FLYING = "flying"
    LANDING = "landing"
    EMERGENCY = "emergency"


TINY = 1e-9
"""[s] by which sums of ticks may be off."""

P = Phase
IN_AIR = (P.TAKING_OFF, P.FLYING, P.LANDING)
MOTORS_ON = (P.SPINNING, *IN_AIR)


class Settings(NamedTuple):
    """What PCMD's shares are shares of; the indoor defaults of the drone."""

    euler_angle_max: float = 0.21
    """[rad]."""
    control_vz_max: float = 0.7
    """[m/s]."""
    control_yaw: float = 1.75
    """[rad/s]."""
    altitude_max: float = 3.0
    """[m]; it does not climb on above."""


SETTABLE = {
    "control:euler_angle_max": ("euler_angle_max", 1.0, 0.0, 0.52),
    "control:control_vz_max": ("control_vz_max", 1e-3, 0.2, 2.0),
    "control:control_yaw": ("control_yaw", 1.0, 0.7, 6.11),
    "control:altitude_max": ("altitude_max", 1e-3, 0.5, 100.0),
}
"""By its key: the entry, what a number on the wire is worth in SI units, and the least and most that is taken."""


class Memory(NamedTuple):
    """What the firmware remembers."""

    phase: Phase
    since: float
    """When it came into this phase [s]."""
    last: int
    """Number of the last line obeyed."""
    heard: float
    """When that was [s]."""
    pcmd: Pcmd
    ref: Ref
    stubborn: bool
    """It came down of its own accord: REF has yet to say "land"."""
    watchdog: bool
    """Reported until COMWDG comes."""
    lost: bool
    ack: bool
    trimmed: int
    """How often it was told that it stands level."""
    demo: bool | None
    """Whether short navdata were configured; None: neither was."""
    settings: Settings
    battery: float
    """What is left, as a share."""
    tumbled: bool
    """Whether it cut its motors because it was about to fall over."""
    pressed: float
    """Since when the floor has been under the hull [s]; infinite in the air."""


@dataclass(frozen=True, slots=True)
class Firmware:
    """Times and thresholds."""

    watchdog: float = 0.05  # [s] developer guide, section on AT commands
    lost: float = 2.0  # [s] same
    spin_up: float = 1.2  # [s]; chosen, motors start one after the other
    height: float = 1.0  # [m] of take-off; developer guide: about one metre
    near: float = 0.1  # [m] from there at which it has taken off
    patience: float = 6.0  # [s] after which it has, wherever it is
    descent: float = 0.4  # [m/s]; chosen
    soft: float = 0.2  # [m/s] below 0.4 m
    ground: float = 0.05  # [m] above which no floor is
    settled: float = 0.15  # [s] on the floor before the motors stop
    upright: float = 0.5  # cosine of the angle at which it cuts its motors
    endurance: float = 1080.0  # [s] of hovering on one battery; Parrot's 1,500 mAh, 18 minutes
    empty: float = 0.05  # share of the battery at which it lands; chosen

    def init(self, t: float, battery: float = 1.0) -> Memory:
        """Switched on at `t` [s], on the floor, nobody there."""
        return Memory(
            phase=P.LANDED,
            since=t,
            last=0,
            heard=-inf,
            pcmd=Pcmd.hover(),
            ref=Ref(fly=False),
            stubborn=False,
            watchdog=True,
            lost=False,
            ack=False,
            trimmed=0,
            demo=None,
            settings=Settings(),
            battery=battery,
            tumbled=False,
            pressed=inf,
        )

    def aloft(self, t: float, battery: float = 1.0) -> Memory:
        """In the air, as if it had taken off; for studies that begin there."""
        started = self.init(t, battery)
        return started._replace(phase=P.FLYING, heard=t, ref=Ref(fly=True), watchdog=False)

    # What it hears.

    def hear(self, memory: Memory, t: float, commands: Iterable[bytes]) -> Memory:
        """Datagrams that came to the AT port by `t` [s]."""
        memory = self._watched(memory, t)
        for data in commands:
            for line in ardrone.decode(data):
                if not isinstance(line, Malformed) and ardrone.accepts(memory.last, line.sequence):
                    memory = memory._replace(last=line.sequence, heard=t, lost=False)
                    memory = self._obey(memory, t, line.command)
        return memory

    def silent(self, memory: Memory, t: float) -> bool:
        """Whether nothing was heard for so long that the drone flies by itself."""
        return t - memory.heard > self.watchdog + TINY

    def _watched(self, memory: Memory, t: float) -> Memory:
        if not self.silent(memory, t):
            return memory
        return memory._replace(last=0, watchdog=True, lost=self.lost + TINY < t - memory.heard < inf)

    def _obey(self, memory: Memory, t: float, command: ardrone.Command) -> Memory:
        match command:
            case Pcmd():
                return memory._replace(pcmd=command)
            case Ref():
                return self._referred(memory, t, command)
            case Config(key, value):
                return self._configured(memory, key, value)._replace(ack=True)
            case Ctrl(mode):
                return memory._replace(ack=False) if mode == Mode.CLEAR_ACKNOWLEDGEMENT else memory
            case Comwdg():
                return memory._replace(watchdog=False)
            case Ftrim():
                return memory._replace(trimmed=memory.trimmed + (memory.phase == P.LANDED))

    def _referred(self, memory: Memory, t: float, ref: Ref) -> Memory:
        risen = ref.emergency and not memory.ref.emergency
        memory = memory._replace(ref=ref, stubborn=memory.stubborn and ref.fly)
        if not risen:
            return memory
        return _to(memory, P.LANDED if memory.phase == P.EMERGENCY else P.EMERGENCY, t)._replace(
            tumbled=False, stubborn=True
        )

    def _configured(self, memory: Memory, key: str, value: str) -> Memory:
        if key == "general:navdata_demo":
            return memory._replace(demo=value.upper() in ("TRUE", "1"))
        if key not in SETTABLE:
            return memory
        name, scale, least, most = SETTABLE[key]
        number = _number(value)
        if number is None or not least <= number * scale <= most:
            return memory
        return memory._replace(settings=memory.settings._replace(**{name: number * scale}))

    # What it does.

    def decide(self, memory: Memory, t: float, sensed: Sensed) -> tuple[Memory, Wish]:
        """What the loops are told until the next tick."""
        memory = self._advanced(memory, t, sensed)
        match memory.phase:
            case P.LANDED | P.EMERGENCY:
                return memory, Wish(motors=False)
            case P.SPINNING:
                return memory, Wish(motors=True, lifted=False)
            case P.TAKING_OFF:
                return memory, Wish(motors=True, height=self.height)
            case P.LANDING:
                return memory, Wish(motors=True, climb=-self.soft if sensed.altitude < 0.4 else -self.descent)
            case P.FLYING:
                return memory, self._flown(memory, t, sensed)

    def _flown(self, memory: Memory, t: float, sensed: Sensed) -> Wish:
        p, s = memory.pcmd, memory.settings
        if not Flag.PROGRESSIVE & p.flags or self.silent(memory, t):
            return Wish(motors=True)
        climb = s.control_vz_max * p.gaz
        return Wish(
            motors=True,
            hover=False,
            # On the wire: right side down, nose up, up, clockwise.
            roll=s.euler_angle_max * p.roll,
            pitch=-s.euler_angle_max * p.pitch,
            climb=0.0 if climb > 0.0 and sensed.altitude > s.altitude_max else climb,
            turn=-s.control_yaw * p.yaw,
        )

    def _advanced(self, memory: Memory, t: float, sensed: Sensed) -> Memory:
        """The phase one tick later."""
        for_ = t - memory.since
        alone = memory.lost or memory.battery < self.empty
        memory = memory._replace(pressed=min(memory.pressed, t) if sensed.altitude < self.ground else inf)
        match memory.phase:
            case P.LANDED if memory.ref.fly and not (memory.stubborn or alone):
                return _to(memory, P.SPINNING, t)
            case P.SPINNING if not memory.ref.fly or alone:
                return _to(memory, P.LANDED, t)
            case P.SPINNING if for_ > self.spin_up:
                return _to(memory, P.TAKING_OFF, t)
            case P.TAKING_OFF | P.FLYING | P.LANDING if sensed.upright < self.upright:
                return _to(memory, P.EMERGENCY, t)._replace(tumbled=True, stubborn=True)
            case P.TAKING_OFF | P.FLYING if not memory.ref.fly or alone:
                return _to(memory, P.LANDING, t)._replace(stubborn=alone)
            case P.TAKING_OFF if for_ > self.patience or abs(sensed.altitude - self.height) < self.near:
                return _to(memory, P.FLYING, t)
            case P.LANDING if t - memory.pressed > self.settled:
                return _to(memory, P.LANDED, t)
        return memory

    def drain(self, memory: Memory, power: float, dt: float) -> Memory:
        """The battery after `dt` [s] at a power, as a share of that of hovering; electronics draw 2 % at rest."""
        left = memory.battery - (0.02 + power) * dt / self.endurance
        return memory._replace(battery=max(left, 0.0))


def _to(memory: Memory, phase: Phase, t: float) -> Memory:
    return memory._replace(phase=phase, since=t)


def _number(text: str) -> float | None:
    """What a text says, if it is a number."""
    try:
        return float(text)
    except ValueError:
        return None
