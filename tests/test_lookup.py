"""A name is the name of a module, or points outside; there is no registry."""

import pytest

from fledge import lookup
from fledge.errors import FledgeError, UnknownName
from fledge.manoeuvres import MANOEUVRES, AbstractManoeuvre, Combined
from fledge.pilots import PILOTS, AbstractPilot, Servo
from fledge.setups import HELD_OUT_FAMILIES


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
