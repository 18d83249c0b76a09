"""A campaign gives every family its share, counts what is so, and shows it again. One UGV, short flights."""

import json
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from fledge.clearance import clearances
from fledge.dynamics import UGV_FLEET
from fledge.errors import FledgeError
from fledge.falsification.attacks import FAMILIES
from fledge.falsification.campaign import LARGEST, POLICY, TURNS, Campaign, checked, falsify, reenact, summary
from fledge.falsification.scenarios import Terms
from fledge.falsification.toll import KEPT
from fledge.formation import FormationControl
from fledge.geometry import Box
from fledge.pilots import Servo
from fledge.report.replay import draw_flight
from fledge.safety import AbstractNet, NoNet
from fledge.simulation import Rig
from fledge.storage import read_flight, write_flight
from fledge.world import Arena

RIG = Rig(formation=FormationControl(fleet=UGV_FLEET[:1]))
TERMS = Terms(rig=RIG, attack_ticks=300, retreat_ticks=300, factor=2.0)
SMALL = Campaign(NoNet(), "none", 100 * TERMS.ticks, 5, {"servo": Servo()}, TERMS)


@pytest.fixture(scope="module")
def tolls():
    return list(falsify(SMALL))


@pytest.fixture(scope="module")
def flights(tolls):
    return list(reenact(SMALL, tolls[-1].violations))


@pytest.mark.parametrize("flights", [1, 13, 100, 1000, 5000, 77_777])
@pytest.mark.parametrize("policies", [0, 1, 2, 5])
def test_all_steps_are_flown_and_few_more(flights, policies):
    campaign = replace(
        SMALL, steps=flights * TERMS.ticks, policies={str(i): Servo() for i in range(policies)}
    )
    assert campaign.flights >= flights
    least = len(TURNS) + policies
    assert campaign.flights <= max(1.1 * flights + policies, least) + len(TURNS)
    assert len({*campaign.attacks}) == 1 and campaign.attacks[0] % len(TURNS) == 0, "one size, one program"
    assert max(campaign.attacks + campaign.piloted) <= LARGEST
    assert not policies or sum(campaign.piloted) > 0


@pytest.mark.slow
def test_every_family_has_its_turns(tolls):
    turns = Counter(TURNS)
    families = tolls[-1].families
    assert set(families) == {*FAMILIES, POLICY}
    for name in FAMILIES:
        assert families[name].flights * len(TURNS) == turns[name] * sum(SMALL.attacks)
    assert families[POLICY].flights == sum(SMALL.piloted)


@pytest.mark.slow
def test_the_toll_only_grows(tolls):
    assert len(tolls) == len(SMALL.attacks) + len(SMALL.piloted)
    flown = [toll.total.flights for toll in tolls]
    assert flown == sorted(set(flown)) and flown[-1] == SMALL.flights


@pytest.mark.slow
def test_without_a_net_something_is_touched(tolls):
    total = tolls[-1].total
    assert total.contacts > 0.2 * total.flights
    assert total.uav_contacts > 0 and total.ugv_contacts > 0 and total.interventions == 0


@pytest.mark.slow
def test_the_same_seed_finds_the_same(tolls):
    assert list(falsify(SMALL))[-1] == tolls[-1]


@pytest.mark.slow
def test_the_summary_is_json_and_says_all(tolls):
    found = json.loads(json.dumps(summary(SMALL, tolls[-1]), allow_nan=False))
    assert {
        *(
            "net",
            "steps",
            "flights",
            "contacts",
            "breaches",
            "deadlocks",
            "interventions",
            "false_alarm_rate",
        ),
        *("upper_bound_95", "rejected_arenas", "families", "settings", "seed", "version"),
    } <= set(found)
    assert found["steps"] == found["flights"] * TERMS.ticks >= SMALL.steps
    assert found["contacts"] == sum(one["contacts"] for one in found["families"].values())
    assert found["false_alarm_rate"] is None, "no alarm, no rate"
    assert found["contacts"] / found["flights"] < found["upper_bound_95"] <= 1.0
    assert found["near_starts"] > 0.25
    assert found["settings"]["policies"] == ["servo"]


@pytest.mark.slow
def test_what_was_found_is_flown_again_and_replays(tolls, flights, tmp_path):
    found = tolls[-1].violations
    assert {one.family for one in found} >= {"nearest-wall", POLICY}
    assert max(Counter((one.family, one.kind) for one in found).values()) <= KEPT
    assert len(flights) >= 0.9 * len(found), "what hangs by a hair may go well the second time"
    for violation, flight in flights:
        assert flight.rows == TERMS.ticks // 5
        assert (flight.manoeuvre, flight.net, flight.case) == ("attack", "none", violation.flight)
        assert flight.pilot == (violation.pilot or violation.family)
        near = clearances(flight.arena, flight.episode.world, RIG.uav, RIG.formation.fleet)
        if violation.kind == "contact":
            assert min(nearest.gap.min() for nearest in near) < 0.05
    violation, flight = next(pair for pair in flights if pair[0].family == "garbage")
    write_flight(tmp_path / "garbage.mcap", flight)
    again = read_flight(tmp_path / "garbage.mcap")
    np.testing.assert_array_equal(again.episode.world.uav.position.x, flight.episode.world.uav.position.x)
    assert not np.isfinite(again.episode.proposed.uav.forward).all(), "garbage as it came"
    assert np.abs(again.episode.action.forward).max() <= 1.0, "and as the vehicle took it"
    assert draw_flight(again, tmp_path / "garbage.png").stat().st_size > 10_000


class Picky(AbstractNet):
    """Decides with `if`."""

    def init(self, arena, world):
        return ()

    def filter(self, memory, world, commands):
        return (memory, ()) if world.t > 0.0 else (memory, None)


def test_what_cannot_be_flown_is_refused_before():
    assert checked(SMALL) is SMALL
    with pytest.raises(FledgeError, match="picky: JAX cannot compile this net: valid is one that decides"):
        checked(replace(SMALL, net=Picky(), name="picky"))
    closet = Arena(Box(-0.5, 0.5, -0.5, 0.5), 2.0)
    with pytest.raises(FledgeError, match="no room for a UAV and 1 UGVs"):
        checked(replace(SMALL, terms=replace(TERMS, arena=closet)))
