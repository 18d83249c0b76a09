"""How the vehicles move: a quadrotor with its published inner loops, and a differential-drive UGV.

**UAV.** A rigid body carried by four rotors in X configuration, with a first-order lag per rotor and linear
drag, under the velocity and attitude loops of tum_simulator's AR.Drone (commit a020d89; file
`quadrotor_simple_controller.cpp`): velocity error -> tilt -> torque, velocity error -> thrust, each loop
u = P (in - x) + D (d in/dt - dx/dt) with its input clipped. The published loops push the body directly;
the rotors between them are ours, and so is the drag, through which wind acts.

**UGV.** A unicycle with the speed limits of the Pioneer P3-DX and P3-AT and bounded accelerations.

Frames: world ENU, body FLU, commands in the heading frame (body turned level). What is not modelled:
ground effect, blade flapping, battery sag, wheel slip, contacts other than the floor.

A model holds parameters; its memory is passed: `memory = model.init(state)`,
`memory, state = model.step(memory, state, command, ..., dt)`.
"""

from dataclasses import dataclass

from fledge.geometry import Heading, Vec3
from fledge.scalars import Scalar, clip, maximum
from fledge.world import UavState, UgvState, VelocityCommand, settle_on_floor

GRAVITY = 9.81  # [m/s^2]


COMMAND_LAG = 0.2
"""[s] on velocity and yaw commands; chosen. With it a step of 1 m/s stays within the tilt limit, so that the loops stay
linear and two computers agree on a whole flight."""

TILT_LAG = 0.05
"""[s] on the tilt the velocity loop asks for; chosen. The published loop pushes the body with any torque; rotors would
clip the spikes of a restless pilot's commands, and the vehicle then brakes later than its loops say."""


@dataclass(frozen=True, slots=True)
class Gains:
    """One published loop: u = p (in - x) + d (d in/dt - dx/dt), input clipped to +-limit and lagged."""

    p: float
    d: float
    limit: float
    lag: float = 0.0
    """[s] of the published filter on the input. The original leaves it at 0, and every new command is then a spike that
    drives tilt and rotors into their stops; see `COMMAND_LAG`."""

    def update(
        self, wanted: Scalar, previous: Scalar, x: Scalar, dx: Scalar, dt: float
    ) -> tuple[Scalar, Scalar]:
        """(the filtered input, to be passed as `previous` next time; the output u)."""
        rate = (clip(wanted, -self.limit, self.limit) - previous) / (dt + self.lag)
        aim = previous + rate * dt
        return aim, self.p * (aim - x) + self.d * (rate - dx)


@dataclass(frozen=True, slots=True)
class Setpoints:
    """What the inner loops aimed at one step ago."""

    forward: Scalar
    left: Scalar
    up: Scalar
    turn: Scalar
    roll: Scalar
    pitch: Scalar


@dataclass(frozen=True, slots=True)
class UavMemory:
    """The inside of a flying UAV."""

    thrusts: tuple[Scalar, Scalar, Scalar, Scalar]
    """Rotor thrusts [N]: front left, rear left, rear right, front right."""
    acceleration: Vec3
    """World acceleration over the last step [m/s^2]."""
    setpoints: Setpoints


@dataclass(frozen=True, slots=True)
class Quadrotor:
    """An AR.Drone as tum_simulator describes it."""

    mass: float = 1.477  # [kg], quadrotor_base.urdf.xacro
    inertia_xy: float = 0.01152  # [kg m^2], same file
    inertia_z: float = 0.0218  # [kg m^2], same file
    max_thrust: float = 30.0  # [N] in all, quadrotor_simple_controller.urdf.xacro
    velocity_xy: Gains = Gains(5.0, 1.0, 2.0, COMMAND_LAG)  # same file; limit [m/s]
    velocity_z: Gains = Gains(5.0, 1.0, 0.5, COMMAND_LAG)  # limit [m/s]
    tilt: Gains = Gains(10.0, 5.0, 0.5, TILT_LAG)  # limit [rad]
    yaw: Gains = Gains(2.0, 1.0, 1.5, COMMAND_LAG)  # limit [rad/s]
    rotor_offset: float = 0.126  # [m] from each body axis; AR.Drone arm 0.178 m / sqrt(2)
    rotor_drag: float = 0.02  # [m] yaw torque per thrust; chosen, typical of 8-inch rotors
    rotor_lag: float = 0.03  # [s]; chosen, small brushless rotors answer in 20-50 ms
    drag: float = 0.1  # [1/s] deceleration per air speed; chosen small: the original has none at all
    radius: float = 0.26  # [m] half diagonal of the indoor hull, 0.517 m across (Parrot data sheet)
    half_height: float = 0.1  # [m]; chosen, the hull is 0.13 m high

    def init(self, state: UavState) -> UavMemory:
        """Hovering: the rotors carry the weight, the loops are at rest."""
        nothing = 0.0 * state.position.z
        hover = nothing + self.mass * GRAVITY / 4.0
        return UavMemory(
            (hover, hover, hover, hover),
            Vec3(nothing, nothing, nothing),
            Setpoints(nothing, nothing, nothing, nothing, nothing, nothing),
        )

    def step(
        self,
        memory: UavMemory,
        state: UavState,
        command: VelocityCommand,
        wind: Vec3,
        dt: float,
    ) -> tuple[UavMemory, UavState]:
        """One physics step of `dt` [s] in air that moves at `wind` [m/s, world]."""
        setpoints, thrust, torque = self._loops(memory, state, command, dt)
        thrusts = self._rotors(memory.thrusts, thrust, torque, dt)
        acceleration, angular = self._forces(state, thrusts, wind)
        rates = state.rates + angular * dt
        velocity = state.velocity + acceleration * dt
        moved = UavState(
            state.position + velocity * dt,
            velocity,
            state.attitude.integrate(rates, dt),
            rates,
            state.stamp,
        )
        return UavMemory(thrusts, acceleration, setpoints), settle_on_floor(moved)

    def _loops(
        self, memory: UavMemory, state: UavState, command: VelocityCommand, dt: float
    ) -> tuple[Setpoints, Scalar, Vec3]:
        """The published cascade: command -> thrust [N] and torque [N m]."""
        last = memory.setpoints
        roll, pitch, upright = state.attitude.tilt()
        heading = state.attitude.heading()
        vx, vy = heading.from_world(state.velocity.x, state.velocity.y)
        ax, ay = heading.from_world(memory.acceleration.x, memory.acceleration.y)
        forward, want_x = self.velocity_xy.update(command.forward, last.forward, vx, ax, dt)
        left, want_y = self.velocity_xy.update(command.left, last.left, vy, ay, dt)
        up, want_z = self.velocity_z.update(command.up, last.up, state.velocity.z, memory.acceleration.z, dt)
        aim_roll, roll_torque = self.tilt.update(-want_y / GRAVITY, last.roll, roll, state.rates.x, dt)
        aim_pitch, pitch_torque = self.tilt.update(want_x / GRAVITY, last.pitch, pitch, state.rates.y, dt)
        # The published yaw loop has no measured derivative.
        turn, yaw_torque = self.yaw.update(command.turn, last.turn, state.rates.z, 0.0, dt)
        # Tilted rotors lift less: the load factor gives back 1 / cos(tilt).
        load = GRAVITY / maximum(upright, 0.1)
        thrust = clip(self.mass * (want_z + load), 0.0, self.max_thrust)
        torque = Vec3(
            self.inertia_xy * roll_torque,
            self.inertia_xy * pitch_torque,
            self.inertia_z * yaw_torque,
        )
        return Setpoints(forward, left, up, turn, aim_roll, aim_pitch), thrust, torque

    def _rotors(
        self, thrusts: tuple[Scalar, ...], thrust: Scalar, torque: Vec3, dt: float
    ) -> tuple[Scalar, Scalar, Scalar, Scalar]:
        """Share thrust and torque out among the rotors, within what each can lift, after its lag."""
        lift = thrust / 4.0
        roll = torque.x / (4.0 * self.rotor_offset)
        pitch = torque.y / (4.0 * self.rotor_offset)
        yaw = torque.z / (4.0 * self.rotor_drag)
        wanted = (
            lift + roll - pitch - yaw,
            lift + roll + pitch + yaw,
            lift - roll + pitch - yaw,
            lift - roll - pitch + yaw,
        )
        most, share = self.max_thrust / 4.0, dt / (dt + self.rotor_lag)
        a, b, c, d = (
            now + (clip(goal, 0.0, most) - now) * share for now, goal in zip(thrusts, wanted, strict=True)
        )
        return a, b, c, d

    def _forces(
        self, state: UavState, thrusts: tuple[Scalar, Scalar, Scalar, Scalar], wind: Vec3
    ) -> tuple[Vec3, Vec3]:
        """World acceleration [m/s^2] and body angular acceleration [rad/s^2]."""
        a, b, c, d = thrusts
        specific = Vec3(0.0 * a, 0.0 * a, (a + b + c + d) / self.mass)
        lifted = state.attitude.rotate(specific)
        acceleration = lifted + (wind - state.velocity) * self.drag - Vec3(0.0, 0.0, GRAVITY)
        w = state.rates
        # Euler's equations of a body with two equal moments of inertia.
        gyration = (self.inertia_xy - self.inertia_z) / self.inertia_xy
        angular = Vec3(
            self.rotor_offset * (a + b - c - d) / self.inertia_xy + gyration * w.y * w.z,
            self.rotor_offset * (b + c - a - d) / self.inertia_xy - gyration * w.x * w.z,
            self.rotor_drag * (b + d - a - c) / self.inertia_z,
        )
        return acceleration, angular


REAL_AR_DRONE = Quadrotor(
    mass=0.42,  # [kg] with indoor hull; published weights run from 0.38 to 0.466 kg
    inertia_xy=0.0022,  # [kg m^2]; scaled from published identifications, 0.002-0.003
    inertia_z=0.0043,  # [kg m^2]; likewise
    max_thrust=8.5,  # [N]; twice the weight
    velocity_xy=Gains(5.0, 1.0, 2.0, COMMAND_LAG),
    velocity_z=Gains(5.0, 1.0, 0.7, COMMAND_LAG),  # control_vz_max 700 mm/s, ardrone_autonomy launch file
    tilt=Gains(10.0, 5.0, 0.21, TILT_LAG),  # euler_angle_max 0.21 rad, same file
    yaw=Gains(2.0, 1.0, 1.75, COMMAND_LAG),  # control_yaw 1.75 rad/s, same file
    drag=0.3,  # [1/s]; chosen, the indoor hull catches the air
)
"""The same loops within the indoor limits of the real AR.Drone 2.0 (ardrone_autonomy, commit d35607b)."""


@dataclass(frozen=True, slots=True)
class Pioneer:
    """A differential-drive robot; defaults are the P3-DX (AriaCoda b0d02e0, params/p3dx-sh.p)."""

    max_speed: float = 1.2  # [m/s]; cruising limit, the firmware's absolute maximum is 2.2
    max_turn_rate: float = 2.0  # [rad/s]; chosen below the firmware's 500 deg/s
    acceleration: float = 1.0  # [m/s^2]; chosen, gentle for a 9 kg base
    turn_acceleration: float = 4.0  # [rad/s^2]; chosen
    length: float = 0.511  # [m]
    width: float = 0.425  # [m]
    height: float = 0.24  # [m]; 237 mm (data sheet)

    @property
    def radius(self) -> float:
        """Radius [m] of the disc around its centre that contains its footprint."""
        return 0.5 * (self.length**2 + self.width**2) ** 0.5

    def step(self, state: UgvState, command: VelocityCommand, dt: float) -> UgvState:
        """One physics step of `dt` [s]: a unicycle whose speeds chase the command at bounded rates."""
        speed = _chase(state.speed, command.forward, self.max_speed, self.acceleration * dt)
        turn = _chase(state.turn_rate, command.turn, self.max_turn_rate, self.turn_acceleration * dt)
        vx, vy = Heading.of(state.heading + 0.5 * turn * dt).to_world(speed, 0.0)
        return UgvState(
            state.x + vx * dt,
            state.y + vy * dt,
            state.heading + turn * dt,
            speed,
            turn,
            state.stamp,
        )


P3_DX = Pioneer()
P3_AT = Pioneer(max_speed=0.8, length=0.626, width=0.505, height=0.28)  # params/p3at-sh.p; cruising limit

UGV_FLEET = (P3_AT, P3_DX, P3_DX)
"""The paper's three heterogeneous UGVs; it does not say how many of each."""


def _chase(now: Scalar, wanted: Scalar, limit: float, most: float) -> Scalar:
    """`now` moved towards `wanted` (held within +-limit) by at most `most`."""
    return now + clip(clip(wanted, -limit, limit) - now, -most, most)
