"""The twin's room at work: MuJoCo moves the vehicles, step by step.

MuJoCo keeps its state in place, so a `Plant` is an object that changes, unlike everything else in the lab. Nothing in
it is drawn by chance: the same calls leave the same state, bit for bit, on the same machine.

Added to what the scene says is the air: a force -m c (v - wind) on the middle of the UAV, c its drag per mass. It
stands for what rotors and hull feel at a few metres per second, where that is nearly linear.

Frames: world ENU, bodies FLU; SI units.
"""

from collections.abc import Sequence
from math import atan2, pi
from typing import Any, NamedTuple

import mujoco

from fledge.geometry import Quat, Vec3
from fledge.lab.twin.bodies import BASES, NAMES, UAV_NAME, Airframe
from fledge.lab.twin.scene import mjcf
from fledge.world import Arena, UavState, UgvState, WorldState

ROTORS = 4


class Place(NamedTuple):
    """Where a vehicle is put."""

    position: Vec3
    """[m]."""
    heading: float
    """[rad]."""


class Motion(NamedTuple):
    """How the UAV really moves."""

    position: Vec3
    """World position [m]."""
    attitude: Quat
    """world_from_body."""
    velocity: Vec3
    """World velocity [m/s]."""
    rates: Vec3
    """Body rates [rad/s]."""


class Plant:
    """The room and everything in it."""

    def __init__(
        self, arena: Arena, uav: Place, ugvs: Sequence[Place], airframe: Airframe = Airframe()
    ) -> None:
        """Everybody at rest where they are put, the rotors still; a UAV that is put into the air falls."""
        self.airframe = airframe
        lib: Any = mujoco  # its types are compiled in, unknown to type checkers
        self._model = lib.MjModel.from_xml_string(mjcf(arena, airframe))
        self._data = lib.MjData(self._model)
        names = [self._model.geom(i).name for i in range(self._model.ngeom)]
        self._solids = {i: name for i, name in enumerate(names) if name and "_" not in name}
        self._drag = airframe.mass * airframe.drag
        self._force = self._data.xfrc_applied[self._model.body(UAV_NAME).id]
        self._poses, self._speeds = zip(*(self._views(name) for name in (UAV_NAME, *NAMES)), strict=True)
        for pose, place in zip(self._poses, (uav, *ugvs), strict=True):
            q = Quat.from_yaw(place.heading)
            pose[:] = (place.position.x, place.position.y, place.position.z, q.w, q.x, q.y, q.z)
        self._headings = [place.heading for place in ugvs]
        lib.mj_forward(self._model, self._data)

    def _views(self, name: str) -> tuple[Any, Any]:
        """A vehicle's pose and speeds, as they lie in MuJoCo's state."""
        joint = self._model.joint(name)
        at, moving = int(joint.qposadr[0]), int(joint.dofadr[0])
        return self._data.qpos[at : at + 7], self._data.qvel[moving : moving + 6]

    def spin(self, thrust: float) -> None:
        """Have every rotor at a thrust [N] at once, as in flight."""
        self._data.act[:ROTORS] = thrust

    def drive(self, wheels: Sequence[tuple[float, float]]) -> None:
        """What the servos of left and right wheels are told from now on [rad/s], for every UGV."""
        speeds: list[float] = []
        for base, (left, right) in zip(BASES, wheels, strict=True):
            speeds += [left] * len(base.axles) + [right] * len(base.axles)
        self._data.ctrl[ROTORS:] = speeds

    def step(self, thrusts: Sequence[float], wind: Vec3) -> None:
        """One step of `scene.TIMESTEP`: rotors told these thrusts [N], air that moves at `wind` [m/s, world]."""
        self._data.ctrl[:ROTORS] = thrusts
        vx, vy, vz = self._speeds[0][:3].tolist()
        c = self._drag
        self._force[:3] = (c * (wind.x - vx), c * (wind.y - vy), c * (wind.z - vz))
        mujoco.mj_step(self._model, self._data)  # pyright: ignore[reportAttributeAccessIssue]

    def uav(self) -> Motion:
        """How the UAV moves now."""
        x, y, z, qw, qx, qy, qz = self._poses[0].tolist()
        vx, vy, vz, p, q, r = self._speeds[0].tolist()
        return Motion(Vec3(x, y, z), Quat(qw, qx, qy, qz), Vec3(vx, vy, vz), Vec3(p, q, r))

    def attitudes(self) -> list[tuple[Vec3, Quat]]:
        """Position [m] and world_from_body of every vehicle, the UAV first."""
        return [(Vec3(*pose[:3].tolist()), Quat(*pose[3:].tolist())) for pose in self._poses]

    def world(self, t: float) -> WorldState:
        """The truth, stamped `t`."""
        motion = self.uav()
        uav = UavState(motion.position, motion.velocity, motion.attitude, motion.rates, t)
        return WorldState(t, uav, tuple(self._ugv(i, t) for i in range(len(NAMES))))

    def _ugv(self, i: int, t: float) -> UgvState:
        x, y, _, qw, _, _, qz = self._poses[1 + i].tolist()
        vx, vy, _, _, _, turn = self._speeds[1 + i].tolist()
        nose = Quat(qw, 0.0, 0.0, qz).heading()
        # Unwrapped: whoever drives on through the back sees no jump.
        turned = atan2(nose.sin, nose.cos) - self._headings[i]
        self._headings[i] += (turned + pi) % (2.0 * pi) - pi
        return UgvState(x, y, self._headings[i], nose.cos * vx + nose.sin * vy, turn, t)

    def touching(self) -> set[tuple[str, str]]:
        """Who touches what right now: the names of two hulls, of a hull and an obstacle, or of a hull and the floor.

        In alphabetical order. Wheels on the floor are not told of.
        """
        pairs = self._data.contact.geom[: self._data.ncon].tolist()
        names = ((self._solids.get(a), self._solids.get(b)) for a, b in pairs)
        return {(min(a, b), max(a, b)) for a, b in names if a and b}
