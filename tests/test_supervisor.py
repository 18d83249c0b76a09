"""Layer two as a whole: from what comes in to what is sent."""

from dataclasses import dataclass, fields, is_dataclass, replace
from itertools import pairwise
from math import inf, nan
from pathlib import Path

import pytest

from fledge.geometry import Quat, Vec3
from fledge.inputs import HOVER, Inputs, Operator
from fledge.modes import TABLE, Mode, Row, diagram, listing
from fledge.safety.base import AbstractNet
from fledge.supervisor import Decision, Supervisor
from fledge.watchdog import Severity, Watchdog
from fledge.world import (
    Arena,
    Commands,
    Reason,
    UavState,
    UgvState,
    VelocityCommand,
    Verdict,
    WorldState,
)

M, R = Mode, Reason
STILL = Vec3(0.0, 0.0, 0.0)
WISH = VelocityCommand(0.3, 0.0, 0.0, 0.0)
TOO_FAST = VelocityCommand(0.9, 0.0, 0.0, 0.0)
ESCAPE = VelocityCommand(-0.2, 0.0, 0.0, 0.0)
HUMAN = VelocityCommand(-0.4, 0.1, 0.0, 0.2)


@dataclass(frozen=True, slots=True)
class Limit(AbstractNet):
    """Answers everything faster than 0.5 m/s forwards with a way out."""

    def init(self, arena, world):
        return ()

    def filter(self, memory, world, commands):
        return memory, tuple(
            Verdict(ESCAPE, 1.0, float(R.WALL), 0.1) if c.forward > 0.5 else Verdict(c, 0.0, 0.0, 2.0)
            for c in (commands.uav, *commands.ugvs)
        )


NET = Limit()


@dataclass(frozen=True, slots=True)
class Says:
    """One tick's inputs in the words of a scenario; the vehicles stand still."""

    wish: VelocityCommand = WISH
    pose_age: float = 0.0
    reported: float = 0.0
    """Speed that the UAV says it has [m/s]."""
    heard: float = 0.0
    """Age of the link [s]."""
    decided: float = 0.0
    """Age of the decision [s]."""
    battery: float = 1.0
    airborne: float = 1.0
    person: Operator = Operator(arm=1.0)

    def inputs(self, t: float, ugvs: int) -> Inputs:
        stamp = t - self.pose_age
        uav = UavState(
            Vec3(0.0, 0.0, 2.0), Vec3(self.reported, 0.0, 0.0), Quat(1.0, 0.0, 0.0, 0.0), STILL, stamp
        )
        seen = WorldState(t, uav, tuple(UgvState(2.0 + i, 0.0, 0.0, 0.0, 0.0, t) for i in range(ugvs)))
        return Inputs(
            seen,
            Commands(self.wish, (WISH,) * ugvs),
            t - self.decided,
            (self.person,) * (1 + ugvs),
            t - self.heard,
            (self.battery,) * (1 + ugvs),
            self.airborne,
        )

    def but(self, **changed) -> "Says":
        """With some of it changed; what is none of its own is the person's."""
        own = {name: value for name, value in changed.items() if name in type(self).__slots__}
        theirs = {name: value for name, value in changed.items() if name not in own}
        return replace(self, **own, person=replace(self.person, **theirs))


@dataclass(frozen=True, slots=True)
class Flight:
    """A supervisor at work; a value, so that many things can happen after the same beginning."""

    supervisor: Supervisor
    memory: object
    t: float
    says: Says
    decisions: tuple[Decision, ...] = ()
    ugvs: int = 0
    dt: float = 0.02

    @classmethod
    def begin(cls, supervisor: Supervisor = Supervisor(NET), ugvs: int = 0, dt: float = 0.02, **said):
        says = Says().but(**said)
        memory = supervisor.init(Arena.square(), says.inputs(0.0, ugvs).seen)
        return cls(supervisor, memory, 0.0, says, ugvs=ugvs, dt=dt).fly(dt)

    def fly(self, seconds: float, **said) -> "Flight":
        """So much later, the inputs being changed for good."""
        return self.history(seconds, **said)[-1]

    def history(self, seconds: float, **said) -> "list[Flight]":
        """The same tick by tick."""
        flight, says, ticks = self, self.says.but(**said), []
        for _ in range(max(round(seconds / self.dt), 1)):
            t = flight.t + self.dt
            memory, decisions = self.supervisor.step(flight.memory, says.inputs(t, self.ugvs))
            flight = replace(flight, memory=memory, t=t, says=says, decisions=decisions)
            ticks.append(flight)
        return ticks

    @property
    def mode(self) -> Mode:
        return Mode(int(self.decisions[0].mode))

    @property
    def reason(self) -> Reason:
        return Reason(int(self.decisions[0].verdict.reason))

    @property
    def sent(self) -> VelocityCommand:
        return self.decisions[0].verdict.command


def ready(**how) -> Flight:
    return Flight.begin(**how, arm=0.0).fly(1.1)


def auto(**how) -> Flight:
    return ready(**how).fly(0.1, arm=1.0)


BROKEN = VelocityCommand(nan, 0.0, 0.0, 0.0)
WAYS = {
    M.INIT: lambda **how: Flight.begin(**how).fly(1.1),
    M.READY: ready,
    M.AUTO: auto,
    M.SHIELDED: lambda **how: auto(**how).fly(0.1, wish=TOO_FAST),
    M.RECOVER: lambda **how: auto(**how).fly(1.1, wish=BROKEN).fly(1.1, wish=WISH),
    M.HOLD: lambda **how: auto(**how).fly(0.1, wish=BROKEN),
    M.STOPPED: lambda **how: auto(**how).fly(1.1).fly(0.1, stop=1.0).fly(0.1, stop=0.0),
    M.MANUAL: lambda **how: auto(**how).fly(1.1).fly(0.1, switch=1.0).fly(0.1, switch=0.0),
    M.LAND: lambda **how: auto(**how).fly(0.1, land=1.0).fly(0.1, land=0.0),
    M.TERMINATED: lambda **how: auto(**how).fly(0.1, terminate=1.0).fly(0.1, terminate=0.0),
}  # fmt: skip
"""How each mode comes about; what brought it about goes on only where nothing else keeps it."""

GRABBED = {"deflection": 0.6}
WELL = {"wish": WISH}
POLICY = (M.AUTO, M.SHIELDED, M.RECOVER, M.HOLD, M.STOPPED)
FADING = POLICY[:3]
FLYING = (*POLICY, M.MANUAL, M.LAND)


def all_to(modes: tuple[Mode, ...], to: Mode) -> dict[Mode, Mode]:
    return {mode: to for mode in modes}


SPEC = {
    "nothing happens": (0.3, {}, {}),
    "nothing happens for long": (3.0, {}, {M.RECOVER: M.AUTO}),
    "all is well for a while": (1.5, WELL, {M.SHIELDED: M.AUTO, M.RECOVER: M.AUTO, M.HOLD: M.RECOVER}),
    "order to terminate": (0.1, {"terminate": 1.0}, all_to(tuple(M), M.TERMINATED)),
    "order to terminate on the ground": (
        0.1,
        {"terminate": 1.0, "airborne": 0.0},
        all_to(tuple(M), M.TERMINATED),
    ),
    "order to land": (0.1, {"land": 1.0}, all_to(FLYING, M.LAND)),
    "order to land against the switch": (0.1, {"land": 1.0, "switch": 1.0}, all_to(FLYING, M.LAND)),
    "order to land over a silent link": (0.1, {"land": 1.0, "heard": 0.6}, all_to(FLYING, M.LAND)),
    "order to land on the ground": (
        0.1,
        {"land": 1.0, "airborne": 0.0},
        {**all_to(FLYING, (M.LAND, M.INIT)), M.LAND: M.INIT},
    ),
    "on the ground": (0.1, {"airborne": 0.0}, {M.LAND: M.INIT}),
    "disarmed in the air": (0.1, {"arm": 0.0}, {M.INIT: M.READY}),
    "disarmed on the ground": (
        0.1,
        {"arm": 0.0, "airborne": 0.0},
        {**all_to(FLYING, (M.INIT, M.READY)), M.INIT: M.READY, M.HOLD: M.INIT},
    ),
    "order to land, and disarmed on the ground": (
        0.02,
        {"land": 1.0, "arm": 0.0, "airborne": 0.0},
        {**all_to(FLYING, M.INIT), M.INIT: M.READY},
    ),
    "disarmed with an alarm": (
        0.1,
        {"arm": 0.0, "heard": -1.0},
        {**all_to(FADING, M.HOLD), M.READY: M.INIT, M.MANUAL: M.STOPPED},
    ),
    "armed": (0.1, {"arm": 1.0}, {M.READY: M.AUTO}),
    "armed with an alarm": (
        0.1,
        {"arm": 1.0, "heard": -1.0},
        {**all_to(FADING, M.HOLD), M.READY: M.INIT, M.MANUAL: M.STOPPED},
    ),
    "order to stop": (0.1, {"stop": 1.0}, all_to(POLICY, M.STOPPED)),
    "order to stop with an empty battery": (
        0.1,
        {"stop": 1.0, "battery": 0.1},
        {**all_to(POLICY, M.LAND), M.READY: M.INIT},
    ),
    "switch": (0.1, {"switch": 1.0}, all_to(FLYING, M.MANUAL)),
    "switch and armed": (0.1, {"switch": 1.0, "arm": 1.0}, all_to((M.READY, *FLYING), M.MANUAL)),
    "switch and armed with an empty battery": (
        0.1,
        {"switch": 1.0, "arm": 1.0, "battery": 0.1},
        {**all_to(FLYING, M.MANUAL), M.READY: M.INIT},
    ),
    "switch of a silent link": (0.1, {"switch": 1.0, "heard": 0.6}, {M.MANUAL: M.STOPPED}),
    "sticks": (0.3, GRABBED, all_to(FADING, M.MANUAL)),
    "sticks for long": (3.0, GRABBED, all_to(POLICY, M.MANUAL)),
    "sticks of a silent link": (0.3, {**GRABBED, "heard": 0.6}, {M.MANUAL: M.STOPPED}),
    "sticks with an alarm": (0.3, {**GRABBED, "decided": 0.6}, {**all_to(FADING, M.HOLD), M.READY: M.INIT}),
    "handed back": (0.1, {"hand_back": 1.0}, {M.MANUAL: M.RECOVER, M.STOPPED: M.RECOVER}),
    "old pose": (0.3, {"pose_age": 0.2}, {M.AUTO: M.SHIELDED, M.RECOVER: M.HOLD, M.READY: M.INIT}),
    "late policy": (0.1, {"decided": 0.6}, {**all_to(FADING, M.HOLD), M.READY: M.INIT}),
    "contradicting pose": (0.3, {"reported": 1.0}, {**all_to(POLICY, M.STOPPED), M.READY: M.INIT}),
    "empty battery": (0.1, {"battery": 0.1}, {**all_to(POLICY, M.LAND), M.READY: M.INIT}),
    "the net acts": (0.1, {"wish": TOO_FAST}, {M.AUTO: M.SHIELDED}),
}
"""What happens, for how long, and to which mode, or through which modes, that leads; a mode that is not named stays."""

PATIENCE = {"deaf": 2.0}
"""[s]; shorter than by default, to save time."""


def failures(supervisor: Supervisor):
    """What of the specification does not hold, and what happens instead."""
    for mode, way in WAYS.items():
        begin = way(supervisor=supervisor)
        if begin.mode != mode:
            yield mode, "comes about", begin.mode
            continue
        for name, (seconds, said, leads) in SPEC.items():
            modes = [mode, *(flight.mode for flight in begin.history(seconds, **said))]
            path = tuple(to for was, to in pairwise(modes) if to != was)
            to = leads.get(mode, mode)
            if path != (to if isinstance(to, tuple) else () if to == mode else (to,)):
                yield mode, name, path


def test_every_mode_answers_to_everything_as_it_should():
    assert list(failures(Supervisor(NET, **PATIENCE))) == []


def noticed(i: int, *instead: Row) -> bool:
    """Whether something of the specification fails with these rows instead of row `i`."""
    table = TABLE[:i] + instead + TABLE[i + 1 :]
    return next(failures(Supervisor(NET, **PATIENCE, table=table)), None) is not None


EVERY_ROW = pytest.mark.parametrize("i", range(len(TABLE)), ids=lambda i: f"{i}-{TABLE[i].to.name}")


@EVERY_ROW
def test_no_row_can_be_missed(i):
    assert noticed(i)


@pytest.mark.slow
@EVERY_ROW
def test_no_part_of_a_row_can_be_missed(i):
    """Neither one of its modes nor one of its conditions."""
    row = TABLE[i]
    for mode in row.modes:
        assert noticed(i, replace(row, modes=tuple(m for m in row.modes if m != mode))), mode
    for trigger in row.when:
        assert noticed(i, replace(row, when=tuple(t for t in row.when if t != trigger))), trigger


# What is sent, and why.


def test_in_auto_the_policy_flies_and_nothing_is_held_back():
    flight = auto(ugvs=2)
    for decision in flight.decisions:
        assert decision == Decision(M.AUTO, Verdict(WISH, 0.0, R.NONE, 2.0), decision.alarm)
        assert (decision.alarm.severity, decision.alarm.reason) == (Severity.OK, R.NONE)


def test_shielded_is_what_the_net_says_and_outlasts_it_for_a_while():
    flight = auto().fly(0.02, wish=TOO_FAST)
    assert (flight.mode, flight.sent, flight.reason) == (M.AUTO, ESCAPE, R.WALL)
    flight = flight.fly(0.02)
    assert (flight.mode, flight.sent, flight.reason) == (M.SHIELDED, ESCAPE, R.WALL)
    flight = flight.fly(0.4, wish=WISH)
    assert (flight.mode, flight.sent, flight.reason) == (M.SHIELDED, WISH, R.NONE)
    assert flight.fly(0.3).mode == M.AUTO


def test_an_alarm_that_says_brake_brakes_and_leaves_the_policy_its_turn():
    flight = auto().fly(0.3, pose_age=0.2)
    assert (flight.mode, flight.sent) == (M.SHIELDED, HOVER)
    assert flight.reason in (R.STALE, R.BACKWARD)
    flight = flight.fly(0.1, pose_age=0.0)
    assert flight.sent == WISH


FAULTS = {
    R.NOT_FINITE: {"wish": BROKEN},
    R.POLICY_LATE: {"decided": 0.6},
    R.LINK_LOST: {"heard": 11.0},
    R.BATTERY_LOW: {"battery": 0.1},
    R.INCONSISTENT: {"reported": 2.0},
    R.BAD_POSE: {"reported": nan},
    R.FUTURE: {"pose_age": -0.1},
    R.BACKWARD: {"pose_age": 3.0},
}


@pytest.mark.parametrize("reason", FAULTS, ids=lambda reason: reason.name)
def test_a_fault_is_named_for_as_long_as_it_lasts_and_the_policy_does_not_fly(reason):
    flight = auto().fly(0.8, **FAULTS[reason])
    assert flight.mode in (M.HOLD, M.STOPPED, M.LAND)
    for _ in range(10):
        flight = flight.fly(0.1)
        assert flight.reason == reason
        assert (flight.sent.forward, flight.sent.left, flight.sent.turn) == (0.0, 0.0, 0.0)
        assert flight.decisions[0].verdict.intervened


def test_one_vehicle_s_fault_is_its_own():
    says = Says().but(arm=1.0)
    flight = auto(ugvs=2)
    given = says.inputs(flight.t + 0.02, 2)
    memory, decisions = flight.supervisor.step(flight.memory, replace(given, batteries=(1.0, 0.1, 1.0)))
    assert [d.mode for d in decisions] == [M.AUTO, M.LAND, M.AUTO]
    assert [d.verdict.reason for d in decisions] == [R.NONE, R.BATTERY_LOW, R.NONE]
    assert decisions[1].verdict.command == HOVER


def test_a_frozen_pose_brakes_then_holds_then_lands():
    begin = flight = auto()
    pose, changes = begin.says.inputs(begin.t, 0).seen.uav, {}
    for i in range(1, 130):
        age = 0.02 * i - 0.01
        given = begin.says.inputs(begin.t + age, 0)
        given = replace(given, seen=replace(given.seen, uav=pose))
        memory, decisions = flight.supervisor.step(flight.memory, given)
        flight = replace(flight, memory=memory, decisions=decisions)
        changes.setdefault((flight.mode, flight.sent), round(age, 2))
        assert flight.reason == (R.STALE if age > 0.1 else R.NONE)
    assert changes == {
        (M.AUTO, WISH): 0.01,
        (M.AUTO, HOVER): 0.11,
        (M.SHIELDED, HOVER): 0.13,
        (M.HOLD, HOVER): 0.51,
        (M.LAND, VelocityCommand(0.0, 0.0, -0.3, 0.0)): 2.01,
    }


def test_a_ugv_that_lands_stands_still_and_has_to_be_armed_again():
    flight = auto(ugvs=1).fly(0.02, land=1.0)
    assert [d.mode for d in flight.decisions] == [M.LAND, M.LAND]
    assert [d.verdict.command.up for d in flight.decisions] == [-0.3, 0.0]
    flight = flight.fly(3.0, land=0.0)
    assert [d.mode for d in flight.decisions] == [M.LAND, M.INIT]
    assert flight.decisions[1].verdict.command == HOVER and flight.decisions[1].verdict.reason == R.NOT_READY
    flight = flight.fly(0.1, airborne=0.0, arm=0.0).fly(0.1, arm=1.0, airborne=1.0)
    assert [d.mode for d in flight.decisions] == [M.AUTO, M.AUTO]


# Nets that steer.


@dataclass(frozen=True, slots=True)
class Steer(AbstractNet):
    """A net that always has something better to do."""

    def init(self, arena, world):
        return ()

    def filter(self, memory, world, commands):
        return memory, (Verdict(ESCAPE, 1.0, float(R.WALL), -0.1),) * (1 + len(commands.ugvs))


STEERED = Supervisor(Steer())


@pytest.mark.parametrize("mode", (M.AUTO, M.SHIELDED, M.HOLD, M.STOPPED, M.MANUAL))
def test_a_net_that_sees_steers(mode):
    assert WAYS[mode](supervisor=STEERED).sent == ESCAPE


@pytest.mark.parametrize("mode", (M.INIT, M.READY, M.LAND, M.TERMINATED))
def test_what_does_not_fly_or_comes_down_is_not_steered(mode):
    flight = WAYS[mode](supervisor=STEERED)
    assert flight.mode == mode
    assert flight.sent == (VelocityCommand(0.0, 0.0, -0.3, 0.0) if mode == M.LAND else HOVER)


def test_a_net_that_is_blind_does_not_steer():
    for age in (0.12, 0.3, 1.0):
        for flight in auto(supervisor=STEERED).fly(age + 0.04, pose_age=age).history(0.5):
            assert flight.sent == HOVER


@pytest.mark.parametrize("bad", (nan, inf))
@pytest.mark.parametrize("mode", (M.AUTO, M.HOLD, M.STOPPED, M.MANUAL))
def test_not_even_a_net_gets_nonsense_through(mode, bad):
    @dataclass(frozen=True, slots=True)
    class Broken(AbstractNet):
        def init(self, arena, world):
            return ()

        def filter(self, memory, world, commands):
            return memory, (Verdict(replace(WISH, up=bad), nan, nan, nan),) * (1 + len(commands.ugvs))

    flight = WAYS[mode](supervisor=Supervisor(Broken()))
    verdict = flight.decisions[0].verdict
    assert (flight.sent, flight.reason, verdict.intervened) == (HOVER, R.NOT_FINITE, 1.0)


# A person.


def test_who_takes_over_flies_through_the_net():
    flight = auto().fly(0.1, switch=1.0, command=HUMAN)
    assert (flight.mode, flight.sent, flight.reason) == (M.MANUAL, HUMAN, R.TAKE_OVER)
    assert flight.decisions[0].verdict.intervened
    flight = flight.fly(0.1, command=TOO_FAST)
    assert (flight.sent, flight.reason) == (ESCAPE, R.WALL)


def test_the_dead_man_switch_takes_the_net_away_but_only_by_hand():
    flight = auto().fly(0.1, switch=1.0, command=TOO_FAST, dead_man=1.0)
    assert (flight.sent, flight.reason) == (TOO_FAST, R.TAKE_OVER)
    assert flight.fly(0.1, dead_man=0.0).sent == ESCAPE
    assert flight.fly(0.1, command=replace(TOO_FAST, up=nan)).sent == HOVER
    assert auto().fly(0.1, wish=TOO_FAST, dead_man=1.0).sent == ESCAPE


def test_what_a_person_asks_for_is_what_the_net_is_asked():
    """So a person may always fly away from a wall: nothing but the net stands in between."""
    for command in (WISH, HUMAN, VelocityCommand(-2.0, 1.0, 0.5, 1.0)):
        for age in (0.0, 0.3, 5.0):
            assert auto().fly(0.1, switch=1.0).fly(0.5, command=command, pose_age=age).sent == command


def test_a_stick_that_is_no_number_is_a_hover():
    flight = auto().fly(0.1, switch=1.0, command=HUMAN)
    for bad in (
        {"command": replace(HUMAN, left=nan)},
        {"command": replace(HUMAN, up=inf)},
        {"deflection": nan},
    ):
        broken = flight.fly(0.1, **bad)
        assert (broken.mode, broken.sent, broken.reason) == (M.MANUAL, HOVER, R.NOT_FINITE)


def test_a_spike_of_the_stick_takes_nothing_over():
    flight = auto()
    for _ in range(20):
        flight = flight.fly(0.08, deflection=1.0).fly(0.04, deflection=0.0)
        assert flight.mode == M.AUTO
    assert flight.fly(1.0, deflection=0.29).mode == M.AUTO
    assert flight.fly(1.0, deflection=nan).mode == M.HOLD
    assert flight.fly(0.14, deflection=0.31).mode == M.MANUAL


def test_a_hold_is_deaf_to_sticks_for_five_seconds_never_to_the_switch():
    hold = WAYS[M.HOLD]()
    assert hold.fly(4.7, **GRABBED).mode == M.HOLD
    assert hold.fly(5.1, **GRABBED).mode == M.MANUAL
    assert hold.fly(0.02, switch=1.0).mode == M.MANUAL


def test_handing_back_needs_hands_off_a_quiet_alarm_and_a_net_with_nothing_to_say():
    manual = WAYS[M.MANUAL]().fly(1.1)
    assert manual.fly(0.02, hand_back=1.0).mode == M.RECOVER
    hindered = (
        {"deflection": 0.11},
        {"deflection": nan},
        {"switch": 1.0},
        {"switch": nan},
        {"dead_man": 1.0},
        {"command": TOO_FAST},
        {"wish": BROKEN},
        {"pose_age": 0.2},
        {"battery": nan},
    )
    for hindrance in hindered:
        held = manual.fly(0.2, **hindrance).fly(0.5, hand_back=1.0)
        assert held.mode == M.MANUAL, hindrance
    assert manual.fly(0.1, pose_age=0.2).fly(0.5, pose_age=0.0, hand_back=1.0).mode == M.MANUAL, "too early"


def test_the_command_fades_from_the_person_s_to_the_policy_s():
    before = WAYS[M.MANUAL](dt=0.01).fly(1.1, command=HUMAN)
    ticks = before.history(1.3, hand_back=1.0)
    sent = [before.sent.forward, *(flight.sent.forward for flight in ticks)]
    assert sent[0] == HUMAN.forward and sent[-1] == WISH.forward
    most = (WISH.forward - HUMAN.forward) * 0.01 / 1.0
    assert all(-1e-9 <= b - a <= most + 1e-9 for a, b in zip(sent, sent[1:], strict=False))
    fading = [flight for flight in ticks if flight.mode == M.RECOVER]
    assert fading == ticks[: len(fading)] and len(fading) == pytest.approx(100, abs=1)
    assert {flight.mode for flight in ticks[len(fading) :]} == {M.AUTO}
    assert {flight.reason for flight in fading} == {R.RECOVERING}


def test_who_flies_by_hand_and_is_not_heard_is_stopped_and_lands():
    flight, modes = auto().fly(0.1, switch=1.0, command=HUMAN), {}
    last = flight.t + 0.01
    for _ in range(520):
        flight = flight.fly(0.02, heard=flight.t + 0.02 - last)
        modes.setdefault(flight.mode, round(flight.t - last, 2))
    assert modes == {M.MANUAL: 0.01, M.STOPPED: 0.51, M.LAND: 10.01}
    assert flight.reason == R.LINK_LOST


def test_armed_too_early_is_not_armed():
    flight = Flight.begin(arm=1.0).fly(5.0)
    assert flight.mode == M.INIT and flight.sent == HOVER
    assert flight.fly(0.04, arm=nan).fly(0.1, arm=1.0).mode == M.INIT


# Whatever comes in.


def numbers(record, *above):
    """Every number in a record, by its way there."""
    named = (
        [(str(i), value) for i, value in enumerate(record)]
        if isinstance(record, tuple)
        else [(field.name, getattr(record, field.name)) for field in fields(record)]
    )
    for name, value in named:
        if is_dataclass(value) or isinstance(value, tuple):
            yield from numbers(value, *above, name)
        else:
            yield (*above, name)


def put(record, path, value):
    name, *rest = path
    if isinstance(record, tuple):
        items = list(record)
        items[int(name)] = put(items[int(name)], rest, value) if rest else value
        return tuple(items)
    return replace(record, **{name: put(getattr(record, name), rest, value) if rest else value})


EVERY_NUMBER = [path for path in numbers(Says().inputs(0.0, 1)) if path != ("airborne",)]


@pytest.mark.parametrize("bad", (nan, inf, -inf))
@pytest.mark.parametrize("path", EVERY_NUMBER, ids=".".join)
def test_a_number_that_is_none_anywhere_stops_its_vehicle_and_is_named(path, bad):
    """No matter what the net does with it."""
    begin = auto(ugvs=1)
    touched = set()
    flight = begin
    for _ in range(40):
        t = flight.t + 0.02
        memory, decisions = flight.supervisor.step(flight.memory, put(begin.says.inputs(t, 1), path, bad))
        flight = replace(flight, memory=memory, t=t)
        for i, decision in enumerate(decisions):
            command = decision.verdict.command
            assert all(abs(getattr(command, axis)) < inf for axis in VelocityCommand.__slots__)
            if decision.verdict.intervened:
                touched.add(i)
                assert decision.verdict.reason > 0
    assert touched, "somebody is concerned"
    for i in touched:
        command = decisions[i].verdict.command
        assert (command.forward, command.left, command.turn) == (0.0, 0.0, 0.0) and command.up <= 0.0
    shared = path[0] in ("decided", "heard") or path == ("seen", "t")
    own = (
        {"uav": {0}, "ugvs": {1}}.get(path[1], {int(path[1])} if path[1].isdigit() else set())
        if path[1:]
        else set()
    )
    assert touched == ({0, 1} if shared else own)


def test_who_may_be_on_the_ground_is_taken_for_flying():
    assert WAYS[M.LAND]().fly(1.0, airborne=nan).mode == M.LAND
    assert auto().fly(1.0, airborne=nan, arm=0.0).mode == M.AUTO


# What is written about it.

DOCS = (Path(__file__).parents[1] / "docs" / "supervisor.md").read_text()


@pytest.mark.parametrize(
    "name, drawn",
    (
        ("diagram", f"```mermaid\n{diagram()}\n```"),
        ("table", listing()),
    ),
)
def test_the_documentation_shows_the_table_as_it_is(name, drawn):
    _, _, rest = DOCS.partition(f"<!-- {name} -->\n")
    assert rest.partition(f"\n<!-- end of {name} -->")[0] == drawn


def test_the_documentation_names_every_mode_and_every_reason_and_every_limit():
    for mode in Mode:
        assert f"| {mode.name} |" in DOCS, mode
    for reason in Reason:
        assert reason == R.NONE or f"| {reason.name} |" in DOCS, reason
    dog = Watchdog()
    records = (Supervisor(NET), dog, dog.tracker)
    for record in records:
        for field in fields(record):
            value = getattr(record, field.name)
            if isinstance(value, float):
                assert f"| `{field.name}` | {value:g} " in DOCS, field.name
