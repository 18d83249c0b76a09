"""UGVs that are ours to drive."""

from math import hypot

import pytest
from standin import ROWS, lateral

from fledge.dynamics import UGV_FLEET
from fledge.lab.control.phases import Phase
from fledge.lab.control.team import Team
from fledge.supervision.inputs import HOVER
from fledge.world import UgvState


class Fleet:
    """Robots that do as they are told."""

    def __init__(self, team, spread=1.0):
        self.team, self.memory = team, team.init()
        corners = team.formation.corners(team._target(0, False), team.plan.orientation)
        self.ugvs = tuple(
            UgvState(spread * x, spread * y, team.plan.orientation, 0.0, 0.0, 0.0) for x, y, _, _ in corners
        )

    def drive(self, rows, phase, flown=True):
        for _ in range(rows):
            self.memory = self.team.decide(self.memory, phase, flown, self.ugvs)
            for _ in range(5):
                self.ugvs = tuple(
                    model.step(ugv, command, 0.01)
                    for model, ugv, command in zip(UGV_FLEET, self.ugvs, self.memory.told, strict=True)
                )

    def off(self, row):
        """How far the farthest is from its place in a row [m]."""
        corners = self.team.formation.corners(self.team._target(row, False), self.team.plan.orientation)
        return max(hypot(ugv.x - x, ugv.y - y) for ugv, (x, y, _, _) in zip(self.ugvs, corners, strict=True))

    @property
    def fastest(self):
        return max(abs(ugv.speed) for ugv in self.ugvs)


@pytest.mark.parametrize("phase", [Phase.WAIT, Phase.TAKE_OFF, Phase.CLIMB, Phase.JOIN])
def test_they_go_to_their_corners_and_wait(phase):
    fleet = Fleet(Team(lateral()), spread=1.2)
    assert fleet.off(0) > 0.1
    fleet.drive(300, phase)
    assert fleet.off(0) < 0.08
    assert (fleet.memory.row, fleet.fastest < 0.02) == (0, True)


def test_while_the_pilot_flies_they_follow_the_track_and_stand_at_its_end():
    fleet = Fleet(Team(lateral()))
    fleet.drive(ROWS - 1, Phase.FLY)
    assert fleet.memory.row == ROWS - 1
    assert fleet.off(ROWS - 1) < 0.25
    fleet.drive(200, Phase.FLY)
    assert fleet.memory.row == ROWS - 1
    assert fleet.off(ROWS - 1) < 0.08 and fleet.fastest < 0.02


def test_the_track_waits_for_the_pilot():
    fleet = Fleet(Team(lateral()))
    fleet.drive(100, Phase.FLY)
    fleet.drive(100, Phase.FLY, flown=False)
    assert fleet.memory.row == 100
    assert fleet.off(100) < 0.08 and fleet.fastest < 0.02
    fleet.drive(50, Phase.FLY)
    assert fleet.memory.row == 150


@pytest.mark.parametrize("phase", [Phase.LAND, Phase.OVER])
def test_under_a_vehicle_that_comes_down_nobody_moves(phase):
    fleet = Fleet(Team(lateral()), spread=1.2)
    fleet.drive(100, Phase.FLY)
    fleet.drive(1, phase)
    assert fleet.memory.told == (HOVER,) * 3


def test_restless_ones_stop_hard_and_catch_up():
    fleet, speeds = Fleet(Team(lateral(), restless=True)), []
    for _ in range(ROWS - 1):
        fleet.drive(1, Phase.FLY)
        speeds.append(fleet.fastest)
    halts = [i for i in range(1, len(speeds)) if speeds[i] == 0.0 < speeds[i - 1]]
    assert len(halts) >= 3, "one for every few seconds"
    assert max(speeds[i - 8] for i in halts) > 0.2, "from a speed worth stopping from"
    assert fleet.off(ROWS - 1) < 0.6, "and they are where the track is, or nearly"
