"""How far a UAV overruns the stop that the safety nets predict: stops flown in the simulator, in still air.

An episode is one restless flight: commands jump at the episode's own pace, in height and yaw, too, and now and then the
UAV is told to hover. Every stop is compared with what `safety.tube` predicts of a vehicle that hears at once and whose
state is known: delays, errors of measurement and wind have terms of their own in the contract.

All episodes fly side by side, as one scene made of arrays.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from fledge.dynamics import Quadrotor, UavMemory
from fledge.geometry import Quat, Vec3
from fledge.observation import StickScale
from fledge.safety import Contract, UavStop
from fledge.safety.tube import Pace, Sent, filter_share, uav_miss, uav_tube
from fledge.safety.turns import CALMING
from fledge.scalars import Scalar, clip, maximum, minimum, sqrt
from fledge.simulation import STEP, STEPS_PER_TICK, TICK
from fledge.world import UavState, VelocityCommand

APPROACH_TICKS = 200
STOP_TICKS = 200
"""2 s each; a stop takes less."""
PACES = (0.01, 0.8)
"""[s] for which a command is held on average; an episode's own is drawn between them, evenly in its logarithm."""
GENTLEST = 0.1
"""Least share of full stick to which an episode may be limited."""
HIGH = 100.0
"""[m] no floor is near."""
TINY = 1e-12


class Flying(NamedTuple):
    """All that changes during an episode."""

    uav: UavState
    memory: UavMemory
    sent: tuple[Sent, Sent, Sent]
    pace: Pace


def fly_stops(
    model: Quadrotor,
    key: Sequence[int],
    episodes: int,
    stops: int = 5,
    stop: UavStop = UavStop(),
    contract: Contract = Contract(),
) -> np.ndarray:
    """How far each stop goes beyond the bound of `stop` [m]; shape (episodes, stops), negative within it."""
    rng = np.random.default_rng(list(key))
    commands = _restless(rng, episodes)
    zero = np.zeros(episodes)
    hover = VelocityCommand(zero, zero, zero, zero)
    flying = _begin(model, contract, rng.uniform(-np.pi, np.pi, episodes))
    share = filter_share(contract, stop)
    overruns = []
    for _ in range(stops):
        for _ in range(APPROACH_TICKS):
            flying = _tick(model, flying, next(commands), share)
        begin = flying.uav
        ahead = uav_tube(contract, stop, begin, flying.sent, flying.pace, zero).rests[0]
        miss = uav_miss(stop, begin, flying.pace)
        worst = zero - np.inf
        for _ in range(STOP_TICKS):
            flying = _tick(model, flying, hover, share)
            worst = maximum(worst, overrun(miss, stop.error_up, ahead, flying.uav.position - begin.position))
        overruns.append(worst)
    return np.stack(overruns, axis=1)


def overrun(miss: Scalar, miss_up: float, ahead: Vec3, moved: Vec3) -> np.ndarray:
    """By how much these bounds are too small [m] for a UAV that was to stop `ahead` of where it was and has `moved`."""
    share = (moved.x * ahead.x + moved.y * ahead.y) / (ahead.x * ahead.x + ahead.y * ahead.y + TINY)
    beside = moved - ahead * clip(share, 0.0, 1.0)
    across = sqrt(beside.x * beside.x + beside.y * beside.y)
    up, down = moved.z - maximum(ahead.z, 0.0), minimum(ahead.z, 0.0) - moved.z
    return maximum(across - miss, maximum(up, down) - miss_up)


def _restless(rng: np.random.Generator, episodes: int) -> Iterator[VelocityCommand]:
    """Commands that jump, a third of them to full stick or nearly, each episode at its own pace and strength."""
    full = StickScale()
    quick, slow = np.log(PACES)
    pace = np.exp(rng.uniform(quick, slow, episodes))
    strength = rng.uniform(GENTLEST, 1.0, episodes)
    stick = np.zeros((4, episodes))
    while True:
        jumps = rng.random(episodes) < TICK / pace
        stick = np.where(jumps, clip(rng.uniform(-1.5, 1.5, stick.shape), -1.0, 1.0) * strength, stick)
        forward, left, up, turn = stick
        yield VelocityCommand(
            forward * full.horizontal, left * full.horizontal, up * full.vertical, turn * full.turn
        )


def _begin(model: Quadrotor, contract: Contract, yaw: np.ndarray) -> Flying:
    """Hovering."""
    zero = 0.0 * yaw
    nothing = Vec3(zero, zero, zero)
    uav = UavState(Vec3(zero, zero, zero + HIGH), nothing, Quat.from_yaw(yaw), nothing, zero)
    silence = Sent.nothing(contract, zero)
    return Flying(uav, model.init(uav), (silence, silence, silence), Pace(zero, zero))


def _tick(model: Quadrotor, flying: Flying, command: VelocityCommand, share: float) -> Flying:
    """One tick later; `share` as in `Sent.then`."""
    uav, memory, sent, pace = flying
    x, y = uav.attitude.heading().to_world(command.forward, command.left)
    a, b, c = (axis.then(v, share) for axis, v in zip(sent, (x, y, command.up), strict=True))
    pace = pace.then(x, y, command.turn, TICK / CALMING)
    still = Vec3(0.0, 0.0, 0.0)
    for _ in range(STEPS_PER_TICK):
        memory, uav = model.step(memory, uav, command, still, STEP)
    return Flying(uav, memory, (a, b, c), pace)
