"""What is counted of a flight behind a net: interventions, needless ones, holds; on either backend."""

from dataclasses import dataclass

import jax
import numpy as np
import pytest

from fledge.engines import fly, fly_plain
from fledge.manoeuvres import FixedAltitude
from fledge.observation import ROW_RATE, Action
from fledge.pilots import AbstractPilot, Servo
from fledge.safety import AbstractNet, NoNet
from fledge.scalars import where
from fledge.simulation import Case, Crew, Rig
from fledge.study.bill import BUDGE, HELD, HORIZON, billed, holds, watched
from fledge.world import VelocityCommand, Verdict

pytestmark = pytest.mark.slow

ROWS = 140
CASE = Case.draw(FixedAltitude(), (1, 0), ROWS)
KEYS = [(2, 0), (2, 1)]
RIG = Rig()


@dataclass(frozen=True, slots=True)
class Nag(AbstractNet):
    """Stops the UAV between two moments [s], needed or not."""

    begin: float
    end: float

    def init(self, arena, world):
        return ()

    def filter(self, memory, world, commands):
        zero = 0.0 * world.t
        stops = (world.t >= self.begin) & (world.t < self.end)
        sent = where(stops, VelocityCommand(zero, zero, zero, zero), commands.uav)
        verdict = Verdict(sent, where(stops, 1.0 + zero, zero), where(stops, 1.0 + zero, zero), zero)
        return memory, (verdict, *(Verdict(told, zero, zero, zero) for told in commands.ugvs))


@dataclass(frozen=True, slots=True)
class Sink(AbstractPilot):
    """Goes down, whatever is below."""

    name = "sink"

    def act(self, memory, observation, noise):
        zero = 0.0 * observation.radius
        return memory, Action(zero, zero, zero - 1.0, zero)


def charge(pilot, net, rows=ROWS):
    """The bill of two flights."""
    return fly([CASE.lasting(rows)] * 2, Crew(pilot, net=net), KEYS, RIG, billed(RIG), watched)


def test_without_a_net_there_is_nothing_to_pay():
    bill = charge(Servo(), NoNet())
    assert not bill.interventions.any() and not bill.needless.any() and not bill.held.any()
    assert bill.interventions.shape == (2, 5) and bill.gap.shape == bill.thing.shape == bill.held.shape == (
        2,
        4,
    )
    assert (bill.gap > 0.0).all()
    # Whatever is nearest is never farther than the nearest wall.
    assert (bill.gap <= bill.thing).all()


def test_where_nothing_would_have_been_touched_every_intervention_was_needless():
    """From the tenth row to the thirtieth; the shadow that judges them has ended before the flight."""
    bill = charge(Servo(), Nag(0.495, 1.495))
    np.testing.assert_array_equal(bill.interventions, [[20, 0, 0, 0, 20]] * 2)
    np.testing.assert_array_equal(bill.needless, bill.interventions)


def test_what_the_end_leaves_undecided_was_needless_too():
    rows, undecided = fly_plain(CASE.lasting(25), Crew(Servo(), net=Nag(0.495, 100.0)), KEYS[0], RIG, watched)
    assert not np.sum(rows.needless)
    assert undecided == (15.0, 0.0, 0.0, 0.0, 15.0)


def test_where_the_floor_would_have_been_touched_none_was():
    """The UAV sinks at 0.5 m/s from 2.8 m, is stopped at 1.1 m, and would have landed hard."""
    bill = charge(Sink(), Nag(3.495, 100.0))
    assert (bill.interventions[:, 0] == ROWS - 70).all()
    # All but those after the first shadow, which the end leaves undecided.
    assert (bill.needless[:, 0] == ROWS - 70 - HORIZON).all()
    assert (bill.gap[:, 0] > 0.0).all() and (charge(Sink(), NoNet()).gap[:, 0] <= 0.0).all()


def test_both_backends_send_the_same_bill():
    case = CASE.lasting(25)
    crew = Crew(Servo(), net=Nag(0.495, 100.0))
    compiled = fly([case], crew, KEYS[:1], RIG, None, watched)
    plain = fly_plain(case, crew, KEYS[0], RIG, watched)
    for one, other in zip(jax.tree.leaves(compiled), jax.tree.leaves(plain), strict=True):
        np.testing.assert_allclose(np.asarray(one)[0], other, rtol=2e-3, atol=2e-3)


@pytest.mark.parametrize(
    ("rows", "way", "expected"),
    ((HELD - 1, 0.0, 0), (HELD, 0.0, 1), (2 * HELD, 0.0, 1), (2 * HELD, 2.0 * BUDGE, 0)),
    ids=("a little less than long enough", "long enough", "longer is no more often", "it gets on"),
)
def test_who_does_not_get_on_for_five_seconds_waits_for_a_person(rows, way, expected):
    assert HELD / ROW_RATE == 5.0
    intervened = np.zeros(3 * HELD)
    intervened[20 : 20 + rows] = 1.0
    x = way / HELD * np.arange(3.0 * HELD)
    assert holds(intervened, (x, 0.0 * x, 0.0 * x)) == expected


def test_to_be_held_twice_is_to_wait_twice():
    intervened = np.ones(3 * HELD)
    intervened[HELD + 20] = 0.0
    still = np.zeros(3 * HELD)
    assert holds(intervened, (still, still, still)) == 2
