"""What one flight leaves behind."""

import numpy as np
import pytest

from fledge.camera import Lens
from fledge.conditions import Conditions
from fledge.engines import fly_plain
from fledge.episode import Flight
from fledge.manoeuvres import Climb
from fledge.observation import IDEAL_RADIUS_PX, StickScale
from fledge.pilots import Servo
from fledge.simulation import Case, Crew

pytestmark = pytest.mark.slow


def test_a_flight_knows_its_rows_and_what_it_was():
    plan = Climb().plan(np.random.default_rng(0), 7)
    episode = fly_plain(Case(plan, Conditions()), Crew(Servo()), key=(0,))
    flight = Flight(episode, "climb", "servo", "none", seed=0, case=0, axes=Climb.axes, arena=plan.arena)
    assert flight.rows == 7
    assert (flight.lens, flight.sticks, flight.ideal_radius) == (Lens(), StickScale(), IDEAL_RADIUS_PX)
