"""What the AR.Drone of the twin says of itself: navdata, to whoever asked for them.

Somebody asks by any datagram to port 5554. From then on 24 bytes without options go out 15 times a second, until
`general:navdata_demo` was configured: TRUE, and it is the demo option 15 times a second; FALSE, and it is 200 times,
here with the demo option alone, out of some twenty.

Numbers count on over everything, so that clients hear on that take no smaller one. Whether the real drone counts anew
after its watchdog, as Parrot's own client expects it might, is not known; `navdata.fresh` is ready for both.

Reference for the rates: docs/reading.rst of github.com/AutonomyLab/ardrone_autonomy, commit d35607b.
"""

from dataclasses import dataclass
from math import pi
from typing import NamedTuple

from fledge.geometry import Vec3
from fledge.lab.twin import firmware
from fledge.lab.twin.firmware import Phase as P
from fledge.lab.twin.senses import Sensed
from fledge.lab.wire import navdata
from fledge.lab.wire.ardrone import Flag
from fledge.lab.wire.navdata import ControlState, Demo, Navdata, State

DOING = {
    P.LANDED: ControlState.LANDED,
    P.SPINNING: ControlState.TAKING_OFF,
    P.TAKING_OFF: ControlState.TAKING_OFF,
    P.LANDING: ControlState.LANDING,
    P.EMERGENCY: ControlState.DEFAULT,
}


class Memory(NamedTuple):
    """What is remembered."""

    asked: bool = False
    """Whether somebody wants them."""
    sent: int = 0
    """Number of the last."""
    due: float = 0.0
    """When the next are [s]."""


@dataclass(frozen=True, slots=True)
class Telemetry:
    """Rates and thresholds."""

    slow: float = 1.0 / 15.0  # [s]
    fast: float = 0.005  # [s]
    low: float = 0.2  # share of the battery below which it is said to be; chosen

    def is_due(self, memory: Memory, t: float) -> bool:
        """Whether anything is to be said at `t` [s]."""
        return memory.asked and t >= memory.due - firmware.TINY

    def say(
        self, memory: Memory, t: float, knows: firmware.Memory, sensed: Sensed, silent: bool
    ) -> tuple[Memory, bytes | None]:
        """What is due at `t` [s], if anything; `silent` is whether the drone flies by itself."""
        if not self.is_due(memory, t):
            return memory, None
        period = self.fast if knows.demo is False else self.slow
        due = memory.due + period if t < memory.due + period else t + period
        demo = None if knows.demo is None else _demo(knows, sensed, silent)
        data = navdata.encode(Navdata(memory.sent + 1, self._state(knows), demo, vision=True))
        return memory._replace(sent=memory.sent + 1, due=due), data

    def _state(self, knows: firmware.Memory) -> State:
        bits = {
            State.FLYING: knows.phase in firmware.IN_AIR,
            State.COMMAND_ACK: knows.ack,
            State.NAVDATA_DEMO: knows.demo is True,
            State.BOOTSTRAP: knows.demo is None,
            State.COM_LOST: knows.lost,
            State.BATTERY_LOW: knows.battery < self.low,
            State.USER_EMERGENCY: knows.phase == P.EMERGENCY and knows.ref.emergency,
            State.ANGLES_OUT_OF_RANGE: knows.tumbled,
            State.COM_WATCHDOG: knows.watchdog,
            State.EMERGENCY: knows.phase == P.EMERGENCY,
        }
        return State(sum(bit for bit, on in bits.items() if on))


def _demo(knows: firmware.Memory, sensed: Sensed, silent: bool) -> Demo:
    obeys = Flag.PROGRESSIVE in knows.pcmd.flags and not silent
    return Demo(
        control=DOING.get(knows.phase, ControlState.FLYING if obeys else ControlState.HOVERING),
        battery=knows.battery,
        roll=sensed.roll,
        pitch=sensed.pitch,
        yaw=(sensed.yaw + pi) % (2.0 * pi) - pi,
        altitude=max(sensed.altitude, 0.0),
        velocity=Vec3(sensed.forward, sensed.left, sensed.up),
    )
