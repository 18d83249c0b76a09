"""What a terminal shows of a flight, and that it shows nothing where there is none."""

import io
import time
from dataclasses import replace

import pytest
from rich.console import Console
from ticks import decision, said, world

from fledge.lab.control.phases import Phase
from fledge.lab.control.tick import Said
from fledge.lab.shell.runtime import Now
from fledge.lab.shell.tally import Tally
from fledge.lab.shell.view import WHO, Screen, View, drawn
from fledge.supervision.modes import Mode
from fledge.world import Arena, Reason

SCREEN = Screen("policy.onnx behind stop-tube", ("ardrone", "p3at", "p3dx1", "p3dx2"), 1, "l land")
TALLY = Tally(Arena.lab())


def now(tick, ticks=1, **more):
    """After so many ticks like this one."""
    count = TALLY.init()
    for number in range(ticks):
        count = TALLY.step(count, 0.01 * number, tick)
    return Now(12.34, tick, count, 420, 0, 0, True, False)._replace(**more)


def text(shown, screen=SCREEN):
    """The picture, as plain text of 100 columns."""
    console = Console(file=io.StringIO(), width=100)
    console.print(drawn(screen, shown))
    return console.file.getvalue()


def test_who_flies_where_and_how_long_a_tick_takes():
    shown = text(now(said(seen=world(x=1.25, y=-0.5, z=2.6, middle=(1.25, -0.5))), 20))
    assert "policy.onnx behind stop-tube: fly, 12.3 s" in shown
    assert "1.25  -0.50  2.60 m" in shown and "tick 0.42 ms" in shown and "in view 100.0 %" in shown
    line = next(line for line in shown.splitlines() if "ardrone" in line)
    assert line.rstrip().endswith("policy")
    assert "l land" in shown and "interventions: net 0, watchdog 0, people 0" in shown


@pytest.mark.parametrize("mode", list(Mode))
def test_every_mode_has_its_words(mode):
    assert WHO[mode] in text(now(said(uav=decision(mode, Reason.WALL))))


def test_why_something_is_held_back():
    held = decision(Mode.SHIELDED, Reason.OBSTACLE)
    shown = text(now(said(uav=held), 20))
    assert "policy, held back (obstacle)" in shown and "interventions: net 1" in shown


def test_vehicles_that_are_not_ours_have_no_commander():
    lines = [line for line in text(now(said())).splitlines() if "p3" in line]
    assert len(lines) == 3 and all(line.rstrip().endswith("m") for line in lines)
    ours = text(now(said()), SCREEN._replace(commanded=4))
    assert ours.count(WHO[Mode.READY]) == 3


def test_what_is_missing_or_wrong_is_said():
    blind = Said((), Phase.WAIT, complaint="no poses from motion capture yet")
    shown = text(now(blind))
    assert "no poses from motion capture yet" in shown and shown.count("not seen yet") == 4
    assert "not to be armed yet" in text(now(said(), ready=False))
    assert "landing, as ordered; Ctrl-C once more" in text(now(said(), landing=True))
    trouble = text(now(said(), missed=3, lost=7, wires="the ROS master does not answer"))
    assert "the ROS master does not answer" in trouble
    assert "3 slots missed" in trouble and "7 datagrams not sent" in trouble


def test_a_complaint_is_not_taken_for_markup():
    assert "[bold]why[/nonsense]" in text(now(replace(said(), complaint="[bold]why[/nonsense]")))


def test_a_terminal_is_drawn_on_and_nothing_else():
    for terminal in (True, False):
        console = Console(file=io.StringIO(), width=100, force_terminal=terminal)
        with View(SCREEN, console) as view:
            for _ in range(3):
                view.show(now(said()))
                time.sleep(0.15)
        assert ("policy.onnx" in console.file.getvalue()) is terminal


def test_to_show_takes_no_time():
    with View(SCREEN, Console(file=io.StringIO(), force_terminal=True)) as view:
        shown, slowest = now(said()), 0.0
        for _ in range(100):
            before = time.perf_counter()
            view.show(shown)
            slowest = max(slowest, time.perf_counter() - before)
            time.sleep(0.005)
    assert slowest < 0.05  # microseconds as a rule; other processes may have had their turn
