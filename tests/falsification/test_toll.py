"""Counts add up, nothing is lost, and what is no number is held against the net."""

import numpy as np
import pytest

from fledge.falsification.scenarios import Terms, draw_scenario
from fledge.falsification.sorties import Outcome, Tally
from fledge.falsification.toll import KEPT, Count, Salvo, Toll, violations

NAN = float("nan")
DRAW = draw_scenario(np.random.default_rng(0), 0, 2, Terms())


def salvo(families, uav, ugv, deadlocks=None, first=0) -> Salvo:
    """Flights with these gaps of the UAV and of the first UGV."""
    n = len(families)
    some = np.arange(n, dtype=float)
    least = (np.array(uav), np.array(ugv), np.full(n, 0.8))
    contact = ~(np.minimum(*least[:2]) > 0.0)
    tally = Tally(least, np.where(contact, 120.0, -1.0), contact * 1.0, some, some, some // 2)
    deadlock = np.zeros(n) if deadlocks is None else np.array(deadlocks)
    outcome = Outcome(tally, np.ones(n), deadlock, ())
    return Salvo(range(first, first + n), families, None, [DRAW] * n, outcome, 10.0)


MIXED = salvo(
    ["a", "b", "a", "b", "a"],
    [0.5, -0.1, 0.2, NAN, 0.4],
    [0.3, 0.2, -0.2, 0.1, 0.6],
    [0.0, 0.0, 1.0, 0.0, 1.0],
)


def test_contacts_are_counted_by_flight_and_by_kind_of_vehicle():
    a, b = Count.of(MIXED, "a"), Count.of(MIXED, "b")
    assert (a.flights, a.contacts, a.uav_contacts, a.ugv_contacts, a.deadlocks) == (3, 1, 0, 1, 2)
    assert (b.flights, b.contacts, b.uav_contacts, b.ugv_contacts, b.deadlocks) == (2, 2, 2, 0, 0)
    assert (a.uav_gap_m, a.ugv_gap_m) == pytest.approx((0.2, -0.2))
    assert b.uav_gap_m == pytest.approx(-0.1)
    assert a.alarms + b.alarms == 10 and a.false_alarms + b.false_alarms == 4


def test_what_is_no_number_has_touched_something():
    found = {one.flight: one for one in violations(MIXED)}
    assert found[3].kind == "contact" and found[3].vehicle == 0 and found[3].gap_m == 0.0


def test_every_contact_and_dead_lock_is_a_violation():
    assert [(one.flight, one.kind, one.vehicle, one.time_s) for one in violations(MIXED)] == [
        (1, "contact", 0, 1.2),
        (2, "contact", 1, 1.2),
        (3, "contact", 0, 1.2),
        (4, "deadlock", 2, 10.0),
    ]


def test_salvos_add_up():
    toll = Toll().after(MIXED).after(MIXED)
    assert toll.total.flights == 10 and toll.total.contacts == 6
    assert toll.families["a"] == Count.of(MIXED, "a") + Count.of(MIXED, "a")
    assert toll.rejected == 10 * DRAW.rejected and toll.near == 10 * DRAW.near


def test_a_few_violations_of_every_kind_are_kept_the_first_ones():
    many = salvo(["a"] * 9, [-1.0] * 6 + [1.0] * 3, [1.0] * 9, [0.0] * 6 + [1.0] * 3)
    toll = Toll().after(many).after(many)
    assert [one.flight for one in toll.violations] == [*range(KEPT), *range(6, 6 + KEPT)]


def test_nothing_flown_is_nothing_found():
    assert Toll().total == Count()
