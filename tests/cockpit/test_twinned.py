"""The twin in the cockpit: from the pad and back, flown by a pilot, taken over, or flown by a person from the start."""

import io
import os
import time
from dataclasses import replace
from math import atan2

import drawing
import numpy as np
import pytest
from drawing import gone, needs_egl
from PIL import Image

from fledge import lookup
from fledge.camera import look
from fledge.cockpit.flight import Person
from fledge.cockpit.messages import decode_told, encode
from fledge.cockpit.scene import PERSON
from fledge.cockpit.screen import frame
from fledge.cockpit.seat import HANDS_OFF, Seats, Spoken
from fledge.cockpit.twinned import Twinned
from fledge.lab.shell.rows import together
from fledge.learning.takeovers import LEAST, corrections
from fledge.observation import Action, StickScale
from fledge.pilots import Servo
from fledge.storage import read_flight, write_flight
from fledge.supervision.inputs import Operator
from fledge.supervision.modes import Mode
from fledge.supervision.watchdog import TICK
from fledge.world import Arena, Reason

M = Mode
STOP_TUBE = lookup.lab_net("stop-tube")
DOWN = Action(0.0, 0.0, -0.6, 0.0)
PUSH = Action(0.5, -0.25, 0.7, 0.9)
"""A person's, on all axes."""


class Flown:
    """A flight, somebody at the sticks, and what was shown, stage by stage."""

    def __init__(self, pilot, seed=0):
        self.pictures = []
        names = ("some-pilot", "stop-tube")
        self.scene = Twinned.draw(pilot, STOP_TUBE, names, seed, self.pictures.append)
        self.memory, self.ticks = self.scene.init(), 0
        self.stages = {}

    def tick(self, action=HANDS_OFF, silent=0.0, **says):
        lost = silent > Seats().silence
        rest = Operator(arm=says.get("arm", 1.0), land=says.get("land", 0.0))
        action = HANDS_OFF if lost else action
        axes = (action.forward, action.left, action.up, action.turn)
        uav = replace(rest, command=StickScale().command(action), deflection=max(map(abs, axes)), **says)
        spoken = Spoken((rest if lost else uav, rest, rest, rest), action, silent, lost)
        self.memory, shown = self.scene.tick(self.memory, spoken)
        self.ticks += 1
        return shown

    def go(self, stage, seconds, silent=False, **says):
        """So much later."""
        ticks = range(1, round(seconds / TICK) + 1)
        self.stages[stage] = [self.tick(silent=silent * i * TICK, **says) for i in ticks]

    def until(self, stage, note, within=40.0, **says):
        """Until it says so."""
        self.stages[stage] = shown = [self.tick(**says)]
        while shown[-1].note != note:
            assert len(shown) * TICK < within, f"{note} did not come: {shown[-1].note}"
            shown.append(self.tick(**says))

    def flight(self, *stages):
        """The rows of these stages, as a tape of everything has them."""
        rows = [one.row for stage in stages for one in self.stages[stage] if one.row is not None]
        return replace(self.scene.about, episode=together(rows))


def modes(shown):
    return {Mode(int(one.decisions[0].mode)) for one in shown}


def heading(uav):
    nose = uav.attitude.heading()
    return atan2(nose.sin, nose.cos)


@pytest.fixture(scope="module")
def undrawn():
    """Nothing can be drawn here; everything flies all the same, and faster."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MUJOCO_GL", "oil")
        yield


@pytest.fixture(scope="module")
def served(undrawn):
    """A servo flies until somebody takes over and, in the end, lands."""
    flown = Flown(Servo())
    flown.go("pad", 1.5, arm=0.0)
    flown.until("up", "fly")
    flown.go("servo", 1.0)
    flown.go("by hand", 2.0, action=DOWN, switch=1.0)
    flown.until("down", "over", land=1.0)
    yield flown
    flown.scene.close()


@pytest.fixture(scope="module")
def manned(undrawn):
    """A person flies from the start."""
    flown = Flown(Person())
    flown.go("pad", 1.5, arm=0.0)
    flown.until("up", "fly")
    flown.go("person", 1.5, action=PUSH)
    flown.go("silent", 1.0, action=PUSH, silent=True)
    flown.go("again", 0.5, action=PUSH)
    flown.go("by hand", 1.5, action=DOWN, switch=1.0)
    yield flown
    flown.scene.close()


# A pilot flies


@pytest.mark.slow
def test_on_the_pad_it_waits_for_somebody_to_arm(served):
    pad = served.stages["pad"]
    place = pad[0].world.uav.position
    assert "not yet for long enough" in pad[0].note and pad[-1].note == "wait"
    assert modes(pad) == {M.INIT, M.READY} and {one.commanders for one in pad} == {("nobody",) * 4}
    assert not any(one.row for one in pad) and not any(one.over for one in pad)
    assert abs(pad[-1].world.uav.position.z - place.z) < 1e-3


@pytest.mark.slow
def test_arming_that_came_too_early_counts_once_it_was_let_go(undrawn):
    flown = Flown(Servo())
    flown.go("too early", 2.0)
    early = flown.stages["too early"]
    assert early[-1].note == "wait" and not any(one.armable for one in early) and M.AUTO not in modes(early)
    flown.go("let go", 0.1, arm=0.0)
    assert flown.stages["let go"][-1].armable
    flown.until("up", "take-off", within=1.0)
    flown.scene.close()


@pytest.mark.slow
def test_armed_it_takes_off_and_the_pilot_flies(served):
    up, servo = served.stages["up"], served.stages["servo"]
    notes = [one.note for one in up]
    assert sorted(set(notes), key=notes.index) == ["take-off", "climb", "join", "fly"]
    assert not any(one.row for one in up if one.note == "take-off")
    assert up[-1].world.uav.position.z > 2.0
    assert not any(one.flown for one in up) and {one.flown for one in servo if one.row} == {True}
    assert {one.commanders for one in servo} == {("pilot", "nobody", "nobody", "nobody")}


@pytest.mark.slow
def test_the_switch_takes_over_and_what_was_done_is_to_be_learnt_from(served, tmp_path):
    by_hand = served.stages["by hand"]
    assert modes(by_hand) == {M.MANUAL} and {one.commanders[0] for one in by_hand} == {PERSON}
    assert by_hand[-1].world.uav.velocity.z < -0.2
    assert not any(one.flown for one in by_hand)
    write_flight(tmp_path / "lab-000.mcap", served.flight("up", "servo", "by hand"))
    ((states, actions),) = corrections([read_flight(tmp_path / "lab-000.mcap")])
    assert len(states) >= 2 * LEAST - 1
    np.testing.assert_allclose(actions, np.tile([0.0, 0.0, DOWN.up], (len(actions), 1)), atol=1e-12)


@pytest.mark.slow
def test_told_to_land_it_comes_down_and_that_was_the_flight(served):
    down = served.stages["down"]
    assert down[-1].over and not any(one.over for one in down[:-1])
    assert {one.commanders[0] for one in down} == {"nobody"}
    assert down[-1].world.uav.position.z < 0.1 and not any(one.flown for one in down)
    assert 0.0 < down[-1].battery < served.stages["pad"][0].battery <= 1.0


@pytest.mark.slow
def test_a_row_has_five_ticks_and_begins_with_its_first(served):
    shown = served.stages["servo"]
    ends = [i for i, one in enumerate(shown) if one.row]
    assert set(np.diff(ends)) == {5}
    for end in ends[1:]:
        row = shown[end].row
        assert row.world == shown[end - 4].world
        assert row.verdicts[0].command == shown[end].decisions[0].verdict.command
    about = served.scene.about
    assert (about.manoeuvre, about.pilot, about.net, about.seed) == ("lab", "some-pilot", "stop-tube", 0)
    assert about.arena == Arena.lab() and about.axes == (0, 1)


@pytest.mark.slow
def test_what_is_shown_can_be_said(served):
    for shown in (served.stages[stage][at] for stage in served.stages for at in (0, -1)):
        told = frame(shown, served.scene.about)
        assert decode_told(encode(told)) == told
        assert shown.picture == look(served.scene.about.lens, shown.world)


# A person flies


@pytest.mark.slow
def test_a_persons_sticks_are_the_pilots_action_forward_and_left_alone(manned):
    person = manned.stages["person"]
    assert modes(person) == {M.AUTO} and {one.commanders[0] for one in person} == {PERSON}
    said = [one.row.action for one in person if one.row]
    assert {(one.forward, one.left) for one in said[2:]} == {(PUSH.forward, PUSH.left)}
    assert not any(one.up or one.turn for one in said)
    begin, end = person[0].world.uav, person[-1].world.uav
    forward, left = end.attitude.heading().from_world(end.velocity.x, end.velocity.y)
    assert (forward, left) == pytest.approx((PUSH.forward, PUSH.left), abs=0.15)
    assert abs(end.position.z - begin.position.z) < 0.15 and abs(heading(end) - heading(begin)) < 0.1
    assert all(one.flown for one in person[5:] if one.row)


@pytest.mark.slow
def test_a_person_who_falls_silent_lets_go(manned):
    silent, again = manned.stages["silent"], manned.stages["again"]
    velocity = silent[-1].world.uav.velocity
    assert np.hypot(velocity.x, velocity.y) < 0.15
    unheard = silent[round(Seats().silence / TICK) + 1 :]
    assert any(one.row for one in unheard) and not any(one.flown for one in unheard)
    assert all(one.flown for one in again[5:] if one.row)


@pytest.mark.slow
def test_a_person_who_is_the_pilot_takes_over_with_the_switch(manned):
    by_hand = manned.stages["by hand"]
    assert modes(by_hand) == {M.MANUAL} and by_hand[-1].world.uav.velocity.z < -0.2
    rows = [one.row for one in by_hand if one.row][1:]
    assert {Reason(int(row.verdicts[0].reason)) for row in rows} == {Reason.TAKE_OVER}
    assert not any(one.flown for one in by_hand)


@pytest.mark.slow
def test_who_says_nothing_sends_nothing(undrawn):
    """Arming must be said to be heard, however long it has been meant."""
    flown = Flown(Servo())
    flown.go("pad", 1.5, arm=0.0)
    for _ in range(50):
        shown = flown.tick(silent=2.0 * TICK)
    assert shown.note == "wait"
    flown.scene.close()


# The flight itself


@pytest.mark.slow
def test_one_seed_is_one_flight(undrawn):
    def flown(seed):
        flight = Flown(Servo(), seed)
        flight.go("pad", 1.5, arm=0.0)
        flight.go("up", 2.0)
        flight.scene.close()
        return flight.stages["up"]

    one, same, other = flown(1), flown(1), flown(2)
    assert one == same
    assert one[-1].note == "take-off" and one[-1].world != other[-1].world


@pytest.mark.slow
def test_where_it_would_come_to_rest_is_what_its_net_says(undrawn):
    flown = Flown(Servo())
    assert flown.scene.net == STOP_TUBE and flown.scene.halts(flown.memory) == ()
    flown.go("pad", 1.0, arm=0.0)
    halts, world = flown.scene.halts(flown.memory), flown.stages["pad"][-1].world
    assert len(halts) == 4
    for halt, (x, y) in zip(halts[1:], ((ugv.x, ugv.y) for ugv in world.ugvs), strict=True):
        assert np.hypot(halt.x - x, halt.y - y) <= halt.miss
    flown.scene.close()


# The camera


def drawers():
    return drawing.drawers(os.getpid())


def until(true, flown, patience=20.0):
    late = time.monotonic() + patience
    while not true() and time.monotonic() < late:
        flown.tick(arm=0.0)
        time.sleep(TICK)
    return true()


@needs_egl
@pytest.mark.slow
def test_its_camera_is_on_until_it_is_closed(monkeypatch):
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    before, flown = set(drawers()), Flown(Servo())
    assert until(lambda: len(flown.pictures) >= 3, flown)
    (first,) = set(drawers()) - before
    picture = Image.open(io.BytesIO(flown.pictures[-1]))
    assert (picture.format, picture.size) == ("JPEG", (640, 360))
    flown.memory = flown.scene.init()
    assert gone(first), "a flight begun anew has a camera of its own"
    count = len(flown.pictures)
    assert until(lambda: len(flown.pictures) > count, flown)
    (second,) = set(drawers()) - before
    flown.scene.close()
    flown.scene.close()
    assert gone(second) and set(drawers()) == before
