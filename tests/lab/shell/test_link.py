"""All ports of one side: in which order, what wakes, and what becomes of what cannot be sent. Real sockets."""

import time

import pytest

from fledge.lab.shell.link import Link
from fledge.lab.shell.udp import UdpPort, Wire
from fledge.lab.wire.datagrams import AT, NAVDATA, VICON, Datagram

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


def test_arrivals_of_all_ports_are_in_order(opened):
    a, b = opened(VICON, HERE), opened(NAVDATA, HERE)
    to_a, to_b = opened(AT, there=a.address), opened(AT, there=b.address)
    order = [to_b, to_a, to_a, to_b, to_a]
    for i, port in enumerate(order):
        port.send(Datagram(AT, bytes([i])))
    with Link([a, b]) as link:
        arrivals = link.receive()
    assert [arrival.datagram.data for arrival in arrivals] == [bytes([i]) for i in range(5)]
    assert [arrival.at for arrival in arrivals] == sorted(arrival.at for arrival in arrivals)


def test_nobody_at_the_other_end_raises_nothing_and_is_counted(opened):
    gone = opened(AT, HERE)
    mouth = UdpPort(Wire(AT, there=gone.address))
    gone.close()
    with Link([mouth]) as link:
        for _ in range(4):
            link.send([Datagram(AT, b"?")])
            assert link.receive() == []
        link.send([Datagram("/cmd_vel", b"no such wire")])
    assert link.lost[AT] > 0 and link.lost["/cmd_vel"] == 1


def test_who_waits_is_woken_by_what_it_waits_for_alone(opened):
    poses, others = opened(VICON, HERE), opened(NAVDATA, HERE)
    link = Link([poses, others], (VICON,))
    opened(AT, there=others.address).send(Datagram(AT, b"not this"))
    began = time.monotonic_ns()
    assert not link.wait(began + 30_000_000)
    assert time.monotonic_ns() - began >= 29_000_000
    opened(AT, there=poses.address).send(Datagram(AT, b"this"))
    assert link.wait(time.monotonic_ns() + 10**9)
    assert not Link([others]).wait(time.monotonic_ns() + 1_000_000)


def test_what_is_wrong_with_a_transport_is_passed_on(opened):
    port, other = opened(VICON, HERE), opened(NAVDATA, HERE)
    assert Link([port, other]).complaint == ""
    other.complaint = "the master does not answer"
    assert Link([port, other]).complaint == "the master does not answer"
