"""What stands in the twin's room: sizes, masses and motors of the real vehicles, as far as they are published.

They are deliberately not those of `dynamics`, with which pilots learn and nets are proved: what becomes of a policy
between the two is the gap between simulator and lab, and it is there to be measured.

What is shared are the hulls of the UGVs (`dynamics.Pioneer`), because the net and the referee know them by that name.
"""

from dataclasses import dataclass

from fledge.dynamics import GRAVITY, P3_AT, P3_DX, Pioneer


@dataclass(frozen=True, slots=True)
class Airframe:
    """An AR.Drone 2.0 with its indoor hull."""

    mass: float = 0.42  # [kg]; published weights run from 0.38 to 0.466 kg
    inertia: tuple[float, float, float] = (0.0024, 0.0027, 0.0047)
    """[kg m^2] about body x, y, z; chosen within published identifications, 0.002-0.003 and 0.004-0.005."""
    radius: float = 0.26  # [m] half of the hull's 0.517 m (Parrot data sheet)
    half_height: float = 0.065  # [m] half of the hull's 0.127 m, rounded up (same)
    rotor_offset: float = 0.126  # [m] from each body axis; arm 0.178 m / sqrt(2)
    rotor_drag: float = 0.016  # [m] yaw torque per thrust; chosen, typical of 8-inch rotors
    rotor_lag: float = 0.04  # [s]; chosen, small brushless rotors answer in 20-50 ms
    most_thrust: float = 2.2  # [N] of one rotor with a full battery; chosen, a little over twice its share
    drag: float = 0.58
    """[1/s] deceleration per air speed, along all axes; tum_ardrone commit 3464fb7, DroneKalmanFilter.cpp, c1, where it
    was fitted to flights of a real one."""

    @property
    def weight(self) -> float:
        """[N]."""
        return self.mass * GRAVITY


@dataclass(frozen=True, slots=True)
class Base:
    """A Pioneer on its wheels. Wheels on one side turn together, as under the real ones' belts."""

    hull: Pioneer
    mass: float
    """With its wheels [kg]."""
    axles: tuple[float, ...]
    """Where the axles are, forward of the middle [m]."""
    half_track: float
    """From the middle to a wheel's middle [m]."""
    wheel_radius: float
    """[m]."""
    track: float
    """Distance between wheels by which a turn rate becomes wheel speeds [m]; more than the real one if it skids."""
    caster: float | None = None
    """Where the caster is, forward of the middle [m]."""
    balance: float = 0.0
    """Where the weight is, forward of the middle [m]."""
    wheel_mass: float = 0.5  # [kg]; amr-ros-config commit 265989b, gazebo/pioneer3at.sdf
    clearance: float = 0.05  # [m] below the hull; chosen


DX = Base(
    hull=P3_DX,
    mass=9.0,  # [kg] data sheet
    axles=(0.0,),
    half_track=0.165,  # [m]; chosen between the 0.15 and 0.18 m of others' models
    wheel_radius=0.0975,  # [m] data sheet, 195 mm across
    track=0.33,
    caster=-0.2,  # [m]; chosen
    balance=-0.05,  # [m]; chosen: the batteries are in the back, a quarter of the weight is on the caster
)
"""Its hull is centred on its axle, as in `Pioneer`; the real one reaches 45 mm less far ahead, and more behind."""

AT = Base(
    hull=P3_AT,
    mass=12.0,  # [kg] data sheet
    axles=(0.135, -0.135),  # [m]; pioneer3at.sdf, as above
    half_track=0.197,  # [m]; same
    wheel_radius=0.111,  # [m]; same
    track=0.579,
)
"""Four wheels that cannot steer: to turn it skids. With sliding friction the same under all four, a wheel's own speed
over the ground and its skidding are at right angles, and the moments cancel where track = 2 (b + a^2 / b), with a from
the middle to an axle and b to a wheel: 0.579 m, which the twin's own motion confirms. ARIA's number for the real one is
0.588 m (AriaCoda commit 44dbf74, params/p3at-sh.p, DiffConvFactor)."""

BASES = (AT, DX, DX)
"""In the order of `dynamics.UGV_FLEET`."""

NAMES = ("p3at", "p3dx1", "p3dx2")
"""What they are called, in this order, in the scene, by motion capture and as ROS namespaces."""
UAV_NAME = "ardrone"
