"""UDP sockets for both sides of a lab's wires: the only file that opens any.

A `Wire` says where the datagrams of one channel come and go; a `UdpPort` is its open socket. Both sides are here:

| channel | the controller | the vehicle, or its twin |
|---|---|---|
| vicon | listens | writes to whom it was told |
| navdata | asks from a port of its own, and hears only who was asked | answers whoever asked last |
| at | writes | listens |
| sticks | listens | |
| glances | answers whoever asked last | |

How many datagrams are taken at once is bounded, so that no flood holds up a tick; the rest waits for the next.
"""

import errno
import socket
import struct
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

from fledge.errors import FledgeError
from fledge.lab.shell.link import Arrival
from fledge.lab.wire import ardrone, navdata
from fledge.lab.wire.datagrams import AT, GLANCES, NAVDATA, STICKS, VICON, Datagram

Address = tuple[str, int]
"""Host and port."""

STICKS_PORT = 51002
"""Chosen: beside Vicon's, and as little used."""
GLANCES_BEYOND = 1
"""By so much the port of glances is beyond that of sticks."""

LONGEST = 32_768
"""[bytes] that are read of a datagram; the drone's navdata with every option are shorter, and so is any glance."""
MOST = 64
"""Datagrams that are taken from one socket at once; chosen: six come in a tick where all is well."""

NO_ADDRESS = ("0.0.0.0", 0)
"""Any of this machine's addresses, any port that is free."""

SO_TIMESTAMPNS = 35
"""Linux's option for the times of arrival (asm-generic/socket.h), which Python's `socket` has no name for."""
TIMESPEC = struct.Struct("@qq")


@dataclass(frozen=True, slots=True)
class Wire:
    """One channel's socket."""

    channel: str
    here: Address = NO_ADDRESS
    """Where it listens."""
    there: Address | None = None
    """Whom it writes to, and who alone is heard; None: everybody is heard, and the last of them is answered."""
    only: str | None = None
    """The one host that is heard where `there` does not say so already."""
    mute: bool = False
    """Whether nothing is ever said here in return, so that nobody need listen."""


def controller_wires(
    mocap: Address | None,
    drone: Address | None,
    sticks: Address | None = None,
    shown: bool = False,
) -> tuple[Wire, ...]:
    """The controller's side: poses from a host to a port of ours, a drone by its AT port, a port for sticks.

    Where the flight is `shown` to whoever has the sticks, the port beyond that one is for those who ask to see it.

    Cameras on this machine are heard at that very address only; others at all of ours, whoever else may write there.
    """
    wires = []
    if mocap is not None:
        host, port = mocap
        near = is_loopback(host)
        wires.append(Wire(VICON, (host if near else NO_ADDRESS[0], port), None, None if near else host))
    if drone is not None:
        host, port = drone
        wires.append(Wire(NAVDATA, there=(host, navdata_port(port))))
        wires.append(Wire(AT, there=(host, port), mute=True))
    if sticks is not None:
        wires.append(Wire(STICKS, sticks))
        if shown:
            wires.append(Wire(GLANCES, glances_at(sticks)))
    return tuple(wires)


def twin_wires(mocap: Address, drone: Address) -> tuple[Wire, ...]:
    """The other side of the same: poses go to `mocap`, the drone is at `drone`, its AT port."""
    host, port = drone
    return Wire(VICON, there=mocap), Wire(NAVDATA, (host, navdata_port(port))), Wire(AT, drone)


def navdata_port(at_port: int) -> int:
    """The port of a drone's navdata: as far from its AT port as the protocol's two are apart."""
    return at_port - ardrone.PORT + navdata.PORT


def glances_at(sticks: Address) -> Address:
    """Where one asks to see a flight whose sticks are there."""
    host, port = sticks
    return host, port + GLANCES_BEYOND


def is_loopback(host: str) -> bool:
    """Whether a host is this very machine, seen from itself.

    Raises:
        FledgeError: there is no such host.
    """
    return resolved(host).startswith("127.")


def resolved(host: str) -> str:
    """The host's IPv4 address.

    Raises:
        FledgeError: there is no such host.
    """
    try:
        return socket.getaddrinfo(host, None, socket.AF_INET, socket.SOCK_DGRAM)[0][4][0]  # pyright: ignore
    except (OSError, UnicodeError) as error:
        raise FledgeError(
            f"host {host!r} is not known ({error}): valid is an IPv4 address, or a name of one"
        ) from error


class Clocks:
    """What leads from the kernel's time of day to our clock; measured anew every second, since people set the one."""

    def __init__(self) -> None:
        self._offset = self._measured = 0

    def offset(self) -> int:
        """[ns] to be added."""
        now = time.monotonic_ns()
        if now - self._measured > 10**9 or not self._measured:
            self._offset, self._measured = _offset(), now
        return self._offset


class UdpPort:
    """An open socket."""

    complaint = ""
    """Once it is open, nothing is wrong with a socket itself."""

    def __init__(self, wire: Wire) -> None:
        """Open it.

        Raises:
            FledgeError: a host that is not known, or a port that cannot be had; says whose it is and what to do.
        """
        self.wire = wire
        self.channels = frozenset((wire.channel,))
        self.last: Address | None = None
        """Whoever wrote last."""
        self._refused = False
        self._clocks = Clocks()
        self._only = wire.only and resolved(wire.only)
        there = wire.there and (resolved(wire.there[0]), wire.there[1])
        self._socket = _bound(wire)
        if there is not None:
            _connect(self._socket, wire.channel, there)

    @property
    def address(self) -> Address:
        """Where it really listens."""
        return self._socket.getsockname()

    def fileno(self) -> int:
        """The socket's."""
        return self._socket.fileno()

    def receive(self) -> list[Arrival]:
        """What came, at most `MOST` at once."""
        arrivals: list[Arrival] = []
        if self.wire.mute:
            return arrivals
        clocks = self._clocks.offset()
        for _ in range(MOST):
            try:
                data, notes, _, sender = self._socket.recvmsg(LONGEST, socket.CMSG_SPACE(TIMESPEC.size))
            except BlockingIOError:
                break
            except OSError:  # nobody listens where the last datagram went; what came is behind that
                self._refused = True
                continue
            if self._only in (None, sender and sender[0]):
                self.last = sender
                arrivals.append(Arrival(_stamp(notes, clocks), Datagram(self.wire.channel, data)))
        return arrivals

    def send(self, datagram: Datagram) -> bool:
        """To the other end; lost if there is none, or it cannot be reached, or the one before was refused."""
        refused, self._refused = self._refused, False
        try:
            if self.wire.there is not None:
                self._socket.send(datagram.data)
            elif self.last is not None:
                self._socket.sendto(datagram.data, self.last)
            else:
                return False
        except OSError:
            return False
        return not refused

    def close(self) -> None:
        """Give the port back."""
        self._socket.close()


def opened(wires: Sequence[Wire]) -> list[UdpPort]:
    """Their ports, all or none.

    Raises:
        FledgeError: one of them cannot be had.
    """
    ports: list[UdpPort] = []
    try:
        for wire in wires:
            ports.append(UdpPort(wire))
    except FledgeError:
        for port in ports:
            port.close()
        raise
    return ports


def _bound(wire: Wire) -> socket.socket:
    """A socket that listens where the wire says, and stamps what comes."""
    host, port = wire.here
    opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    opened.setblocking(False)
    with suppress(OSError):  # a kernel without it: then the time of reading counts
        opened.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
    try:
        opened.bind((resolved(host), port))
    except (OSError, OverflowError) as error:
        opened.close()
        raise FledgeError(_refusal(wire, error)) from error
    return opened


def _connect(one: socket.socket, channel: str, there: Address) -> None:
    try:
        one.connect(there)
    except (OSError, OverflowError) as error:
        one.close()
        place = f"{channel}: port {there[1]} of {there[0]}"
        raise FledgeError(
            f"{place} cannot be reached ({error}): valid are ports from 1 to 65535 of a host on a network of ours"
        ) from error


def _refusal(wire: Wire, error: Exception) -> str:
    host, port = wire.here
    place = f"{wire.channel}: UDP port {port} of {host}"
    code = error.errno if isinstance(error, OSError) else None
    if code == errno.EADDRINUSE:
        return f"{place} is taken: end whoever has it (`ss -lunp sport = :{port}` says who), or use another"
    if code == errno.EADDRNOTAVAIL:
        return f"{place} cannot be had: valid is an address of this machine"
    if code == errno.EACCES:
        return f"{place} needs more rights than you have: valid are ports from 1024 on"
    return f"{place} cannot be had ({error}): valid are ports from 1 to 65535"


def _offset() -> int:
    """From the time of day to our clock [ns]: of a few readings the one that was least interrupted."""
    readings = []
    for _ in range(5):
        before, kernel, after = time.monotonic_ns(), time.time_ns(), time.monotonic_ns()
        readings.append((after - before, (before + after) // 2 - kernel))
    return min(readings)[1]


def _stamp(notes: Sequence[tuple[int, int, bytes]], clocks: int) -> int:
    """When the kernel took the datagram [ns], or now if it does not say; `clocks` leads from its clock to ours."""
    for level, kind, data in notes:
        if level == socket.SOL_SOCKET and kind == SO_TIMESTAMPNS and len(data) >= TIMESPEC.size:
            seconds, rest = TIMESPEC.unpack_from(data)
            return seconds * 10**9 + rest + clocks
    return time.monotonic_ns()
