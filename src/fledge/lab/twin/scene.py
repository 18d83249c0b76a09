"""The lab as a MuJoCo scene: an arena, the AR.Drone and three Pioneers, as MJCF text.

Frames: world ENU, origin as the arena's, z up from the floor; bodies FLU. The AR.Drone's origin is the middle of its
hull, a Pioneer's lies between its wheels, on the floor.

* The AR.Drone is a free body with four rotors, each a thrust and a yaw moment at its place, behind a first-order lag
  (MuJoCo's `filterexact`). Its hull is an upright cylinder.
* A Pioneer is a box on wheels. A wheel touches the floor alone, in one point (it is a sphere to the collision code),
  and is driven by a velocity servo. A P3-DX rests on a caster without friction.
* Obstacles are boxes. The safe area is a line on the floor: it holds nobody back, and whoever crosses it is for the
  referee to see (`contacts`).

Contacts are solved with an elliptic cone, since a skidding robot lives by its friction, and with dense matrices: in
MuJoCo 4.0.0 the sparse solver factors a wrong matrix (release notes of 4.0.1).

Everything is matt, so that a lid seen from above has its colour of `SURFACES` wherever it is in the picture.

Ground effect, blade flapping and the robots' suspension are not modelled.
"""

from math import atan, degrees, pi

from fledge.camera import Lens
from fledge.geometry import Box
from fledge.lab.twin.bodies import BASES, NAMES, UAV_NAME, Airframe, Base
from fledge.world import Arena, Obstacle

TIMESTEP = 0.002
"""[s] 500 Hz, at which the drone's own loops run."""

SIDES = (("left", 1.0), ("right", -1.0))
ROTORS = ((1.0, 1.0, -1.0), (-1.0, 1.0, 1.0), (-1.0, -1.0, -1.0), (1.0, -1.0, 1.0))
"""Front left, rear left, rear right, front right: signs of x and y, and of the yaw moment that goes with its thrust."""

SERVO = 300.0
"""[N m s/rad] of a wheel's servo; chosen: stiff enough that a skid does not slow the wheels. Only the tyres limit its
torque, by slipping at 1.6 N m: MuJoCo steps a servo at its limit explicitly, and it then rattles from limit to limit,
while a robot that should stand creeps away at 4 cm/s."""

TYRE = 'priority="1" friction="0.5 0.005 0.0001" solref="0.02 1" solimp="0.3 0.98 0.003"'
"""Hard indoor tyres on a hall's floor; chosen. They give by some tenths of a millimetre: four wheels that do not, on a
floor that does not, rattle."""

HULL, ROLLING = 1, 2
"""Bits of what may touch what: hulls touch everything solid, wheels the floor only."""

SURFACES = {
    "floor": "0.62 0.62 0.6 1",
    "line": "0.9 0.8 0.1 1",
    "obstacle": "0.45 0.3 0.2 1",
    "ardrone": "0.1 0.1 0.1 1",
    "p3at": "0.75 0.1 0.1 1",
    "p3dx1": "0.1 0.3 0.75 1",
    "p3dx2": "0.1 0.6 0.25 1",
    "wheel": "0.05 0.05 0.05 1",
}


def mjcf(arena: Arena, airframe: Airframe = Airframe(), lens: Lens = Lens()) -> str:
    """The scene; all vehicles stand at the origin until they are placed. `lens` is that of the bottom camera."""
    vehicles = [_uav(airframe, lens), *(_ugv(*pair) for pair in zip(NAMES, BASES, strict=True))]
    obstacles = [_obstacle(f"obstacle{i}", one) for i, one in enumerate(arena.obstacles, start=1)]
    return f"""<mujoco model="fledge's lab">
<compiler angle="radian"/>
<option timestep="{TIMESTEP}" integrator="discrete" jacobian="dense" cone="elliptic" impratio="10"/>
<visual><global offwidth="1280" offheight="720"/><quality offsamples="0" shadowsize="0"/>
<headlight ambient="0.3 0.3 0.3" diffuse="0 0 0" specular="0 0 0"/></visual>
<asset>{"".join(f'<material name="{name}" rgba="{rgba}" specular="0"/>' for name, rgba in SURFACES.items())}</asset>
<worldbody>
<light directional="true" pos="0 0 8" dir="0.2 0.1 -1" castshadow="false"/>
<geom name="floor" type="plane" size="0 0 1" contype="0" conaffinity="{HULL | ROLLING}" material="floor"/>
{_lines(arena.bounds)}
{"".join(obstacles)}
{"".join(vehicles)}
</worldbody>
<actuator>
{_rotors(airframe)}
{"".join(_motors(*pair) for pair in zip(NAMES, BASES, strict=True))}
</actuator>
</mujoco>"""


def _lines(bounds: Box) -> str:
    """The edge of the safe area, painted on the floor."""
    b, half = bounds, 0.02
    middle_x, middle_y = 0.5 * (b.x_min + b.x_max), 0.5 * (b.y_min + b.y_max)
    wide, long = 0.5 * (b.x_max - b.x_min), 0.5 * (b.y_max - b.y_min)
    painted = [(x, middle_y, half, long) for x in (b.x_min, b.x_max)]
    painted += [(middle_x, y, wide, half) for y in (b.y_min, b.y_max)]
    return "".join(
        f'<geom type="box" pos="{x} {y} 0.001" size="{w} {h} 0.001" contype="0" conaffinity="0" material="line"/>'
        for x, y, w, h in painted
    )


def _obstacle(name: str, obstacle: Obstacle) -> str:
    f, half = obstacle.footprint, 0.5 * obstacle.height
    middle = f"{0.5 * (f.x_min + f.x_max)} {0.5 * (f.y_min + f.y_max)} {half}"
    size = f"{0.5 * (f.x_max - f.x_min)} {0.5 * (f.y_max - f.y_min)} {half}"
    solid = f'contype="0" conaffinity="{HULL}"'
    return f'<geom name="{name}" type="box" pos="{middle}" size="{size}" {solid} material="obstacle"/>'


def _uav(airframe: Airframe, lens: Lens) -> str:
    inertia = " ".join(map(str, airframe.inertia))
    hull = f'type="cylinder" size="{airframe.radius} {airframe.half_height}"'
    offset = airframe.rotor_offset
    sites = "".join(
        f'<site name="rotor{i}" pos="{x * offset} {y * offset} 0"/>' for i, (x, y, _) in enumerate(ROTORS)
    )
    field = degrees(2.0 * atan(0.5 * lens.height_px / lens.focal_px))
    return f"""<body name="{UAV_NAME}"><freejoint name="{UAV_NAME}"/>
<inertial pos="0 0 0" mass="{airframe.mass}" diaginertia="{inertia}"/>
<geom name="{UAV_NAME}" {hull} contype="{HULL}" conaffinity="{HULL}" material="ardrone"/>
<camera name="bottom" pos="0 0 {-airframe.half_height}" xyaxes="0 -1 0 1 0 0" fovy="{field}"/>
{sites}</body>"""


def _ugv(name: str, base: Base) -> str:
    """A free body whose parts hang in it; the hull's weight lies low, as batteries do."""
    hull, low = base.hull, base.clearance
    half_height = 0.5 * (hull.height - low)
    size = f"{0.5 * hull.length} {0.5 * hull.width} {half_height}"
    middle = f"{base.balance} 0 {base.wheel_radius}"
    mass = base.mass - base.wheel_mass * 2 * len(base.axles)
    wheels = [
        _wheel(f"{name}_{side}{i}", base, axle, sign * base.half_track)
        for side, sign in SIDES
        for i, axle in enumerate(base.axles)
    ]
    return f"""<body name="{name}"><freejoint name="{name}"/>
<inertial pos="{middle}" mass="{mass}" diaginertia="{_box_inertia(mass, hull.length, hull.width)}"/>
<geom name="{name}" type="box" pos="0 0 {low + half_height}" size="{size}"
 contype="{HULL}" conaffinity="{HULL}" material="{name}"/>
{_caster(name, base)}{"".join(wheels)}</body>"""


def _box_inertia(mass: float, length: float, width: float) -> str:
    """Of a flat box, 0.15 m high, a little more than its batteries and motors are."""
    squares = (width**2 + 0.15**2, length**2 + 0.15**2, length**2 + width**2)
    return " ".join(str(mass * square / 12.0) for square in squares)


def _caster(name: str, base: Base) -> str:
    if base.caster is None:
        return ""
    ball = f'type="sphere" size="0.03" pos="{base.caster} 0 0.03" material="wheel"'
    smooth = 'condim="1" priority="1"'  # else the floor's friction would count
    return f'<geom name="{name}_caster" {ball} {smooth} contype="{ROLLING}" conaffinity="0"/>'


def _wheel(name: str, base: Base, x: float, y: float) -> str:
    r, m = base.wheel_radius, base.wheel_mass
    spin, tumble = 0.5 * m * r * r, 0.25 * m * r * r
    return f"""<body name="{name}" pos="{x} {y} {r}">
<joint name="{name}" axis="0 1 0" damping="0.02" armature="0.02"/>
<inertial pos="0 0 0" mass="{m}" diaginertia="{tumble} {spin} {tumble}"/>
<geom name="{name}" type="sphere" size="{r}" contype="{ROLLING}" conaffinity="0" {TYRE} group="3"/>
<geom type="cylinder" size="{r} 0.03" euler="{pi / 2} 0 0" contype="0" conaffinity="0" material="wheel"/></body>"""


def _rotors(airframe: Airframe) -> str:
    lag = f'dyntype="filterexact" dynprm="{airframe.rotor_lag}"'
    reach = f'ctrllimited="true" ctrlrange="0 {airframe.most_thrust}"'
    return "".join(
        f'<general name="rotor{i}" site="rotor{i}" gear="0 0 1 0 0 {sign * airframe.rotor_drag}" {lag} {reach}/>'
        for i, (_, _, sign) in enumerate(ROTORS)
    )


def _motors(name: str, base: Base) -> str:
    return "".join(
        f'<velocity name="{name}_{side}{i}" joint="{name}_{side}{i}" kv="{SERVO}"/>'
        for side, _ in SIDES
        for i in range(len(base.axles))
    )
