"""What a study leaves behind can be read again, and its folder holds nothing else."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fledge.engines import fly_plain
from fledge.episode import Flight
from fledge.learning.policy import Policy
from fledge.manoeuvres import Combined
from fledge.pilots import Servo
from fledge.runs import archive
from fledge.simulation import Case, Crew
from fledge.storage import read_flight, read_json, read_policy
from fledge.study.experiments import Progress, Results
from fledge.study.setups import Study

pytestmark = pytest.mark.slow

STUDY = Study("quick", (), 3, 2, 2)


def layer(*shape):
    return np.arange(np.prod(shape), dtype=np.float32).reshape(shape)


@pytest.fixture(scope="module")
def results():
    """Of a set-up that learnt, with two seeds, and of one that did not."""
    case = Case.draw(Combined(), (0,), rows=20)
    episode = fly_plain(case, Crew(Servo()), (1,))
    sample = Flight(episode, "combined", "primitive", "none", 0, 0, (0, 1, 2), case.plan.arena)
    both = Policy((layer(2, 11, 4),), (layer(2, 4),), layer(2, 11), 1.0 + layer(2, 11), tuple(range(11)), 11)
    learnt = SimpleNamespace(sample=sample, policy=both)
    servo = SimpleNamespace(sample=replace(sample, pilot="servo"), policy=None)
    summary = {"seed": 0, "setups": {"servo": {"mean": np.float32(0.5)}}, "comparisons": ()}
    return Results(STUDY, {"primitive": learnt, "servo": servo}, summary)


def test_everything_is_there_and_can_be_read(results, tmp_path):
    summary = archive.store(tmp_path / "report", results, {"study": 1.5})
    names = sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*") if path.is_file())
    assert names == [
        "report/flights/primitive.mcap",
        "report/flights/servo.mcap",
        "report/policies/primitive.onnx",
        "report/results.json",
    ]
    assert read_flight(tmp_path / "report/flights/servo.mcap").pilot == "servo"
    assert read_json(tmp_path / "report/results.json") == summary
    assert summary == {
        "seed": 0,
        "setups": {"servo": {"mean": 0.5}},
        "comparisons": [],
        "times": {"study": 1.5},
    }


def test_the_policy_is_the_first_seeds(results, tmp_path):
    archive.store(tmp_path, results, {})
    stored = read_policy(tmp_path / "policies" / "primitive.onnx")
    assert np.array_equal(stored.weights[0], layer(2, 11, 4)[0])
    assert np.array_equal(stored.mean, layer(2, 11)[0])


def test_a_study_once_killed_while_writing_is_swept(results, tmp_path):
    archive.store(tmp_path, results, {})
    for folder in (tmp_path, tmp_path / "policies", tmp_path / "flights"):
        (folder / ".half.01234567.partial").write_bytes(b"half")
    archive.store(tmp_path, results, {})
    assert not list(tmp_path.rglob("*.partial"))


def test_conducting_ends_with_the_results(results, monkeypatch):
    def run(study, flights, bystanders):
        assert (study, flights, bystanders) == (STUDY, [], None)
        yield Progress("primitive", 0, 1)
        yield Progress("primitive: training", 1, 20)
        yield results

    monkeypatch.setattr(archive, "run", run)
    assert archive.conduct(STUDY, []) is results
