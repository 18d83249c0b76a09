"""Who touched what: by the physics, by the referee, and by which name."""

import pytest

from fledge.clearance import clearances
from fledge.dynamics import REAL_AR_DRONE, UGV_FLEET
from fledge.geometry import Box, Quat, Vec3
from fledge.lab.twin.contacts import AREA, FLOOR, VEHICLES, Witness, physical, refereed
from fledge.world import Arena, Obstacle, UavState, UgvState, WorldState

BOX = Obstacle(Box(2.0, 2.5, -2.0, -1.0), 1.0)
LAB = Arena(Box(-3.3, 3.3, -2.5, 2.5), 4.0, (Obstacle(Box(-3.0, -2.8, 2.0, 2.2), 0.3), BOX))
APART = ((0.0, 1.5), (-1.0, -1.0), (1.0, -0.5))
FREE = (-2.0, 0.0, 2.0)


def world(uav=FREE, ugvs=APART):
    still = Vec3(0.0, 0.0, 0.0)
    return WorldState(
        0.0,
        UavState(Vec3(*uav), still, Quat(1.0, 0.0, 0.0, 0.0), still, 0.0),
        tuple(UgvState(x, y, 0.0, 0.0, 0.0, 0.0) for x, y in ugvs),
    )


def by_referee(*pairs):
    return {(who, what, Witness.REFEREE) for who, what in pairs}


def test_nobody_touches_anything():
    assert refereed(LAB, world()) == set()
    assert physical(set()) == set()


@pytest.mark.parametrize(
    ("now", "found"),
    (
        (world(uav=(3.1, 0.0, 2.0)), by_referee(("ardrone", AREA))),
        (world(uav=(-2.0, 0.0, 3.95)), by_referee(("ardrone", AREA))),
        (world(uav=(-2.0, 0.0, 0.07)), by_referee(("ardrone", FLOOR))),
        (world(uav=(2.2, -1.5, 1.05)), by_referee(("ardrone", "obstacle2"))),
        (world(uav=(-3.06, 2.1, 0.35)), by_referee(("ardrone", "obstacle1"), ("ardrone", AREA))),
        (world(uav=(1.0, -0.5, 0.3)), by_referee(("ardrone", "p3dx2"))),
        (world(ugvs=((0.0, 2.2), *APART[1:])), by_referee(("p3at", AREA))),
        (world(ugvs=((0.0, 1.5), (2.2, -0.8), (0.0, 0.0))), by_referee(("p3dx1", "obstacle2"))),
        (world(ugvs=((-1.3, -0.8), *APART[1:])), by_referee(("p3at", "p3dx1"))),
        (world(ugvs=((0.0, 1.5), (1.3, -0.5), APART[2])), by_referee(("p3dx1", "p3dx2"))),
    ),
)
def test_the_referee_names_what_is_touched(now, found):
    assert refereed(LAB, now) == found


@pytest.mark.parametrize("uav", ((0.0, 0.0, 0.5), (3.2, 2.4, 3.9), (2.2, -1.2, 0.05), (1.2, -0.6, 0.2)))
@pytest.mark.parametrize("first", ((0.0, 1.5), (-1.2, -0.9), (2.0, -0.6)))
def test_it_finds_something_exactly_where_no_distance_is_left(uav, first):
    now = world(uav, (first, *APART[1:]))
    gaps = clearances(LAB, now, REAL_AR_DRONE, UGV_FLEET)
    told = {name for who, what, _ in refereed(LAB, now) for name in (who, what)}
    assert {VEHICLES[i] for i, nearest in enumerate(gaps) if nearest.gap <= 0.0} == told & set(VEHICLES)


def test_the_physics_name_the_vehicle_first():
    touching = {("ardrone", "floor"), ("obstacle2", "p3at"), ("ardrone", "p3dx1"), ("p3at", "p3dx1")}
    assert physical(touching) == {
        ("ardrone", "floor", Witness.PHYSICS),
        ("p3at", "obstacle2", Witness.PHYSICS),
        ("ardrone", "p3dx1", Witness.PHYSICS),
        ("p3at", "p3dx1", Witness.PHYSICS),
    }
