"""What is counted of a flight: each law on ticks made by hand."""

import pytest
from ticks import HEIGHT, SPREAD, decision, said, world

from fledge.camera import Lens
from fledge.dynamics import REAL_AR_DRONE
from fledge.lab.control.phases import Phase
from fledge.lab.shell.tally import LAYERS, Tally, summary
from fledge.supervision.modes import Mode
from fledge.world import Arena, Reason

TALLY = Tally(Arena.lab())
M, R = Mode, Reason


def counted(ticks, tally=TALLY, truth=None):
    """The summary of ticks 10 ms apart."""
    count = tally.init()
    for number, tick in enumerate(ticks):
        count = tally.step(count, 0.01 * number, tick, truth)
    return summary(count)


def times(decided, seconds, phase=Phase.FLY):
    return [said(uav=decided, phase=phase) for _ in range(round(100 * seconds))]


def test_nothing_is_counted_of_nothing():
    found = counted([])
    assert (found["in_view"], found["distance_rmse_px"], found["least_gap_m"]) == (None, None, None)
    assert found["interventions"] == {"net": {}, "watchdog": {}, "people": {}}


def test_the_pilots_time_is_that_of_its_phase():
    flight = [
        *times(decision(), 1.0, Phase.JOIN),
        *times(decision(), 3.0),
        *times(decision(), 1.0, Phase.LAND),
    ]
    assert counted(flight)["flown_s"] == pytest.approx(3.0, abs=0.02)


def test_errors_are_those_of_the_picture():
    """The centroid is f x / z pixels off where the UAV is x metres off, and the radius f spread / z."""
    off = counted([said(seen=world(x=0.2)) for _ in range(50)])
    assert off["distance_rmse_px"] == pytest.approx(Lens().focal_px * 0.2 / HEIGHT)
    assert off["radius_rmse_px"] == pytest.approx(0.0, abs=1e-9)
    high = counted([said(seen=world(z=3.5)) for _ in range(50)])
    assert high["radius_rmse_px"] == pytest.approx(Lens().focal_px * SPREAD * (1.0 / HEIGHT - 1.0 / 3.5))


def test_in_view_is_a_share_of_the_pilots_frames():
    seen, lost = world(), world(x=2.0)
    flight = [said(seen=seen) for _ in range(300)] + [said(seen=lost) for _ in range(100)]
    assert counted(flight)["in_view"] == 0.75
    before = [said(seen=lost, phase=Phase.JOIN) for _ in range(100)]
    assert counted([*before, *flight])["in_view"] == 0.75


def test_an_intervention_begins_after_half_a_second_without():
    held, free = decision(M.SHIELDED, R.WALL), decision()
    flight = [*times(held, 1.0), *times(free, 0.3), *times(held, 0.1), *times(free, 0.6), *times(held, 0.1)]
    assert counted(flight)["interventions"]["net"] == {"wall": 2}


def test_interventions_have_layers_and_reasons():
    flight = [
        *times(decision(M.SHIELDED, R.OBSTACLE), 0.1),
        *times(decision(M.HOLD, R.STALE), 0.1),
        *times(decision(M.RECOVER, R.RECOVERING), 0.1),
        *times(decision(M.MANUAL, R.TAKE_OVER), 0.1),
        *times(decision(M.LAND, R.LANDING), 0.1, Phase.LAND),
    ]
    assert counted(flight)["interventions"] == {
        "net": {"obstacle": 1},
        "watchdog": {"stale": 1},
        "people": {"take_over": 1},
    }
    assert {LAYERS[reason] for reason in R if reason in LAYERS} == {"net", "watchdog", "people"}
    assert R.NONE not in LAYERS and R.LANDING not in LAYERS and R.NOT_READY not in LAYERS


def test_what_is_held_back_on_the_floor_is_no_intervention():
    for phase in (Phase.WAIT, Phase.TAKE_OFF, Phase.LAND, Phase.OVER):
        found = counted(times(decision(M.HOLD, R.STALE), 1.0, phase))
        assert found["interventions"]["watchdog"] == {}


def test_take_overs_are_counted_as_they_begin():
    by_hand, free = decision(M.MANUAL, R.TAKE_OVER), decision()
    assert (
        counted([*times(free, 0.1), *times(by_hand, 2.0), *times(free, 0.1), *times(by_hand, 0.1)])[
            "takeovers"
        ]
        == 2
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("decided", "seconds", "needed"),
    [
        (decision(M.STOPPED, R.JUMP), 1.0, 1),
        (decision(M.STOPPED, R.STOPPED), 1.0, 0),  # ordered by a person
        (decision(M.HOLD, R.STALE), 9.9, 0),
        (decision(M.HOLD, R.STALE), 10.2, 1),
        (decision(M.HOLD, R.STALE), 30.0, 1),
        (decision(M.SHIELDED, R.WALL), 30.0, 0),
        (decision(M.MANUAL, R.TAKE_OVER), 30.0, 0),
    ],
)
def test_a_person_is_needed_where_a_vehicle_waits_for_one(decided, seconds, needed):
    flight = [*times(decision(), 0.5), *times(decided, seconds), *times(decision(), 0.5)]
    assert counted(flight)["human_interventions_needed"] == needed


def test_a_person_is_needed_where_an_alarm_lands_it():
    for reason, needed in ((R.BATTERY_LOW, 1), (R.LINK_LOST, 1), (R.LANDING, 0)):
        flight = [*times(decision(), 0.5), *times(decision(M.LAND, reason), 2.0, Phase.LAND)]
        assert counted(flight)["human_interventions_needed"] == needed


def test_the_referee_sees_hulls():
    """The UAV's hull a centimetre before the wall, then a centimetre behind."""
    wall = Arena.lab().bounds.x_max - REAL_AR_DRONE.radius
    near = counted([said(seen=world(x=wall - 0.01))] * 20)
    assert near["contacts"] == 0 and near["least_gap_m"]["uav"] == pytest.approx(0.01)
    behind = counted([said(seen=world(x=wall + 0.01))] * 20)
    assert behind["contacts"] == 1 and behind["least_gap_m"]["uav"] == pytest.approx(-0.01)


def test_a_contact_is_counted_as_it_begins():
    there, away = [said(seen=world(x=3.2))] * 20, [said()] * 20
    assert counted([*away, *there, *away, *there])["contacts"] == 2


def test_the_floor_may_be_touched_on_the_way_up_and_down_alone():
    low = world(z=0.05, middle=(2.0, 0.0))
    for phase, contacts in ((Phase.TAKE_OFF, 0), (Phase.LAND, 0), (Phase.WAIT, 0), (Phase.FLY, 1)):
        assert counted([said(seen=low, phase=phase)] * 20)["contacts"] == contacts
    onto = world(z=0.2, middle=(-SPREAD, 0.0))
    assert counted([said(seen=onto, phase=Phase.LAND)] * 20)["contacts"] == 1


def test_the_referee_sees_the_truth_where_it_is_shown():
    assert counted([said()] * 20, truth=world(x=3.2))["contacts"] == 1
