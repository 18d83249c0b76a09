"""Rows of a lab flight: one for each decision of the pilot's, and none for anybody else's."""

import numpy as np
import pytest
from ticks import SPREAD, decision, said, world

from fledge.lab.control.phases import Phase
from fledge.lab.shell.rows import Rows, spread, together
from fledge.observation import Action
from fledge.supervision.modes import Mode
from fledge.world import Reason, VelocityCommand

ROWS = Rows()
PUSH = VelocityCommand(0.5, 0.0, 0.0, 0.0)


def flown(ticks):
    """The rows that come of these."""
    memory, rows = ROWS.init(), []
    for tick in ticks:
        memory, row = ROWS.step(memory, tick)
        rows += [row] if row else []
    return rows


def decisions(count, ticks=5, phase=Phase.FLY, start=0):
    """So many decisions, each for so many ticks."""
    flight = []
    for i in range(start, start + count):
        action = Action(0.01 * i, 0.0, 0.0, 0.0)
        flight += [said(0.05 * i + 0.01 * k, action=action, phase=phase) for k in range(ticks)]
    return flight


def test_a_row_for_every_decision_with_the_world_as_it_was_then():
    rows = flown(decisions(4))
    assert [row.action.forward for row in rows] == [0.0, 0.01, 0.02]  # the last may have more ticks to come
    assert [row.world.t for row in rows] == pytest.approx([0.0, 0.05, 0.1])
    assert [row.ideal_spread for row in rows] == pytest.approx([SPREAD] * 3)


def test_ticks_that_come_early_or_late_change_no_row():
    for ticks in (4, 6):
        assert [row.action.forward for row in flown(decisions(4, ticks))] == [0.0, 0.01, 0.02]


def test_there_are_rows_only_while_the_pilot_flies():
    """What a servo decided before it is not the pilot's, though it stands for the first ticks of its turn."""
    joining = decisions(3, phase=Phase.JOIN)
    late = [said(0.2, action=joining[-1].action) for _ in range(3)]
    landing = decisions(3, phase=Phase.LAND, start=7)
    rows = flown([*joining, *late, *decisions(2, start=5), *landing])
    assert [row.action.forward for row in rows] == [0.05, 0.06]


def test_a_decision_that_stands_for_long_has_several_rows():
    rows = flown(decisions(2, ticks=35))
    assert [row.action.forward for row in rows] == [0.0] * 4 + [0.01] * 3
    assert np.diff([row.world.t for row in rows[:4]]) == pytest.approx(0.1)


def test_an_intervention_in_any_tick_is_one_of_the_row():
    held = decision(Mode.SHIELDED, Reason.WALL, PUSH, clearance=0.2)
    ticks = decisions(2)
    ticks[2] = said(0.02, held, action=ticks[0].action)
    (row,) = flown(ticks)
    assert (row.verdicts[0].intervened, row.verdicts[0].reason) == (1.0, Reason.WALL)
    assert row.verdicts[0].clearance == 0.2
    assert len(row.verdicts) == 4


def test_rows_become_one_episode():
    rows = flown(decisions(6))
    episode = together(rows)
    assert episode.world.t.shape == episode.verdicts[3].reason.shape == (5,)
    assert episode.action.forward.tolist() == [row.action.forward for row in rows]
    assert spread(world(middle=(2.0, -1.0))) == pytest.approx(SPREAD)
