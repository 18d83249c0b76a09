"""Every mode against everything that can happen in it, flown; and whether a wrong table would be noticed."""

from dataclasses import replace
from itertools import pairwise, product
from typing import NamedTuple
from unittest.mock import patch

import numpy as np
import pytest
from scripted import NET, TOO_FAST, WAYS, WISH

from fledge.supervision.modes import TABLE, Row, Trigger, advance
from fledge.supervision.modes import Mode as M
from fledge.supervision.supervisor import Supervisor

pytestmark = pytest.mark.slow

GRABBED = {"deflection": 0.6}
WELL = {"wish": WISH}
POLICY = (M.AUTO, M.SHIELDED, M.RECOVER, M.HOLD, M.STOPPED)
FADING = POLICY[:3]
FLYING = (*POLICY, M.MANUAL, M.LAND)


def all_to(modes: tuple[M, ...], to: M) -> dict[M, M]:
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


def flown(table: tuple[Row, ...], mode: M, name: str) -> tuple[M, ...]:
    """The modes through which a flight goes on from `mode`, which comes first."""
    seconds, said, _ = SPEC[name]
    begin = WAYS[mode](supervisor=Supervisor(NET, **PATIENCE, table=table))
    modes = [begin.mode, *(flight.mode for flight in begin.history(seconds, **said))]
    return (modes[0], *(to for was, to in pairwise(modes) if to != was))


def wanted(mode: M, name: str) -> tuple[M, ...]:
    """The modes that the specification says."""
    to = SPEC[name][2].get(mode, mode)
    return (mode, *to) if isinstance(to, tuple) else (mode,) if to == mode else (mode, to)


class Visits(NamedTuple):
    """Every situation that the specification's flights come through; arrays of shape (ticks,)."""

    cell: np.ndarray
    """Which flight: an index into `CELLS`."""
    mode: np.ndarray
    triggers: dict[Trigger, np.ndarray]

    def after(self, table: tuple[Row, ...]) -> np.ndarray:
        """The mode after each."""
        return advance(table, (self.mode, 0.0 * self.mode), self.triggers, 0.0)[0]


CELLS = list(product(WAYS, SPEC))


@pytest.fixture(scope="module")
def flights() -> tuple[list[tuple[M, ...]], Visits]:
    """(what came of every cell, the visits)."""
    paths, rows = [], []

    def watched(table, now, triggers, alarm):
        rows.append((len(paths), now[0], *(triggers[trigger] for trigger in Trigger)))
        return advance(table, now, triggers, alarm)

    with patch("fledge.supervision.supervisor.advance", watched):
        for cell in CELLS:
            paths.append(flown(TABLE, *cell))
    cell, mode, *triggers = np.array(rows, dtype=float).T
    named = zip(Trigger, triggers, strict=True)
    return paths, Visits(cell.astype(int), mode, {trigger: column > 0.5 for trigger, column in named})


def test_every_mode_answers_to_everything_as_it_should(flights):
    paths, _ = flights
    wrong = {cell: path for cell, path in zip(CELLS, paths, strict=True) if path != wanted(*cell)}
    assert not wrong


def noticed(visits: Visits, table: tuple[Row, ...]) -> bool:
    """Whether some flight fails with another table; flown only where it decides otherwise."""
    others = np.unique(visits.cell[visits.after(table) != visits.after(TABLE)])
    return any(flown(table, *CELLS[i]) != wanted(*CELLS[i]) for i in others)


EVERY_ROW = pytest.mark.parametrize("i", range(len(TABLE)), ids=lambda i: f"{i}-{TABLE[i].to.name}")


@EVERY_ROW
def test_no_row_and_no_part_of_it_can_be_missed(flights, i):
    """Neither the row nor one of its modes, nor one of its conditions."""
    _, visits = flights
    row = TABLE[i]
    assert noticed(visits, TABLE[:i] + TABLE[i + 1 :])
    for mode in row.modes:
        less = replace(row, modes=tuple(m for m in row.modes if m != mode))
        assert noticed(visits, TABLE[:i] + (less,) + TABLE[i + 1 :]), mode
    for trigger in row.when:
        less = replace(row, when=tuple(t for t in row.when if t != trigger))
        assert noticed(visits, TABLE[:i] + (less,) + TABLE[i + 1 :]), trigger
