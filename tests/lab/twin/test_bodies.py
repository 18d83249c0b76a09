"""The vehicles' numbers: that they hang together, and agree with what is published."""

import pytest

from fledge.dynamics import REAL_AR_DRONE, UGV_FLEET
from fledge.lab.twin.bodies import AT, BASES, DX, NAMES, UAV_NAME, Airframe


def test_the_bases_stand_in_the_order_of_the_fleet():
    assert tuple(base.hull for base in BASES) == UGV_FLEET
    assert len({UAV_NAME, *NAMES}) == 1 + len(BASES)


def test_a_skidding_base_turns_as_sliding_friction_has_it():
    a, b = AT.axles[0], AT.half_track
    assert AT.track == pytest.approx(2.0 * (b + a * a / b), abs=1e-3)


def test_its_track_is_near_that_of_the_real_one():
    aria = 2.0 / 0.0034 / 1e3  # DiffConvFactor of p3at-sh.p is 2 / track [1/mm]
    assert AT.track == pytest.approx(aria, rel=0.02)


def test_wheels_that_do_not_skid_turn_at_their_distance():
    assert DX.track == 2.0 * DX.half_track


@pytest.mark.parametrize("base", BASES)
def test_a_base_stands_on_its_wheels(base):
    contacts = [*base.axles, *([base.caster] if base.caster is not None else [])]
    assert min(contacts) < base.balance < max(contacts)
    assert base.wheel_radius > base.clearance
    assert base.mass > base.wheel_mass * 2 * len(base.axles)


def test_the_rotors_can_carry_the_uav_and_steer_it():
    body = Airframe()
    assert 4.0 * body.most_thrust > 1.5 * body.weight


def test_the_uav_is_not_the_one_that_nets_were_proved_for():
    body, known = Airframe(), REAL_AR_DRONE
    assert body.drag != known.drag and body.rotor_lag != known.rotor_lag
    assert known.inertia_xy not in body.inertia
    assert body.radius <= known.radius and body.half_height <= known.half_height
