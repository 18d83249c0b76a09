"""What connects a process to the wires of a lab, whatever transports there are.

A `Port` is one transport's end: a UDP socket (`udp`), a ROS node (`ros`). A `Link` is all ports of one side. Every
datagram comes with the time at which it came off the wire, so that a tick can be timed from there, and datagrams of
several ports are handed over in the order of these times.

A datagram that cannot be sent is lost, as on any wire: it is counted, and nothing raises in flight.
"""

import select
import time
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple, Protocol

from fledge.lab.wire.datagrams import Datagram


class Arrival(NamedTuple):
    """A datagram that came in."""

    at: int
    """When it came off the wire [ns], on the clock of `time.monotonic_ns`."""
    datagram: Datagram


class Port(Protocol):
    """What a link needs of a transport."""

    channels: frozenset[str]
    """What can be sent over it."""

    @property
    def complaint(self) -> str:
        """What is wrong with the transport itself, in one line for people; empty where nothing is."""
        ...

    def fileno(self) -> int:
        """A file descriptor that can be read as soon as something came for which a tick should begin."""
        ...

    def receive(self) -> list[Arrival]:
        """What came since the last call; does not wait, does not raise."""
        ...

    def send(self, datagram: Datagram) -> bool:
        """Whether it is on its way; does not wait, does not raise."""
        ...

    def close(self) -> None:
        """Give everything back."""
        ...


class Link:
    """All ports of one side; a context that closes them."""

    def __init__(self, ports: Sequence[Port], awaited: Sequence[str] = ()) -> None:
        """`awaited` are the channels for whose datagrams a tick begins."""
        self.ports = tuple(ports)
        self.awaited = frozenset(awaited)
        self.lost: Counter[str] = Counter()
        """How many datagrams could not be sent, by channel."""
        self._by_channel = {channel: port for port in self.ports for channel in port.channels}
        self._waking = list(dict.fromkeys(self._by_channel[channel] for channel in awaited))

    def __enter__(self) -> "Link":
        return self

    def __exit__(self, *_: object) -> None:
        for port in self.ports:
            port.close()

    @property
    def complaint(self) -> str:
        """The first of its ports'."""
        return next((port.complaint for port in self.ports if port.complaint), "")

    def port(self, channel: str) -> Port | None:
        """Over which a channel goes; None if there is none."""
        return self._by_channel.get(channel)

    def wait(self, until: int) -> bool:
        """Sleep until one of the awaited channels has something, at most until a time [ns]; whether it has."""
        left = (until - time.monotonic_ns()) / 1e9
        if not self._waking:
            time.sleep(max(left, 0.0))
            return False
        ready, _, _ = select.select(self._waking, (), (), max(left, 0.0))
        return bool(ready)

    def receive(self) -> list[Arrival]:
        """What came over all ports, in the order of its arrival."""
        arrivals = [arrival for port in self.ports for arrival in port.receive()]
        arrivals.sort(key=lambda arrival: arrival.at)
        return arrivals

    def send(self, datagrams: Sequence[Datagram]) -> None:
        """Each over the port of its channel; what cannot be sent is counted in `lost`."""
        for datagram in datagrams:
            port = self._by_channel.get(datagram.channel)
            if port is None or not port.send(datagram):
                self.lost[datagram.channel] += 1
