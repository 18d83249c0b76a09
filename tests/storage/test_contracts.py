"""Contracts on disk."""

import tomllib
from dataclasses import replace

import pytest

from fledge import lookup
from fledge.errors import BadFile
from fledge.safety import Contract, UavStop
from fledge.safety.terms import Terms
from fledge.storage import read_contract, write_contract

TERMS = Terms(Contract(latency=0.03, velocity_error=0.155), UavStop(tilt=-0.1, error=0.123, hold=0.09))


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "mine.toml"
    write_contract(
        path, TERMS, 'the "blue" one', {"stops": 41, "delay_s": 0.02, "ugv_stops": [3, 0]}, "How.\nBy whom."
    )
    return path


def changed(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    return path


def test_what_is_written_is_read(path):
    read = read_contract(path)
    assert replace(read, ugvs=TERMS.ugvs) == TERMS
    for one, other in zip(read.ugvs, TERMS.ugvs, strict=True):
        assert one.radius == pytest.approx(other.radius, rel=1e-3) and one.acceleration == other.acceleration


def test_people_find_where_it_comes_from(path):
    assert path.read_text().startswith("# How.\n# By whom.\n")
    file = tomllib.loads(path.read_text())
    assert file["name"] == 'the "blue" one'
    assert file["found"] == {"stops": 41, "delay_s": 0.02, "ugv_stops": [3, 0]}


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("latency_s =", "latency =", "contract has 'latency'"),
        ("speed_s = 0.34\n", "", "uav has no speed_s"),
        ("error_m = 0.123", 'error_m = "much"', "error_m of uav is 'much'"),
        ("error_m = 0.123", "error_m = nan", "error_m of uav is nan"),
        ("error_m = 0.123", "error_m = -0.1", "a number from 0 to 50"),
        ("acceleration_m_s2 = 1.0", "acceleration_m_s2 = 0.2", "valid is more than the disturbance, 0.3"),
        ("period_s = 0.01", "period_s = 0.0", "a period of 0 s"),
        ("[uav]", "[uva]", "a contract has 'uva'"),
        ("[contract]", "[contract", "a contract"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(path, old, new, said):
    with pytest.raises(BadFile, match=r"mine\.toml") as error:
        read_contract(changed(path, old, new))
    assert said in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize("name", lookup.CONTRACTS)
def test_those_that_come_along_can_be_read(name):
    terms = read_contract(lookup.contract_file(name))
    assert terms.uav.error >= 0.05 and len(terms.ugvs) == 3


def test_the_lab_has_one():
    assert lookup.LAB_CONTRACT in lookup.CONTRACTS
