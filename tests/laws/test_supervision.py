"""Layer two on two backends, through faults of every kind: plain floats and JAX decide the same, tick by tick."""

import jax
import numpy as np
import pytest

from fledge.geometry import Quat, Vec3
from fledge.pytrees import stack
from fledge.safety import NoNet
from fledge.supervision.inputs import Inputs, Operator
from fledge.supervision.modes import Mode
from fledge.supervision.supervisor import Supervisor
from fledge.world import Arena, Commands, Reason, UavState, UgvState, VelocityCommand, WorldState

pytestmark = pytest.mark.slow

SUPERVISOR = Supervisor(NoNet())
FLIGHTS, TICKS, UGVS = 12, 700, 2
FLAGS = ("switch", "hand_back", "stop", "dead_man", "land", "terminate")
OFTEN = {
    "switch": 0.003,
    "hand_back": 0.3,
    "stop": 0.003,
    "dead_man": 0.05,
    "land": 0.0005,
    "terminate": 0.0001,
}
"""Share of ticks in which a flag is set."""
FAULT = 0.03
"""Share of ticks in which something that comes in is wrong, and of ticks after which what is wrong goes on."""


def commands(rng: np.random.Generator) -> VelocityCommand:
    return VelocityCommand(*rng.uniform(-0.5, 0.5, 4).tolist())


def operator(rng: np.random.Generator, t: float) -> Operator:
    flags = {name: float(rng.uniform() < OFTEN[name]) for name in FLAGS}
    stick = float(rng.choice([0.0, 0.2, 0.5], p=[0.9, 0.05, 0.05]))
    return Operator(commands(rng), stick, arm=float(t > 0.05 and rng.uniform() > 0.001), **flags)


def wrong(rng: np.random.Generator, given: Inputs) -> Inputs:
    """The same with one of its numbers spoilt."""
    leaves, shape = jax.tree.flatten(given)
    i = rng.integers(len(leaves))
    leaves[i] = float(
        rng.choice([np.nan, np.inf, leaves[i] + 0.5, leaves[i] - 0.5, -leaves[i], 1e3 * leaves[i]])
    )
    return jax.tree.unflatten(shape, leaves)


def flight(seed: int) -> list[Inputs]:
    """What comes in during a flight in which much goes wrong."""
    rng, told, still = np.random.default_rng(seed), [], Vec3(0.0, 0.0, 0.0)
    pose_age = link_age = 0.0
    for i in range(TICKS):
        t = 0.01 * i
        pose_age = pose_age + 0.01 if rng.uniform() < 0.9 * (pose_age > 0.0) + 0.02 else 0.0
        link_age = link_age + 0.01 if rng.uniform() < 0.98 * (link_age > 0.0) + 0.01 else 0.0
        seen = t - pose_age
        uav = UavState(
            Vec3(float(np.sin(seen)), 0.0, 2.0),
            Vec3(float(np.cos(seen)), 0.0, 0.0),
            Quat(1.0, 0.0, 0.0, 0.0),
            still,
            seen,
        )
        ugvs = tuple(UgvState(float(k) + 0.3 * seen, 0.0, 0.0, 0.3, 0.0, seen) for k in range(UGVS))
        given = Inputs(
            WorldState(t, uav, ugvs),
            Commands(commands(rng), tuple(commands(rng) for _ in ugvs)),
            t - float(rng.uniform(0.0, 0.05)),
            tuple(operator(rng, t) for _ in range(1 + UGVS)),
            t - link_age,
            (1.0,) * (1 + UGVS),
            float(rng.uniform() > 0.1),
        )
        told.append(wrong(rng, given) if i and rng.uniform() < FAULT else given)
    return told


@pytest.fixture(scope="module")
def flights():
    """(decisions in plain Python, decisions by JAX in double precision); leaves of shape (flights, ticks)."""
    hover = VelocityCommand.hover()
    still = Vec3(0.0, 0.0, 0.0)
    uav = UavState(Vec3(0.0, 0.0, 2.0), still, Quat(1.0, 0.0, 0.0, 0.0), still, 0.0)
    begin = WorldState(0.0, uav, tuple(UgvState(float(k), 0.0, 0.0, 0.0, 0.0, 0.0) for k in range(UGVS)))
    start = SUPERVISOR.init(Arena.square(), begin)
    # Stacking makes pytrees of the records.
    stack([(start, Inputs.unattended(begin, Commands(hover, (hover,) * UGVS)))])
    told = [flight(seed) for seed in range(FLIGHTS)]
    plain = []
    for inputs in told:
        memory, decisions = start, []
        for given in inputs:
            memory, decision = SUPERVISOR.step(memory, given)
            decisions.append(decision)
        plain.append(jax.tree.map(lambda *leaves: np.array(leaves, dtype=float), *decisions))
    with jax.enable_x64(True):
        fly = jax.jit(jax.vmap(lambda inputs: jax.lax.scan(SUPERVISOR.step, start, inputs)[1]))
        jaxed = jax.tree.map(np.asarray, fly(stack([stack(inputs) for inputs in told])))
    return jax.tree.map(lambda *leaves: np.array(leaves), *plain), jaxed


def test_plain_floats_and_jax_decide_the_same(flights):
    plain, jaxed = flights
    for (path, a), b in zip(jax.tree_util.tree_leaves_with_path(plain), jax.tree.leaves(jaxed), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-12, err_msg=jax.tree_util.keystr(path))


def test_every_mode_and_most_reasons_came_up(flights):
    """Else the comparison says little."""
    plain, _ = flights
    assert set(np.unique([decision.mode for decision in plain])) == set(map(float, Mode))
    reasons = {Reason(int(r)) for decision in plain for r in np.unique(decision.alarm.reason)}
    assert len(reasons) >= 12


def test_nothing_that_is_no_number_is_ever_sent(flights):
    plain, _ = flights
    for decision in plain:
        for leaf in jax.tree.leaves(decision.verdict.command):
            assert np.isfinite(leaf).all()
        held = decision.verdict.intervened > 0.0
        assert (decision.verdict.reason[held] > 0.0).all() and (decision.verdict.reason[~held] == 0.0).all()
