"""What an alarm is raised for, and how loud."""

from dataclasses import replace
from math import inf, nan

import pytest

from fledge.geometry import Quat, Vec3
from fledge.safety import Contract
from fledge.supervision.inputs import HOVER, Inputs, Operator
from fledge.supervision.tracking import LEAD, Tracker
from fledge.supervision.watchdog import TICK, Alarm, Severity, Watchdog
from fledge.world import Commands, Reason, UavState, UgvState, VelocityCommand, WorldState

DOG = Watchdog()
STILL = Vec3(0.0, 0.0, 0.0)
OK = Alarm(Severity.OK, Reason.NONE)


def world(t, uav_age=0.0, ugv_age=0.0, x=0.0) -> WorldState:
    uav = UavState(Vec3(x, 0.0, 2.0), STILL, Quat(1.0, 0.0, 0.0, 0.0), STILL, t - uav_age)
    return WorldState(t, uav, (UgvState(2.0, 0.0, 0.0, 0.0, 0.0, t - ugv_age),))


def inputs(seen: WorldState, **changed) -> Inputs:
    return replace(Inputs.unattended(seen, Commands(HOVER, (HOVER,))), **changed)


def checked(given: Inputs, before: WorldState | None = None) -> tuple[WorldState, Alarm, Alarm]:
    """One check, after a first pose that was in order: (world, the UAV's alarm, the UGV's)."""
    memory = DOG.init(world(0.0) if before is None else before)
    _, seen, alarms = DOG.check(memory, given)
    return seen, *alarms


def test_where_all_is_well_the_world_passes_untouched_and_silently():
    memory = DOG.init(world(0.0))
    for i in range(100):
        memory, seen, alarms = DOG.check(memory, inputs(world(i * TICK)))
        assert seen == world(i * TICK) and alarms == (OK, OK)


GRADES = (
    *((age, Severity.OK) for age in (0.0, 0.05, 0.1)),
    *((age, Severity.BRAKE) for age in (0.11, 0.3, 0.5)),
    *((age, Severity.HOLD) for age in (0.51, 1.0, 2.0)),
    *((age, Severity.LAND) for age in (2.1, 10.0)),
)


@pytest.mark.parametrize("age, severity", GRADES)
def test_an_old_pose_is_an_alarm_for_its_vehicle(age, severity):
    """A stream that stands still: the last sample over and over."""
    begin = world(0.0)
    seen, uav, ugv = checked(inputs(WorldState(age, begin.uav, world(age).ugvs)), begin)
    assert seen.uav == begin.uav and seen.ugvs == world(age).ugvs
    assert uav == Alarm(severity, Reason.STALE if severity else Reason.NONE) and ugv == OK
    _, uav, ugv = checked(inputs(WorldState(age, world(age).uav, begin.ugvs)), begin)
    assert ugv == Alarm(severity, Reason.STALE if severity else Reason.NONE) and uav == OK


@pytest.mark.parametrize(
    "reason, ahead, x",
    (
        (Reason.FUTURE, 10.0, 0.0),
        (Reason.BACKWARD, -20.0, 0.0),
        (Reason.BAD_POSE, 0.0, nan),
        (Reason.BAD_POSE, 0.0, 1e3),
        (Reason.JUMP, 0.0, 90.0),
    ),
)
@pytest.mark.parametrize("age, severity", GRADES[1:])
def test_a_dropped_sample_names_the_fault_and_its_age_says_how_bad(reason, ahead, x, age, severity):
    begin = world(0.0)
    seen, uav, ugv = checked(inputs(world(age, uav_age=-ahead, x=x)), begin)
    assert seen.uav == begin.uav, "the last good one is kept, with its stamp"
    assert uav == Alarm(max(severity, Severity.WARN), reason) and ugv == OK


def fed(xs: list[float]) -> list[Alarm]:
    memory, alarms = DOG.init(world(0.0)), []
    for i, x in enumerate(xs, start=1):
        memory, _, found = DOG.check(memory, inputs(world(i * TICK, x=x)))
        alarms.append(found[0])
    return alarms


def test_a_short_jump_is_worth_a_word_only():
    alarms = fed([1.0] * 9 + [0.0] * 20)
    assert alarms == [Alarm(Severity.WARN, Reason.JUMP)] * 9 + [OK] * 20


def test_a_jump_that_stays_ends_with_a_person():
    alarms = fed([1.0] * 130)
    assert [a.severity for a in alarms] == sorted(a.severity for a in alarms[:101]) + [Severity.OK] * 29
    assert alarms[100] == Alarm(Severity.STOP, Reason.JUMP)
    assert all(a.reason == Reason.JUMP for a in alarms[:101])
    assert Severity.LAND not in {a.severity for a in alarms}


def test_a_contradiction_ends_with_a_person():
    memory = DOG.init(world(0.0))
    for i in range(1, 50):
        seen = world(i * TICK)
        seen = replace(seen, uav=replace(seen.uav, velocity=Vec3(0.0, 0.5, 0.0)))
        memory, believed, alarms = DOG.check(memory, inputs(seen))
    assert alarms == (Alarm(Severity.STOP, Reason.INCONSISTENT), OK)
    assert believed.uav.position == seen.uav.position


@pytest.mark.parametrize(
    "age, severity",
    (
        (0.5, 0),
        (0.51, Severity.HOLD),
        (1e9, Severity.HOLD),
        (-0.9 * LEAD, 0),
        (-1.1 * LEAD, Severity.HOLD),
        (nan, Severity.HOLD),
    ),
)
def test_a_policy_must_decide_in_time(age, severity):
    _, *alarms = checked(inputs(world(1.0), decided=1.0 - age), world(0.99))
    assert alarms == [Alarm(severity, Reason.POLICY_LATE if severity else 0)] * 2


@pytest.mark.parametrize(
    "age, severity", ((9.9, 0), (10.1, Severity.LAND), (-1.0, Severity.HOLD), (nan, Severity.HOLD))
)
def test_an_operator_must_be_heard_of(age, severity):
    _, *alarms = checked(inputs(world(1.0), heard=1.0 - age), world(0.99))
    assert alarms == [Alarm(severity, Reason.LINK_LOST if severity else 0)] * 2


@pytest.mark.parametrize(
    "share, severity",
    ((0.2, 0), (0.19, Severity.LAND), (-inf, Severity.LAND), (nan, Severity.HOLD), (inf, Severity.HOLD)),
)
def test_who_runs_empty_lands_and_who_does_not_know_holds(share, severity):
    _, uav, ugv = checked(inputs(world(0.01), batteries=(1.0, share)))
    assert uav == OK and ugv == Alarm(severity, Reason.BATTERY_LOW if severity else 0)


@pytest.mark.parametrize("bad", (nan, inf))
def test_a_command_must_be_a_number(bad):
    commands = Commands(VelocityCommand(0.0, 0.0, bad, 0.0), (HOVER,))
    _, uav, ugv = checked(inputs(world(0.01), proposed=commands))
    assert uav == Alarm(Severity.HOLD, Reason.NOT_FINITE) and ugv == OK


def test_what_an_operator_says_must_be_numbers():
    _, uav, ugv = checked(inputs(world(0.01), operators=(Operator(), Operator(deflection=nan))))
    assert ugv == Alarm(Severity.HOLD, Reason.NOT_FINITE) and uav == OK


@pytest.mark.parametrize("t", (nan, inf, -inf, 4.99, 5.0))
def test_a_clock_that_cannot_be_right_is_replaced(t):
    memory = DOG.init(world(5.0))
    memory, _, _ = DOG.check(memory, inputs(world(5.0)))
    for i in range(1, 300):
        held = replace(world(5.0), t=t)
        memory, seen, alarms = DOG.check(memory, inputs(held, decided=5.0, heard=5.0))
        assert seen.t == pytest.approx(5.0 + i * TICK)
        assert min(a.severity for a in alarms) >= Severity.HOLD
        assert i > 10 or all(a.reason == Reason.CLOCK for a in alarms)
    assert all(a.severity == Severity.LAND for a in alarms), "ages still grow"
    _, seen, alarms = DOG.check(memory, inputs(world(9.0)))
    assert seen == world(9.0) and alarms == (OK, OK)


def test_a_leap_of_the_clock_is_believed_if_a_pose_was_measured_after_it():
    memory = DOG.init(world(0.0))
    _, seen, alarms = DOG.check(memory, inputs(replace(world(0.01), t=10.0)))
    assert seen.t == pytest.approx(0.0, abs=0.02)
    assert alarms == (Alarm(Severity.HOLD, Reason.CLOCK),) * 2
    _, seen, alarms = DOG.check(memory, inputs(world(10.0, uav_age=9.99)))
    assert seen.t == 10.0 and alarms[0].reason == Reason.STALE and alarms[1] == OK
    _, seen, alarms = DOG.check(memory, inputs(replace(world(0.0), t=0.4)))
    assert seen.t == 0.4 and alarms == (Alarm(Severity.BRAKE, Reason.STALE),) * 2


def test_the_worst_counts_and_among_equals_the_pose():
    late = inputs(world(0.6), decided=0.0, batteries=(0.1, 1.0))
    _, uav, ugv = checked(late)
    assert uav == Alarm(Severity.LAND, Reason.BATTERY_LOW)
    assert ugv == Alarm(Severity.HOLD, Reason.POLICY_LATE)
    _, uav, _ = checked(replace(late, seen=replace(world(0.6), uav=world(0.0).uav), batteries=(1.0, 1.0)))
    assert uav == Alarm(Severity.HOLD, Reason.STALE)


def test_limits_are_parameters():
    patient = Watchdog(
        Tracker(Contract(velocity_error=10.0), fastest=300.0), poses=((1.0, Severity.LAND),), low=0.0
    )
    memory = patient.init(world(0.0))
    _, _, alarms = patient.check(memory, inputs(world(0.01, x=2.0), batteries=(0.1, 0.1)))
    assert alarms == (OK, OK)
    _, _, alarms = patient.check(memory, inputs(replace(world(1.5), uav=world(0.0).uav)))
    assert alarms[0] == Alarm(Severity.LAND, Reason.STALE)
