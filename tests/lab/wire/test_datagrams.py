"""Datagrams: that two channels are never taken for one."""

from fledge.lab.wire import datagrams


def test_every_wire_has_a_name_of_its_own_and_none_is_a_topic():
    names = [datagrams.VICON, datagrams.AT, datagrams.NAVDATA, datagrams.STICKS]
    assert len(set(names)) == len(names)
    assert not any(name.startswith("/") for name in names)
