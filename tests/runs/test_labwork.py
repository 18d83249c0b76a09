"""The physical experiment: the same days behind every net, the same ways in the simulator, and a folder on disk."""

from dataclasses import replace

import pytest
from harvested import NETS, PLAN, harvest

from fledge.errors import BadFile
from fledge.runs import labwork
from fledge.runs.labwork import Harvest, store, summarise
from fledge.safety import NoNet, StopTube
from fledge.storage import read_flight, read_json
from fledge.study.transfer import FEWEST


def test_all_nets_see_the_same_days():
    flown = {}
    for key, one in PLAN.outings():
        flown.setdefault(key, []).append((one.seed, one.seconds, one.reversed))
    assert list(flown) == [(kind, net) for kind in labwork.KINDS for net in NETS]
    assert flown["lab", "stop-tube"] == flown["lab", "none"] == [(i, 2.0, False) for i in range(6)]
    assert flown["reversed", "none"] == [(i, 2.0, True) for i in range(6)]


def test_another_seed_shares_no_day():
    other = replace(PLAN, seed=1, flights=labwork.SEEDS)
    assert not set(other.seeds) & set(replace(PLAN, flights=labwork.SEEDS).seeds)


def test_the_results_say_what_they_are():
    told = summarise(PLAN, harvest(), "fledge lab-study servo")
    assert set(told["flights"]) == {"lab", "reversed"} and list(told["flights"]["lab"]) == list(NETS)
    assert told["settings"]["command"] == "fledge lab-study servo"
    assert told["settings"]["versions"]["mujoco"] and told["settings"]["policy_sha256"] is None
    assert told["settings"]["twin"]["drone"]["loops"]["airframe"]["mass"] == 0.42
    assert [one["seed"] for one in told["flights"]["lab"]["none"]["each"]] == list(range(6))
    assert "No robot flew" in told["sentences"][0]


def test_the_twin_is_compared_where_no_net_had_a_hand_in_it():
    assert summarise(PLAN, harvest(), "")["transfer"]["net"] == "none"
    fewer = replace(PLAN, nets={"stop-tube": StopTube()})
    assert summarise(fewer, harvest(fewer), "")["transfer"]["net"] == "stop-tube"


def test_flights_that_did_not_come_about_are_not_compared():
    made = harvest()
    grounded = [one._replace(flight=None) for one in made.twin["lab", "none"][:1]]
    twin = dict(made.twin) | {("lab", "none"): [*grounded, *made.twin["lab", "none"][1:]]}
    assert summarise(PLAN, made._replace(twin=twin), "")["transfer"] is None
    few = replace(PLAN, flights=FEWEST - 1)
    assert summarise(few, harvest(few), "")["transfer"] is None
    only = replace(PLAN, kinds=("reversed",))
    assert summarise(only, harvest(only), "")["transfer"] is None


def test_a_policy_is_told_by_its_hash(tmp_path):
    file = tmp_path / "policy.onnx"
    file.write_bytes(b"abc")
    told = summarise(replace(PLAN, name=str(file)), harvest(), "")
    assert told["settings"]["policy_sha256"].startswith("ba7816bf")


def test_the_folder_holds_results_and_a_flight_of_each(tmp_path):
    results = store(tmp_path / "out", harvest(), summarise(PLAN, harvest(), ""), {"flights": 1.0})
    assert read_json(tmp_path / "out" / "results.json") == results
    names = {path.stem for path in (tmp_path / "out" / "flights").iterdir()}
    assert names == {"lab-stop-tube", "lab-none", "reversed-stop-tube", "reversed-none"}
    assert read_flight(tmp_path / "out" / "flights" / "lab-none.mcap").net == "none"


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "results.json").mkdir()
    with pytest.raises(BadFile, match=r"results\.json"):
        store(tmp_path, harvest(), summarise(PLAN, harvest(), ""), {})


@pytest.mark.slow
def test_the_same_ways_are_flown_in_the_simulator():
    scores = labwork.in_simulator(PLAN)
    assert scores.distance_rmse.shape == (1, 6) and (scores.in_view == 1.0).all()
    assert (0.0 < scores.distance_rmse).all() and (scores.distance_rmse < 100.0).all()


@pytest.mark.slow
def test_a_small_experiment_from_beginning_to_end():
    plan = replace(PLAN, nets={"none": NoNet()}, flights=2, seconds=1.0, kinds=("lab",))
    *steps, made = labwork.conduct(plan, jobs=2)
    assert steps == [(1, 2), (2, 2)] and isinstance(made, Harvest)
    told = summarise(plan, made, "")
    assert told["flights"]["lab"]["none"]["began"] == 2
    assert made.simulator.distance_rmse.shape == (1, 2) and told["transfer"] is None
