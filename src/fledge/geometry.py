"""Vectors, rotations and distances, written out component by component.

A vector is a record of three numbers, not an array of shape (3,): under `vmap` that compiles to
structure-of-arrays code with no transposes, and on plain floats it is several times faster than NumPy.
Frames are right-handed; angles are in radians; a rotation `world_from_body` takes body coordinates to
world coordinates.
"""

from dataclasses import dataclass

from fledge.scalars import Scalar, asin, clip, cos, maximum, minimum, sin, sqrt


@dataclass(frozen=True, slots=True)
class Vec3:
    """A vector in space."""

    x: Scalar
    y: Scalar
    z: Scalar

    def __add__(self, other: "Vec3") -> "Vec3":
        return Vec3(self.x + other.x, self.y + other.y, self.z + other.z)

    def __sub__(self, other: "Vec3") -> "Vec3":
        return Vec3(self.x - other.x, self.y - other.y, self.z - other.z)

    def __mul__(self, factor: Scalar) -> "Vec3":
        return Vec3(self.x * factor, self.y * factor, self.z * factor)

    def cross(self, other: "Vec3") -> "Vec3":
        """Vector product."""
        return Vec3(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )


@dataclass(frozen=True, slots=True)
class Heading:
    """A direction in the plane, as the cosine and sine of its angle from east."""

    cos: Scalar
    sin: Scalar

    @classmethod
    def of(cls, angle: Scalar) -> "Heading":
        """From an angle [rad], counter-clockwise."""
        return cls(cos(angle), sin(angle))

    def to_world(self, forward: Scalar, left: Scalar) -> tuple[Scalar, Scalar]:
        """(east, north) of a plane vector given as (forward, left)."""
        return self.cos * forward - self.sin * left, self.sin * forward + self.cos * left

    def from_world(self, x: Scalar, y: Scalar) -> tuple[Scalar, Scalar]:
        """(forward, left) of a plane vector given as (east, north)."""
        return self.cos * x + self.sin * y, self.cos * y - self.sin * x


@dataclass(frozen=True, slots=True)
class Quat:
    """A unit quaternion, scalar part first."""

    w: Scalar
    x: Scalar
    y: Scalar
    z: Scalar

    @classmethod
    def from_yaw(cls, yaw: Scalar) -> "Quat":
        """Rotation about z by `yaw` [rad]."""
        return cls(cos(0.5 * yaw), 0.0 * yaw, 0.0 * yaw, sin(0.5 * yaw))

    def rotate(self, v: Vec3) -> Vec3:
        """Take `v` from the right-hand frame to the left-hand frame of the name."""
        u = Vec3(self.x, self.y, self.z)
        t = u.cross(v) * 2.0
        return v + t * self.w + u.cross(t)

    def conjugate(self) -> "Quat":
        """The inverse rotation."""
        return Quat(self.w, -self.x, -self.y, -self.z)

    def heading(self) -> Heading:
        """Where the nose points, seen from above (the yaw of the z-y-x convention)."""
        x = 1.0 - 2.0 * (self.y * self.y + self.z * self.z)
        y = 2.0 * (self.w * self.z + self.x * self.y)
        scale = 1.0 / sqrt(maximum(x * x + y * y, 1e-12))
        return Heading(x * scale, y * scale)

    def tilt(self) -> tuple[Scalar, Scalar, Scalar]:
        """(roll [rad], pitch [rad], cosine of the angle between body z and up), z-y-x convention.

        Roll is given within +-90 degrees: an airframe on its back is beyond recovery here.
        """
        w, x, y, z = self.w, self.x, self.y, self.z
        side, up = 2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)
        roll = asin(side / sqrt(maximum(side * side + up * up, 1e-12)))
        return roll, asin(2.0 * (w * y - z * x)), up

    def integrate(self, rates: Vec3, dt: float) -> "Quat":
        """The attitude after `dt` [s] at body rates `rates` [rad/s], normalised again (first order)."""
        w, x, y, z = self.w, self.x, self.y, self.z
        h = 0.5 * dt
        w, x, y, z = (
            w - h * (x * rates.x + y * rates.y + z * rates.z),
            x + h * (w * rates.x + y * rates.z - z * rates.y),
            y + h * (w * rates.y + z * rates.x - x * rates.z),
            z + h * (w * rates.z + x * rates.y - y * rates.x),
        )
        scale = 1.0 / sqrt(w * w + x * x + y * y + z * z)
        return Quat(w * scale, x * scale, y * scale, z * scale)


@dataclass(frozen=True, slots=True)
class Box:
    """An axis-aligned rectangle in the plane [m]; empty when an upper edge is below its lower edge."""

    x_min: Scalar
    x_max: Scalar
    y_min: Scalar
    y_max: Scalar

    def gap(self, x: Scalar, y: Scalar) -> tuple[Scalar, Scalar]:
        """Vector [m] from the nearest point of the box to (x, y); zero inside."""
        return x - clip(x, self.x_min, self.x_max), y - clip(y, self.y_min, self.y_max)

    def distance(self, x: Scalar, y: Scalar) -> Scalar:
        """Signed distance [m] from (x, y) to the edge: positive outside, negative inside."""
        dx, dy = self.gap(x, y)
        inside = minimum(minimum(x - self.x_min, self.x_max - x), minimum(y - self.y_min, self.y_max - y))
        return sqrt(dx * dx + dy * dy) - maximum(inside, 0.0)

    def overlaps(self, other: "Box") -> Scalar:
        """Whether the two have some area in common; to touch is not enough."""
        return (
            (self.x_min < other.x_max)
            & (other.x_min < self.x_max)
            & (self.y_min < other.y_max)
            & (other.y_min < self.y_max)
        )
