"""The downward camera: where the UGVs appear in its image (section "Simulation Environment").

A pinhole: pixel (u, v) has u to the right and v down the picture; the top of the picture is the UAV's nose. A
point at body coordinates (x forward, y left, z up) below the lens appears at
    u = c_u - f y / -z,    v = c_v - f x / -z.
The features are computed from poses, as in the paper's physical experiment, so nothing is lost when a UGV
leaves the picture. Two mounts: a **levelled** lens (default, as on a gimbal: only yaw turns the picture)
and a **body-fixed** one, which tilts with the airframe. Lens distortion is not modelled.
"""

from dataclasses import dataclass

from fledge.errors import OutOfRange
from fledge.geometry import Vec3
from fledge.scalars import Scalar, maximum, sqrt
from fledge.world import UavState, WorldState

NEAREST = 0.1
"""[m] depths below this are treated as this: at the floor the pinhole has no image."""


@dataclass(frozen=True, slots=True)
class Lens:
    """A pinhole camera that looks down; the default is tum_simulator's bottom camera."""

    focal_px: float = 374.7  # 320 px / tan(81 deg / 2), quadrotor_sensors.urdf.xacro
    width_px: float = 640.0
    height_px: float = 360.0
    levelled: bool = True

    def __post_init__(self) -> None:
        for name in ("focal_px", "width_px", "height_px"):
            if not 1.0 <= getattr(self, name) <= 1e5:
                raise OutOfRange(f"lens {name}", getattr(self, name), "1 to 100000 px")

    @property
    def centre(self) -> tuple[float, float]:
        """(u, v) of the image centre [px]."""
        return self.width_px / 2.0, self.height_px / 2.0

    def project(self, uav: UavState, x: Scalar, y: Scalar, z: Scalar = 0.0) -> tuple[Scalar, Scalar]:
        """Pixel (u, v) of the world point (x, y, z) [m]."""
        p = uav.position
        away = Vec3(x - p.x, y - p.y, z - p.z)
        if self.levelled:
            forward, left = uav.attitude.heading().from_world(away.x, away.y)
            depth = -away.z
        else:
            body = uav.attitude.conjugate().rotate(away)
            forward, left, depth = body.x, body.y, -body.z
        scale = self.focal_px / maximum(depth, NEAREST)
        u, v = self.centre
        return u - scale * left, v - scale * forward

    def sees(self, u: Scalar, v: Scalar) -> Scalar:
        """Whether the pixel lies in the picture."""
        return (u >= 0.0) & (u <= self.width_px) & (v >= 0.0) & (v <= self.height_px)


REAL_BOTTOM_CAMERA = Lens(focal_px=700.5)
"""The AR.Drone's own calibration (ardrone_autonomy d35607b, ardrone_bottom.yaml), principal point centred."""


@dataclass(frozen=True, slots=True)
class Picture:
    """What the paper reads off the image of the UGVs."""

    u: Scalar
    """Centre of mass of the UGVs, to the right [px]."""
    v: Scalar
    """Centre of mass of the UGVs, downwards [px]."""
    radius: Scalar
    """Distance from that centre to the farthest UGV [px] (Table 2's definition; D3)."""
    all_in_view: Scalar
    """Whether every UGV's centre lies in the picture."""


def look(lens: Lens, world: WorldState) -> Picture:
    """The UGVs in the picture."""
    pixels = [lens.project(world.uav, ugv.x, ugv.y) for ugv in world.ugvs]
    n = len(pixels)
    u = sum(p[0] for p in pixels[1:]) * (1.0 / n) + pixels[0][0] * (1.0 / n)
    v = sum(p[1] for p in pixels[1:]) * (1.0 / n) + pixels[0][1] * (1.0 / n)
    farthest, seen = 0.0 * u, lens.sees(*pixels[0])
    for pu, pv in pixels:
        farthest = maximum(farthest, (pu - u) * (pu - u) + (pv - v) * (pv - v))
        seen = seen & lens.sees(pu, pv)
    return Picture(u, v, sqrt(farthest), seen)
