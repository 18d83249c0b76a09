"""Attacks in one compiled program: what it finds is so, whoever looks again. One UGV, short flights."""

from dataclasses import dataclass

import jax
import numpy as np
import pytest

from fledge.clearance import clearances
from fledge.dynamics import UGV_FLEET
from fledge.falsification.attacks import FAMILIES
from fledge.falsification.scenarios import Terms, draw_scenario
from fledge.falsification.sorties import LEFT, Trial, fly_sorties, traceable
from fledge.formation import FormationControl
from fledge.pilots import Servo
from fledge.safety import AbstractNet, NoNet, StopTube, UgvStop
from fledge.simulation import Rig
from fledge.world import VelocityCommand, Verdict

pytestmark = pytest.mark.slow

RIG = Rig(formation=FormationControl(fleet=UGV_FLEET[:1]))
TERMS = Terms(rig=RIG, attack_ticks=300, retreat_ticks=800)
FLIGHTS = 40
SCENARIOS = [
    draw_scenario(np.random.default_rng([1, i]), i % len(FAMILIES), i % 2, TERMS).scenario
    for i in range(FLIGHTS)
]
KEYS = [(1, i) for i in range(FLIGHTS)]


@dataclass(frozen=True, slots=True)
class Prison(AbstractNet):
    """Lets nobody move."""

    def init(self, arena, world):
        return ()

    def filter(self, memory, world, commands):
        zero = 0.0 * world.t
        still = VelocityCommand(zero, zero, zero, zero)
        return memory, (Verdict(still, zero + 1.0, zero, zero),) * (1 + len(world.ugvs))


def flown(net, record=False, pilot=None):
    return fly_sorties(Trial(net, TERMS, record), SCENARIOS, KEYS, pilot)


@pytest.fixture(scope="module")
def bare():
    return flown(NoNet(), record=True)


@pytest.fixture(scope="module")
def guarded():
    return flown(StopTube(ugvs=(UgvStop.of(UGV_FLEET[0]),)))


def test_without_a_net_much_is_touched_and_nobody_locked_in(bare):
    least = np.stack(bare.tally.least)
    assert (least <= 0.0).any(axis=0).mean() > 0.3
    assert bare.tally.interventions.sum() == bare.tally.alarms.sum() == 0.0
    assert ((bare.tally.first >= 0.0) == (least <= 0.0).any(axis=0)).all()
    assert not (bare.deadlock > bare.way).any()


def test_behind_the_default_net_nothing_is_touched_and_nobody_locked_in(guarded):
    assert np.stack(guarded.tally.least).min() > 0.0
    assert guarded.deadlock.sum() == 0.0 and guarded.way.sum() > 0.5 * FLIGHTS
    assert (guarded.tally.first == -1.0).all()


def test_it_steps_in_and_some_of_its_alarms_were_false_and_some_not(guarded):
    tally = guarded.tally
    assert 0.0 < tally.interventions.sum() < 2 * TERMS.ticks * FLIGHTS
    assert 0.0 < tally.false_alarms.sum() < tally.alarms.sum()


def test_a_prison_is_found_out():
    locked = flown(Prison())
    assert locked.way.sum() > 0.5 * FLIGHTS
    np.testing.assert_array_equal(locked.deadlock, locked.way)


def test_the_record_is_what_was_judged(bare):
    track = bare.track
    assert track.world.t.shape == (FLIGHTS, TERMS.ticks)
    np.testing.assert_allclose(track.world.t[0], np.arange(TERMS.ticks) * 0.01, atol=1e-4)
    for i in range(0, FLIGHTS, 7):
        world = jax.tree.map(lambda leaf, i=i: leaf[i], track.world)
        near = clearances(SCENARIOS[i].arena, world, RIG.uav, RIG.formation.fleet)
        for nearest, least in zip(near, bare.tally.least, strict=True):
            # The last world is no row of its own.
            assert nearest.gap.min() == pytest.approx(least[i], abs=0.02)
        start = SCENARIOS[i].world.uav.position
        assert (world.uav.position.x[0], world.uav.position.z[0]) == pytest.approx(
            (start.x, start.z), abs=1e-5
        )


def test_only_the_vehicle_in_focus_moves_in_the_end_and_it_leaves(bare):
    for i in np.flatnonzero((bare.way > 0.0) & (bare.deadlock == 0.0))[:10]:
        told = jax.tree.map(lambda leaf, i=i: leaf[i, TERMS.attack_ticks :], bare.track.told)
        moving = [
            np.abs(c.forward).max() + np.abs(c.left).max() + np.abs(c.up).max()
            for c in (told.uav, *told.ugvs)
        ]
        focus = int(SCENARIOS[i].focus)
        assert moving[focus] > 0.0 and moving[1 - focus] == 0.0
        ways = jax.tree.map(lambda leaf, i=i: leaf[i, TERMS.attack_ticks :], bare.track.world)
        body = ways.ugvs[0] if focus else ways.uav.position
        assert np.hypot(body.x - body.x[0], body.y - body.y[0]).max() > 0.9 * LEFT or not focus


def test_the_same_flights_are_the_same_flights(guarded):
    again = flown(StopTube(ugvs=(UgvStop.of(UGV_FLEET[0]),)))
    jax.tree.map(np.testing.assert_array_equal, guarded, again)


def test_a_pilot_may_fly_the_uav(bare):
    piloted = flown(NoNet(), record=True, pilot=Servo())
    up = piloted.track.told.uav.up[:, : TERMS.attack_ticks]
    held = up.reshape(FLIGHTS, -1, 5)
    assert (held == held[:, :, :1]).all(), "it decides at 20 Hz"
    (
        np.testing.assert_array_equal(
            piloted.track.told.ugvs[0].turn[:, 0], bare.track.told.ugvs[0].turn[:, 0]
        ),
        "the attackers still drive the UGVs",
    )


@dataclass(frozen=True, slots=True)
class Picky(Prison):
    """Decides with `if`."""

    def filter(self, memory, world, commands):
        return super().filter(memory, world, commands) if world.t > 0.0 else (memory, ())


def test_a_net_that_cannot_be_compiled_is_found_out_before():
    assert traceable(NoNet(), SCENARIOS[0]) and traceable(Prison(), SCENARIOS[0])
    assert not traceable(Picky(), SCENARIOS[0])
