"""Whole flights of the controller, through the real bytes, against a lab of point masses."""

import struct
from dataclasses import dataclass, replace
from math import hypot, inf, nan

import numpy as np
import pytest
from flown import Flight, Spoil, flying, into, over_ros, over_udp, ready
from standin import FLOOR, Lab

from fledge.geometry import Vec3
from fledge.lab.control.phases import Phase, Phases
from fledge.lab.wire.ardrone import Ftrim, Pcmd, Ref
from fledge.lab.wire.datagrams import NAVDATA, STICKS, VICON, Datagram, Heard
from fledge.lab.wire.navdata import ControlState
from fledge.lab.wire.vicon import ITEM, OBJECT
from fledge.learning.policy import Policy
from fledge.observation import OBSERVATION_NAMES, Action
from fledge.pilots import AbstractPilot, Servo
from fledge.safety.turns import Memory as NetMemory
from fledge.supervision.inputs import Operator
from fledge.supervision.modes import Mode
from fledge.world import Reason, VelocityCommand

pytestmark = pytest.mark.slow

P, M = Phase, Mode


@dataclass(frozen=True, slots=True)
class Reckless(AbstractPilot):
    """Full stick to the east, always."""

    name = "reckless"

    def act(self, memory, observation, noise):
        return memory, Action(1.0, 0.0, 0.0, 0.0)


# A flight.


def test_a_flight_from_the_pad_to_the_floor_with_a_person_s_hand_in_between():
    flight = ready()
    ground = flight.lab.air.position
    assert flight.lab.control is ControlState.LANDED
    assert flight.lab.configured["control:euler_angle_max"] == "0.21"
    flight.until(P.CLIMB, arm=1.0)
    assert 0.8 < flight.lab.air.position.z < 1.2
    flight.until(P.JOIN)
    assert abs(flight.lab.air.position.z - 374.7 * 0.75 / 108.0) < 0.12
    assert hypot(flight.lab.air.position.x - ground.x, flight.lab.air.position.y - ground.y) < 0.15
    flight.until(P.FLY).go(1.0)
    errors = []
    for _ in range(2000):
        flight.tick()
        errors.append(flight.off)
    assert flight.lab.way > 3.0  # the UGVs have moved
    assert np.sqrt(np.mean(np.square(errors))) < 0.2
    assert flight.mode in (M.AUTO, M.SHIELDED)

    before = flight.lab.air.position
    away = VelocityCommand(*flight.lab.air.heading.from_world(0.3, 0.0), 0.2, 0.0)
    flight.go(3.0, command=away, deflection=0.5)
    assert (flight.mode, flight.last.phase) == (M.MANUAL, P.CLIMB)
    assert flight.lab.air.position.x - before.x > 0.6
    assert flight.lab.air.position.z - before.z > 0.3
    flight.go(1.0, command=VelocityCommand.hover(), deflection=0.0)
    flight.go(0.2, hand_back=1.0)
    assert flight.mode is M.RECOVER
    flight.until(P.FLY, hand_back=0.0).go(3.0)
    assert flight.mode is M.AUTO and flight.off < 0.3

    flight.go(0.2, land=1.0)
    assert (flight.mode, flight.last.phase) == (M.LAND, P.LAND)
    flight.until(P.OVER, within=90.0, land=0.0)
    assert flight.lab.control is ControlState.LANDED
    assert flight.lab.air.position.z < FLOOR + 0.02
    flight.go(3.0, arm=0.0).go(3.0, arm=1.0)
    assert flight.last.phase is P.OVER  # a run is one flight
    assert flight.lab.control is ControlState.LANDED


def test_whatever_the_pilot_wants_it_stays_clear_of_walls_and_vehicles():
    flight = flying()
    flight.controller = over_udp(Reckless(), phases=Phases(lost=inf))
    held = 0
    for _ in range(1000):
        said = flight.tick()
        held += said.decisions[0].verdict.intervened > 0.5
        p = flight.lab.air.position
        assert abs(p.x) < 3.3 - 0.26 and abs(p.y) < 2.5 - 0.26
        assert 1.0 < p.z < 4.0
    assert held > 100
    assert {Reason(int(said.decisions[0].verdict.reason)) for said in flight.saids} >= {Reason.WALL}


def test_a_network_flies_on_numpy_and_what_it_says_is_plain_numbers():
    """One that goes by where the centroid is: a servo, as a matrix."""
    names, weights = list(OBSERVATION_NAMES), np.zeros((11, 4), np.float32)
    weights[names.index("ugv_v"), 0] = weights[names.index("ugv_u"), 1] = -0.01
    zero, one = np.zeros(11, np.float32), np.ones(11, np.float32)
    centre = zero.copy()
    centre[names.index("ugv_u")], centre[names.index("ugv_v")] = 320.0, 180.0
    network = Policy((weights,), (np.zeros(4, np.float32),), centre, one, tuple(range(11)), 11)
    flight = flying()
    flight.controller = over_udp(network)
    flight.go(10.0)
    assert flight.last.phase is P.FLY and flight.off < 0.3
    a = flight.last.action
    assert {type(x) for x in (a.forward, a.left, a.up, a.turn)} == {float}


def test_nobody_there_and_allowed_to_it_arms_flies_and_lands_by_itself():
    controller = over_udp(Servo(), unattended=True, phases=Phases(duration=5.0))
    flight = Flight(controller, says=None)
    flight.until(P.FLY).until(P.LAND).until(P.OVER, within=90.0).go(5.0)
    assert flight.lab.control is ControlState.LANDED
    assert flight.last.phase is P.OVER
    assert M.AUTO not in {Mode(int(said.decisions[0].mode)) for said in flight.saids[-400:]}


def test_who_speaks_up_in_an_unattended_flight_is_obeyed():
    flight = Flight(over_udp(Servo(), unattended=True), says=None).until(P.FLY)
    flight.says = Operator(land=1.0)
    flight.go(0.2)
    assert flight.mode is M.LAND


def test_over_ros_the_ugvs_are_driven_too_and_behind_the_net():
    controller, lab = over_ros(Servo())
    flight = Flight(controller, lab)
    flight.go(2.5)
    assert flight.last.complaint == ""
    flight.until(P.FLY, arm=1.0)
    assert all(Mode(int(one.mode)) in (M.AUTO, M.SHIELDED) for one in flight.last.decisions)
    begin, errors = lab.ugvs, []
    for _ in range(1500):
        flight.tick()
        errors.append(flight.off)
    assert max(hypot(a[0] - b[0], a[1] - b[1]) for a, b in zip(begin, lab.ugvs, strict=True)) > 0.5
    assert np.sqrt(np.mean(np.square(errors))) < 0.2
    sent = [command.forward for command in lab.driven]
    assert sent == pytest.approx([one.verdict.command.forward for one in flight.saids[-2].decisions[1:]])
    flight.until(P.OVER, within=90.0, land=1.0)
    assert lab.control is ControlState.LANDED
    assert all(abs(robot.speed) < 0.01 for robot in lab.robots)


# Before it.


def test_without_an_operator_nothing_takes_off():
    flight = Flight(says=None).go(5.0)
    assert "no operator" in flight.last.complaint
    assert flight.mode is M.INIT
    flight.says = Operator()
    flight.go(1.5)
    assert (flight.mode, flight.last.complaint) == (M.READY, "")


def test_who_arms_too_early_has_to_arm_again():
    flight = Flight(says=Operator(arm=1.0)).go(5.0)
    assert flight.last.phase is P.WAIT and flight.lab.control is ControlState.LANDED
    flight.go(1.5, arm=0.0).until(P.TAKE_OFF, within=0.2, arm=1.0)


def test_who_arms_while_something_is_missing_has_to_arm_again():
    flight = ready()
    flight.lab.speaks = False
    flight.go(1.0)
    assert "does not answer" in flight.last.complaint
    flight.go(1.0, arm=1.0)
    flight.lab.speaks = True
    flight.go(3.0)
    assert flight.last.complaint == "" and flight.last.phase is P.WAIT
    flight.go(1.5, arm=0.0).until(P.TAKE_OFF, within=0.2, arm=1.0)


def test_before_take_off_the_drone_is_told_that_it_stands_level():
    flight = ready().until(P.CLIMB, arm=1.0)
    commands = [line.command for line in flight.lab.heard]
    first = commands.index(Ref(fly=True))
    assert Ftrim() in commands[:first] and Ftrim() not in commands[first:]


def test_who_disarms_on_the_ground_waits_again():
    flight = ready().until(P.TAKE_OFF, arm=1.0)
    flight.go(0.12, arm=0.0)
    assert flight.last.phase is P.WAIT
    assert not flight.lab.ref.fly


def test_a_drone_in_an_emergency_is_made_ready():
    lab = Lab()
    lab.emergency = True
    flight = Flight(lab=lab).go(1.0)
    assert "emergency" in flight.last.complaint or not lab.emergency
    flight.go(3.0)
    assert not lab.emergency and flight.last.complaint == ""


def test_a_low_battery_keeps_it_on_the_ground_and_brings_it_down():
    flight = Flight(lab=Lab(battery=0.15)).go(3.0, arm=0.0).go(1.0, arm=1.0)
    assert "battery" in flight.last.complaint and flight.last.phase is P.WAIT
    flight = flying()
    flight.lab.battery = 0.15
    flight.go(0.3)
    assert (flight.mode, flight.last.phase) == (M.LAND, P.LAND)


# What a person says counts in every phase.

IN_FLIGHT = (P.TAKE_OFF, P.CLIMB, P.JOIN, P.FLY)


@pytest.mark.parametrize("phase", IN_FLIGHT)
def test_a_person_can_land_it_in_every_phase(phase):
    flight = into(phase)
    flight.go(0.2, land=1.0)
    assert flight.last.phase in (P.LAND, P.OVER)
    flight.until(P.OVER, within=90.0)
    assert flight.lab.control is ControlState.LANDED


@pytest.mark.parametrize("phase", IN_FLIGHT)
def test_a_person_can_terminate_it_in_every_phase(phase):
    flight = into(phase)
    flight.go(0.2, terminate=1.0)
    assert (flight.mode, flight.last.phase) == (M.TERMINATED, P.OVER)
    assert flight.lab.emergency
    flight.go(5.0, terminate=0.0)
    assert flight.lab.emergency  # for good


@pytest.mark.parametrize("phase", [P.CLIMB, P.JOIN, P.FLY])
def test_a_person_can_stop_it_in_every_phase_of_the_air(phase):
    flight = into(phase)
    flight.go(2.0, stop=1.0)
    assert flight.mode is M.STOPPED
    place = flight.lab.air.position
    flight.go(3.0, stop=0.0)
    moved = flight.lab.air.position - place
    assert hypot(moved.x, moved.y) < 0.1 and abs(moved.z) < 0.1
    assert flight.lab.told.flags  # by our own loop, over poses


@pytest.mark.parametrize("phase", [P.CLIMB, P.JOIN, P.FLY])
def test_a_person_can_take_over_in_every_phase_of_the_air(phase):
    flight = into(phase)
    flight.go(1.0, switch=1.0, command=VelocityCommand(0.0, 0.0, 0.0, 0.4))
    assert flight.mode is M.MANUAL
    yaw = flight.lab.air.yaw
    flight.go(1.0)
    assert flight.lab.air.yaw - yaw == pytest.approx(0.4, rel=0.1)


def test_a_person_who_falls_silent_is_missed():
    flight = flying()
    flight.says = None
    flight.go(12.0)
    assert flight.last.phase in (P.LAND, P.OVER)
    assert flight.reasons(3.0) == {Reason.LINK_LOST}


# Faults.


def without_poses(begin: float, end: float) -> Spoil:
    return lambda t, came: tuple(one for one in came if one.channel != VICON or not begin <= t < end)


@pytest.mark.parametrize(
    ("seconds", "modes", "named"),
    [
        (0.1, {M.AUTO, M.SHIELDED}, {Reason.STALE}),
        (0.7, {M.AUTO, M.SHIELDED, M.HOLD, M.RECOVER}, {Reason.STALE}),
        (2.5, {M.AUTO, M.SHIELDED, M.HOLD, M.LAND, M.INIT, M.READY}, {Reason.STALE}),
    ],
)
def test_a_pause_of_the_cameras_brakes_holds_and_lands(seconds, modes, named):
    flight = flying()
    flight.spoil = without_poses(flight.lab.t, flight.lab.t + seconds)
    begin, place = len(flight.saids), flight.lab.air.position
    flight.go(4.0)
    assert {Mode(int(said.decisions[0].mode)) for said in flight.saids[begin:]} <= modes
    assert flight.reasons(4.0) - {Reason.POLICY_LATE} <= named
    moved = flight.lab.air.position - place
    assert hypot(moved.x, moved.y) < 1.0
    if seconds < 1.0:
        assert flight.go(2.0).mode in (M.AUTO, M.SHIELDED)


def test_late_poses_do_not_make_it_swing():
    flight, waiting = flying(), []

    def late(t, came):
        waiting.append([one for one in came if one.channel == VICON])
        others = tuple(one for one in came if one.channel != VICON)
        return others + (tuple(waiting.pop(0)) if len(waiting) > 30 else ())

    flight.spoil = late
    fastest = 0.0
    for i in range(500):
        flight.tick()
        v = flight.lab.air.velocity
        fastest = max(fastest, hypot(v.x, v.y)) if i > 150 else fastest
    assert flight.mode is M.HOLD
    assert fastest < 0.05


def test_a_jump_brakes_then_stops_it_and_two_that_swap_names_hold_it():
    flight = flying()
    flight.lab.spoil = lambda frame: with_object(frame, 0, lambda one: one.position + Vec3(0.5, 0.0, 0.0))
    flight.go(2.0)
    assert flight.mode is M.STOPPED
    assert Reason.JUMP in flight.reasons(2.0)

    flight = flying()
    flight.lab.spoil = swapped
    flight.go(0.9)
    assert flight.mode is M.HOLD
    assert flight.saids[-1].decisions[1].alarm.reason == Reason.SWAP


def with_object(frame, i, place):
    objects = list(frame.objects)
    objects[i] = replace(objects[i], position=place(objects[i]))
    return replace(frame, objects=tuple(objects))


def swapped(frame):
    """The first two UGVs under each other's names."""
    uav, a, b, c = frame.objects
    return replace(frame, objects=(uav, replace(a, name=b.name), replace(b, name=a.name), c))


def first_x(data: bytes, x: float) -> bytes:
    """A Vicon datagram whose first object is there."""
    at = 5 + ITEM.size + 24
    assert OBJECT.size == 72
    return data[:at] + struct.pack("<d", x) + data[at + 8 :]


@pytest.mark.parametrize("x", [nan, 2e9])
def test_a_pose_that_is_no_number_or_in_other_units_is_not_flown_by(x):
    flight = flying()
    flight.spoil = lambda t, came: tuple(
        Datagram(VICON, first_x(one.data, x)) if one.channel == VICON else one for one in came
    )
    flight.go(0.3)
    assert flight.reasons(0.3) == {Reason.BAD_POSE}
    assert not flight.lab.told.flags  # the drone's own hover
    flight.spoil = lambda t, came: came
    assert flight.go(2.0).mode in (M.AUTO, M.SHIELDED)


def test_a_vehicle_that_falls_silent_is_held_and_said_to_be():
    flight = flying()
    flight.lab.speaks = False
    flight.go(3.0)
    assert flight.mode is M.HOLD
    assert "said nothing" in flight.last.complaint
    flight.lab.speaks = True
    assert flight.go(3.0).mode is M.AUTO


def test_a_drone_that_lands_by_itself_is_not_sent_up_again():
    flight = flying()
    flight.lab.give_up()
    flight.until(P.LAND, within=0.2).until(P.OVER).go(5.0)
    assert flight.lab.control is ControlState.LANDED
    assert not flight.lab.ref.fly


def test_a_process_that_was_stopped_for_three_seconds_holds_and_goes_on():
    flight, held = flying(), []
    for _ in range(300):
        held += flight.lab.tick(())
    flight.memory, said = flight.controller.step(flight.memory, Heard(flight.lab.t, tuple(held)))
    assert Mode(int(said.decisions[0].mode)) in (M.HOLD, M.AUTO, M.SHIELDED)
    flight.go(4.0)
    assert flight.mode in (M.AUTO, M.SHIELDED) and flight.off < 0.6


def test_garbage_on_every_wire_does_nothing_at_all():
    rng = np.random.default_rng(5)
    channels = (
        VICON,
        NAVDATA,
        STICKS,
        "at",
        "/joy",
        "/cmd_vel",
        "/ardrone/navdata",
        "/vicon/ardrone/ardrone",
        "?",
    )

    def noisy(t, came):
        garbage = (Datagram(str(c), rng.bytes(rng.integers(0, 300))) for c in rng.choice(channels, 5))
        return (*came, *garbage)

    clean, dirty = flying(), flying()
    dirty.spoil = noisy
    assert [said.datagrams for said in clean.go(3.0).saids] == [
        said.datagrams for said in dirty.go(3.0).saids
    ]


# What it is.


def test_the_same_heard_twice_says_the_same_bytes():
    flight = ready().until(P.FLY, arm=1.0).go(1.0)
    memory, again = flight.controller.init(), []
    for heard in flight.heards:
        memory, said = flight.controller.step(memory, heard)
        again.append(said)
    assert [said.datagrams for said in again] == [said.datagrams for said in flight.saids]
    assert again == flight.saids
    assert memory == flight.memory


def test_the_net_is_told_what_was_really_sent():
    flight, spoken = into(P.TAKE_OFF), 0
    net = flight.memory.supervision.net
    assert isinstance(net, NetMemory)
    assert {axis.newest[0] for axis in net.uav.sent} == {0.0}  # nothing: the firmware takes off by itself
    flight, done = into(P.JOIN), [[], [], []]
    for _ in range(200):
        said = flight.tick()
        for ways, ugv in zip(done, said.world.ugvs, strict=True):
            ways.append((ugv.speed, -ugv.speed, ugv.turn_rate, -ugv.turn_rate))
        net, command = flight.memory.supervision.net, said.decisions[0].verdict.command
        x, y = (
            flight.memory.supervision.watch
            .tracks[0]
            .trusted.attitude.heading()
            .to_world(command.forward, command.left)
        )
        sent = (axis.newest[0] for axis in net.uav.sent)
        assert tuple(sent) == pytest.approx((x, y, command.up), abs=1e-9)
        spoken += command != VelocityCommand.hover()
    assert spoken > 150
    # UGVs that are not ours count as told what they do.
    for ways, told in zip(done, net.ugvs, strict=True):
        for now, most, held in zip(ways[-1], map(max, zip(*ways, strict=True)), told, strict=True):
            assert now <= held.most <= max(most, 0.0)


def test_over_udp_only_the_uav_is_commanded():
    flight = flying().go(1.0)
    assert {one.channel for said in flight.saids for one in said.datagrams} == {"at"}
    modes = {Mode(int(one.mode)) for said in flight.saids if said.decisions for one in said.decisions[1:]}
    assert modes <= {M.INIT, M.READY}


def test_every_tick_says_something_and_the_drone_is_never_left_alone():
    flight = flying()
    flight.go(1.0)
    assert all(any(one.channel == "at" for one in said.datagrams) for said in flight.saids)
    assert isinstance(flight.lab.heard[-1].command, Pcmd)


def test_decisions_fall_twenty_times_a_second_and_stand_in_between():
    flight = flying()
    actions = [said.action for said in flight.go(2.0).saids[-200:]]
    changes = sum(a is not b for a, b in zip(actions, actions[1:], strict=False))
    assert 39 <= changes <= 41


def test_what_is_observed_is_said_with_the_decision_and_the_world():
    flight = flying()
    said = flight.last
    assert said.world.t == flight.heards[-1].t
    assert said.observation.altitude == pytest.approx(flight.lab.air.position.z, abs=0.02)
    assert said.world.uav.position.x == pytest.approx(flight.lab.air.position.x, abs=0.02)
    assert said.proposed.uav.forward == pytest.approx(said.action.forward)
