"""A sortie: what is shown of it, and what becomes of its recording."""

from dataclasses import dataclass, field

import pytest

from fledge.cockpit.asks import Fly
from fledge.cockpit.flight import Choice, Live
from fledge.cockpit.seat import HANDS_OFF, Spoken
from fledge.cockpit.sortie import Sortie
from fledge.cockpit.tape import Tape
from fledge.errors import FledgeError
from fledge.manoeuvres import Climb
from fledge.observation import ROW_RATE
from fledge.pilots import Servo
from fledge.safety import StopTube
from fledge.storage import read_flight
from fledge.supervision.inputs import Operator

pytestmark = pytest.mark.slow

TICKS = round(100.0 / ROW_RATE)
"""Of a row."""
CLIMB = Fly("climb", "servo", "stop-tube", record="flight")


@dataclass
class Flown:
    """A climb of three rows, with somebody who arms it."""

    folder: object
    problems: list = field(default_factory=list)

    def __post_init__(self):
        scene = Live.draw(Choice(Climb(), Servo(), StopTube(), "stop-tube", 3))
        self.sortie = Sortie(CLIMB, scene, Tape(self.folder, scene.about) if self.folder else None)

    def go(self, rows, arm=True):
        spoken = Spoken((Operator(arm=float(arm)),) * 4, HANDS_OFF, silent=0.0, lost=False)
        self.problems += [self.sortie.tick(spoken) for _ in range(rows * TICKS)]
        return self


def test_before_the_first_tick_there_is_nothing_to_see():
    flown = Flown(None)
    assert flown.sortie.frame() is None
    assert flown.go(1).sortie.frame().rows == 0


def test_on_the_ground_nothing_is_recorded_and_in_the_air_every_row(tmp_path):
    flown = Flown(tmp_path).go(25, arm=False)
    assert flown.sortie.frame().rows == 0
    flown.go(4)
    assert 2 <= flown.sortie.frame().rows <= 4 and flown.sortie.is_recorded
    rows = flown.sortie.tape.rows
    assert read_flight(flown.sortie.keep()).rows == rows


def test_what_was_not_recorded_cannot_be_kept(tmp_path):
    with pytest.raises(FledgeError, match="nothing was recorded"):
        Flown(None).sortie.keep()
    flown = Flown(tmp_path)
    flown.sortie.discard()
    assert not [*tmp_path.iterdir()] and not flown.go(1).sortie.is_recorded
    with pytest.raises(FledgeError, match="nothing was recorded"):
        flown.sortie.keep()


def test_a_problem_is_told_once(tmp_path):
    flown = Flown(tmp_path).go(25, arm=False)
    flown.sortie.tape.problem = "cannot be written any more: no space"
    flown.go(2)
    assert [one for one in flown.problems if one] == ["cannot be written any more: no space"]
    flown.sortie.close()


def test_who_leaves_leaves_the_tape_to_be_recovered(tmp_path):
    flown = Flown(tmp_path).go(25, arm=False).go(2)
    flown.sortie.close()
    assert len([*tmp_path.glob(".*.tape")]) == 1
