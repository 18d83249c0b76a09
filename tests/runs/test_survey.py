"""From logs of flights to a contract's file."""

import pytest
from surveyed import flight

from fledge.errors import BadFile, FledgeError
from fledge.lab.control.outfit import SUBJECTS, Outfit
from fledge.lab.lockstep import fly_lockstep
from fledge.lab.shell.logs import Entry, Log
from fledge.lab.shell.rerun import read_opening, read_ticks
from fledge.lab.survey.identify import identify
from fledge.lab.twin.twin import Options, Twin
from fledge.pilots import Exciter
from fledge.runs import hangar, survey
from fledge.safety import StopTube
from fledge.storage import read_contract
from fledge.storage.records import to_json
from fledge.world import Arena


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """A second of the exciter's, from the twin's pad, logged."""
    path, arena = tmp_path_factory.mktemp("survey") / "flight.mcap", Arena.lab()
    outfit = Outfit(arena, "exciter", "stop-tube", axes=(0, 1, 2), duration=1.0, unattended=True)
    ticks = fly_lockstep(outfit.controller(Exciter(), StopTube()), Twin(arena, 0, Options()), 16.0)
    with Log(path, hangar._facts(outfit), {"outfit": to_json(outfit)}) as book:
        for number, tick in enumerate(ticks):
            book.tick(Entry(number, tick.heard, tick.said, 0))
    return path


@pytest.mark.slow
def test_a_log_is_flown_once_more(log, tmp_path):
    outfit, controller = hangar.restored(read_opening(log), tmp_path)
    seen = []
    found = survey._trace(log, controller, outfit, seen.append)
    ticks = sum(1 for _ in read_ticks(log))
    assert seen == list(range(ticks)) and 0.9 * ticks < len(found.t) <= ticks


@pytest.mark.slow
def test_one_that_shows_too_little_is_refused(log):
    with pytest.raises(FledgeError, match="1 flights with . stops in the plane"):
        survey.survey([log])


@pytest.mark.slow
def test_one_that_another_pilot_flew_is_refused(log, tmp_path):
    outfit, _ = hangar.restored(read_opening(log), tmp_path)
    other = outfit.controller(Exciter(reach=0.0, gentlest=1.0, longest=9.0), StopTube(scale=0.0))
    with pytest.raises(BadFile, match="not the same when it is flown once more"):
        survey._trace(log, other, outfit, lambda ticks: None)


def test_nothing_is_too_little():
    with pytest.raises(FledgeError, match="no flight"):
        survey.survey([])


@pytest.mark.slow
def test_what_is_kept_is_what_was_found(tmp_path):
    surveyed = survey.Surveyed(identify([flight(130.0)], 0.1), SUBJECTS)
    found = survey.keep(tmp_path / "mine.toml", surveyed, "mine", ["a.mcap"])
    terms = read_contract(tmp_path / "mine.toml")
    assert terms.uav.error == pytest.approx(surveyed.identified.terms.uav.error, rel=1e-3)
    assert terms.contract.latency == surveyed.identified.terms.contract.latency
    assert found["stops"] == surveyed.identified.findings.stops
    assert "# - a.mcap" in (tmp_path / "mine.toml").read_text()
