"""The command line as a user meets it: in a folder of one's own, with good input, bad input, and the plug pulled."""

import hashlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from fledge import cli
from fledge.cli import main
from fledge.commands import doctor
from fledge.errors import FledgeError
from fledge.learning import demonstrations
from fledge.learning.policy import Contract
from fledge.learning.recipe import Recipe
from fledge.storage import read_flight, read_policy, write_flight, write_policy
from fledge.study import proving, setups

pytestmark = pytest.mark.slow

EXAMPLES = Path(__file__).parents[1] / "examples"
MANOEUVRES = ("climb", "combined", "descend", "fixed-altitude")


@pytest.fixture(scope="module")
def shop(tmp_path_factory):
    """A folder in which somebody demonstrated and trained: demos/, policy.onnx."""
    folder = tmp_path_factory.mktemp("shop")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        main("demonstrate --episodes 1 --minutes 0.2".split())
        main("train demos --epochs 3".split())
    return folder


@pytest.fixture
def here(shop, tmp_path, monkeypatch):
    """A fresh folder beside them, to stand in."""
    for name in ("demos", "policy.onnx"):
        (tmp_path / name).symlink_to(shop / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def fails(capsys):
    """Run a command that must fail: returns its one line."""

    def run(*arguments):
        capsys.readouterr()
        with pytest.raises(SystemExit) as left:
            main(arguments)
        out, err = capsys.readouterr()
        assert left.value.code == 2
        assert out == ""
        assert err.startswith("fledge: ") and err.count("\n") == 1
        return err.removeprefix("fledge: ").rstrip()

    return run


def contents(folder):
    """Everything below a folder, and what is in it."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


# What is said


@pytest.mark.parametrize("command", ["", *cli.COMMANDS])
def test_help_fits_a_terminal_and_leaves_no_question(command, capsys):
    with pytest.raises(SystemExit) as left:
        main([*command.split(), "--help"])
    text = capsys.readouterr().out
    assert left.value.code == 0
    assert "None" not in text and "{" not in re.sub(r"\{[a-z-]+(,[a-z-]+)+\}", "", text)
    assert all(len(line) <= 80 for line in text.splitlines() if not line.startswith("usage:"))


def test_help_is_there_at_once():
    began = time.perf_counter()
    code = "import sys; from fledge.cli import main\ntry: main(['--help'])\nfinally: sys.exit('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, check=False).returncode == 0
    assert time.perf_counter() - began < 5.0  # under one on an idle machine


def test_demonstrations_are_the_flights_that_were_asked_for(here):
    flights = [read_flight(path) for path in sorted(Path("demos").iterdir())]
    assert [flight.manoeuvre for flight in flights] == sorted(MANOEUVRES)
    assert {(flight.rows, flight.pilot, flight.case) for flight in flights} == {(240, "human-model", 0)}


def test_a_policy_knows_its_contract_and_leaves_no_checkpoint(here):
    policy = read_policy("policy.onnx")
    assert replace(policy.contract, data="") == Contract()
    assert len(policy.contract.data) == 64
    assert [path.name for path in (here / "policy.onnx").resolve().parent.iterdir()] == [
        "demos",
        "policy.onnx",
    ]


def test_what_is_there_is_not_flown_again(here, capsys):
    before = {path: path.stat() for path in Path("demos").iterdir()}
    main("demonstrate --episodes 1 --minutes 0.2 --json -".split())
    out, err = capsys.readouterr()
    assert json.loads(out)["rows"] == dict.fromkeys(MANOEUVRES, 240)
    assert err == ""
    assert {path: path.stat() for path in Path("demos").iterdir()} == before


def test_replay_draws_and_scores(here, capsys):
    main("replay demos/climb-000.mcap --out climb.png --json climb.json".split())
    shown = capsys.readouterr().out
    assert "climb by human-model" in shown and "picture: climb.png" in shown
    summary = json.loads(Path("climb.json").read_text())
    assert summary["rows"] == 240
    assert summary["scores"]["in_view"] == 1.0
    assert Path("climb.png").read_bytes().startswith(b"\x89PNG")


def test_evaluate_compares_the_first_with_the_others(here, capsys):
    main("evaluate servo policy.onnx --cases 2 --manoeuvre climb --json both.json".split())
    shown = capsys.readouterr().out
    assert "climb, net none: 2 flights of 60 s each" in shown and "servo minus policy.onnx" in shown
    main("evaluate servo policy.onnx --cases 2 --manoeuvre climb --json -".split())
    out, err = capsys.readouterr()
    assert (out, err) == (Path("both.json").read_text(), "")
    found = json.loads(out)
    assert list(found["entries"]) == ["policy.onnx", "servo"]
    assert {(one["a"], one["b"]) for one in found["comparisons"]} == {("servo", "policy.onnx")}


def test_evaluate_flies_behind_a_net(here, capsys):
    for net in ("none", "paper"):
        main(f"evaluate servo --cases 2 --net {net} --json {net}.json".split())
        assert f"combined, net {net}: 2 flights" in capsys.readouterr().out
    free, behind = (json.loads(Path(f"{net}.json").read_text()) for net in ("none", "paper"))
    assert (free["net"], behind["net"]) == ("none", "paper")
    # The paper's net stops UGVs for good.
    assert free["entries"]["servo"]["distance"] != behind["entries"]["servo"]["distance"]


def test_falsify_counts_what_a_net_lets_happen_and_keeps_some_of_it(here, capsys):
    main("falsify --net none --steps 24000 --policy policy.onnx --arena lab --json found.json".split())
    shown, noted = capsys.readouterr()
    assert "none steps in so far before a wall, hull to wall: UAV never" in noted
    assert "none under attack: " in shown and "none is beaten: in " in shown and "late-reverse" in shown
    found = json.loads(Path("found.json").read_text())
    assert found["net"] == "none" and found["contacts"] > 0 and found["rejected_arenas"] == 0
    assert found["steps"] == 2000 * found["flights"] >= 24_000
    assert found["families"]["policy"]["flights"] > 0
    files = [one["file"] for one in found["violations"] if one["file"]]
    assert contents(Path("violations")).keys() == {Path(file).name for file in files}
    main(["replay", files[0], "--json", "-"])
    flight = json.loads(capsys.readouterr().out)
    assert (flight["manoeuvre"], flight["net"], flight["rows"]) == ("attack", "none", 400)


# What is refused

BAD = {
    "demonstrate --manoeuvre loop": "unknown manoeuvre 'loop': valid are climb, combined, descend, fixed-altitude",
    "demonstrate --pilot ace": "unknown pilot 'ace': valid are exciter, human-model, package.module:Name, servo",
    "demonstrate --episodes 0": "episodes is 0: valid is a whole number from 1 to 1,000",
    "demonstrate --minutes nan": "minutes is nan: valid is 0.1 to 60.0",
    "demonstrate --episodes 1000 --minutes 60": "rows in all is 288,000,000: valid is up to 1,000,000",
    "demonstrate --seed -1": "seed is -1: valid is a whole number from 0",
    "demonstrate --out file": "file: a file is in the way of this folder",
    "demonstrate --out file/demos": "file/demos: a file is in the way of this folder",
    "demonstrate --out demos": "demos/climb-000.mcap: 240 rows by human-model with seed 0, where 470 rows",
    "demonstrate --out demos --episodes 1 --minutes 0.2 --pilot servo": "where 240 rows by servo with seed 0 belong",
    "demonstrate --out demos --episodes 1 --minutes 0.2 --seed 1": "where 240 rows by human-model with seed 1 belong",
    "demonstrate --out damaged --episodes 1": "damaged/climb-000.mcap: cut short",
    "train nowhere": "nowhere: there is no such folder",
    "train empty": "empty: there are no flights (*.mcap) in it; `fledge demonstrate` makes some",
    "train damaged": "damaged/climb-000.mcap: cut short",
    "train foreign": "foreign/foreign.mcap: not an MCAP file",
    "train part": "no demonstrations of climb, fixed-altitude; found descend",
    "train part --setup dnn-combined": "no demonstrations of combined; found descend",
    "train mixed": "flights of different lens",
    "train demos --setup best": "unknown set-up 'best': valid are dnn-combined, primitive, primitive-paper,",
    "train demos --epochs 0": "epochs is 0: valid is a whole number from 1",
    "train demos --out empty": "empty: a folder: valid is a file's name",
    "train demos --out file/policy.onnx": "file: a file is in the way of this folder",
    "train demos --json nowhere/losses.json": "nowhere/losses.json: cannot be written: valid is a file in a folder",
    "evaluate": "nobody to evaluate",
    "evaluate ace": "valid are exciter, human-model, package.module:Name, servo, or a policy's file",
    "evaluate ace.onnx": "ace.onnx: cannot be read: No such file or directory",
    "evaluate file": "file: damaged, or not a policy at all",
    "evaluate lens.onnx": "lens.onnx: the policy was trained with lens = ",
    "evaluate rate.onnx": "rate.onnx: the policy was trained with rate = 10.0, but is to fly with 20.0",
    "evaluate names.onnx": "names.onnx: the policy was trained with observation = ",
    "evaluate three.onnx": "three.onnx: the policy was trained with actions = ('forward', 'left', 'up'), but is to",
    "evaluate tank.onnx": "tank.onnx: a policy without a contract",
    "evaluate servo --cases 1": "cases is 1: valid is a whole number from 2 to 10,000",
    "evaluate servo --cases many": "cases is many: valid is a whole number",
    "evaluate servo --manoeuvre loop": "unknown manoeuvre 'loop'",
    "evaluate servo --net hammock": "unknown net 'hammock': valid are ",
    "reproduce --quick --full": "--quick and --full exclude each other",
    "reproduce --seed 99999999999": "seed is 99999999999: valid is a whole number from 0 to 4,294,966",
    "reproduce --out file": "file/demonstrations: a file is in the way of this folder",
    "replay nothing.mcap": "nothing.mcap: cannot be read: No such file or directory",
    "replay foreign/foreign.mcap": "foreign/foreign.mcap: not an MCAP file",
    "replay damaged/climb-000.mcap": "damaged/climb-000.mcap: cut short",
    "replay demos/climb-000.mcap --out climb.bmp": "climb.bmp: no such picture: valid are .png, .svg, .pdf and .gif",
    "replay demos/climb-000.mcap --out nowhere/climb.png": "nowhere/climb.png: cannot be written",
    "falsify --net tube": "unknown net 'tube': valid are barrier, conformal, none, package.module:Name, paper,",
    "falsify --net nowhere:Net": "net 'nowhere': cannot be imported: No module named 'nowhere'",
    "falsify --steps 2000": "steps is 2000: valid is a whole number from 24,000 to 10,000,000,000",
    "falsify --factor -1": "factor is -1: valid is 0.0 to 5.0",
    "falsify --factor nan": "factor is nan: valid is 0.0 to 5.0",
    "falsify --arena moon": "unknown arena 'moon': valid are FILE.toml, lab, square",
    "falsify --arena closet.toml": "the arena has no room for a UAV and 3 UGVs",
    "falsify --policy ace.onnx": "ace.onnx: cannot be read: No such file or directory",
    "falsify --policy policy.onnx tank.onnx": "tank.onnx: a policy without a contract",
    "falsify --json nowhere/found.json": "nowhere/found.json: cannot be written: valid is a file in a folder",
    "doctor --json empty": "empty: cannot be written: valid is a file in a folder that exists",
}


CLOSET = """
[bounds]
x_min_m = -0.5
x_max_m = 0.5
y_min_m = -0.5
y_max_m = 0.5
ceiling_m = 2.0
"""


@pytest.fixture
def spoilt(here):
    """With files and folders in it that are of no use."""
    for name in ("empty", "damaged", "foreign", "part", "mixed"):
        (here / name).mkdir()
    (here / "file").write_text("nothing")
    (here / "closet.toml").write_text(CLOSET)
    (here / "foreign" / "foreign.mcap").write_text("nothing")
    (here / "damaged" / "climb-000.mcap").write_bytes((here / "demos" / "climb-000.mcap").read_bytes()[:5000])
    flights = [read_flight(path) for path in sorted((here / "demos").iterdir())]
    write_flight(here / "part" / "descend-000.mcap", flights[2])
    for flight in flights:
        body_fixed = replace(flight.lens, levelled=flight.manoeuvre != "climb")
        write_flight(here / "mixed" / f"{flight.manoeuvre}.mcap", replace(flight, lens=body_fixed))
    policy = read_policy(here / "policy.onnx")
    odd = Contract()
    for name, contract in {
        "lens": replace(odd, lens=replace(odd.lens, focal_px=700.5)),
        "rate": replace(odd, rate=10.0),
        "names": replace(odd, observation=tuple(f"the {name}" for name in odd.observation)),
        "tank": None,
    }.items():
        write_policy(here / f"{name}.onnx", replace(policy, contract=contract))
    last = {
        "weights": (*policy.weights[:-1], policy.weights[-1][:, :3]),
        "biases": (*policy.biases[:-1], np.zeros(3)),
    }
    write_policy(here / "three.onnx", replace(policy, **last, contract=replace(odd, actions=odd.actions[:3])))
    return here


def test_whatever_is_wrong_is_one_line_and_changes_nothing(spoilt, fails):
    before = contents(spoilt)
    for command, reason in BAD.items():
        assert reason in fails(*command.split()), command
        assert contents(spoilt) == before, command
    assert [path.name for path in spoilt.rglob("*.partial")] == []


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (FledgeError("no"), "no"),
        (
            ModuleNotFoundError("No module named 'onnx'"),
            "No module named 'onnx'; `fledge doctor` says what to install",
        ),
        (FileExistsError(17, "File exists", "a"), "a: a file is in the way of this folder"),
        (OSError(28, "No space left on device"), "standard output: No space left on device"),
        (PermissionError(13, "Permission denied", "a/b"), "a/b: Permission denied"),
        (ZeroDivisionError("a bug of ours"), None),
    ],
)
def test_what_the_world_does_wrong_is_explained_and_our_bugs_are_not(error, line):
    assert cli.explain(error) == line


def test_our_own_bug_shows_itself(monkeypatch):
    monkeypatch.setattr(doctor, "examine", partial(int, "no number"))
    with pytest.raises(ValueError, match="no number"):
        main(["doctor"])


# Strangers

STRANGER = """
import fledge

class Crashes(fledge.AbstractPilot):
    name = "crashes"
    def act(self, memory, seen, noise):
        return memory, fledge.Action(0.0, 0.0, 0.0, [0.0][1])

class Forgets(fledge.AbstractPilot):
    name = "forgets"
    def act(self, memory, seen, noise):
        return fledge.Action(0.0, 0.0, 0.0, 0.0)
"""


def test_a_strangers_bug_is_located_in_the_strangers_file(here, fails):
    (here / "stranger.py").write_text(STRANGER)
    command = "demonstrate --manoeuvre climb --episodes 1 --minutes 0.1 --out own --pilot"
    assert (
        fails(*command.split(), "stranger:Crashes")
        == "stranger.py, line 7: IndexError: list index out of range"
    )
    assert "valid is a pair (memory, Action)" in fails(*command.split(), "stranger:Forgets")
    assert contents(here / "own") == {}


@pytest.mark.parametrize(
    ("folder", "package"), [(EXAMPLES, ""), (EXAMPLES.parent, "examples.")], ids=["beside it", "from above"]
)
def test_strangers_fly_by_name(folder, package, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    own = f"--pilot {package}own_pilot:Gentle --manoeuvre {package}own_manoeuvre:Orbit"
    main(f"demonstrate {own} --episodes 2 --minutes 0.1 --out {tmp_path}".split())
    flights = [read_flight(path) for path in sorted(tmp_path.iterdir())]
    assert [(f.manoeuvre, f.pilot, f.axes, f.rows, f.case) for f in flights] == [
        ("orbit", "gentle", (0, 1), 120, 0),
        ("orbit", "gentle", (0, 1), 120, 1),
    ]
    assert "orbit 240 rows" in capsys.readouterr().out


# The same seed, the same bytes


def test_a_study_of_one_seed_is_the_same_study_twice(tmp_path, monkeypatch, capsys):
    small = tuple(replace(order, episodes=2, rows=200) for order in demonstrations.PAPER_ORDERS)
    few = [setup for setup in setups.BASIC if setup.name in ("human-combined", "primitive")]
    study = setups.Study(
        "quick", tuple(replace(setup, recipe=Recipe.fast(2)) for setup in few), 3, 2, 1, rows=200
    )
    monkeypatch.setattr(demonstrations, "PAPER_ORDERS", small)
    monkeypatch.setattr(proving, "credibility", lambda *_, **__: [])  # has its own tests, and takes long
    monkeypatch.setattr(setups.Study, "of", lambda mode, seed: replace(study, seed=seed))
    stored, found = [], []
    for folder in (tmp_path / "once", tmp_path / "twice"):
        main(["reproduce", "--quick", "--seed", "7", "--out", str(folder), "--json", "-"])
        out, err = capsys.readouterr()
        assert (out, err) == ((folder / "results.json").read_text(), "")
        assert (folder / "index.html").exists()
        found.append({**json.loads(out), "times": None})
        unlike = {"results.json", "index.html"}  # they tell how long it took
        stored.append({name: sha for name, sha in contents(folder).items() if name not in unlike})
    assert found[0] == found[1]
    assert stored[0] == stored[1]
    assert {"policies/primitive.onnx", "flights/primitive.mcap", "demonstrations/climb-001.mcap"} <= stored[
        0
    ].keys()


# The plug is pulled

PLAIN = """
import signal
from fledge.cli import main
# Whoever runs the tests in the background may have had them, and so this, ignore Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)
main()
"""

FULL = """
import resource
from fledge.cli import main
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
main()
"""
"""The command line where no file may be larger than 20 kB; a flight is."""

HANGING = """
import os, time
from fledge.cli import main

real, calls = os.fsync, []

def fsync(descriptor):
    calls.append(descriptor)
    if len(calls) == HANG:
        print("writing", flush=True)
        time.sleep(60)
    real(descriptor)

os.fsync = fsync
main()
"""
"""The command line, but one flush to the disk, its number put for HANG, never comes back. Each file takes two."""


@pytest.fixture(scope="module")
def launch(tmp_path_factory):
    """Start a real process in a folder; all of them share what JAX compiled."""
    cache = tmp_path_factory.mktemp("compiled")
    environment = {
        **os.environ,
        "JAX_COMPILATION_CACHE_DIR": str(cache),
        "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
        "JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES": "-1",
    }
    started = []

    def start(command, folder, program=PLAIN):
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        line = [sys.executable, "-c", program, *command.split()]
        process = subprocess.Popen(line, cwd=folder, env=environment, **pipes)
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()


def finish(process, code=0):
    out, err = process.communicate(timeout=120)
    assert process.returncode == code, err
    return out, err


def kill_when(process, happened):
    """SIGKILL as soon as something has happened."""
    while not happened():
        assert process.poll() is None, process.communicate()
        time.sleep(0.001)
    process.kill()
    assert process.wait() == -signal.SIGKILL


def kill_while_writing(process):
    assert process.stdout.readline() == "writing\n"
    process.kill()
    assert process.wait() == -signal.SIGKILL


def flights_in(folder):
    """Name -> (inode, time of change) of what stands under a final name."""
    stats = {path.name: path.stat() for path in folder.glob("[!.]*")}
    return {name: (stat.st_ino, stat.st_mtime_ns) for name, stat in stats.items()}


OWN = "--pilot own_pilot:Gentle --manoeuvre own_manoeuvre:Orbit climb"
DEMONSTRATE = f"demonstrate {OWN} --episodes 3 --minutes 0.1 --out "


def test_demonstrate_killed_again_and_again_loses_nothing(launch, tmp_path, monkeypatch):
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    monkeypatch.chdir(EXAMPLES)
    main((DEMONSTRATE + str(whole)).split())
    kill_while_writing(launch(DEMONSTRATE + str(killed), EXAMPLES, HANGING.replace("HANG", "3")))
    first = flights_in(killed)
    assert len(first) == 1 and len(list(killed.glob(".*.partial"))) == 1
    kill_when(launch(DEMONSTRATE + str(killed), EXAMPLES), lambda: len(flights_in(killed)) >= 4)
    second = flights_in(killed)
    for name in second:
        read_flight(killed / name)
    finish(launch(DEMONSTRATE + str(killed), EXAMPLES))
    last = flights_in(killed)
    assert len(last) == 6
    assert first.items() <= second.items() <= last.items()
    assert contents(killed) == contents(whole)


TRAIN = "train demos --epochs 60 --out "


def test_train_killed_and_resumed_ends_in_the_same_bytes(launch, here):
    main((TRAIN + "whole.onnx").split())
    checkpoint = here / "killed.onnx.checkpoint.npz"
    kill_while_writing(launch(TRAIN + "killed.onnx", here, HANGING.replace("HANG", "9")))
    assert checkpoint.exists() and len(list(here.glob(".*.partial"))) == 1
    before = checkpoint.stat().st_mtime_ns
    resumed = launch(TRAIN + "killed.onnx --resume", here)
    kill_when(resumed, lambda: checkpoint.stat().st_mtime_ns != before)
    assert not (here / "killed.onnx").exists()
    finish(launch(TRAIN + "killed.onnx --resume", here))
    assert (here / "killed.onnx").read_bytes() == (here / "whole.onnx").read_bytes()
    assert sorted(path.name for path in here.iterdir()) == [
        "demos",
        "killed.onnx",
        "policy.onnx",
        "whole.onnx",
    ]


def test_an_interrupt_leaves_one_line_and_whole_files(launch, tmp_path):
    process = launch(DEMONSTRATE + str(tmp_path), EXAMPLES)
    while not flights_in(tmp_path):
        time.sleep(0.001)
    process.send_signal(signal.SIGINT)
    out, err = finish(process, code=130)
    assert (out, err) == ("", "fledge: interrupted; every file is whole\n")
    assert len(flights_in(tmp_path)) < 6
    for name in contents(tmp_path):
        read_flight(tmp_path / name)


def test_a_full_disk_is_one_line_and_leaves_nothing_half_written(launch, tmp_path):
    _, err = finish(launch(DEMONSTRATE + str(tmp_path), EXAMPLES, FULL), code=2)
    assert err == f"fledge: {tmp_path / 'orbit-000.mcap'}: cannot be written: File too large\n"
    assert contents(tmp_path) == {}


def test_whoever_stops_reading_gets_no_traceback(launch, tmp_path):
    process = launch("doctor", tmp_path)
    process.stdout.close()
    process.stdout = None
    _, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (1, "")


def test_a_full_standard_output_is_one_line(tmp_path):
    code = "from fledge.cli import main; main(['--help'])"
    with open("/dev/full", "w") as full:
        left = subprocess.run(
            [sys.executable, "-c", code], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert left.stderr.startswith("fledge: standard output: No space left on device\n")
