"""`make margins` in brief: who keeps too little of the margin is touched, by the families and by who searches."""

from pathlib import Path

import pytest
from loaded import load

from fledge.falsification.scenarios import Terms
from fledge.safety import StopTube

pytestmark = pytest.mark.slow

BENCHMARK = Path(__file__).parents[2] / "benchmarks" / "margins.py"
SPEED = 0.5


@pytest.fixture(scope="module")
def margins():
    return load(BENCHMARK)


@pytest.fixture(scope="module")
def terms(margins):
    return Terms(rig=margins.capped(SPEED), retreat_ticks=1)


def test_the_families_touch_with_both_kinds_of_vehicles(margins, terms):
    hit = margins.contacts(StopTube(scale=0.3), terms, 40)
    assert hit["uav"] > 0 and hit["ugv"] > 0


def test_who_searches_finds_what_is_to_be_found(margins, terms):
    assert margins.hunted(StopTube(scale=0.5), terms, "uav")


@pytest.mark.parametrize("kind", ["uav", "ugv"])
def test_a_hunt_is_after_one_kind_of_vehicle_and_strains_the_whole_contract(margins, terms, kind):
    hunt = margins.lurking(terms, kind)
    c = terms.contract
    assert len(hunt.draws) == len(hunt.searches) == margins.SCENES
    for draw in hunt.draws:
        assert (draw.scenario.focus == 0.0) == (kind == "uav")
        assert draw.scenario.trouble.age * c.period == pytest.approx(c.age)
        assert draw.scenario.trouble.share == draw.scenario.trouble.malice == 1.0
