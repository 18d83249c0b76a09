"""The velocity loop of the AR.Drone: its step response, on airframes of several kinds."""

from dataclasses import dataclass
from math import exp, inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from standin import TICK, Airframe

from fledge.geometry import Quat, Vec3
from fledge.lab.control.estimator import Estimator, Pose
from fledge.lab.control.tilt import Tilt
from fledge.lab.wire.ardrone import Flag, Pcmd
from fledge.safety import Contract, UavStop
from fledge.world import UavState, VelocityCommand

pytestmark = pytest.mark.slow

TILT = Tilt()
E = Estimator()
STEP = 0.5
HOVER = VelocityCommand.hover()
STILL = Vec3(0.0, 0.0, 0.0)
AIRFRAMES = {
    "as designed": {},
    "sluggish": {"bandwidth": 7.0, "damping": 0.7},
    "brisk and draggy": {"bandwidth": 14.0, "damping": 0.6, "drag": 0.5, "delay": 2},
    "slippery": {"damping": 1.0, "drag": 0.2},
    "late": {"delay": 6},
}
"""What `Airframe` is made of; delays in ticks, before the 10 ms of the cameras and half the span of the estimator."""


@dataclass
class Flown:
    """Speed, way and tilt along the nose, tick by tick."""

    speed: np.ndarray
    way: np.ndarray
    share: np.ndarray
    told: list[Pcmd]

    @property
    def t(self) -> np.ndarray:
        return TICK * (1 + np.arange(len(self.speed)))

    def reaches(self, speed: float) -> float:
        return float(self.t[np.argmax(self.speed >= speed)]) if self.speed.max() >= speed else inf


def fly(
    command, seconds=6.0, push=STILL, yaw=0.0, seen=lambda t: True, noise=0.0, tilt=TILT, speed=0.0, **kind
):
    """An airframe under the loop, through the estimator; commands are functions of time, or stay."""
    air, rng = Airframe(yaw=yaw, **kind), np.random.default_rng(0)
    nose = air.heading
    air.velocity = Vec3(*nose.to_world(speed, 0.0), 0.0)
    poses, memory = E.init(1), tilt.init()
    late, rows = [], []
    for i in range(-20, round(seconds / TICK)):
        t = i * TICK
        late.append((t, air.position, air.attitude))
        if len(late) > 1 and seen(t):
            stamp, p, q = late.pop(0)
            off = Vec3(*rng.uniform(-noise, noise, 3).tolist())
            poses = E.see(poses, 0, Pose(stamp, p + off, q.integrate(off, 1.0)))
        late = late[-1:]
        uav = poses[0].state
        if i < 0 or not isinstance(uav, UavState):
            air.position, air.velocity = air.position + air.velocity * TICK, air.velocity
            continue
        now = command(t) if callable(command) else command
        memory, told = tilt.step(memory, uav, now, t)
        air.fly(told, push(t) if callable(push) else push)
        vf, _ = nose.from_world(air.velocity.x, air.velocity.y)
        rows.append((vf, nose.from_world(air.position.x, air.position.y)[0], -told.pitch, told))
    speeds, ways, shares, told = zip(*rows, strict=True)
    return Flown(np.array(speeds), np.array(ways) - ways[0], np.array(shares), list(told))


def forward(speed: float) -> VelocityCommand:
    return VelocityCommand(speed, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("kind", AIRFRAMES)
def test_a_step_is_followed_soon_without_overshoot_and_to_the_end(kind):
    flown = fly(forward(STEP), **AIRFRAMES[kind])
    assert flown.reaches(0.5 * STEP) < 0.5
    assert flown.reaches(0.85 * STEP) < 0.9
    assert flown.speed.max() < 1.1 * STEP
    assert np.abs(flown.speed[-100:] - STEP).max() < 0.02 * STEP


def test_it_answers_much_as_the_vehicle_that_policies_were_trained_on():
    flown = fly(forward(STEP))
    trained = STEP * np.array([1.0 - exp(-t / 0.4) for t in flown.t])
    assert np.abs(flown.speed - trained).max() < 0.25 * STEP


@pytest.mark.parametrize("kind", AIRFRAMES)
@pytest.mark.parametrize("speed", [0.3, 0.6, 1.0])
def test_it_brakes_and_does_not_come_back(kind, speed):
    flown = fly(lambda t: forward(speed if t < 4.0 else 0.0), seconds=7.0, **AIRFRAMES[kind])
    stop = flown.way[400:] - flown.way[400]
    assert stop.max() < 0.48 * speed
    assert flown.speed[400:].min() > -0.16 * speed
    assert abs(flown.speed[-1]) < 0.035


def test_on_the_airframe_of_its_design_a_stop_is_one_that_the_net_foresees():
    """It goes on for the contract's latency at most, then its own way, and misses that by no more than it may."""
    stop, contract = UavStop(), Contract()
    for speed in (0.25, 0.5, 0.75, 1.0):
        flown = fly(lambda t, v=speed: forward(v if t < 4.0 else 0.0), seconds=7.0)
        way = (flown.way[400:] - flown.way[400]).max()
        at_once = (stop.speed + stop.followed) * speed
        late, miss = at_once + contract.latency * speed, stop.miss(speed, 0.0)
        assert at_once - miss < way < late + miss


@pytest.mark.parametrize("kind", AIRFRAMES)
def test_a_push_within_the_contract_leaves_nothing_behind(kind):
    push = Vec3(Contract().disturbance, 0.0, 0.0)
    flown = fly(HOVER, seconds=8.0, push=push, **AIRFRAMES[kind])
    assert flown.speed.max() < 0.13
    assert np.abs(flown.speed[-200:]).max() < 0.015


def test_a_push_it_cannot_hold_is_not_held_against_it_later():
    """It is blown away for three seconds with its tilt at the stop; then the air is still."""
    flown = fly(HOVER, seconds=9.0, push=lambda t: Vec3(2.5 if t < 3.0 else 0.0, 0.0, 0.0))
    assert flown.share[250] == -1.0
    after = flown.speed[300:]
    assert after.min() > -0.35
    assert np.abs(after[300:]).max() < 0.05


def test_noise_of_the_cameras_hardly_moves_the_sticks():
    flown = fly(HOVER, noise=0.0005)
    assert np.std(flown.share[100:]) < 0.15
    assert np.std(flown.speed[100:]) < 0.01


@pytest.mark.parametrize("yaw", [0.0, 1.0, -2.5])
def test_forward_is_along_the_nose_wherever_it_points(yaw):
    assert fly(forward(STEP), yaw=yaw).speed[-1] == pytest.approx(STEP, rel=0.02)


def state(stamp=0.01, velocity=STILL, attitude=Quat(1.0, 0.0, 0.0, 0.0)) -> UavState:
    return UavState(Vec3(0.0, 0.0, 2.0), velocity, attitude, STILL, stamp)


@pytest.mark.parametrize(
    ("command", "share", "sign"),
    [
        (VelocityCommand(0.3, 0.0, 0.0, 0.0), "pitch", -1.0),
        (VelocityCommand(0.0, 0.3, 0.0, 0.0), "roll", -1.0),
        (VelocityCommand(0.0, 0.0, 0.3, 0.0), "gaz", 0.3 / 0.7),
        (VelocityCommand(0.0, 0.0, 0.0, 0.35), "yaw", -0.2),
    ],
)
def test_the_wire_s_signs_are_its_own_and_each_axis_is_alone(command, share, sign):
    _, told = TILT.step(TILT.init(), state(), command, 0.02)
    assert told.flags == Flag.PROGRESSIVE
    for name in ("roll", "pitch", "gaz", "yaw"):
        got = getattr(told, name)
        assert got * sign > 0.0 if name == share else got == 0.0
    if share in ("gaz", "yaw"):
        assert getattr(told, share) == pytest.approx(sign)


BIG = st.floats(-1e6, 1e6)


@given(BIG, BIG, BIG, BIG, st.tuples(BIG, BIG, BIG), st.tuples(*[st.floats(-1.0, 1.0)] * 4), st.booleans())
def test_whatever_comes_in_what_goes_out_has_a_place_on_the_wire(a, b, c, d, v, q, fresh):
    memory = TILT.init()
    for i in range(3):
        uav = state(TICK * i if fresh else 0.0, Vec3(*v), Quat(*q))
        memory, told = TILT.step(memory, uav, VelocityCommand(a, b, c, d), TICK * i)
        assert all(abs(share) <= 1.0 for share in (told.roll, told.pitch, told.gaz, told.yaw))


def test_without_poses_it_goes_on_for_a_while_as_if_all_went_well():
    seen = fly(lambda t: forward(STEP if t < 3.0 else 0.0), seconds=4.0)
    blind = fly(lambda t: forward(STEP if t < 3.0 else 0.0), seconds=4.0, seen=lambda t: not 3.1 <= t < 3.4)
    assert np.abs(blind.speed - seen.speed).max() < 0.1


def test_blind_for_longer_a_hover_is_the_drone_s_own():
    memory, kinds = TILT.init(), []
    for i in range(21):
        memory, told = TILT.step(memory, state(1.0), HOVER, 0.995 + i * TICK)
        kinds.append(told == Pcmd.hover())
    assert kinds == [False] * 11 + [True] * 10
    _, told = TILT.step(memory, state(1.0), VelocityCommand(0.0, 0.0, -0.3, 0.0), 1.21)
    assert told.flags == Flag.PROGRESSIVE and told.gaz < 0.0
    _, told = TILT.step(memory, state(1.2), HOVER, 1.21)
    assert told.flags == Flag.PROGRESSIVE


def test_poses_that_come_late_are_not_flown_by():
    """New ones every tick, but old: closed over them the loop would swing."""
    memory, old = TILT.init(), []
    for i in range(100):
        t = i * TICK
        memory, told = TILT.step(memory, state(t - 0.3, Vec3(0.5, 0.0, 0.0)), HOVER, t)
        old.append(told)
    assert set(old) == {Pcmd.hover()}
    # Told to move it does so by what it expects of itself.
    memory, told = TILT.step(memory, state(0.7, Vec3(5.0, 0.0, 0.0)), forward(0.1), 1.0)
    assert told.pitch < 0.0
