"""A name is the name of a module, or points outside; there is no registry."""

import pytest

from fledge import lookup
from fledge.errors import BadFile, FledgeError, UnknownName
from fledge.geometry import Box
from fledge.manoeuvres import MANOEUVRES, AbstractManoeuvre, Combined
from fledge.pilots import PILOTS, AbstractPilot, Servo
from fledge.safety import NETS, AbstractNet, NoNet, StopTube
from fledge.storage import read_contract
from fledge.study.setups import HELD_OUT_FAMILIES
from fledge.world import Arena


def test_every_shipped_pilot_and_manoeuvre_is_found_by_its_own_name():
    assert lookup.shipped("fledge.pilots", AbstractPilot) == {one.name: type(one) for one in PILOTS}
    assert lookup.shipped("fledge.manoeuvres", AbstractManoeuvre) == {
        one.name: type(one) for one in MANOEUVRES
    }
    assert [lookup.pilot(one.name) for one in PILOTS] == list(PILOTS)
    assert [lookup.manoeuvre(one.name) for one in MANOEUVRES] == list(MANOEUVRES)


@pytest.mark.parametrize("name", ["", "Servo", "base", "paths", "human_model", "servo "])
def test_nothing_else_is_found(name):
    with pytest.raises(UnknownName, match="valid are .*servo"):
        lookup.pilot(name)
    with pytest.raises(
        UnknownName, match="valid are climb, combined, descend, fixed-altitude, package.module:Name"
    ):
        lookup.manoeuvre(name)


def test_every_shipped_net_is_found_by_its_module():
    found = lookup.shipped("fledge.safety", AbstractNet)
    assert set(found.values()) == {type(net) for net in NETS}
    assert lookup.net("stop-tube") == StopTube() and lookup.net("none") == NoNet()
    assert lookup.net("fledge.safety:StopTube") == StopTube()
    with pytest.raises(UnknownName, match="unknown net 'tube': valid are .*none, package.module:Name"):
        lookup.net("tube")


def test_a_colon_points_outside():
    assert lookup.pilot("fledge.pilots:Servo") == Servo()
    assert lookup.manoeuvre("fledge.manoeuvres.combined:Combined") == Combined()


def test_tests_are_flown_along_paths_held_out():
    assert lookup.test("combined").families == HELD_OUT_FAMILIES
    assert lookup.manoeuvre("combined").families != HELD_OUT_FAMILIES
    assert lookup.test("fledge.manoeuvres:Combined") == Combined()


def test_setups_are_those_that_train_once_on_what_is_stored():
    for name in ("primitive", "primitive-paper", "primitive-zero", "dnn-combined"):
        assert lookup.setup(name).name == name
    for name in ("servo", "primitive-matched", "primitive-paper-10000", ""):
        with pytest.raises(UnknownName, match="unknown set-up .*valid are dnn-combined, primitive,"):
            lookup.setup(name)


def test_a_contestant_is_a_pilot_or_a_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "nothing").write_text("")
    assert lookup.contestant("servo") == Servo()
    for name, line in {
        "ace": "unknown pilot 'ace'.*, or a policy's file",
        "ace.onnx": "ace.onnx: cannot be read",
        "nothing": "nothing: an ONNX file without fledge's metadata",
    }.items():
        with pytest.raises(FledgeError, match=line):
            lookup.contestant(name)


def test_the_papers_two_arenas_come_along():
    assert lookup.ARENAS.keys() == {"square", "lab"}
    assert lookup.arena("square") == Arena.square()
    assert lookup.arena("lab").bounds == Box(-3.3, 3.3, -2.5, 2.5)
    assert lookup.arena("lab").obstacles == ()


def test_any_other_arena_is_a_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("lab", "hall", "hall.toml"):
        (tmp_path / name).write_bytes(lookup.ARENAS["square"].read_bytes())
    assert lookup.arena("hall") == lookup.arena("hall.toml") == lookup.arena("./lab") == Arena.square()
    assert lookup.arena("lab") != Arena.square()
    with pytest.raises(BadFile, match="nowhere.toml: cannot be read: No such file"):
        lookup.arena("nowhere.toml")


@pytest.mark.parametrize("name", ["", "Lab", "labs", ".", "lab.yaml"])
def test_an_unknown_arena_is_told_which_there_are(name):
    with pytest.raises(UnknownName, match="unknown arena '.*': valid are FILE.toml, lab, square$"):
        lookup.arena(name)


def test_a_net_in_a_lab_relies_on_its_contract(tmp_path):
    ours, mine = lookup.lab_net("stop-tube"), tmp_path / "mine.toml"
    assert ours == read_contract(lookup.CONTRACTS["ar-drone-2"]).under(StopTube()) != StopTube()
    mine.write_text(lookup.CONTRACTS["ar-drone-2"].read_text().replace("error_m = 0.1312", "error_m = 0.2"))
    assert lookup.lab_net("stop-tube", str(mine)).uav.error == 0.2
    assert lookup.lab_net("none") == NoNet()
    with pytest.raises(UnknownName, match="unknown contract 'paper': valid are FILE.toml, ar-drone-2"):
        lookup.lab_net("stop-tube", "paper")
