"""Every example runs, and shows what it says it shows."""

from pathlib import Path

import loaded
import numpy as np
import pytest

from fledge.engines import fly_plain, traceable
from fledge.learning.policy import Contract, Policy
from fledge.simulation import Case, Crew
from fledge.storage import write_policy

pytestmark = pytest.mark.slow

EXAMPLES = Path(__file__).parents[1] / "examples"
NAMES = sorted(path.stem for path in EXAMPLES.glob("*.py"))


def load(name):
    return loaded.load(EXAMPLES / f"{name}.py")


def test_every_example_is_run_here():
    here = Path(__file__).read_text()
    assert NAMES == sorted(set(NAMES)) and all(f'load("{name}")' in here for name in NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_an_example_fits_on_a_page(name):
    lines = (EXAMPLES / f"{name}.py").read_text().splitlines()
    assert 20 <= len(lines) <= 65
    assert lines[0].startswith('"""') and lines[-2:] == ['if __name__ == "__main__":', lines[-1]]


def test_bootstrap_shows_what_zero_fill_costs(capsys):
    errors = {name: np.sqrt(np.mean(error**2)) for name, error in load("bootstrap").main(episodes=4).items()}
    assert errors["taught, fill='mask'"] < 1.2 * errors["the teacher"]
    assert errors["taught, fill='zero'"] > 1.8 * errors["the teacher"]
    assert capsys.readouterr().out.count("\n") == 4


def test_own_pilots_keep_the_ugvs_in_view(capsys):
    scores = load("own_pilot").main(seconds=5)
    assert {name: float(score.in_view) for name, score in scores.items()} == {"gentle": 1.0, "smooth": 1.0}


def test_one_of_them_can_be_compiled_and_the_other_need_not():
    own = load("own_pilot")
    assert traceable(own.Smooth()) and not traceable(own.Gentle())


def test_own_manoeuvre_can_be_followed():
    off = load("own_manoeuvre").main(seconds=5)
    assert off.max() < 1.0


def test_an_own_pilot_flies_an_own_manoeuvre():
    orbit, gentle = load("own_manoeuvre").Orbit(), load("own_pilot").Gentle()
    flown = fly_plain(Case.draw(orbit, (0,), rows=60), Crew(gentle), (1,))
    assert np.isfinite(np.asarray(flown.world.uav.position.x)).all()


def test_fly_a_pilot_leaves_a_flight_and_a_picture(tmp_path, capsys):
    flight = load("fly_a_pilot").main(tmp_path, seconds=5)
    assert (flight.manoeuvre, flight.rows) == ("combined", 100)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["flight.mcap", "flight.png"]
    assert "all UGVs in view: 100.0%" in capsys.readouterr().out


def test_compare_pilots_finds_the_difference():
    found = load("compare_pilots").main(cases=4)
    (distance,) = [one for one in found["comparisons"] if one["metric"] == "distance_rmse"]
    assert distance["interval"][1] < 0.0, "half the gain cannot follow as well"


def test_a_policy_runs_elsewhere(tmp_path, capsys):
    rng = np.random.default_rng(0)
    weights = tuple(rng.standard_normal(shape).astype(np.float32) for shape in ((11, 8), (8, 4)))
    biases = tuple(np.zeros(n, dtype=np.float32) for n in (8, 4))
    policy = Policy(weights, biases, np.full(11, 50.0), np.full(11, 100.0), tuple(range(11)), 11, Contract())
    write_policy(tmp_path / "policy.onnx", policy)
    up = load("policy_elsewhere").main(str(tmp_path / "policy.onnx"))
    state = [320.0, 180.0, 320.0, 180.0, 2.8, 108.0, 140.0, 0.0, 0.0, 0.0, 0.0]
    assert up == pytest.approx(policy(state)[2], abs=1e-5)
    assert "It wants 20 decisions a second, on a picture of 640 x 360 pixels." in capsys.readouterr().out
