"""The command of the physical experiment, as somebody types it."""

import json

import pytest
from harvested import harvest

from fledge.cli import main
from fledge.runs import labwork

pytestmark = pytest.mark.slow


def run(capsys, *arguments):
    main(arguments)
    return capsys.readouterr()


@pytest.fixture
def plans(monkeypatch):
    """What was to be flown; nothing is."""
    seen = []

    def conduct(plan, jobs):
        seen.append((plan, jobs))
        yield 1, 1
        yield harvest(plan)

    monkeypatch.setattr(labwork, "conduct", conduct)
    return seen


def test_it_leaves_a_page_and_says_what_was_found(plans, capsys, tmp_path):
    out, _ = run(capsys, "lab-study", "servo", "--flights", "6", "--out", str(tmp_path / "report"))
    assert (tmp_path / "report" / "index.html").is_file() and "report: " in out
    assert "stop-tube" in out and "No robot flew" in out and "the same ways in the simulator" in out
    ((plan, jobs),) = plans
    assert (plan.flights, plan.seconds, plan.kinds, jobs) == (6, 30.0, ("lab", "reversed"), None)
    assert list(plan.nets) == ["stop-tube", "paper", "none"] and plan.arena.bounds.x_max == 3.3


def test_the_command_in_the_results_is_one_that_does_it_again(plans, capsys, tmp_path):
    wanted = ["--flights", "2", "--seconds", "5", "--nets", "none", "--days", "ordinary", "--arena", "square"]
    out, _ = run(capsys, "lab-study", "servo", *wanted, "--seed", "3", "--out", str(tmp_path), "--json", "-")
    settings = json.loads(out)["settings"]
    assert settings["command"].split() == ["fledge", "lab-study", "servo", *wanted, "--seed", "3"]
    run(capsys, *settings["command"].split()[1:], "--out", str(tmp_path))
    first, again = (plan for plan, _ in plans)
    assert first == again and first.seed == 3


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nobody"], "nobody"),
        (["servo", "--flights", "0"], "flights"),
        (["servo", "--nets", "hope"], "hope"),
        (["servo", "--nets"], "no net"),
        (["servo", "--arena", "moon"], "moon"),
        (["servo", "--seconds", "0.5"], "seconds"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(plans, capsys, arguments, words):
    with pytest.raises(SystemExit) as left:
        main(["lab-study", *arguments])
    err = capsys.readouterr().err
    assert left.value.code == 2 and words in err and plans == []
