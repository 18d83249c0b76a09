"""Layer two as a whole: what is sent, and why."""

from dataclasses import dataclass, fields, replace
from math import inf, nan
from pathlib import Path

import pytest
from scripted import BROKEN, ESCAPE, NET, TOO_FAST, WAYS, WISH, Says, auto

from fledge.safety.base import AbstractNet
from fledge.supervision.inputs import HOVER
from fledge.supervision.modes import Mode as M
from fledge.supervision.modes import diagram, listing
from fledge.supervision.posts import Decision
from fledge.supervision.supervisor import Supervised, Supervisor
from fledge.supervision.watchdog import Severity, Watchdog
from fledge.world import Arena, Commands, VelocityCommand, Verdict
from fledge.world import Reason as R


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

    why: R = R.WALL

    def init(self, arena, world):
        return ()

    def filter(self, memory, world, commands):
        return memory, (Verdict(ESCAPE, 1.0, float(self.why), -0.1),) * (1 + len(commands.ugvs))


STEERED = Supervisor(Steer())


@pytest.mark.parametrize("mode", (M.AUTO, M.SHIELDED, M.HOLD, M.STOPPED, M.MANUAL, M.LAND))
def test_a_net_that_sees_steers(mode):
    flight = WAYS[mode](supervisor=STEERED)
    assert flight.sent == ESCAPE


@pytest.mark.parametrize("mode", (M.INIT, M.READY, M.TERMINATED))
def test_what_does_not_fly_is_not_steered(mode):
    flight = WAYS[mode](supervisor=STEERED)
    assert (flight.mode, flight.sent) == (mode, HOVER)


def test_on_the_floor_a_landing_keeps_to_the_place_that_the_net_holds():
    floor = Supervisor(Steer(R.FLOOR))
    assert WAYS[M.LAND](supervisor=floor).sent == replace(ESCAPE, up=-0.3)
    assert WAYS[M.AUTO](supervisor=floor).sent == ESCAPE


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
    assert (flight.sent, flight.decisions[0].verdict.intervened) == (HOVER, 1.0)
    assert flight.reason == (R.STOPPED if mode == M.STOPPED else R.NOT_FINITE)


@dataclass(frozen=True, slots=True)
class Listener(AbstractNet):
    """Remembers what it was last asked, and what was sent instead of its answer."""

    why: R = R.WALL

    def init(self, arena, world):
        return ()

    def filter(self, memory, world, commands):
        asked = (commands.uav, *commands.ugvs)
        return asked, tuple(Verdict(ESCAPE, 1.0, float(self.why), 0.1) for _ in asked)

    def overruled(self, memory, world, instead):
        return memory[0], instead.uav


LISTENED = Supervisor(Listener())
DOWN = VelocityCommand(0.0, 0.0, -0.3, 0.0)


def none(command: VelocityCommand) -> bool:
    return command.forward != command.forward


@pytest.mark.parametrize("mode", M)
def test_who_is_not_to_fly_anywhere_is_the_net_s_to_hold(mode):
    """No command, and not one of zero velocity, by which a vehicle drifts."""
    asked, _ = WAYS[mode](supervisor=LISTENED).memory.net
    flown = {M.AUTO: WISH, M.SHIELDED: TOO_FAST, M.MANUAL: HOVER}
    if mode in (*flown, M.RECOVER, M.LAND):
        assert asked == flown.get(mode, asked) and not none(asked)
    else:
        assert none(asked)


@pytest.mark.parametrize("mode", M)
def test_a_net_is_told_what_was_sent_against_its_word_and_only_that(mode):
    flight = WAYS[mode](supervisor=LISTENED)
    _, instead = flight.memory.net
    if mode in (M.INIT, M.READY, M.TERMINATED):
        assert instead == flight.sent == HOVER
    else:
        assert none(instead) and flight.sent == ESCAPE


def test_what_a_vehicle_does_that_is_not_seen_is_the_net_s_to_say_but_for_a_landing():
    blind = auto(supervisor=LISTENED).fly(0.3, pose_age=0.2)
    assert none(blind.memory.net[0]) and none(blind.memory.net[1]) and blind.sent == ESCAPE
    landing = blind.fly(0.1, land=1.0)
    assert landing.memory.net[1] == landing.sent == DOWN


def test_a_net_is_told_of_the_dead_man_s_command_and_of_a_descent():
    escaping = auto(supervisor=LISTENED).fly(0.1, switch=1.0, command=TOO_FAST, dead_man=1.0)
    assert escaping.memory.net[1] == escaping.sent == TOO_FAST
    landing = WAYS[M.LAND](supervisor=Supervisor(Listener(R.FLOOR)))
    assert landing.memory.net[1].up == -0.3 and none(landing.memory.net[1])


def test_a_landing_that_is_held_back_goes_aside_and_tries_again():
    """Towards the corner, and up, over what is in the way; who flies at (0, 0) has it at (-4, -4)."""
    flight = auto(supervisor=LISTENED).fly(0.02, land=1.0)
    assert flight.memory.net[0] == DOWN
    flight = flight.fly(0.1)
    aside = flight.memory.net[0]
    assert aside.up == 0.3
    assert (aside.forward, aside.left) == pytest.approx((-0.3 / 2**0.5, -0.3 / 2**0.5))
    free = replace(flight, supervisor=Supervisor(NET), memory=flight.memory._replace(net=()))
    assert free.fly(0.3).sent == aside and free.fly(0.7).sent == DOWN


def test_in_a_net_s_place_it_flies_a_flight_that_nobody_attends_to():
    """From its second tick on what the policy wants passes, and what the net has against it is still held back."""
    net = Supervised(Supervisor(NET))
    seen = [Says().inputs(0.01 * i, 2).seen for i in range(4)]
    memory, reasons, sent = net.init(Arena.square(), seen[0]), [], []
    for i, world in enumerate(seen):
        wish = WISH if i < 3 else TOO_FAST
        memory, verdicts = net.filter(memory, world, Commands(wish, (WISH, WISH)))
        reasons.append([v.reason for v in verdicts])
        sent.append([v.command for v in verdicts])
    assert reasons == [[R.NOT_READY] * 3, [R.NONE] * 3, [R.NONE] * 3, [R.WALL, R.NONE, R.NONE]]
    assert sent == [[HOVER] * 3, [WISH] * 3, [WISH] * 3, [ESCAPE, WISH, WISH]]


# What is written about it.

DOCS = (Path(__file__).parents[2] / "docs" / "supervisor.md").read_text()


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
    for mode in M:
        assert f"| {mode.name} |" in DOCS, mode
    for reason in R:
        assert reason == R.NONE or f"| {reason.name} |" in DOCS, reason
    dog = Watchdog()
    records = (Supervisor(NET), dog, dog.tracker)
    for record in records:
        for field in fields(record):
            value = getattr(record, field.name)
            if isinstance(value, float):
                assert f"| `{field.name}` | {value:g} " in DOCS, field.name
