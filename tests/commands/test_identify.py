"""`fledge identify`, as it is typed."""

import pytest

from fledge.commands import identify
from fledge.errors import FledgeError
from fledge.lab.survey.answers import Answer
from fledge.lab.survey.identify import Findings, Identified
from fledge.runs import survey
from fledge.safety.terms import Terms
from fledge.storage import read_contract

FINDINGS = Findings(
    2, 240.0, 101, 75, 0.89, 101, 0.02, 0.005, 0.011, Answer(0.5, 0.12, 0.7), 0.03, 0.07, 0.2, 0.02, 0.08, (0, 7, 7)
)  # fmt: skip


def test_the_file_is_written_and_people_read_what_was_found(tmp_path, monkeypatch, capsys):
    found = survey.Surveyed(Identified(Terms(), FINDINGS), ("ardrone",))
    monkeypatch.setattr(survey, "survey", lambda logs, seen: found)
    out = tmp_path / "mine.toml"
    identify.identify((tmp_path / "flight.mcap",), out)
    assert read_contract(out).contract == Terms().contract
    said = capsys.readouterr().out
    assert "101 stops in the plane, 75 of them fast" in said and "delay 20 ms, poses 5 ms old" in said
    assert said.count("not ours: as simulated") == 1 and str(out) in said


def test_a_folder_that_is_not_there_is_refused_before_any_work(tmp_path):
    with pytest.raises(FledgeError, match="a file in a folder that exists"):
        identify.identify((), tmp_path / "nowhere" / "mine.toml")


def test_without_flights_it_says_what_it_wants(tmp_path):
    with pytest.raises(FledgeError, match="valid are logs of lab flights"):
        identify.identify((), tmp_path / "mine.toml")
