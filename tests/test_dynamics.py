"""How the vehicles move, against closed forms and balances of force."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from fledge.dynamics import GRAVITY, P3_AT, P3_DX, REAL_AR_DRONE, UGV_FLEET, Pioneer, Quadrotor
from fledge.geometry import Heading, Quat, Vec3
from fledge.world import UavState, UgvState, VelocityCommand

pytestmark = pytest.mark.slow

DT = 0.002
STILL_AIR = Vec3(0.0, 0.0, 0.0)
QUADROTORS = pytest.mark.parametrize("model", (Quadrotor(), REAL_AR_DRONE), ids=("simulated", "real"))


def at_rest(z: float = 20.0, yaw: float = 0.0) -> UavState:
    still = Vec3(0.0, 0.0, 0.0)
    return UavState(Vec3(0.0, 0.0, z), still, Quat.from_yaw(yaw), still, 0.0)


def fly(model, command, seconds, wind=STILL_AIR, state=None, memory=None, dt=DT):
    """(memory, state) after every step."""
    state = state or at_rest()
    memory = memory or model.init(state)
    history = []
    for _ in range(round(seconds / dt)):
        memory, state = model.step(memory, state, command, wind, dt)
        history.append((memory, state))
    return history


def steady_tilt_and_speed(model, wanted, wind):
    """Where tilt balances drag: g tan(tilt) = drag (v - wind), with tilt = p (wanted - v) / g."""
    wanted = float(np.clip(wanted, -model.velocity_xy.limit, model.velocity_xy.limit))

    def tilt(v):
        return model.velocity_xy.p * (wanted - v) / GRAVITY

    def surplus(v):
        return GRAVITY * math.tan(tilt(v)) - model.drag * (v - wind)

    reach = 1.5 * GRAVITY / model.velocity_xy.p
    v = brentq(surplus, wanted - reach, wanted + reach)
    return tilt(v), v


@QUADROTORS
@pytest.mark.parametrize("yaw", (0.0, 2.0))
def test_hover_is_an_equilibrium(model, yaw):
    memory, state = fly(model, VelocityCommand.hover(), 2.0, state=at_rest(yaw=yaw))[-1]
    for part in (state.velocity, state.rates, memory.acceleration):
        assert (part.x, part.y, part.z) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    assert state.position.z == pytest.approx(20.0, abs=1e-12)
    assert sum(memory.thrusts) == pytest.approx(model.mass * GRAVITY)


@QUADROTORS
@pytest.mark.parametrize("wanted", (0.3, -1.0, 5.0))
def test_a_velocity_step_settles_at_the_command_less_what_drag_takes(model, wanted):
    history = fly(model, VelocityCommand(wanted, 0.0, 0.0, 0.0), 12.0)
    state = history[-1][1]
    tilt, speed = steady_tilt_and_speed(model, wanted, wind=0.0)
    assert state.velocity.x == pytest.approx(speed, abs=1e-6)
    assert state.attitude.tilt()[1] == pytest.approx(tilt, abs=1e-6)
    assert (state.velocity.y, state.velocity.z) == pytest.approx((0.0, 0.0), abs=1e-6)
    # The linear form of the same: p / (p + drag) of what was asked.
    asked = min(max(wanted, -model.velocity_xy.limit), model.velocity_xy.limit)
    share = model.velocity_xy.p / (model.velocity_xy.p + model.drag)
    assert speed == pytest.approx(share * asked, rel=1e-3)


@QUADROTORS
def test_hover_in_a_breeze_drifts_by_what_the_tilt_leaves(model):
    state = fly(model, VelocityCommand.hover(), 12.0, wind=Vec3(0.0, 2.0, 0.0))[-1][1]
    tilt, speed = steady_tilt_and_speed(model, 0.0, wind=2.0)
    assert state.velocity.y == pytest.approx(speed, abs=1e-6)
    assert state.attitude.tilt()[0] == pytest.approx(-tilt, abs=1e-6)


@QUADROTORS
@pytest.mark.parametrize("wanted", (0.2, 3.0, -3.0))
def test_climbs_and_descents_settle_within_their_limit(model, wanted):
    history = fly(model, VelocityCommand(0.0, 0.0, wanted, 0.0), 8.0)
    loop = model.velocity_z
    limited = min(max(wanted, -loop.limit), loop.limit)
    assert history[-1][1].velocity.z == pytest.approx(loop.p / (loop.p + model.drag) * limited, abs=1e-6)
    assert all(abs(state.velocity.z) <= loop.limit for _, state in history)


@QUADROTORS
@pytest.mark.parametrize("wanted", (0.5, 9.0, -9.0))
def test_turns_settle_at_the_command_within_their_limit_and_stay_in_place(model, wanted):
    state = fly(model, VelocityCommand(0.0, 0.0, 0.0, wanted), 6.0)[-1][1]
    limited = min(max(wanted, -model.yaw.limit), model.yaw.limit)
    assert state.rates.z == pytest.approx(limited, abs=1e-4)
    assert math.hypot(state.position.x, state.position.y) < 1e-6


@QUADROTORS
def test_steady_tilt_never_exceeds_its_limit_however_hard_it_blows(model):
    history = fly(model, VelocityCommand.hover(), 12.0, wind=Vec3(200.0, 0.0, 0.0))
    for _, state in history[-1000:]:
        assert abs(state.attitude.tilt()[1]) <= model.tilt.limit + 1e-6
    assert abs(state.attitude.tilt()[1]) == pytest.approx(model.tilt.limit, abs=1e-6)
    assert history[-1][1].position.z == pytest.approx(20.0, abs=0.05)


@QUADROTORS
def test_no_rotor_pulls_down_or_lifts_more_than_it_can(model):
    harsh = [VelocityCommand(9.0 * s, -9.0 * s, 9.0 * s, 9.0 * s) for s in (1.0, -1.0)]
    state = at_rest()
    memory = model.init(state)
    for i in range(500):
        memory, state = model.step(memory, state, harsh[i // 25 % 2], STILL_AIR, DT)
        assert all(0.0 <= thrust <= model.max_thrust / 4.0 for thrust in memory.thrusts)
    assert state.attitude.tilt()[2] > 0.0


def turned(v: Vec3, heading: Heading) -> tuple[float, float, float]:
    return (*heading.to_world(v.x, v.y), v.z)


def test_space_is_the_same_in_every_direction():
    """Turning wind and nose turns the whole flight."""
    model, yaw, command = Quadrotor(), 1.1, VelocityCommand(0.8, -0.3, 0.2, 0.4)
    heading = Heading.of(yaw)
    wind = Vec3(1.0, -0.5, 0.2)
    there = fly(model, command, 1.5, wind)[-1][1]
    turned_wind = Vec3(*turned(wind, heading))
    here = fly(model, command, 1.5, turned_wind, state=at_rest(yaw=yaw))[-1][1]
    for part in ("position", "velocity"):
        got = getattr(here, part)
        wanted = turned(getattr(there, part), heading)
        assert (got.x, got.y, got.z) == pytest.approx(wanted, abs=1e-9)
    assert here.attitude.tilt() == pytest.approx(there.attitude.tilt(), abs=1e-9)


def test_left_is_the_mirror_of_right():
    model = Quadrotor()
    left = fly(model, VelocityCommand(0.5, 0.7, 0.1, 0.9), 1.5)[-1][1]
    right = fly(model, VelocityCommand(0.5, -0.7, 0.1, -0.9), 1.5)[-1][1]
    for part in ("position", "velocity"):
        a, b = getattr(left, part), getattr(right, part)
        assert (a.x, a.y, a.z) == pytest.approx((b.x, -b.y, b.z), abs=1e-9)


def test_commands_count_from_where_the_nose_points():
    state = fly(Quadrotor(), VelocityCommand(1.0, 0.0, 0.0, 0.0), 3.0, state=at_rest(yaw=math.pi / 2))[-1][1]
    assert state.velocity.y > 0.9 and abs(state.velocity.x) < 1e-9


def unpowered(drag: float):
    model = Quadrotor(max_thrust=0.0, drag=drag)
    state = at_rest(z=100.0)
    return model, state, replace(model.init(state), thrusts=(0.0, 0.0, 0.0, 0.0))


def test_with_the_rotors_off_it_falls_towards_its_terminal_speed():
    """v[n+1] = v[n] - (g + drag v[n]) dt has the closed form below; g / drag is the terminal speed."""
    drag = 0.3
    model, state, memory = unpowered(drag)
    for n, (_, falling) in enumerate(fly(model, VelocityCommand.hover(), 2.0, state=state, memory=memory), 1):
        assert falling.velocity.z == pytest.approx(-GRAVITY / drag * (1.0 - (1.0 - drag * DT) ** n))
    assert falling.velocity.z == pytest.approx(-GRAVITY / drag * (1.0 - math.exp(-drag * 2.0)), rel=1e-3)


@pytest.mark.parametrize("dt", (0.002, 0.001))
def test_free_fall_loses_energy_only_to_the_step(dt):
    """The symplectic step takes g^2 t dt / 2 per mass from v^2 / 2 + g z, and nothing else."""
    model, state, memory = unpowered(0.0)
    end = fly(model, VelocityCommand.hover(), 2.0, state=state, memory=memory, dt=dt)[-1][1]
    energy = 0.5 * end.velocity.z**2 + GRAVITY * end.position.z
    assert energy == pytest.approx(GRAVITY * 100.0 - 0.5 * GRAVITY**2 * 2.0 * dt, rel=1e-9)


def test_it_lies_on_the_floor_and_takes_off_again():
    model = Quadrotor()
    history = fly(model, VelocityCommand(0.0, 0.0, -0.5, 0.0), 2.0, state=at_rest(z=0.3))
    assert all(state.position.z >= 0.0 for _, state in history)
    memory, state = history[-1]
    assert state.position.z == 0.0
    up = fly(model, VelocityCommand(0.0, 0.0, 0.5, 0.0), 3.0, state=state, memory=memory)
    assert up[-1][1].position.z > 0.5


def test_a_gentle_flight_converges_as_the_step_shrinks():
    """At first order: halving the step halves the error. (A rotor at its stop answers a jump otherwise.)"""
    breeze = Vec3(0.3, 0.1, 0.0)
    ends = [
        fly(Quadrotor(), VelocityCommand.hover(), 1.0, wind=breeze, dt=dt)[-1][1] for dt in (4e-3, 2e-3, 1e-3)
    ]
    x = [state.position.x for state in ends]
    assert (x[0] - x[1]) / (x[1] - x[2]) == pytest.approx(2.0, rel=0.05)
    assert x[2] == pytest.approx(x[0], rel=0.01)


def test_nan_in_the_command_does_not_pass_for_a_flight():
    state = fly(Quadrotor(), VelocityCommand(math.nan, 0.0, 0.0, 0.0), 0.01)[-1][1]
    assert math.isnan(state.velocity.x)


def ugv(speed: float = 0.0, turn_rate: float = 0.0, heading: float = 0.0) -> UgvState:
    return UgvState(0.0, 0.0, heading, speed, turn_rate, 0.0)


def drive(command: VelocityCommand, steps: int, start: UgvState, dt: float = DT, model: Pioneer = P3_DX):
    history = [start]
    for _ in range(steps):
        history.append(model.step(history[-1], command, dt))
    return history


@pytest.mark.parametrize("speed", (0.5, -0.5))
@pytest.mark.parametrize("turn", (1.0, -0.4))
def test_a_turning_ugv_keeps_exactly_to_a_circle(speed, turn):
    """Chords of length v dt under angles of w dt: a polygon on a circle of radius v dt / (2 sin(w dt / 2))."""
    dt = 0.01
    radius = speed * dt / (2.0 * math.sin(0.5 * turn * dt))
    history = drive(VelocityCommand(speed, 0.0, 0.0, turn), 400, ugv(speed, turn), dt)
    for n, state in enumerate(history):
        angle = n * turn * dt
        assert state.x == pytest.approx(radius * math.sin(angle), abs=1e-12)
        assert state.y == pytest.approx(radius * (1.0 - math.cos(angle)), abs=1e-12)
        assert state.heading == pytest.approx(angle, abs=1e-12)
    assert radius == pytest.approx(speed / turn, rel=1e-4)


@pytest.mark.parametrize("model", UGV_FLEET[:2], ids=("P3-AT", "P3-DX"))
def test_a_ugv_takes_its_time_to_speed_up_and_stays_below_its_limit(model):
    history = drive(VelocityCommand(9.0, 0.0, 0.0, 9.0), 1500, ugv(), model=model)
    for n, state in enumerate(history):
        assert state.speed == pytest.approx(min(model.acceleration * n * DT, model.max_speed))
        assert state.turn_rate == pytest.approx(min(model.turn_acceleration * n * DT, model.max_turn_rate))


rate = st.floats(-10.0, 10.0)


@given(rate, rate, st.floats(-1.2, 1.2), st.floats(-2.0, 2.0))
def test_no_command_breaks_the_limits_of_acceleration(forward, turn, speed, turn_rate):
    before = ugv(speed, turn_rate)
    after = P3_DX.step(before, VelocityCommand(forward, 0.0, 0.0, turn), DT)
    assert abs(after.speed - before.speed) <= P3_DX.acceleration * DT + 1e-12
    assert abs(after.turn_rate - before.turn_rate) <= P3_DX.turn_acceleration * DT + 1e-12
    assert abs(after.speed) <= P3_DX.max_speed and abs(after.turn_rate) <= P3_DX.max_turn_rate


@given(rate, rate)
def test_a_ugv_obeys_forward_and_turn_only(left, up):
    deaf = P3_DX.step(ugv(0.3, 0.2), VelocityCommand(0.5, left, up, 0.1), DT)
    assert deaf == P3_DX.step(ugv(0.3, 0.2), VelocityCommand(0.5, 0.0, 0.0, 0.1), DT)


def test_a_ugv_told_to_hover_brakes_to_a_stand():
    history = drive(VelocityCommand.hover(), 400, ugv(0.6, 1.0))
    braking = 0.6**2 / (2.0 * P3_DX.acceleration)
    length = sum(math.hypot(b.x - a.x, b.y - a.y) for a, b in zip(history, history[1:], strict=False))
    assert length == pytest.approx(braking, abs=0.6 * DT)
    assert (history[-1].speed, history[-1].turn_rate) == (0.0, 0.0)


@pytest.mark.parametrize("model", (P3_AT, P3_DX), ids=("P3-AT", "P3-DX"))
def test_the_disc_of_a_pioneer_just_contains_its_corners(model):
    assert model.radius == pytest.approx(math.hypot(model.length / 2.0, model.width / 2.0))


def test_a_fleet_in_one_record_of_arrays_drives_as_one_by_one():
    speeds = np.array([0.2, -0.4, 0.6])
    many = P3_DX.step(ugv(speeds, 0.1, 0.3), VelocityCommand(0.5, 0.0, 0.0, -1.0), DT)
    for i, speed in enumerate(speeds.tolist()):
        one = P3_DX.step(ugv(speed, 0.1, 0.3), VelocityCommand(0.5, 0.0, 0.0, -1.0), DT)
        assert (many.x[i], many.y[i], many.speed[i]) == pytest.approx((one.x, one.y, one.speed), rel=1e-14)
