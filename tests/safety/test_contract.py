"""The numbers a net relies on, measured again on the simulated vehicles."""

import numpy as np
import pytest

from fledge.dynamics import COMMAND_LAG, P3_AT, P3_DX, Quadrotor
from fledge.geometry import Quat, Vec3
from fledge.safety import Contract, UavStop, UgvStop
from fledge.safety.tube import Pace
from fledge.safety.turns import CALMING
from fledge.simulation import STEP, STEPS_PER_TICK
from fledge.world import UavState, UgvState, VelocityCommand

pytestmark = pytest.mark.slow

FLIGHTS = 400


def restless(longest: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(by how much it may miss, predicted way to rest, farthest way really gone), after commands that change after
    `longest` ticks [10 ms] at the latest; forwards, and negative predictions count as none."""
    rng, model, stop, zero = np.random.default_rng(seed), Quadrotor(), UavStop(), np.zeros(FLIGHTS)
    state = UavState(
        Vec3(zero, zero, zero + 50.0),
        Vec3(zero, zero, zero),
        Quat(zero + 1.0, zero, zero, zero),
        Vec3(zero, zero, zero),
        zero,
    )
    memory, followed, told, left = model.init(state), zero, np.zeros((3, FLIGHTS)), np.zeros(FLIGHTS, int)
    bias, pace = rng.uniform(-1.0, 1.0, FLIGHTS), Pace(zero, zero)
    for _ in range(150):
        fresh = np.clip(
            rng.choice([-1.0, -1.0, 0.0, 0.5, 1.0, 1.0], (3, FLIGHTS)) + bias * rng.integers(0, 2, FLIGHTS),
            -1,
            1,
        )
        told = np.where(left <= 0, fresh, told)
        left = np.where(left <= 0, rng.integers(1, longest + 1, FLIGHTS), left - 1)
        pace = pace.then(told[0], told[1], zero, 0.01 / CALMING)
        followed = followed + (told[0] - followed) * (1.0 - np.exp(-0.01 / stop.lag))
        for _ in range(STEPS_PER_TICK):
            memory, state = model.step(
                memory,
                state,
                VelocityCommand(told[0], told[1], 0.5 * told[2], zero),
                Vec3(zero, zero, zero),
                STEP,
            )
    _, pitch, _ = state.attitude.tilt()
    predicted = (
        stop.speed * state.velocity.x
        + stop.tilt * pitch
        + stop.rate * state.rates.y
        + stop.followed * followed
    )
    start, farthest = state.position.x, zero
    for _ in range(200 * STEPS_PER_TICK):
        memory, state = model.step(
            memory, state, VelocityCommand(zero, zero, zero, zero), Vec3(zero, zero, zero), STEP
        )
        farthest = np.maximum(farthest, state.position.x - start)
    return stop.miss(pace.speed, pace.turn), np.maximum(predicted, 0.0), farthest


@pytest.mark.parametrize("longest", (2, 8, 80))
def test_stops_end_where_they_are_predicted(longest):
    miss, predicted, farthest = restless(longest, seed=longest)
    assert (farthest <= predicted + miss).all()


def test_the_sizes_are_the_vehicles():
    model, stop = Quadrotor(), UavStop()
    assert (stop.radius, stop.half_height, stop.lag) == (model.radius, model.half_height, COMMAND_LAG)


@pytest.mark.parametrize("model", (P3_DX, P3_AT))
def test_a_ugv_stops_within_its_way(model):
    stop = UgvStop.of(model)
    state = UgvState(0.0, 0.0, 0.0, model.max_speed, 0.0, 0.0)
    while state.speed > 0.0:
        state = model.step(state, VelocityCommand.hover(), STEP)
    assert state.x <= model.max_speed**2 / (2.0 * stop.acceleration) + 1e-3
    assert stop.acceleration - Contract().disturbance > 0.0


def test_the_way_out_of_a_hold_is_stronger_than_the_push():
    assert Contract().age + Contract().latency == pytest.approx(0.1)
    assert UavStop().hold > Contract().disturbance / 2.5 / 1.5, "push over loop gain over hold gain"
