"""What is drawn before a drill, and how it is judged."""

from dataclasses import replace
from math import inf

import jax
import numpy as np
import pytest

from fledge.clearance import clearances
from fledge.dynamics import UGV_FLEET, Quadrotor
from fledge.faults.catalogue import FAULTS, Promise
from fledge.faults.drills import ASIDE, LOW, PHASES, ROWS, Report, draw_drill, judge
from fledge.pytrees import stack
from fledge.safety import Contract
from fledge.supervision.modes import Mode as M

FREEZE, JUMP, MIRROR = (
    next(fault for fault in FAULTS if part in fault.name) for part in ("freeze for 0.5 s", "jumps", "flipped")
)
SOME = range(12)


def same(one, other) -> None:
    jax.tree.map(np.testing.assert_array_equal, stack([one]), stack([other]))


@pytest.mark.parametrize("phase", PHASES)
def test_a_key_stands_for_a_drill(phase):
    one, again, other = (draw_drill(JUMP, phase, key) for key in ((3, 1), (3, 1), (3, 2)))
    same(one, again)
    assert one.begins != other.begins and one.world != other.world


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("i", SOME)
def test_a_drill_begins_clear_of_everything_and_within_the_contract(phase, i):
    drill = draw_drill(JUMP, phase, (5, i))
    assert all(near.gap > 0.0 for near in clearances(drill.arena, drill.world, Quadrotor(), UGV_FLEET))
    assert len(drill.track.x) == ROWS
    assert max(drill.trouble.age, drill.trouble.latency) * 0.01 <= Contract().age
    assert 0.0 <= drill.trouble.share <= 1.0 and drill.trouble.cut == 0.0
    earliest, latest = PHASES[phase]
    assert earliest <= drill.begins <= latest and 1.0 <= drill.ends - drill.begins <= 5.0


def test_phases_begin_where_they_should():
    assert draw_drill(JUMP, "climb", (0,)).world.uav.position.z == LOW
    wall = draw_drill(JUMP, "wall", (0,))
    assert max(ugv.x for ugv in wall.world.ugvs) == pytest.approx(wall.arena.bounds.x_max - ASIDE)
    assert wall.pushing and not draw_drill(JUMP, "cruise", (0,)).pushing


def test_faults_share_all_but_length_and_victims():
    one, other = draw_drill(JUMP, "cruise", (2,)), draw_drill(FREEZE, "cruise", (2,))
    same(one[5:], other[5:])
    assert one.begins == other.begins
    assert other.ends - other.begins == pytest.approx(0.5)
    assert sum(one.struck) == 1.0 and sum(other.struck) == 4.0


def test_everybody_is_struck_in_turn_and_some_faults_are_there_from_the_start():
    groups = {draw_drill(JUMP, "cruise", (i,)).struck for i in range(60)}
    assert len(groups) == 4
    drill = draw_drill(MIRROR, "wall", (1,))
    assert drill.begins == 0.0 and drill.ends == inf


def report(**changed) -> Report:
    """Of one drill in which all went well and the UAV was struck."""
    values = {
        "gaps": (0.1,) * 4,
        "modes": (M.AUTO,) * 4,
        "speeds": (0.5,) * 4,
        "named": (0.1, inf, inf, inf),
        "showing": 0.0,
        "overdue": 0.0,
    }
    fields = {name: changed.get(name, value) for name, value in values.items()}
    return Report(
        *(tuple(np.array([v]) for v in x) if isinstance(x, tuple) else np.array([x]) for x in fields.values())
    )


def judged(fault, struck=(1.0, 0.0, 0.0, 0.0), **changed):
    drill = draw_drill(fault, "cruise", (0,))._replace(struck=struck)
    result = judge(fault, report(**changed), [drill])
    return bool(result.touched[0]), bool(result.safe[0]), float(result.named[0]), bool(result.overdue[0])


def test_a_drill_in_which_all_went_well():
    assert judged(JUMP) == (False, True, 0.1, False)


def test_a_touch_is_a_touch_whoever_it_is():
    for i in range(4):
        assert judged(JUMP, gaps=tuple(0.0 if j == i else 0.2 for j in range(4)))[0]


def test_who_ends_as_nobody_declared_is_not_safe():
    for mode in (M.HOLD, M.RECOVER, M.TERMINATED, M.MANUAL, M.INIT):
        assert not judged(JUMP, modes=(mode, M.AUTO, M.AUTO, M.AUTO))[1]
    assert judged(JUMP, modes=(M.STOPPED,) * 4, speeds=(0.1, 0.0, 0.0, 0.0))[1]
    assert not judged(JUMP, modes=(M.STOPPED,) * 4, speeds=(0.2, 0.0, 0.0, 0.0))[1], "it does not stand"
    assert not judged(FREEZE, modes=(M.AUTO, M.STOPPED, M.AUTO, M.AUTO))[1]


def test_who_was_not_struck_may_fly_on_where_the_others_may_not():
    landing = next(fault for fault in FAULTS if fault.name == "a battery runs low")
    assert judged(landing, modes=(M.INIT, M.AUTO, M.SHIELDED, M.AUTO))[1]
    assert not judged(landing, modes=(M.AUTO, M.AUTO, M.AUTO, M.AUTO))[1]


def test_all_that_are_struck_must_be_named():
    assert judged(JUMP, struck=(1.0, 1.0, 0.0, 0.0))[2] == inf
    assert judged(JUMP, struck=(1.0, 1.0, 0.0, 0.0), named=(0.1, 0.3, inf, inf))[2] == 0.3
    assert judged(JUMP, overdue=1.0)[3]


def test_promises_come_first():
    order = [list(Promise).index(fault.promise) == 2 for fault in FAULTS]
    assert order == sorted(order)
    assert replace(JUMP, tilt=0.5) != JUMP
