"""The room at work: falling, drag, rotors, wheels, touches; the laws that MuJoCo must obey as it is set up here."""

from math import exp, pi

import pytest
from workbench import CALM, HALL, PARKED, room

from fledge.dynamics import GRAVITY
from fledge.geometry import Box, Vec3
from fledge.lab.twin.bodies import Airframe
from fledge.lab.twin.plant import Place, Plant
from fledge.lab.twin.scene import TIMESTEP
from fledge.world import Arena, Obstacle

OFF = (0.0, 0.0, 0.0, 0.0)
BODY = Airframe()
EVEN = (0.25 * BODY.weight,) * 4


def steps(plant, thrusts, seconds, wind=CALM):
    for _ in range(round(seconds / TIMESTEP)):
        plant.step(thrusts, wind)


def test_without_rotors_it_falls():
    plant = Plant(HALL, Place(Vec3(0.0, 0.0, 20.0), 0.0), PARKED)
    steps(plant, OFF, 0.5)
    c = BODY.drag
    assert plant.uav().velocity.z == pytest.approx(-GRAVITY * (1.0 - exp(-0.5 * c)) / c, rel=5e-3)


def test_with_its_weight_on_the_rotors_it_hovers():
    plant = room()
    steps(plant, EVEN, 1.0)
    assert plant.uav().velocity.z == pytest.approx(0.0, abs=1e-9)


def test_air_that_moves_takes_it_along_at_the_published_rate():
    plant = room()
    steps(plant, EVEN, 1.0, Vec3(1.0, -2.0, 0.0))
    gone = 1.0 - exp(-BODY.drag)
    v = plant.uav().velocity
    assert (v.x, v.y) == pytest.approx((gone, -2.0 * gone), rel=5e-3)


def test_a_rotor_needs_its_lag():
    plant = Plant(HALL, Place(Vec3(0.0, 0.0, 20.0), 0.0), PARKED)
    steps(plant, (1.0,) * 4, BODY.rotor_lag)
    lifted = sum(plant._data.act[:4]) / 4.0
    assert lifted == pytest.approx(1.0 - exp(-1.0), abs=0.02)


def test_a_rotor_gives_no_more_than_it_can():
    plant = room()
    steps(plant, (100.0,) * 4, 1.0)
    assert max(plant._data.act[:4]) <= BODY.most_thrust


def test_it_stands_on_the_floor_and_stays_there():
    plant = Plant(HALL, Place(Vec3(0.0, 0.0, BODY.half_height), 0.0), PARKED)
    steps(plant, OFF, 2.0)
    p = plant.uav().position
    assert (p.x, p.y, p.z) == pytest.approx((0.0, 0.0, BODY.half_height), abs=2e-3)
    assert plant.touching() == {("ardrone", "floor")}


def test_parked_robots_stay_where_they_are():
    plant = room()
    steps(plant, EVEN, 3.0)
    for ugv, place in zip(plant.world(0.0).ugvs, PARKED, strict=True):
        assert (ugv.x, ugv.y) == pytest.approx((place.position.x, place.position.y), abs=2e-3)
    assert plant.touching() == set()


def test_hulls_and_obstacles_that_meet_are_told_of():
    box = Obstacle(Box(4.0, 4.6, -0.5, 0.5), 1.0)
    near = (Place(Vec3(5.0, 0.0, 0.0), pi), *PARKED[1:])
    plant = Plant(Arena(HALL.bounds, 30.0, (box,)), Place(Vec3(-5.0, 5.0, 0.5), 0.0), near)
    plant.drive([(4.0, 4.0), (0.0, 0.0), (0.0, 0.0)])
    seen = set()
    for _ in range(100):
        steps(plant, OFF, 0.01)
        seen |= plant.touching()
    assert ("obstacle1", "p3at") in seen  # drove into it
    assert ("ardrone", "p3dx1") in seen  # fell onto it
    assert not any("p3dx2" in pair for pair in seen)


def test_a_robot_that_turns_on_and_on_has_a_heading_that_grows():
    plant = room()
    plant.drive([(0.0, 0.0), (-3.0, 3.0), (0.0, 0.0)])
    headings = []
    for i in range(500):
        steps(plant, EVEN, 0.01)
        headings.append(plant.world(0.01 * i).ugvs[1].heading)
    assert headings[-1] > 2.0 * pi
    assert max(abs(b - a) for a, b in zip(headings, headings[1:], strict=False)) < 0.1


def test_speed_is_along_the_nose():
    plant = Plant(
        HALL, Place(Vec3(0.0, 0.0, 5.0), 0.0), (PARKED[0], Place(Vec3(-5.0, 5.0, 0.0), pi / 2), PARKED[2])
    )
    plant.drive([(0.0, 0.0), (-2.0, -2.0), (0.0, 0.0)])
    steps(plant, EVEN, 1.0)
    backwards = plant.world(0.0).ugvs[1]
    assert backwards.speed == pytest.approx(-2.0 * 0.0975, rel=0.02)
    assert backwards.y < 5.0 and backwards.x == pytest.approx(-5.0, abs=1e-3)


def test_the_same_calls_leave_the_same_state():
    def flown():
        plant = room()
        plant.drive([(1.0, 2.0), (3.0, 1.0), (-1.0, 1.0)])
        steps(plant, (1.0, 1.05, 1.02, 1.1), 1.0, Vec3(0.3, 0.0, 0.0))
        return plant._data.qpos.tobytes()

    assert flown() == flown()
