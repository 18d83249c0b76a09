"""The firmware: phases, orders, silence, configuration; each by the lines a client would send."""

import pytest

from fledge.geometry import Vec3
from fledge.lab.twin.firmware import Firmware, Phase, Settings
from fledge.lab.twin.senses import Sensed
from fledge.lab.wire import ardrone
from fledge.lab.wire.ardrone import Comwdg, Config, Ctrl, Flag, Ftrim, Mode, Pcmd, Ref

F = Firmware()
TICK = 0.01
TAKE_OFF, LAND, CUT = Ref(fly=True), Ref(fly=False), Ref(fly=False, emergency=True)


def sensed(altitude=1.0, upright=1.0):
    return Sensed(0.0, 0.0, Vec3(0.0, 0.0, 0.0), 0.0, 0.0, 0.0, altitude, 0.0, upright)


class Clocked:
    """A firmware over time: lines in, wishes out."""

    def __init__(self, memory=None):
        self.memory = F.init(0.0) if memory is None else memory
        self.t, self.sequence, self.wish = 0.0, 1, None

    def tick(self, *commands, altitude=1.0, upright=1.0):
        data = [ardrone.encode(self.sequence, *commands)] if commands else []
        self.sequence += len(commands)
        self.memory = F.hear(self.memory, self.t, data)
        self.memory, self.wish = F.decide(self.memory, self.t, sensed(altitude, upright))
        self.t += TICK
        return self

    def go_on(self, seconds, *commands, **state):
        for _ in range(round(seconds / TICK)):
            self.tick(*commands, **state)
        return self

    @property
    def phase(self):
        return self.memory.phase


def flying():
    return Clocked(F.aloft(0.0)).tick(TAKE_OFF)


def test_a_flight_from_floor_to_floor():
    drone = Clocked().go_on(0.5, LAND, altitude=0.0)
    assert drone.phase == Phase.LANDED and not drone.wish.motors
    drone.tick(TAKE_OFF, altitude=0.0)
    assert drone.phase == Phase.SPINNING and drone.wish.motors and not drone.wish.lifted
    drone.go_on(F.spin_up + 0.05, TAKE_OFF, altitude=0.0)
    assert drone.phase == Phase.TAKING_OFF and drone.wish.height == F.height
    drone.tick(TAKE_OFF, altitude=0.95)
    assert drone.phase == Phase.FLYING
    drone.tick(LAND, altitude=0.9)
    assert drone.phase == Phase.LANDING and drone.wish.climb < 0.0
    drone.go_on(0.1, LAND, altitude=0.02)
    assert drone.phase == Phase.LANDING  # it makes sure
    drone.go_on(0.2, LAND, altitude=0.02)
    assert drone.phase == Phase.LANDED and not drone.wish.motors


def test_take_off_ends_sometime_even_where_the_altitude_is_never_right():
    drone = Clocked().go_on(F.spin_up + F.patience + 0.1, TAKE_OFF, altitude=0.5)
    assert drone.phase == Phase.FLYING


def test_a_landing_is_completed():
    drone = flying().tick(LAND).go_on(1.0, TAKE_OFF)
    assert drone.phase == Phase.LANDING
    drone.go_on(0.3, TAKE_OFF, altitude=0.0)
    assert drone.phase == Phase.SPINNING  # and then the order stands


def test_a_tilt_is_a_share_of_what_is_allowed_with_the_signs_of_the_wire():
    wish = flying().tick(Pcmd(roll=0.5, pitch=-1.0, gaz=1.0, yaw=0.5)).wish
    assert not wish.hover
    assert wish.roll == pytest.approx(0.105)  # right side down, about x
    assert wish.pitch == pytest.approx(0.21)  # nose down, about y
    assert wish.climb == pytest.approx(0.7)
    assert wish.turn == pytest.approx(-0.875)  # clockwise


def test_without_the_flag_the_shares_mean_nothing():
    wish = flying().tick(Pcmd(1.0, 1.0, 1.0, 1.0, Flag(0))).wish
    assert wish.hover and (wish.climb, wish.turn) == (0.0, 0.0)


def test_it_obeys_no_pcmd_before_it_has_taken_off():
    drone = Clocked().go_on(F.spin_up + 0.2, TAKE_OFF, Pcmd(1.0, 0.0, 0.0, 0.0), altitude=0.1)
    assert drone.phase == Phase.TAKING_OFF and drone.wish.hover


def test_fifty_milliseconds_of_silence_are_borne_and_more_are_not():
    drone = flying().tick(Comwdg(), Pcmd(0.0, -1.0, 0.0, 0.0))
    drone.go_on(0.05)
    assert not drone.wish.hover and not drone.memory.watchdog
    drone.tick()
    assert drone.wish.hover and drone.memory.watchdog


def test_the_watchdog_is_reported_until_it_is_answered():
    drone = flying().go_on(0.1)
    drone.tick(Pcmd(0.0, -1.0, 0.0, 0.0))
    assert drone.memory.watchdog and not drone.wish.hover  # clients that never answer are obeyed all the same
    drone.tick(Comwdg())
    assert not drone.memory.watchdog


def test_after_a_silence_lines_are_counted_from_the_start():
    drone = flying().tick(Pcmd.hover())
    drone.sequence = 2
    assert drone.tick(Pcmd(0.0, 1.0, 0.0, 0.0)).wish.hover  # number 2 is long gone
    drone.go_on(0.1)
    drone.sequence = 2
    assert not drone.tick(Pcmd(0.0, 1.0, 0.0, 0.0)).wish.hover


def test_a_line_that_comes_late_is_not_obeyed():
    drone = flying().tick(Pcmd.hover(), Pcmd.hover(), Pcmd.hover())
    drone.sequence = 3
    assert drone.tick(Pcmd(0.0, 1.0, 0.0, 0.0)).wish.hover


def test_two_seconds_of_silence_and_it_lands():
    drone = flying().go_on(F.lost)
    assert drone.phase == Phase.FLYING and drone.wish.hover
    drone.go_on(0.05)
    assert drone.phase == Phase.LANDING and drone.memory.lost
    drone.tick(TAKE_OFF)
    assert not drone.memory.lost and drone.phase == Phase.LANDING


def test_after_a_landing_of_its_own_it_has_to_be_told_to_land_before_it_flies_again():
    drone = flying().go_on(F.lost + 0.1).go_on(0.5, altitude=0.0)
    assert drone.phase == Phase.LANDED
    drone.go_on(1.0, TAKE_OFF, altitude=0.0)
    assert drone.phase == Phase.LANDED
    assert drone.tick(LAND, altitude=0.0).tick(TAKE_OFF, altitude=0.0).phase == Phase.SPINNING


def test_an_emergency_cuts_the_motors_once_and_the_next_one_ends_it():
    drone = flying().tick(CUT)
    assert drone.phase == Phase.EMERGENCY and not drone.wish.motors
    drone.go_on(0.5, CUT, altitude=0.0)
    assert drone.phase == Phase.EMERGENCY  # held down is not pressed again
    drone.tick(LAND, altitude=0.0).tick(CUT, altitude=0.0)
    assert drone.phase == Phase.LANDED
    assert drone.tick(TAKE_OFF, altitude=0.0).phase == Phase.LANDED  # not before "land"
    assert drone.tick(LAND, altitude=0.0).tick(TAKE_OFF, altitude=0.0).phase == Phase.SPINNING


def test_whoever_falls_over_cuts_the_motors():
    drone = flying().tick(TAKE_OFF, upright=0.4)
    assert drone.phase == Phase.EMERGENCY and drone.memory.tumbled and not drone.wish.motors


def test_level_is_told_on_the_floor_only():
    assert Clocked().tick(Ftrim(), altitude=0.0).memory.trimmed == 1
    assert flying().tick(Ftrim()).memory.trimmed == 0


@pytest.mark.parametrize(
    ("key", "value", "settings"),
    (
        ("control:euler_angle_max", "0.1", Settings(euler_angle_max=0.1)),
        ("control:control_vz_max", "1000", Settings(control_vz_max=1.0)),
        ("control:control_yaw", "3.0", Settings(control_yaw=3.0)),
        ("control:altitude_max", "2500", Settings(altitude_max=2.5)),
        ("control:euler_angle_max", "9", Settings()),
        ("control:euler_angle_max", "nan", Settings()),
        ("control:euler_angle_max", "much", Settings()),
        ("leds:leds_anim", "3,1073741824,2", Settings()),
    ),
)
def test_the_configuration_is_taken_where_it_makes_sense_and_always_acknowledged(key, value, settings):
    drone = Clocked().tick(Config(key, value), altitude=0.0)
    assert drone.memory.settings == settings
    assert drone.memory.ack
    assert not drone.tick(Ctrl(Mode.CLEAR_ACKNOWLEDGEMENT), altitude=0.0).memory.ack


@pytest.mark.parametrize(("value", "demo"), (("TRUE", True), ("FALSE", False), ("1", True), ("0", False)))
def test_navdata_are_short_or_long_as_configured(value, demo):
    assert Clocked().memory.demo is None
    assert Clocked().tick(Config("general:navdata_demo", value)).memory.demo is demo


def test_it_climbs_no_higher_than_it_may():
    drone = flying().tick(Pcmd(0.0, 0.0, 1.0, 0.0), altitude=3.1)
    assert drone.wish.climb == 0.0
    assert drone.tick(Pcmd(0.0, 0.0, -1.0, 0.0), altitude=3.1).wish.climb < 0.0


def test_an_empty_battery_lands_and_keeps_it_down():
    drone = flying()
    drone.memory = drone.memory._replace(battery=0.04)
    assert drone.tick(TAKE_OFF).phase == Phase.LANDING
    drone.go_on(0.5, TAKE_OFF, altitude=0.0)
    assert drone.phase == Phase.LANDED


def test_hovering_empties_the_battery_in_its_time():
    memory = F.aloft(0.0)
    for _ in range(100):
        memory = F.drain(memory, 1.0, F.endurance / 200.0)
    assert memory.battery == pytest.approx(0.5, abs=0.02)
    assert F.drain(memory, 1.0, 10.0 * F.endurance).battery == 0.0


@pytest.mark.parametrize("data", (b"", b"\xff\x00rubbish\r", b"AT*REF=1,290718208", b"AT*FLY=1\r"))
def test_what_is_no_command_changes_nothing(data):
    before = F.init(0.0)
    assert F.hear(before, 0.0, [data]) == before
