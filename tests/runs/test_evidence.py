"""What is said of a net is no more than was found, and what was found can be seen."""

import numpy as np
import pytest

from fledge.errors import BadFile
from fledge.falsification.campaign import Campaign
from fledge.falsification.scenarios import Terms, draw_scenario
from fledge.falsification.toll import Toll, Violation
from fledge.runs import evidence
from fledge.runs.evidence import sentences, store
from fledge.safety import NoNet
from fledge.storage import read_flight

pytestmark = pytest.mark.slow

DRAW = draw_scenario(np.random.default_rng(0), 0, 0, Terms())
CAMPAIGN = Campaign(NoNet(), "my.nets:Own", 24_000, 3)
FOUND = tuple(Violation(i, "corner", None, "contact", 1, 2.5, -0.1, DRAW) for i in (4, 9))


def findings(**numbers):
    usual = {"net": "stop-tube", "contacts": 0, "deadlocks": 0, "flights": 5000, "retreats": 4000}
    return {**usual, "upper_bound_95": 0.0006, "violations": [], **numbers}


def test_a_net_that_was_not_beaten_holds_as_far_as_was_tried():
    (said,) = sentences(findings())
    assert said.startswith("stop-tube holds: ") and "below 0.06 % (95 % confidence)" in said


def test_a_net_that_was_beaten_is_said_to_be():
    files = [{"file": "v/a.mcap"}, {"file": None}]
    said, where = sentences(findings(contacts=12, deadlocks=3, violations=files))
    assert said.startswith("stop-tube is beaten: in 12 of 5,000 flights") and "in 3 of 4,000" in said
    assert where == "1 of them to replay: fledge replay v/a.mcap"
    assert len(sentences(findings(deadlocks=1))) == 1


@pytest.fixture
def reenacted(monkeypatch, shared_flight):
    """The first violation happens again, the second does not."""
    monkeypatch.setattr(evidence, "reenact", lambda campaign, found: iter([(found[0], shared_flight)]))


@pytest.fixture
def shared_flight():
    from fledge.engines import fly_plain
    from fledge.episode import Flight
    from fledge.manoeuvres import Climb
    from fledge.pilots import Servo
    from fledge.simulation import Case, Crew

    case = Case.draw(Climb(), (1, 0), 4)
    episode = fly_plain(case, Crew(Servo()), (1, 0))
    return Flight(episode, "attack", "corner", "none", 3, 4, (0, 1, 2), case.plan.arena)


def test_what_happened_again_is_stored_and_the_rest_is_said_to_have_gone_well(tmp_path, reenacted):
    folder = tmp_path / "violations"
    told = store(folder, CAMPAIGN, Toll(violations=FOUND))
    file = folder / "my.nets-Own-corner-3-4.mcap"
    assert [one["file"] for one in told] == [str(file), None]
    assert [path.name for path in folder.iterdir()] == [file.name]
    assert read_flight(file).manoeuvre == "attack"
    assert told[0] == {
        **{"flight": 4, "family": "corner", "pilot": None, "kind": "contact", "vehicle": 1},
        **{"time_s": 2.5, "gap_m": -0.1, "file": str(file)},
    }


def test_nothing_found_leaves_no_folder(tmp_path):
    assert store(tmp_path / "violations", CAMPAIGN, Toll()) == []
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_is_one_line(tmp_path, reenacted):
    (tmp_path / "file").write_text("")
    with pytest.raises((BadFile, FileExistsError, NotADirectoryError)):
        store(tmp_path / "file", CAMPAIGN, Toll(violations=FOUND))
