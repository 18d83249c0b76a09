"""The table of modes: every mode against every combination of triggers that can occur."""

from itertools import combinations, product

import numpy as np
import pytest

from fledge.supervision.modes import FLYING, POLICY, TABLE, Mode, Trigger, advance, diagram, listing
from fledge.world import Reason

T = Trigger
ALARM = 12.0
"""What the alarm gives as its reason, wherever there is one."""
GRADES = (T.ALARM_BRAKE, T.ALARM_HOLD, T.ALARM_STOP, T.ALARM_LAND)
FREE = (T.TERMINATE, T.LAND, T.STOP, T.ON_GROUND, T.LINK_LOST, T.HELD_BACK)
HANDS = (T.SWITCH, T.STICKS, T.HAND_BACK)


def situations() -> dict[Trigger, np.ndarray]:
    """Every combination of triggers that can occur, a column each."""
    rows = []
    for free in product((False, True), repeat=len(FREE)):
        known = dict(zip(FREE, free, strict=True))
        hands = [(False,) * 3] if known[T.LINK_LOST] else product((False, True), repeat=3)
        for hand, grade, calm, lasted, arming in product(hands, range(5), (False, True), range(3), range(3)):
            switch, _, back = hand
            if (calm and grade) or (back and (switch or not calm)):
                continue
            rows.append({
                **known,
                **dict(zip(HANDS, hand, strict=True)),
                **{trigger: grade > i for i, trigger in enumerate(GRADES)},
                T.CALM: calm,
                T.QUIET: not known[T.HELD_BACK],
                T.LASTED: lasted > 0,
                T.HEARD_OUT: lasted > 1,
                # Neither, where the switch is no number.
                T.ARM: arming == 1,
                T.DISARM: arming == 2,
            })
    return {trigger: np.array([row[trigger] for row in rows]) for trigger in Trigger}


ALL = situations()
COUNT = len(ALL[T.LAND])
BEFORE = 99.0
AFTER = {
    mode: advance(TABLE, (np.full(COUNT, float(mode)), np.full(COUNT, BEFORE)), ALL, ALARM) for mode in Mode
}
RANK = {
    **{Mode.READY: 0, Mode.AUTO: 0, Mode.SHIELDED: 1, Mode.RECOVER: 1, Mode.MANUAL: 2},
    **{Mode.HOLD: 3, Mode.STOPPED: 4, Mode.LAND: 5, Mode.INIT: 5, Mode.TERMINATED: 6},
}
"""How little a vehicle may still do."""


def ranks(mode: Mode, triggers: dict[Trigger, np.ndarray]) -> np.ndarray:
    now = (np.full(len(triggers[T.LAND]), float(mode)), np.zeros(len(triggers[T.LAND])))
    return np.array([RANK[m] for m in Mode])[advance(TABLE, now, triggers, ALARM)[0].astype(int)]


def edges(keep: np.ndarray) -> dict[Mode, set[Mode]]:
    """Where each mode can lead, in the situations kept."""
    return {mode: {Mode(int(to)) for to in np.unique(AFTER[mode][0][keep])} for mode in Mode}


def reachable(start: Mode, graph: dict[Mode, set[Mode]]) -> set[Mode]:
    found, todo = {start}, [start]
    while todo:
        new = graph[todo.pop()] - found
        found |= new
        todo += new
    return found


def test_every_combination_is_there():
    assert COUNT == 32 * 9 * 6 + 32 * 9 * (4 * 6 + 2)
    for trigger in Trigger:
        assert 0 < ALL[trigger].sum() < COUNT, trigger


@pytest.mark.parametrize("mode", Mode)
def test_every_mode_has_an_answer_to_everything(mode):
    to, reason = AFTER[mode]
    assert set(to) <= set(map(float, Mode))
    assert set(reason) <= {BEFORE, ALARM} | set(map(float, Reason))
    # A reason changes by a row only, and a mode takes its reason with it.
    assert (reason[to != float(mode)] != BEFORE).all()


@pytest.mark.parametrize("mode", Mode)
def test_one_scene_is_decided_like_many(mode):
    rng = np.random.default_rng(0)
    for i in rng.integers(COUNT, size=300):
        one = {trigger: bool(column[i]) for trigger, column in ALL.items()}
        assert advance(TABLE, (float(mode), BEFORE), one, ALARM) == tuple(column[i] for column in AFTER[mode])


@pytest.mark.parametrize("mode", Mode)
def test_the_first_row_that_fits_decides(mode):
    rng = np.random.default_rng(1)
    for i in rng.integers(COUNT, size=300):
        fits = (row for row in TABLE if mode in row.modes and all(ALL[trigger][i] for trigger in row.when))
        row = next(fits, None)
        assert AFTER[mode][0][i] == (mode if row is None else row.to)


WEIGHT = (
    (T.TERMINATE,),
    (T.ON_GROUND, T.DISARM),
    (T.LAND,),
    (T.LINK_LOST,),
    (T.SWITCH,),
    GRADES,
    (T.STOP,),
    GRADES[:3],
    GRADES[:2],
    GRADES[:1],
    (T.STICKS, T.HEARD_OUT),
    (T.HAND_BACK,),
    (T.CALM, T.DISARM),
    (T.LASTED,),
    (T.HELD_BACK,),
    (T.QUIET,),
)
"""What outranks what, in every mode: people's orders, the worst alarms, hands on the sticks, then the usual course."""


@pytest.mark.parametrize("mode", Mode)
def test_of_two_things_at_once_the_weightier_decides(mode):
    def after(*triggers: Trigger) -> tuple[float, float]:
        return advance(TABLE, (float(mode), BEFORE), {t: t in triggers for t in Trigger}, ALARM)

    moving = [triggers for triggers in WEIGHT if after(*triggers) != (mode, BEFORE)]
    for heavy, light in combinations(moving, 2):
        assert after(*heavy, *light) == after(*heavy), (heavy, light)


@pytest.mark.parametrize(
    "alarm, to", ((None, Mode.AUTO), (T.SWITCH, Mode.MANUAL), (T.ALARM_BRAKE, Mode.INIT))
)
def test_armed_is_for_the_policy_unless_a_person_or_an_alarm_stands_against_it(alarm, to):
    set_now = {T.ARM, alarm} | ({T.SWITCH} if alarm else set())
    triggers = {trigger: trigger in set_now for trigger in Trigger}
    assert advance(TABLE, (float(Mode.READY), BEFORE), triggers, ALARM)[0] == to


@pytest.mark.parametrize("mode", Mode)
@pytest.mark.parametrize("grade", range(4))
def test_a_worse_alarm_never_lets_a_vehicle_do_more(mode, grade):
    """The same situation, its alarm one grade worse; with an alarm, nothing is calm, nor handed back."""
    below = ~ALL[GRADES[grade]] if grade == 0 else ALL[GRADES[grade - 1]] & ~ALL[GRADES[grade]]
    mild = {trigger: column[below] for trigger, column in ALL.items()}
    no = np.zeros(below.sum(), dtype=bool)
    worse = {**mild, GRADES[grade]: ~no, T.CALM: no, T.HAND_BACK: no}
    assert (ranks(mode, worse) >= ranks(mode, mild)).all()


@pytest.mark.parametrize("mode", Mode)
@pytest.mark.parametrize("order", (T.TERMINATE, T.LAND, T.STOP))
def test_an_order_never_lets_a_vehicle_do_more(mode, order):
    without = {trigger: column[~ALL[order]] for trigger, column in ALL.items()}
    given = {**without, order: np.ones_like(without[order])}
    assert (ranks(mode, given) >= ranks(mode, without)).all()


def test_terminated_is_for_good():
    to, reason = AFTER[Mode.TERMINATED]
    assert (to == Mode.TERMINATED).all() and (reason == BEFORE).all()


@pytest.mark.parametrize("mode", tuple(Mode)[:-1])
def test_the_order_to_terminate_is_always_obeyed(mode):
    assert (AFTER[mode][0][ALL[T.TERMINATE]] == Mode.TERMINATED).all()


@pytest.mark.parametrize("mode", FLYING)
def test_whatever_flies_can_be_landed(mode):
    landing = ALL[T.LAND] & ~ALL[T.TERMINATE] & ~ALL[T.ON_GROUND]
    assert (AFTER[mode][0][landing] == Mode.LAND).all()
    touched = ALL[T.ON_GROUND] & ~ALL[T.TERMINATE]
    assert (AFTER[Mode.LAND][0][touched] == Mode.INIT).all()


@pytest.mark.parametrize("mode", FLYING)
def test_the_switch_always_takes_over(mode):
    """Against everything but an order to land or terminate, and on the ground."""
    free = ~ALL[T.TERMINATE] & ~ALL[T.LAND] & ~ALL[T.ON_GROUND]
    assert (AFTER[mode][0][ALL[T.SWITCH] & free] == Mode.MANUAL).all()


@pytest.mark.parametrize("mode", (Mode.MANUAL, Mode.STOPPED))
def test_what_a_person_took_only_a_person_gives_back(mode):
    """Handed back, or armed anew after a landing."""
    found = reachable(mode, edges(~ALL[T.HAND_BACK] & ~ALL[T.ARM]))
    assert not found & {Mode.AUTO, Mode.SHIELDED, Mode.RECOVER}
    assert {Mode.LAND, Mode.INIT, Mode.READY, Mode.TERMINATED} <= found


def test_a_person_who_flies_is_not_overruled_by_an_alarm():
    in_air = ~ALL[T.TERMINATE] & ~ALL[T.LAND] & ~ALL[T.LINK_LOST] & ~ALL[T.ON_GROUND] & ~ALL[T.HAND_BACK]
    assert (AFTER[Mode.MANUAL][0][in_air] == Mode.MANUAL).all()


@pytest.mark.parametrize("mode", POLICY)
def test_with_a_bad_alarm_the_policy_never_flies(mode):
    held = AFTER[mode][0][ALL[T.ALARM_HOLD]]
    assert not set(held) & {Mode.AUTO, Mode.SHIELDED, Mode.RECOVER}


def test_nothing_flies_that_was_not_armed():
    unarmed = edges(~ALL[T.ARM])
    assert reachable(Mode.INIT, unarmed) == {Mode.INIT, Mode.READY, Mode.TERMINATED}
    assert edges(ALL[T.ARM])[Mode.INIT] == {Mode.INIT, Mode.TERMINATED}, "armed before it was ready"


def test_every_mode_can_be_reached():
    assert reachable(Mode.INIT, edges(np.ones(COUNT, dtype=bool))) == set(Mode)


def test_no_row_is_there_for_nothing():
    """Each decides in some situation."""
    for i, row in enumerate(TABLE):
        without = TABLE[:i] + TABLE[i + 1 :]
        changed = [
            (
                np.array(advance(without, (np.full(COUNT, float(m)), np.full(COUNT, BEFORE)), ALL, ALARM))
                != AFTER[m]
            )
            for m in row.modes
        ]
        assert all(change.any() for change in changed), row


def test_the_drawings_show_every_row():
    assert len(listing().splitlines()) == 2 + len(TABLE)
    drawn = diagram()
    arrows = {(mode, row.to) for row in TABLE for mode in row.modes if mode != row.to}
    assert drawn.count(" --> ") == len(arrows) + 1
    for trigger in Trigger:
        assert trigger.value in listing() and trigger.value in drawn
