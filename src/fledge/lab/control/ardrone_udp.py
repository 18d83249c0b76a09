r"""An AR.Drone 2.0 over its own UDP: AT commands out, navdata in (`ardrone`, `navdata`).

Every tick one datagram, so that no watchdog ever fires: upkeep, REF, PCMD. Upkeep is, when due:

    navdata silent for 0.25 s      a datagram to its port, which makes it speak to us
    watchdog reported              COMWDG; the drone counts from the start again, our numbers are larger anyway
    on the floor, to be trimmed    FTRIM
    not configured                 CONFIG, one entry after the other, as below

An entry of the configuration is sent, acknowledged by a bit in the navdata, and the bit is cleared by CTRL before the
next one goes out. Entries that are not acknowledged are sent anew. A drone that reports its bootstrap state later on
has started again, and is configured again.

The motors' emergency bit is a switch: set, it cuts them; set anew, it makes them ready. An order to cut holds it; an
order to revive sets it for one datagram a second, as long as fresh navdata report an emergency.

References as in `ardrone` and `navdata`; lib/control/UdpControl.js and lib/Client.js of
github.com/felixge/node-ar-drone for what a client has to do.
"""

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from fledge.lab import Malformed
from fledge.lab.control.tilt import Tilt
from fledge.lab.control.vehicle import AbstractVehicle, Orders, Report
from fledge.lab.wire import ardrone, navdata
from fledge.lab.wire.ardrone import FIRST, INT32, Command, Comwdg, Config, Ctrl, Ftrim, Mode, Ref
from fledge.lab.wire.datagrams import AT, NAVDATA, Datagram
from fledge.lab.wire.navdata import Navdata, State

WAKE = b"\x01\x00\x00\x00"
"""Any datagram does; this is what Parrot's own clients send."""
SILENCE = 0.25
"""[s] without navdata after which the drone is woken; chosen: it speaks at least 15 times a second."""
WAKE_EVERY = 0.1
"""[s]; node-ar-drone's."""
ACKNOWLEDGED_WITHIN = 0.5
"""[s]; node-ar-drone's."""
REVIVE_EVERY = 1.0
"""[s] chosen: by then navdata tell what came of it."""


def entries(tilt: Tilt, altitude_max: float) -> tuple[Config, ...]:
    """The configuration that a loop counts on, and a height [m] that the firmware itself keeps below."""
    return (
        Config("general:navdata_demo", "TRUE"),
        Config("control:outdoor", "FALSE"),
        Config("control:euler_angle_max", f"{tilt.most_tilt:g}"),
        Config("control:control_vz_max", f"{1e3 * tilt.most_up:.0f}"),
        Config("control:control_yaw", f"{tilt.most_turn:g}"),
        Config("control:altitude_max", f"{1e3 * altitude_max:.0f}"),
    )


class Line(NamedTuple):
    """What is remembered of the drone."""

    report: Report = Report()
    state: State = State(0)
    """Of the last navdata."""
    last: int = 0
    """Their sequence number."""
    sequence: int = FIRST
    """Of the next AT command."""
    entry: int = 0
    """Of the configuration, the next to be acknowledged."""
    sent: float = -inf
    """When it was sent [s]; never, if it was not."""
    acknowledged: float = -inf
    """When the one before was [s]."""
    woken: float = -inf
    """When the drone was last asked to speak [s]."""
    revived: float = -inf
    """When the emergency was last switched off [s]."""


@dataclass(frozen=True, slots=True)
class ArDroneUdp(AbstractVehicle):
    """The drone, and how it is to be configured."""

    configuration: tuple[Config, ...]

    def init(self) -> Line:
        """Nothing was heard yet."""
        return Line()

    def hear(self, memory: Line, t: float, datagram: Datagram) -> Line:
        """Navdata that are whole and later than the last; after a silence, any."""
        if datagram.channel != NAVDATA:
            return memory
        told = navdata.decode(datagram.data)
        last = memory.last if t - memory.report.heard <= SILENCE else 0
        if isinstance(told, Malformed) or not navdata.fresh(told, last):
            return memory
        memory = _acknowledged(memory, t, told.state)
        report = self._report(memory.report, t, told, memory.entry)
        return memory._replace(report=report, state=told.state, last=told.sequence)

    def _report(self, before: Report, t: float, told: Navdata, entry: int) -> Report:
        configured = entry >= len(self.configuration)
        emergency = State.EMERGENCY in told.state
        if told.demo is None:
            return before._replace(heard=t, emergency=emergency, configured=configured)
        return Report(t, told.demo.control, told.demo.battery, emergency, configured)

    def say(self, memory: Line, t: float, orders: Orders) -> tuple[Line, tuple[Datagram, ...]]:
        """(memory, one datagram of AT commands, and one to the navdata port if the drone has to be woken)."""
        heard_lately = t - memory.report.heard <= SILENCE
        datagrams = []
        if not heard_lately and t - memory.woken >= WAKE_EVERY:
            datagrams.append(Datagram(NAVDATA, WAKE))
            memory = memory._replace(woken=t)
        commands: list[Command] = []
        if heard_lately:
            memory, commands = self._upkeep(memory, t, orders)
        cut = orders.cut
        if orders.revive and memory.report.emergency and heard_lately and t - memory.revived >= REVIVE_EVERY:
            cut, memory = True, memory._replace(revived=t)
        commands += [Ref(orders.fly, cut), orders.tilt]
        first = memory.sequence if memory.sequence <= INT32 - len(commands) else FIRST
        datagrams.append(Datagram(AT, ardrone.encode(first, *commands)))
        return memory._replace(sequence=first + len(commands)), tuple(datagrams)

    def _upkeep(self, memory: Line, t: float, orders: Orders) -> tuple[Line, list[Command]]:
        due: list[Command] = []
        if State.COM_WATCHDOG in memory.state:
            due.append(Comwdg())
        if orders.trim:
            due.append(Ftrim())
        waiting = memory.sent > -inf
        if State.COMMAND_ACK in memory.state and not waiting:
            due.append(Ctrl(Mode.CLEAR_ACKNOWLEDGEMENT))
        elif memory.entry < len(self.configuration) and t - memory.sent > ACKNOWLEDGED_WITHIN:
            due.append(self.configuration[memory.entry])
            memory = memory._replace(sent=t)
        return memory, due


def _acknowledged(memory: Line, t: float, state: State) -> Line:
    """With the entry that was sent ticked off, if it was taken; with all to do, if the drone has started again."""
    if State.COMMAND_ACK in state and memory.sent > -inf:
        return memory._replace(entry=memory.entry + 1, sent=-inf, acknowledged=t)
    if State.BOOTSTRAP in state and memory.entry > 0 and t - memory.acknowledged > ACKNOWLEDGED_WITHIN:
        return memory._replace(entry=0, sent=-inf)
    return memory
