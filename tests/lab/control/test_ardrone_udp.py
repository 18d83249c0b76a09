"""What an AR.Drone is told over UDP, and what becomes of what it says."""

import pytest

from fledge.geometry import Vec3
from fledge.lab.control.ardrone_udp import ACKNOWLEDGED_WITHIN, REVIVE_EVERY, SILENCE, ArDroneUdp, entries
from fledge.lab.control.tilt import Tilt
from fledge.lab.control.vehicle import Orders
from fledge.lab.wire import ardrone, navdata
from fledge.lab.wire.ardrone import FIRST, INT32, Comwdg, Config, Ctrl, Ftrim, Mode, Pcmd, Ref
from fledge.lab.wire.datagrams import AT, NAVDATA, STICKS, Datagram
from fledge.lab.wire.navdata import ControlState, Demo, Navdata, State

TICK = 0.01
CONFIGURATION = entries(Tilt(), 4.0)
UDP = ArDroneUdp(CONFIGURATION)
STILL = Vec3(0.0, 0.0, 0.0)


def demo(control=ControlState.LANDED, battery=0.8):
    return Demo(control, battery, 0.0, 0.0, 0.0, 0.0, STILL)


class Wire:
    """The two ends of it; the drone says something every tick, if it says anything."""

    def __init__(self, udp=UDP):
        self.udp, self.memory, self.t = udp, udp.init(), 0.0
        self.number, self.sequences = 0, []

    def tick(self, *said: Datagram, orders=Orders()):
        """(the AT commands of a tick, whether the drone was woken)."""
        self.t = round(self.t + TICK, 9)
        for datagram in said:
            self.memory = self.udp.hear(self.memory, self.t, datagram)
        self.memory, datagrams = self.udp.say(self.memory, self.t, orders)
        woken = [one for one in datagrams if one.channel == NAVDATA]
        (at,) = (one for one in datagrams if one.channel == AT)
        lines = ardrone.decode(at.data)
        self.sequences += [line.sequence for line in lines]
        return [line.command for line in lines], bool(woken)

    def says(self, state=State(0), what=demo(), number=None) -> Datagram:
        self.number = self.number + 1 if number is None else number
        return Datagram(NAVDATA, navdata.encode(Navdata(self.number, state, what)))

    def configure(self):
        """Until all is taken."""
        state = State(0)
        for _ in range(100):
            commands, _ = self.tick(self.says(state))
            if any(isinstance(one, Config) for one in commands):
                state = State.COMMAND_ACK
            if any(isinstance(one, Ctrl) for one in commands):
                state = State(0)
        return self


def test_every_tick_says_ref_and_pcmd_with_numbers_that_count_up():
    wire = Wire()
    for _ in range(50):
        commands, _ = wire.tick(orders=Orders(fly=True, tilt=Pcmd(0.1, 0.2, 0.3, 0.4)))
        assert commands[-2] == Ref(fly=True)
        assert commands[-1].gaz == pytest.approx(0.3)
    assert wire.sequences == list(range(FIRST, FIRST + len(wire.sequences)))


def test_numbers_begin_anew_before_they_leave_the_wire():
    wire = Wire()
    wire.memory = wire.memory._replace(sequence=INT32 - 3)
    for _ in range(4):
        wire.tick()
    assert wire.sequences == [
        INT32 - 3,
        INT32 - 2,
        FIRST,
        FIRST + 1,
        FIRST + 2,
        FIRST + 3,
        FIRST + 4,
        FIRST + 5,
    ]


def test_a_silent_drone_is_woken_now_and_then_and_a_speaking_one_is_not():
    wire = Wire()
    assert 5 <= sum(wire.tick()[1] for _ in range(100)) <= 11
    assert not any(wire.tick(wire.says())[1] for _ in range(100))
    woken = [wire.tick()[1] for _ in range(100)]
    assert not any(woken[: round(SILENCE / TICK) - 1]) and any(woken)


def test_the_configuration_goes_out_one_entry_after_the_other_each_acknowledged():
    wire, sent, state, since = Wire(), [], State.BOOTSTRAP, 0
    while not wire.memory.report.configured:
        commands, _ = wire.tick(wire.says(state, None if not sent else demo()))
        for command in commands:
            if isinstance(command, Config):
                assert state & State.COMMAND_ACK == 0
                sent.append(command)
                since = 3  # ticks until the drone says that it has heard
            if command == Ctrl(Mode.CLEAR_ACKNOWLEDGEMENT):
                state = State(0)
        since -= 1
        if since == 0:
            state = State.COMMAND_ACK
        assert wire.t < 5.0
    assert tuple(sent) == CONFIGURATION
    assert sent[0] == Config("general:navdata_demo", "TRUE")
    assert Config("control:euler_angle_max", "0.21") in sent
    assert Config("control:altitude_max", "4000") in sent


def test_an_entry_that_got_lost_is_sent_again():
    wire = Wire()
    sent = [wire.t for _ in range(200) for one in wire.tick(wire.says())[0] if isinstance(one, Config)]
    assert len(sent) == 4
    assert min(b - a for a, b in zip(sent, sent[1:], strict=False)) >= ACKNOWLEDGED_WITHIN


def test_a_drone_that_starts_again_is_configured_again():
    wire = Wire().configure()
    assert wire.memory.report.configured
    for _ in range(100):
        wire.tick(wire.says())
    commands, _ = wire.tick(wire.says(State.BOOTSTRAP, None))
    assert not wire.memory.report.configured
    assert CONFIGURATION[0] in commands


def test_its_watchdog_is_answered_its_level_told():
    wire = Wire().configure()
    commands, _ = wire.tick(wire.says(State.COM_WATCHDOG))
    assert commands[0] == Comwdg()
    commands, _ = wire.tick(wire.says(), orders=Orders(trim=True))
    assert commands[0] == Ftrim()
    commands, _ = wire.tick(wire.says())
    assert [type(one) for one in commands] == [Ref, Pcmd]


def test_to_cut_is_one_press_however_often_it_is_said():
    """The bit is set and stays set: a second press would give the motors back."""
    wire = Wire().configure()
    refs = [wire.tick(wire.says(State.EMERGENCY), orders=Orders(cut=True))[0][-2] for _ in range(300)]
    assert all(ref == Ref(fly=False, emergency=True) for ref in refs)


def test_to_revive_is_a_press_a_second_as_long_as_the_drone_says_that_it_is_dead():
    wire = Wire().configure()
    orders = Orders(revive=True)
    pressed = [
        wire.t for _ in range(350) if wire.tick(wire.says(State.EMERGENCY), orders=orders)[0][-2].emergency
    ]
    assert len(pressed) == 4
    assert min(b - a for a, b in zip(pressed, pressed[1:], strict=False)) >= REVIVE_EVERY
    assert not any(wire.tick(wire.says(), orders=orders)[0][-2].emergency for _ in range(200))
    # Nor on old news: it may have been revived since.
    wire.tick(wire.says(State.EMERGENCY))
    wire.t += 5.0
    assert not any(wire.tick(orders=orders)[0][-2].emergency for _ in range(200))


def test_what_it_says_of_itself_is_reported():
    wire = Wire().configure()
    wire.tick(wire.says(what=demo(ControlState.HOVERING, 0.42)))
    report = wire.memory.report
    assert (report.heard, report.control, report.battery) == (wire.t, ControlState.HOVERING, 0.42)
    assert report.configured and report.steady
    wire.tick(wire.says(State.EMERGENCY, demo(ControlState.HOVERING)))
    assert wire.memory.report.emergency and not wire.memory.report.aloft


def test_old_and_garbled_navdata_and_those_of_others_say_nothing():
    wire = Wire().configure()
    before = wire.memory.report
    low = demo(battery=0.01)
    for datagram in (
        wire.says(what=low, number=3),
        Datagram(NAVDATA, b"\x88\x77\x66\x55"),
        Datagram(NAVDATA, wire.says(what=low).data[:-1] + b"\x00"),
        Datagram(STICKS, wire.says(what=low).data),
    ):
        wire.tick(datagram)
        assert wire.memory.report == before
    wire.t += SILENCE + TICK  # after a silence it may have started again, and counts from one
    wire.tick(wire.says(what=low, number=1))
    assert wire.memory.report.battery == 0.01
