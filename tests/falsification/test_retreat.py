"""The retreat pilot knows a way out when it sees one, and takes it."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from fledge.falsification.retreat import SPEED, STEPS, WAYS, lead, place, way_out
from fledge.geometry import Box, Quat, Vec3
from fledge.pytrees import register
from fledge.simulation import Rig
from fledge.world import Arena, Obstacle, UavState, UgvState, WorldState

pytestmark = pytest.mark.slow

RIG = Rig()
STILL = Vec3(0.0, 0.0, 0.0)
HALL = Arena(Box(-5.0, 5.0, -5.0, 5.0), 6.0, (Obstacle(Box(3.0, 3.5, -1.0, 1.0), 1.0),))
EAST = Vec3(1.0, 0.0, 0.0)
LID = RIG.formation.fleet[0].height
LOOK = jax.jit(partial(way_out, RIG))


def world(uav=(0.0, 0.0, 2.0), *ugvs) -> WorldState:
    rest = ((-4.0, -4.0), (-4.0, -2.5), (-4.0, 4.0))[len(ugvs) :]
    return WorldState(
        0.0,
        UavState(Vec3(*uav), STILL, Quat.from_yaw(1.0), STILL, 0.0),
        tuple(UgvState(x, y, 0.5, 0.0, 0.0, 0.0) for x, y in (*ugvs, *rest)),
    )


def way(now: WorldState, focus: int, arena: Arena = HALL, tried: Vec3 = STILL):
    """(the direction, whether there is room)."""
    register((arena, now))
    found, exists = LOOK(arena, now, float(focus), tried)
    return np.array([found.x, found.y, found.z]), bool(exists)


def test_it_leads_away_from_a_wall():
    for focus, now in ((0, world((4.6, 0.0, 3.0))), (1, world((0.0, 0.0, 3.0), (4.5, 3.0)))):
        (x, _, _), exists = way(now, focus)
        assert exists and x < 0.0


def test_it_does_not_try_the_same_way_twice():
    now = world((4.6, 0.0, 3.0))
    first, _ = way(now, 0)
    second, exists = way(now, 0, tried=Vec3(*first))
    assert exists and first @ second < 0.99


@pytest.mark.parametrize("side", [-0.1, 0.1])
def test_it_leads_out_from_under_a_uav(side):
    """As roomy as anything else at first is the way to the other side of it."""
    found, exists = way(world((0.0, 0.0, 0.25 + RIG.uav.half_height + LID), (0.0, side)), 1)
    assert exists and found[1] * side > 0.09


def test_who_is_walled_in_has_no_way():
    closet = Arena(Box(-0.4, 0.4, -0.4, 0.4), 0.5)
    assert not way(world((0.0, 0.0, 0.25)), 0, closet)[1]
    boxed = Arena(
        HALL.bounds,
        6.0,
        tuple(
            Obstacle(Box(x - 0.5, x + 0.5, y - 0.5, y + 0.5), 2.0)
            for x, y in ((1.2, 0.0), (-1.2, 0.0), (0.0, 1.2), (0.0, -1.2))
        ),
    )
    assert not way(world((4.0, 4.0, 4.0), (0.0, 0.0)), 1, boxed)[1]
    (_, _, up), exists = way(world((0.0, 0.0, 1.5)), 0, boxed)
    assert exists and up == 1.0, "a UAV leaves upwards"


def test_a_ugv_does_not_fly():
    found, _ = way(world((0.0, 0.0, 3.0), (1.0, 1.0)), 1)
    assert found[2] == 0.0


@pytest.mark.parametrize("focus", range(4))
def test_one_is_led_and_the_others_stand(focus):
    now = world((0.0, 0.0, 3.0))
    told = lead(RIG, jax.tree.map(jnp.asarray, now), jnp.asarray(float(focus)), EAST)
    moving = [abs(c.forward) + abs(c.left) + abs(c.up) > 0.0 for c in (told.uav, *told.ugvs)]
    assert moving == [i == focus for i in range(4)]
    if focus == 0:
        assert told.uav.forward**2 + told.uav.left**2 == pytest.approx(SPEED**2)
        assert told.uav.forward == pytest.approx(SPEED * np.cos(1.0), rel=1e-5), "in its own heading"


def test_the_place_in_focus_is_the_vehicles():
    now = world((1.0, 2.0, 3.0))
    assert float(place(now, np.float64(0.0)).z) == 3.0
    assert float(place(now, np.float64(3.0)).y) == 4.0


def test_ways_are_directions_and_steps_go_outwards():
    np.testing.assert_allclose(np.linalg.norm(WAYS, axis=1), 1.0)
    assert list(STEPS) == sorted(STEPS)
