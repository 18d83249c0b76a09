"""The loop in real time, with real sockets: when ticks begin, what is measured, how a run begins and ends.

Times are those of a machine that may be busy with other things, so bounds are wide; what they must catch is wider.
"""

import gc
import os
import signal
import sys
import time
from contextlib import contextmanager
from dataclasses import replace
from threading import Event, Thread

import numpy as np
import pytest
from logged import ABOUT, BRIEF
from loopback import own_host
from threadpoolctl import threadpool_info
from ticks import decision, said

from fledge.errors import FledgeError
from fledge.lab.control.phases import Phase
from fledge.lab.control.tick import Said
from fledge.lab.shell import runtime
from fledge.lab.shell.desk import Desk, Nobody
from fledge.lab.shell.link import Link
from fledge.lab.shell.logs import Log
from fledge.lab.shell.rerun import read_ticks
from fledge.lab.shell.runtime import Flight, fly
from fledge.lab.shell.tally import Tally
from fledge.lab.shell.udp import UdpPort, Wire
from fledge.lab.wire.datagrams import AT, STICKS, VICON, Datagram
from fledge.supervision.modes import Mode
from fledge.supervision.watchdog import Alarm
from fledge.world import Arena, Reason

pytestmark = pytest.mark.slow

READY = decision(Mode.READY, Reason.NOT_READY)


class Scripted:
    """A controller that says what a function of the time says, and keeps what it hears."""

    def __init__(self, script):
        self.script, self.heard, self.at = script, [], []

    def init(self):
        return 0

    def step(self, memory, heard):
        self.heard.append(heard)
        self.at.append(time.monotonic())
        return memory + 1, self.script(heard.t)


def flying(seconds):
    """On the floor for a moment, then in the air for so long, then over."""

    def script(t):
        word = Datagram(AT, b"%f" % t)
        if t < 0.1:
            return said(t, READY, Phase.WAIT, datagrams=[word])
        return said(t, phase=Phase.FLY if t < seconds else Phase.OVER, datagrams=[word])

    return script


@contextmanager
def lab(script, device=None, frames=True, **more):
    """(a flight behind real sockets, its controller, the port where its commands come)."""
    host, controller = own_host(), Scripted(script)
    drone = UdpPort(Wire(AT, (host, 5556)))
    ears = [UdpPort(Wire(VICON, (host, 51001))), UdpPort(Wire(AT, there=(host, 5556)))]
    with Link(ears, (VICON,)) as link, cameras(host, frames):
        flight = Flight(controller, link, Desk(4, device or Nobody(4)), Tally(Arena.lab()), **more)
        yield flight, controller, drone
    drone.close()


@contextmanager
def cameras(host, on):
    """Frames a hundred times a second, from a thread of their own."""
    over = Event()

    def shoot():
        port, number, due = UdpPort(Wire(VICON, there=(host, 51001))), 0, time.monotonic()
        while not over.wait(max(due - time.monotonic(), 0.0)):
            port.send(Datagram(VICON, b"frame %d" % number))
            number, due = number + 1, due + 0.01
        port.close()

    thread = Thread(target=shoot)
    if on:
        thread.start()
    yield
    over.set()
    if on:
        thread.join()


def test_a_tick_for_every_frame_as_soon_as_it_comes():
    with lab(flying(2.0)) as (flight, controller, drone):
        outcome = fly(flight)
        commands = drone.receive()
    frames = [sum(one.channel == VICON for one in heard.datagrams) for heard in controller.heard]
    assert 230 <= len(frames) <= 270  # two seconds, and half a one for the last word
    assert np.mean(np.array(frames[100:200]) == 1) > 0.8
    assert np.median(outcome.took_us[100:]) < 5_000  # waits for no slot's end
    assert outcome.said.phase is Phase.OVER
    assert commands and outcome.counted.ticks == len(outcome.took_us) == len(frames)


def test_without_frames_ticks_come_all_the_same_and_on_a_grid():
    with lab(flying(1.0), frames=False) as (flight, controller, _):
        outcome = fly(flight)
    assert len(controller.at) + outcome.skipped == pytest.approx(150, abs=5)
    phase = np.exp(2j * np.pi * np.array(controller.at) / 0.01)
    assert abs(phase.mean()) > 0.5  # ticks at any time would be near 0, all at the same time of their slots 1
    assert np.percentile(outcome.took_us, 50) < 5_000


def test_a_tick_that_takes_too_long_costs_slots_and_no_burst():
    script = flying(1.0)

    def slow(t):
        if 0.5 < t < 0.51:
            time.sleep(0.055)
        return script(t)

    with lab(slow, frames=False) as (flight, controller, _):
        outcome = fly(flight)
    assert 4 <= outcome.skipped <= 40
    assert max(outcome.took_us) > 50_000
    late = next(i for i, took in enumerate(outcome.took_us) if took > 50_000)
    gaps = np.diff(controller.at[late + 2 : late + 12])
    assert np.median(gaps) == pytest.approx(0.01, abs=0.003)


def test_time_counts_from_the_frame_and_not_from_the_look():
    """A controller that takes 3 ms takes more than 3 ms, since the frame had come before."""
    script = flying(0.6)

    def slow(t):
        time.sleep(0.003)
        return script(t)

    with lab(slow) as (flight, _, _):
        outcome = fly(flight)
    assert np.percentile(outcome.took_us, 1) >= 3_000


def test_arming_waits_until_nothing_is_missing():
    def script(t):
        waiting = decision(Mode.INIT if t < 0.6 else Mode.READY, Reason.NOT_READY)
        tick = said(t, waiting, Phase.WAIT if t < 1.0 else Phase.OVER)
        return replace(tick, complaint="no navdata" if t < 0.3 else "")

    with lab(script) as (flight, controller, _):
        fly(flight)
    armed = [
        h.t for h in controller.heard for one in h.datagrams if one.channel == STICKS and b'"arm"' in one.data
    ]
    assert 0.6 <= armed[0] < 0.75


@pytest.mark.parametrize(
    ("tick", "words"),
    [
        (
            Said((), Phase.WAIT, complaint="the vehicle does not answer: no navdata"),
            "the vehicle does not answer",
        ),
        (Said((), Phase.WAIT), "nobody was seen yet"),
        (said(uav=decision(Mode.INIT, Reason.NOT_READY), phase=Phase.WAIT), "for a second of calm, disarmed"),
        (
            said(
                uav=decision(Mode.INIT, Reason.NOT_READY)._replace(
                    alarm=Alarm(3.0, float(Reason.BATTERY_LOW))
                )
            ),
            "the supervisor waits, battery low",
        ),
    ],
)
def test_what_is_missing_for_too_long_ends_the_run_with_one_line(tick, words, monkeypatch):
    monkeypatch.setattr(runtime, "PATIENCE", 0.3)
    with lab(lambda t: replace(tick, phase=Phase.WAIT)) as (flight, _, _):
        with pytest.raises(FledgeError, match=f"^no take-off: [^\n]*{words}"):
            fly(flight)


def test_a_dry_run_arms_nothing_and_is_over_when_all_is_ready():
    with lab(lambda t: said(t, READY, Phase.WAIT), dry=True) as (flight, controller, _):
        outcome = fly(flight)
    assert outcome.counted.ticks < 100
    assert not any(b'"arm"' in one.data for heard in controller.heard for one in heard.datagrams)


def test_a_dry_run_can_go_on_for_a_while_and_says_what_is_missing(monkeypatch):
    monkeypatch.setattr(runtime, "PATIENCE", 0.3)
    with lab(lambda t: said(t, READY, Phase.WAIT), dry=True, duration=0.6) as (flight, controller, _):
        fly(flight)
    assert controller.heard[-1].t >= 0.6
    with lab(lambda t: Said((), Phase.WAIT, complaint="no poses"), dry=True) as (flight, _, _):
        with pytest.raises(FledgeError, match="no take-off: no poses"):
            fly(flight)


def test_a_lab_that_has_gone_silent_is_given_up(monkeypatch):
    monkeypatch.setattr(runtime, "LOST", 0.3)
    with lab(lambda t: said(t, phase=Phase.LAND), frames=False) as (flight, controller, _):
        with pytest.raises(FledgeError, match="nothing was heard for 0.3 s: the vehicle is left to itself"):
            fly(flight)
    assert 0.3 <= controller.heard[-1].t < 1.0


# Orders from outside.


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_lands_and_the_loop_goes_on_to_the_floor(number):
    ordered = []

    def script(t):
        if t > 0.5 and not ordered:
            ordered.append(t)
            os.kill(os.getpid(), number)
        phase = Phase.OVER if ordered and t > ordered[0] + 0.5 else Phase.FLY
        return said(t, phase=phase if t > 0.1 else Phase.WAIT, uav=READY if t <= 0.1 else None)

    with lab(script) as (flight, controller, _):
        outcome = fly(flight)
    orders = [h.t for h in controller.heard if any(b'"land"' in one.data for one in h.datagrams)]
    assert 0.0 <= orders[0] - ordered[0] < 0.15
    assert outcome.said.phase is Phase.OVER and controller.heard[-1].t > ordered[0] + 0.9


def test_on_the_floor_the_order_ends_the_run():
    def script(t):
        if 0.3 < t < 0.32:
            os.kill(os.getpid(), signal.SIGTERM)
        return said(t, READY, Phase.WAIT)

    with lab(script) as (flight, controller, _):
        fly(flight)
    assert controller.heard[-1].t < 2.0


def test_a_second_interrupt_leaves_the_vehicle_to_itself():
    sent = []

    def script(t):
        if t > 0.3 * (1 + len(sent)):
            sent.append(t)
            os.kill(os.getpid(), signal.SIGINT)
        return said(t, phase=Phase.FLY)

    with lab(script) as (flight, _, _), pytest.raises(KeyboardInterrupt):
        fly(flight)
    assert len(sent) == 2


def test_ctrl_z_stops_no_flight():
    def script(t):
        if 0.2 < t < 0.22:
            os.kill(os.getpid(), signal.SIGTSTP)
        return flying(0.5)(t)

    with lab(script) as (flight, _, _):
        assert fly(flight).said.phase is Phase.OVER


def test_the_process_is_afterwards_as_it_was():
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGTSTP)
    before = [signal.getsignal(number) for number in numbers], sys.getswitchinterval(), gc.isenabled()
    inside = []

    def script(t):
        blas = (
            [one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"]
            if not inside
            else []
        )
        inside.append((gc.isenabled(), sys.getswitchinterval(), *blas))
        return flying(0.2)(t)

    with lab(script) as (flight, _, _):
        fly(flight)
    assert inside[0][:2] == (False, pytest.approx(runtime.SWITCH)) and set(inside[0][2:]) <= {1}
    assert ([signal.getsignal(n) for n in numbers], sys.getswitchinterval(), gc.isenabled()) == before


def test_garbage_is_collected_in_the_slack():
    collected = []

    def watch(phase, info):
        collected.append(info["generation"])

    gc.callbacks.append(watch)
    try:
        with lab(flying(1.5)) as (flight, _, _):
            fly(flight)
    finally:
        gc.callbacks.remove(watch)
    assert collected.count(0) > 5 and collected.count(1) >= 1


def test_everything_heard_and_said_is_logged_with_the_time_it_took(tmp_path):
    path = tmp_path / "log.mcap"
    with Log(path, ABOUT, BRIEF) as log, lab(flying(0.5), log=log) as (flight, controller, _):
        outcome = fly(flight)
    logged = list(read_ticks(path))
    assert [tick.heard for tick in logged] == controller.heard
    assert len(logged) == len(outcome.took_us)


def test_the_last_word_is_repeated():
    with lab(flying(0.2)) as (flight, controller, _):
        fly(flight)
    over = [heard for heard in controller.heard if heard.t >= 0.2]
    assert len(over) >= 0.7 * runtime.AFTERWARDS / 0.01


def test_who_may_go_first_does_for_a_while(monkeypatch):
    monkeypatch.setattr(os, "nice", lambda more: 0)
    before = os.sched_getscheduler(0)
    with runtime.urgent() as first:
        assert (os.sched_getscheduler(0) == os.SCHED_FIFO) is first
    assert os.sched_getscheduler(0) == before


def test_who_was_told_to_be_nice_is(monkeypatch):
    monkeypatch.setattr(os, "nice", lambda more: 19)
    with runtime.urgent() as first:
        assert not first and os.sched_getscheduler(0) != os.SCHED_FIFO


def test_who_may_not_go_first_flies_all_the_same(monkeypatch):
    def refuse(*_):
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    with runtime.urgent() as first:
        assert not first
