"""Vehicles come to rest where that was said, within what it may miss: a hundred restless flights side by side."""

from dataclasses import replace

import numpy as np
import pytest
from aloft import HALL, HOVER, RIG, SPREAD, world

from fledge.engines import PLAIN
from fledge.geometry import Box, Quat, Vec3
from fledge.observation import Action
from fledge.safety import NETS, Barrier, Conformal, Contract, Overruns, StopTube, UavStop
from fledge.safety.tube import uav_tube
from fledge.simulation import STEP, STEPS_PER_TICK, TICK, fly_tick
from fledge.world import Arena, Commands, UavState, UgvState, VelocityCommand, WorldState

PREDICTING = (StopTube, Barrier, Conformal)
EMPTY = Arena(Box(-1e3, 1e3, -1e3, 1e3), 1e3)
FLIGHTS, APPROACH, STOP = 100, 120, 200
"""The latter in ticks."""
ZERO = np.zeros(FLIGHTS)
CALM = Vec3(ZERO, ZERO, ZERO)
STILL = VelocityCommand(ZERO, ZERO, ZERO, ZERO)


def scattered(rng) -> WorldState:
    """Everybody at rest, their noses anywhere, far from everything."""
    noses = rng.uniform(-np.pi, np.pi, (4, FLIGHTS))
    uav = UavState(Vec3(ZERO, ZERO, ZERO + 50.0), CALM, Quat.from_yaw(noses[0]), CALM, ZERO)
    ugvs = (UgvState(ZERO + 99.0 * i, ZERO, noses[i], ZERO, ZERO, ZERO) for i in (1, 2, 3))
    return WorldState(ZERO, uav, tuple(ugvs))


def restless(rng):
    """Commands that jump every 0.2 s or so, up to three quarters of what is possible: UGVs also in reverse."""
    said = np.zeros((10, FLIGHTS))
    while True:
        said = np.where(rng.random(FLIGHTS) < 0.05, rng.uniform(-0.75, 0.75, said.shape), said)
        ugvs = zip(RIG.formation.fleet, said[4:7], said[7:], strict=True)
        yield Commands(
            RIG.sticks.command(Action(*said[:4])),
            tuple(VelocityCommand(v * m.max_speed, ZERO, ZERO, w * m.max_turn_rate) for m, v, w in ugvs),
        )


def stopped(net, late):
    """(what the net says as the stop begins, where everybody is then, where they are at rest).

    As the contract allows, the net sees everything `late` ticks ago, and commands act as much later.
    """
    rng = np.random.default_rng(3)
    worlds, sent, policy = [scattered(rng)], [Commands(STILL, (STILL,) * 3)] * (late + 1), restless(rng)
    memory, uav = net.init(EMPTY, worlds[0]), RIG.uav.init(worlds[0].uav)
    halts = ()
    for tick in range(APPROACH + STOP):
        seen = replace(worlds[max(tick - late, 0)], t=ZERO + tick * TICK)
        if tick < APPROACH:
            memory, verdicts = net.filter(memory, seen, next(policy))
            sent.append(Commands(verdicts[0].command, tuple(verdict.command for verdict in verdicts[1:])))
        else:
            halts = halts or net.halts(memory, seen)
            sent.append(sent[0])
        uav, now = fly_tick(RIG, uav, worlds[-1], sent[-1 - late], CALM, ZERO + (tick + 1) * TICK, PLAIN)
        worlds.append(now)
    return halts, places(worlds[APPROACH]), places(worlds[-1])


def places(world):
    return [(one.x, one.y) for one in (world.uav.position, *world.ugvs)]


@pytest.mark.slow
@pytest.mark.parametrize("late", (0, 5), ids=("at once", "late"))
@pytest.mark.parametrize("net", (StopTube(), Barrier()), ids=lambda net: type(net).__name__)
def test_a_stop_that_begins_now_ends_there(net, late):
    halts, begin, end = stopped(net, late)
    for halt, (x0, y0), (x, y) in zip(halts, begin, end, strict=True):
        went, off = np.hypot(x - x0, y - y0), np.hypot(x - halt.x, y - halt.y)
        assert (off <= halt.miss).all()
        far = went > 0.12
        assert far.any() and off[far].mean() < 0.5 * went[far].mean(), "a better guess than where it was"


def overrun(net, late, seed, share, flights=1600):
    """How far beyond the net's bound a UAV that turned got [m], in any direction; full stick is a share."""
    rng, zero = np.random.default_rng(seed), np.zeros(flights)
    calm, still = Vec3(zero, zero, zero), VelocityCommand(zero, zero, zero, zero)
    nose = Quat.from_yaw(rng.uniform(-np.pi, np.pi, flights))
    states, sent = [UavState(Vec3(zero, zero, zero + 50.0), calm, nose, calm, zero)], [still] * (late + 1)
    net, said = replace(net, ugvs=()), np.zeros((4, flights))
    memory, inside = net.init(EMPTY, WorldState(zero, states[0], ())), RIG.uav.init(states[0])
    for tick in range(APPROACH + STOP):
        t, seen = zero + tick * TICK, states[max(tick - late, 0)]
        if tick == APPROACH:
            tube = uav_tube(net.contract, net.uav, seen, memory.uav.sent, memory.uav.pace, t - seen.stamp)
            begin = seen.position
        jumps = rng.random(flights) < 0.05
        said = np.where(jumps, np.clip(rng.uniform(-1.5, 1.5, said.shape), -1.0, 1.0), said)
        command = still
        if tick < APPROACH:
            wanted = Commands(
                RIG.sticks.command(Action(share * said[0], share * said[1], said[2], said[3])), ()
            )
            memory, (verdict,) = net.filter(memory, WorldState(t, seen, ()), wanted)
            command = verdict.command
        sent.append(command)
        state = states[-1]
        for _ in range(STEPS_PER_TICK):
            inside, state = RIG.uav.step(inside, state, sent[-1 - late], calm, STEP)
        states.append(replace(state, stamp=t + TICK))
    most = -np.inf
    for x, y in ((np.cos(a), np.sin(a)) for a in np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)):
        places = (one.position - begin for one in states[APPROACH:])
        far = np.max([place.x * x + place.y * y for place in places], axis=0)
        most = max(most, float((far - tube.advance(x, y) - tube.error).max()))
    return most


@pytest.mark.slow
@pytest.mark.parametrize("share", (0.25, 0.5, 1.0))
def test_a_uav_that_turns_stops_within_its_bound(share):
    """Full stick on all axes, heard as late as may be; none of the bound is left for errors of measurement."""
    exact = Contract(position_error=0.0, velocity_error=0.0, angle_error=0.0, rate_error=0.0)
    sharp = UavStop(hold=0.0)
    straight, still = replace(sharp, error_turn=0.0), replace(sharp, error_speed=0.0)
    bound, *less = (
        max(overrun(StopTube(exact, stop), 5, seed, share) for seed in (23, 33))
        for stop in (sharp, straight, still)
    )
    assert bound < 0.0 < min(less), "they need what turning adds, and what speed does"


@pytest.mark.parametrize(
    "net", [net for net in NETS if type(net) in PREDICTING], ids=lambda net: type(net).__name__
)
def test_what_stands_comes_to_rest_where_it_stands(net):
    start = world()
    halts = net.halts(net.init(HALL, start), start)
    assert [(halt.x, halt.y) for halt in halts] == places(start)
    assert all(0.0 < halt.miss < 0.2 for halt in halts)


def test_one_that_reverses_comes_to_rest_behind_as_far_as_another_ahead():
    def halt(speed):
        start = world()
        moving = replace(start, ugvs=(replace(start.ugvs[0], speed=speed), *start.ugvs[1:]))
        return StopTube().halts(StopTube().init(HALL, start), moving)[1]

    ahead, behind = halt(0.6), halt(-0.6)
    x, y, _ = SPREAD[0]
    assert ahead.x - x == pytest.approx(x - behind.x) and ahead.x > x + 0.6**2 / 2.0
    assert ahead.y == behind.y == y and ahead.miss == pytest.approx(behind.miss)


def test_a_margin_that_was_learnt_makes_the_miss_larger_by_as_much():
    start = world(velocity=Vec3(0.5, 0.2, 0.0))
    proven, learnt = StopTube(), Conformal(overruns=Overruns(0.05, 0.01, 999))
    (uav, *ugvs), (other, *others) = (net.halts(net.init(HALL, start), start) for net in (proven, learnt))
    assert (uav.x, uav.y, ugvs) == (other.x, other.y, others)
    assert 0.0 < other.miss - uav.miss <= 0.05


def test_what_is_on_its_way_to_a_vehicle_still_moves_it():
    """The net knows what it has sent; nothing of it shows in the state yet."""
    net, start = StopTube(), world()
    told = Commands(VelocityCommand(0.8, 0.0, 0.0, 0.0), (HOVER,) * 3)
    memory, _ = net.filter(net.init(HALL, start), start, told)
    assert net.halts(memory, start)[0].x > start.uav.position.x


@pytest.mark.parametrize(
    "net", [net for net in NETS if type(net) not in PREDICTING], ids=lambda net: type(net).__name__
)
def test_who_predicts_no_stop_says_none(net):
    start = world()
    assert net.halts(net.init(HALL, start), start) == ()
