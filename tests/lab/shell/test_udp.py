"""Real sockets on this machine: what comes, when, from whom, and what cannot be had."""

import select
import socket
import time

import pytest
from loopback import own_host

from fledge.errors import FledgeError
from fledge.lab.shell import udp
from fledge.lab.shell.link import Link
from fledge.lab.shell.udp import MOST, UdpPort, Wire, controller_wires, is_loopback, navdata_port, twin_wires
from fledge.lab.wire import ardrone, navdata
from fledge.lab.wire.datagrams import AT, NAVDATA, STICKS, VICON, Datagram

HERE = ("127.0.0.1", 0)


@pytest.fixture
def opened():
    """Opens ports, and closes them after the test."""
    ports = []

    def port(*args, **more):
        ports.append(UdpPort(Wire(*args, **more)))
        return ports[-1]

    yield port
    for one in ports:
        one.close()


def received(port, within=2.0):
    """What comes next."""
    select.select([port], (), (), within)
    return [arrival.datagram.data for arrival in port.receive()]


def test_both_sides_of_every_wire_meet():
    """Whatever the controller sends, the twin hears, and the other way round, on the protocols' own ports."""
    host = own_host()
    mocap, drone, sticks = (host, 51001), (host, 5556), (host, 51002)
    with (
        Link(udp.opened(controller_wires(mocap, drone, sticks)), (VICON,)) as ours,
        Link(udp.opened(twin_wires(mocap, drone))) as theirs,
    ):
        wake = Datagram(NAVDATA, b"\1\0\0\0")
        ours.send([wake, Datagram(AT, b"AT*COMWDG=1\r")])
        assert {arrival.datagram for arrival in theirs.receive()} == {wake, Datagram(AT, b"AT*COMWDG=1\r")}
        theirs.send([Datagram(VICON, b"frame"), Datagram(NAVDATA, b"state")])
        assert ours.wait(time.monotonic_ns() + 10**9)
        assert [a.datagram for a in ours.receive()] == [
            Datagram(VICON, b"frame"),
            Datagram(NAVDATA, b"state"),
        ]
        assert not ours.lost and not theirs.lost


def test_the_two_ports_of_a_drone_move_together():
    assert navdata_port(ardrone.PORT) == navdata.PORT
    wires = {wire.channel: wire for wire in controller_wires(None, ("127.0.0.1", 15556))}
    assert wires[AT].there == ("127.0.0.1", 15556) and wires[NAVDATA].there == ("127.0.0.1", 15554)
    assert {wire.channel for wire in controller_wires(HERE, None, HERE)} == {VICON, STICKS}


def test_cameras_elsewhere_are_heard_on_all_our_addresses_but_alone():
    (wire,) = controller_wires(("192.0.2.1", 51001), None)
    assert wire.here == ("0.0.0.0", 51001) and wire.only == "192.0.2.1"
    (wire,) = controller_wires(("127.0.0.1", 51001), None)
    assert wire.here == ("127.0.0.1", 51001) and wire.only is None
    assert is_loopback("localhost") and not is_loopback("192.0.2.1")


def test_a_stranger_is_not_heard(opened):
    choosy = opened(VICON, HERE, only="192.0.2.1")
    stranger = opened(AT, there=choosy.address)
    open_to_all = opened(VICON, HERE)
    assert stranger.send(Datagram(AT, b"I am no camera"))
    opened(AT, there=open_to_all.address).send(Datagram(AT, b"neither am I"))
    assert received(open_to_all) == [b"neither am I"]
    assert received(choosy) == []


def test_who_asked_last_is_answered(opened):
    drone = opened(NAVDATA, HERE)
    assert not drone.send(Datagram(NAVDATA, b"to nobody"))
    first, second = (opened(NAVDATA, there=drone.address) for _ in range(2))
    for asking in (first, second):
        asking.send(Datagram(NAVDATA, b"\1"))
        assert received(drone) == [b"\1"]
    assert drone.send(Datagram(NAVDATA, b"state"))
    assert received(second) == [b"state"] and received(first, 0.0) == []


def test_the_stamp_is_the_kernels(opened):
    """It tells when a datagram came, not when somebody at last looked."""
    ear = opened(VICON, HERE)
    mouth = opened(AT, there=ear.address)
    before = time.monotonic_ns()
    mouth.send(Datagram(AT, b"early"))
    after = time.monotonic_ns()
    time.sleep(0.05)
    (arrival,) = ear.receive()
    slack = 5_000_000  # the two clocks are read one after the other
    assert before - slack <= arrival.at <= after + slack


def test_a_flood_is_taken_in_parts(opened):
    ear = opened(VICON, HERE)
    mouth = opened(AT, there=ear.address)
    for i in range(MOST + 3):
        mouth.send(Datagram(AT, bytes([i])))
    assert len(ear.receive()) == MOST
    assert [arrival.datagram.data for arrival in ear.receive()] == [bytes([MOST + i]) for i in range(3)]


@pytest.mark.parametrize(
    ("wire", "words"),
    [
        (
            Wire(VICON, ("192.0.2.1", 51001)),
            "vicon: UDP port 51001 of 192.0.2.1 cannot be had: valid is an address",
        ),
        (Wire(VICON, ("127.0.0.1", 99999)), "valid are ports from 1 to 65535"),
        (Wire(AT, there=("no such host", 5556)), "host 'no such host' is not known"),
        (Wire(AT, there=("127.0.0.1", 65536)), "at: port 65536 of 127.0.0.1 cannot be reached"),
        (Wire(AT, there=("255.255.255.255", 5556)), "at: port 5556 of 255.255.255.255 cannot be reached"),
    ],
)
def test_what_cannot_be_opened_is_refused_in_one_line(wire, words):
    with pytest.raises(FledgeError, match="^[^\n]*$") as refused:
        udp.opened([wire])
    assert words in str(refused.value)


def test_a_port_that_is_taken_is_named_and_the_others_are_given_back(opened):
    taken = opened(VICON, HERE).address
    free = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    free.bind(HERE)
    other = free.getsockname()
    free.close()
    with pytest.raises(
        FledgeError, match=rf"vicon: UDP port {taken[1]} of 127.0.0.1 is taken: end whoever"
    ) as refused:
        udp.opened([Wire(NAVDATA, other), Wire(VICON, taken)])
    assert f"sport = :{taken[1]}" in str(refused.value)
    udp.opened([Wire(NAVDATA, other)])[0].close()
