"""From what was typed to a flight: what is refused before anything is opened, and what a log restores.

The flights at the end are of real processes, `fledge twin` and `fledge fly`, over real sockets and in real time.
"""

import json
import os
import pty
import select
import signal
import subprocess
import sys
import termios
import time
from dataclasses import replace
from itertools import islice, pairwise
from pathlib import Path
from threading import Event, Thread

import numpy as np
import pytest
from loopback import own_host
from processes import flown_to, modes, phases, process, sticks, ticks_of, until, wait_for, wires

from fledge.camera import Lens
from fledge.errors import FledgeError
from fledge.lab.control.phases import Phase
from fledge.lab.lockstep import fly_lockstep
from fledge.lab.shell.logs import Entry, Log
from fledge.lab.shell.rerun import read_ticks
from fledge.lab.shell.udp import opened
from fledge.lab.twin.twin import Options, Twin
from fledge.learning.policy import Contract, Policy
from fledge.runs import hangar
from fledge.runs.hangar import Order
from fledge.storage import read_flight, write_policy
from fledge.storage.records import to_json
from fledge.supervision.inputs import Operator
from fledge.world import Arena, VelocityCommand

pytestmark = pytest.mark.slow

LOOPBACK = ("127.0.0.1", 51001)
SERVO = Order(pilot="servo", mocap=LOOPBACK, vehicle=("127.0.0.1", 5556), nobody=True)


@pytest.fixture
def policy(tmp_path):
    """A file of a policy that hardly moves the sticks."""

    def write(contract=Contract(), name="policy.onnx"):
        rng = np.random.default_rng(0)
        shapes = ((11, 30), (30, 30), (30, 4))
        weights = tuple(rng.normal(0.0, 0.05, shape).astype(np.float32) for shape in shapes)
        biases = tuple(np.zeros(shape[1], np.float32) for shape in shapes)
        scale = np.full(11, 100.0, np.float32)
        made = Policy(weights, biases, np.zeros(11, np.float32), scale, tuple(range(11)), 11, contract)
        write_policy(tmp_path / name, made)
        return tmp_path / name

    return write


@pytest.fixture
def nothing_opens(monkeypatch):
    """Whoever opens a socket now fails the test."""

    def fail(wires):
        raise AssertionError("a socket was opened")

    monkeypatch.setattr(hangar, "opened", fail)


@pytest.mark.parametrize(
    ("order", "words"),
    [
        (Order(nobody=True), "who flies? valid is a policy's file, or --pilot NAME"),
        (replace(SERVO, policy=Path("policy.onnx")), "and not both"),
        (replace(SERVO, pilot="ace"), "unknown pilot 'ace'"),
        (replace(SERVO, net="hammock"), "unknown net 'hammock'"),
        (replace(SERVO, arena="moon"), "unknown arena 'moon'"),
        (replace(SERVO, mocap=("192.0.2.1", 51001)), "no --arena: valid is the file of the room you fly in"),
        (replace(SERVO, vehicle=("192.168.1.1", 5556)), "no --arena"),
        (replace(SERVO, mocap=None), "no --arena"),
        (replace(SERVO, policy=Path("nowhere.onnx"), pilot=None), "nowhere.onnx: cannot be read"),
    ],
)
def test_what_makes_no_sense_is_refused_before_anything_is_opened(order, words, nothing_opens):
    with pytest.raises(FledgeError, match="^[^\n]*$") as refused:
        hangar.fly(order)
    assert words in str(refused.value)


def test_a_policy_for_other_eyes_is_refused_before_anything_is_opened(policy, nothing_opens):
    file = policy(Contract(lens=Lens(700.5)))
    with pytest.raises(FledgeError, match="policy.onnx: the policy was trained with lens = "):
        hangar.fly(replace(SERVO, policy=file, pilot=None))
    with pytest.raises(FledgeError, match="a policy without a contract"):
        hangar.fly(replace(SERVO, policy=policy(None), pilot=None))


def test_who_has_no_keyboard_is_told_and_nothing_is_left_open(monkeypatch, nothing_opens):
    with open(os.devnull) as nowhere:
        monkeypatch.setattr(sys, "stdin", nowhere)
        with pytest.raises(FledgeError, match="standard input is no terminal"):
            hangar.fly(replace(SERVO, nobody=False))


def test_a_port_that_is_taken_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    host = own_host()
    order = replace(SERVO, mocap=(host, 51001), vehicle=(host, 5556))
    with hangar.Link(opened(hangar.controller_wires(order.mocap, None))):
        with pytest.raises(FledgeError, match=f"UDP port 51001 of {host} is taken"):
            hangar.fly(order)
    assert list(tmp_path.iterdir()) == []


def test_without_a_lab_there_is_no_take_off_and_no_log(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("fledge.lab.shell.runtime.PATIENCE", 0.5)
    host = own_host()
    order = replace(SERVO, mocap=(host, 51001), vehicle=(host, 5556))
    with pytest.raises(FledgeError, match="^no take-off: no poses from motion capture yet"):
        hangar.fly(order)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(FledgeError, match="no take-off"):
        hangar.fly(replace(order, log=tmp_path / "kept.mcap"))
    assert len(list(read_ticks(tmp_path / "kept.mcap"))) > 20


def test_sticks_that_nobody_holds_let_nobody_take_off(tmp_path, monkeypatch):
    """With a twin that answers, and a port for an operator who does not come."""
    monkeypatch.chdir(tmp_path)
    host = own_host()
    order = replace(SERVO, mocap=(host, 51001), vehicle=(host, 5556), nobody=False, operator="udp")
    with process("twin", "--drone", host, "--mocap", host, "--duration", "20") as twin:
        until(twin, "Ctrl-C ends")
        with pytest.raises(FledgeError, match="^no take-off: no operator: nobody is heard from"):
            hangar.fly(replace(order, sticks=(host, 51002)))


# Logs.


def logged(order, path, ticks):
    """The log of so many ticks, in lock-step with a twin, as `fly` would write it; and what was said."""
    outfit, controller, crew = hangar._made(order)
    outfit = replace(outfit, unattended=True)
    controller = outfit.controller(crew.pilot, controller.supervisor.net)
    twin = Twin(Arena.lab(), 2, Options(duration=60.0))
    brief = {"source": hangar._source(), "outfit": to_json(outfit)}
    flight = list(islice(fly_lockstep(controller, twin), ticks))
    with Log(path, hangar._facts(outfit), brief, crew.files) as log:
        for number, tick in enumerate(flight):
            log.tick(Entry(number, tick.heard, tick.said, 1))
    return flight


def test_an_order_can_be_read_in_a_log():
    text = json.dumps(hangar._plain(replace(SERVO, policy=Path("a.onnx"))), allow_nan=False)
    assert json.loads(text) | {"policy": "a.onnx", "net": "stop-tube"} == json.loads(text)


@pytest.mark.parametrize("by_policy", [False, True])
def test_a_flight_is_flown_again_from_its_log_alone(by_policy, policy, tmp_path):
    """Its policy's file may be gone meanwhile."""
    order = replace(SERVO, pilot=None, policy=policy()) if by_policy else SERVO
    logged(order, tmp_path / "log.mcap", 250)
    (tmp_path / "policy.onnx").unlink(missing_ok=True)
    seen = []
    flight, found = hangar.rerun(tmp_path / "log.mcap", seen.append)
    assert (found.ticks, found.difference, found.missing) == (250, "", "")
    assert flight is None and seen == list(range(1, 251))


def test_the_flight_of_a_log_is_the_one_that_was_logged(tmp_path):
    """Rows of the replay and rows in the file, of a flight long enough to have any."""
    ticks = logged(SERVO, tmp_path / "log.mcap", 1800)
    assert ticks[-1].said.phase is Phase.FLY
    flight, found = hangar.rerun(tmp_path / "log.mcap")
    stored = read_flight(tmp_path / "log.mcap")
    assert found.difference == "" and flight is not None
    assert to_json(replace(flight, episode=None)) == to_json(replace(stored, episode=None))
    assert flight.rows == stored.rows > 20
    assert np.array_equal(flight.episode.action.forward, stored.episode.action.forward)
    assert np.array_equal(flight.episode.world.ugvs[2].x, stored.episode.world.ugvs[2].x)


def test_another_fledge_is_named_where_it_flies_otherwise(tmp_path, monkeypatch):
    logged(SERVO, tmp_path / "log.mcap", 60)
    monkeypatch.setattr("fledge.lab.control.ardrone_udp.WAKE", b"\x02\x00\x00\x00")
    _, found = hangar.rerun(tmp_path / "log.mcap")
    assert found.difference and "another fledge" not in found.difference
    monkeypatch.setattr(hangar, "_source", lambda: "other")
    _, found = hangar.rerun(tmp_path / "log.mcap")
    assert found.difference.endswith("it was flown by another fledge")


# Real processes.


@pytest.fixture
def lab(tmp_path):
    """A twin on an address of its own: (that, its process, the folder in which it leaves twin.json)."""
    host = own_host()
    with process(
        "twin", "--drone", host, "--mocap", host, "--seed", "1", "--json", "twin.json", cwd=tmp_path
    ) as twin:
        until(twin, "Ctrl-C ends")
        yield host, twin, tmp_path


def left(lab):
    """What came of the twin."""
    _, twin, folder = lab
    twin.send_signal(signal.SIGINT)
    twin.communicate(timeout=20)
    return json.loads((folder / "twin.json").read_text())


def test_a_flight_from_the_pad_to_the_floor_and_once_more_from_its_log(lab, policy):
    """An interrupt lands it, the twin's referee has nothing to say, and the log replays byte for byte."""
    host, _, folder = lab
    arguments = (policy().name, *wires(host), "--log", "log.mcap", "--json", "fly.json")
    with process("fly", *arguments, cwd=folder) as fly:
        flown_to("fly", folder / "log.mcap")
        time.sleep(3.0)
        fly.send_signal(signal.SIGINT)
        out, err = fly.communicate(timeout=60)
    assert fly.returncode == 0, err
    assert out.startswith("over: the pilot flew for ") and err == ""  # no terminal, no view
    found, twin = json.loads((folder / "fly.json").read_text()), left(lab)
    assert found["phase"] == "over" and found["flown_s"] > 2.0 and found["ticks"] > 2000
    assert found["contacts"] == found["takeovers"] == 0 and found["in_view"] is not None
    assert set(found["tick_us"]) == {"p50", "p99", "p999", "max"}
    assert found["deadline_misses"] < 0.05 * found["ticks"]
    assert set(found["interventions"]) == {"net", "watchdog", "people"}
    assert (twin["contacts"], twin["phase"]) == ([], "landed")
    flight, again = hangar.rerun(folder / "log.mcap")
    assert (again.ticks, again.difference, again.missing) == (found["ticks"], "", "")
    assert flight is not None and flight.rows == pytest.approx(20 * found["flown_s"], abs=5)


def test_who_kills_the_process_leaves_the_drone_to_its_watchdog(lab):
    """It comes down by itself and touches nobody; the log has all but the last second, and replays."""
    host, _, folder = lab
    with process("fly", "--pilot", "servo", *wires(host), "--log", "log.mcap", cwd=folder) as fly:
        flown_to("climb", folder / "log.mcap")
        time.sleep(1.0)
        fly.send_signal(signal.SIGKILL)
        fly.wait()
    time.sleep(12.0)
    twin = left(lab)
    assert (twin["contacts"], twin["phase"]) == ([], "landed")
    _, again = hangar.rerun(folder / "log.mcap")
    assert again.difference == "" and again.missing == "cut short: its end is missing"


def test_a_process_that_is_paused_for_a_while_flies_on(lab):
    """0.7 s without a command: the drone holds itself; then everything that waited is old, and is known to be."""
    host, _, folder = lab
    arguments = (
        "--pilot",
        "servo",
        *wires(host),
        "--duration",
        "4",
        "--log",
        "log.mcap",
        "--json",
        "fly.json",
    )
    with process("fly", *arguments, cwd=folder) as fly:
        flown_to("climb", folder / "log.mcap")
        fly.send_signal(signal.SIGSTOP)
        time.sleep(0.7)
        fly.send_signal(signal.SIGCONT)
        _, err = fly.communicate(timeout=90)
    assert fly.returncode == 0, err
    found, twin = json.loads((folder / "fly.json").read_text()), left(lab)
    assert found["deadline_misses"] >= 60 and found["phase"] == "over" and found["flown_s"] > 3.5
    assert twin["contacts"] == [] and found["contacts"] == 0
    ticks = ticks_of(folder / "log.mcap")
    _, woken = max((b["t"] - a["t"], b["tick"]) for a, b in pairwise(ticks))
    first = next(tick["said"][0] for tick in ticks if tick["tick"] == woken)
    assert first["mode"] == "HOLD" and first["reason"] in ("POLICY_LATE", "STALE")
    assert hangar.rerun(folder / "log.mcap")[1].difference == ""


def test_a_dry_run_says_that_all_is_ready_and_the_drone_stays_where_it_is(lab):
    host, _, folder = lab
    with process(
        "fly", "--pilot", "servo", *wires(host), "--dry-run", "--json", "fly.json", cwd=folder
    ) as fly:
        _, err = fly.communicate(timeout=60)
    assert fly.returncode == 0, err
    assert json.loads((folder / "fly.json").read_text())["phase"] == "wait"
    assert left(lab)["phase"] == "landed" and not list(folder.glob("*.mcap"))


def test_a_person_takes_over_flies_hands_back_and_lands(lab):
    """Over a wire, from another process, while the policy climbs."""
    host, _, folder = lab
    address, log = (host, 51002), folder / "log.mcap"
    arguments = (
        "--pilot",
        "servo",
        *wires(host)[:-1],
        "--operator",
        f"udp://{host}:51002",
        "--log",
        "log.mcap",
    )
    with sticks(address) as say, process("fly", *arguments, "--json", "fly.json", cwd=folder) as fly:
        wait_for(lambda: len(phases(log)) > 250)
        say(Operator(arm=1.0))
        flown_to("climb", log)
        say(Operator(VelocityCommand(0.0, 0.0, 0.3, 0.0), 0.6, switch=1.0, arm=1.0))
        wait_for(lambda: modes(log)[-1] == "MANUAL")
        time.sleep(2.0)
        say(Operator(hand_back=1.0, arm=1.0))
        wait_for(lambda: modes(log)[-1] == "AUTO")
        say(Operator(arm=1.0, land=1.0))
        _, err = fly.communicate(timeout=60)
    assert fly.returncode == 0, err
    found = json.loads((folder / "fly.json").read_text())
    assert (found["takeovers"], found["contacts"], found["phase"]) == (1, 0, "over")
    assert found["interventions"]["people"] == {"take_over": 1}
    heights = [
        tick["seen"][0]["z"] for tick in ticks_of(log) if tick["said"] and tick["said"][0]["mode"] == "MANUAL"
    ]
    assert heights[-1] - heights[0] > 0.3  # the person climbed
    assert left(lab)["contacts"] == []


def test_a_person_at_the_keyboard_arms_and_lands_and_sees_the_flight(lab):
    """In a terminal of its own, which is as it was before when all is over."""
    host, _, folder = lab
    hands, terminal = pty.openpty()
    before = termios.tcgetattr(terminal)
    command = [sys.executable, "-c", "from fledge.cli import main; main()", "fly", "--pilot", "servo"]
    with subprocess.Popen(
        [*command, *wires(host)[:-1], "--log", "log.mcap"],
        cwd=folder, stdin=terminal, stdout=terminal, stderr=terminal, start_new_session=True,
        env={**os.environ, "TERM": "xterm", "COLUMNS": "100"},
    ) as fly:  # fmt: skip
        shown = Shown(hands)
        shown.until("nobody: may be armed")
        os.write(hands, b"g")
        shown.until(": climb")
        shown.until("policy")
        os.write(hands, b"l")
        shown.until("nobody: lands")
        fly.wait(60)
    shown.until("over: the pilot flew for 0.0 s")
    assert fly.returncode == 0
    assert termios.tcgetattr(terminal) == before
    shown.close()
    os.close(terminal)
    assert left(lab)["phase"] == "landed"


class Shown:
    """What a terminal shows, read as it comes."""

    def __init__(self, hands):
        self._hands, self._text = hands, ""
        self._over = Event()
        self._thread = Thread(target=self._read)
        self._thread.start()

    def _read(self):
        while not self._over.is_set():
            if select.select([self._hands], (), (), 0.1)[0]:
                self._text += os.read(self._hands, 65536).decode(errors="replace")

    def until(self, words):
        """Wait for these, and forget what came before them."""
        wait_for(lambda: words in self._text)
        self._text = self._text[self._text.index(words) :]

    def close(self):
        self._over.set()
        self._thread.join()
        os.close(self._hands)
