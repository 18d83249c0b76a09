"""The scene: what MuJoCo makes of the text, against what the text was made of."""

from math import radians, tan

import mujoco
import numpy as np
import pytest

from fledge.camera import Lens
from fledge.geometry import Box
from fledge.lab.twin.bodies import BASES, NAMES, UAV_NAME, Airframe
from fledge.lab.twin.scene import ROTORS, mjcf
from fledge.world import Arena, Obstacle

BOXES = (Obstacle(Box(1.0, 1.5, -1.0, 0.0), 0.5), Obstacle(Box(-2.0, -1.0, 1.0, 1.2), 1.8))


@pytest.fixture(scope="module")
def model():
    return mujoco.MjModel.from_xml_string(mjcf(Arena(Box(-3.3, 3.3, -2.5, 2.5), 4.0, BOXES)))


def corners(model, name):
    """Lower and upper corner of a box."""
    geom = model.geom(name)
    return geom.pos - geom.size, geom.pos + geom.size


@pytest.mark.parametrize(("number", "obstacle"), list(enumerate(BOXES, start=1)))
def test_obstacles_stand_where_the_arena_has_them(model, number, obstacle):
    low, high = corners(model, f"obstacle{number}")
    f = obstacle.footprint
    assert low == pytest.approx((f.x_min, f.y_min, 0.0))
    assert high == pytest.approx((f.x_max, f.y_max, obstacle.height))


def test_vehicles_weigh_what_they_should(model):
    masses = {name: model.body_subtreemass[model.body(name).id] for name in (UAV_NAME, *NAMES)}
    expected = {UAV_NAME: Airframe().mass, **{n: b.mass for n, b in zip(NAMES, BASES, strict=True)}}
    assert masses == pytest.approx(expected)


@pytest.mark.parametrize(("name", "base"), list(zip(NAMES, BASES, strict=True)))
def test_hulls_are_those_that_nets_and_referee_know(model, name, base):
    low, high = corners(model, name)
    assert high[:2] - low[:2] == pytest.approx((base.hull.length, base.hull.width))
    assert high[2] == pytest.approx(base.hull.height)


def test_the_bottom_camera_is_the_training_lens(model):
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    camera, lens = model.camera("bottom"), Lens()
    assert lens.height_px / 2.0 / tan(radians(camera.fovy[0]) / 2.0) == pytest.approx(lens.focal_px)
    right, up, back = data.camera("bottom").xmat.reshape(3, 3).T
    assert right == pytest.approx((0.0, -1.0, 0.0))  # to the right of the picture is the UAV's right
    assert up == pytest.approx((1.0, 0.0, 0.0))  # and its top is the nose
    assert back == pytest.approx((0.0, 0.0, 1.0))  # it looks down


@pytest.mark.parametrize("rotor", range(4))
def test_a_rotor_lifts_and_turns_by_its_place(model, rotor):
    data, body = mujoco.MjData(model), Airframe()
    data.act[rotor] = 1.0
    mujoco.mj_forward(model, data)
    x, y, spin = ROTORS[rotor]
    offset = body.rotor_offset
    # A force up at (x, y) turns about body x by y, about y by -x; the reaction of the rotor's drag turns about z.
    expected = (0.0, 0.0, 1.0, y * offset, -x * offset, spin * body.rotor_drag)
    start = model.joint(UAV_NAME).dofadr[0]
    assert data.qfrc_actuator[start : start + 6] == pytest.approx(np.array(expected), abs=1e-9)


def test_the_edge_of_the_safe_area_holds_nobody_back(model):
    thin = [i for i in range(model.ngeom) if model.geom(i).name == "" and model.geom_type[i] == 6]
    assert len(thin) == 4
    assert not any(model.geom_contype[i] or model.geom_conaffinity[i] for i in thin)


def test_no_sparse_solver(model):
    assert model.opt.jacobian == mujoco.mjtJacobian.mjJAC_DENSE
