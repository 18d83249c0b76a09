"""The vehicles under attack: what they make of commands, what pushes them, when a pilot decides."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.falsification.melee import TURN_LIMIT, Scene, begin, draw_chance, drive, move, obeyed
from fledge.falsification.scenarios import Terms, draw_scenario
from fledge.observation import Action
from fledge.pilots import AbstractPilot
from fledge.pytrees import register
from fledge.world import Commands, VelocityCommand

pytestmark = pytest.mark.slow

TERMS = Terms()
DRAWN = draw_scenario(np.random.default_rng(2), 2, 0, TERMS).scenario
HOVER = VelocityCommand.hover()
anything = st.floats(width=32) | st.sampled_from((float("nan"), float("inf"), -1e30, 1e30))


class Counter(AbstractPilot):
    """Climbs a little faster with every decision."""

    name = "counter"

    def init(self):
        return 0.0

    def act(self, memory, observation, noise):
        memory = memory + 0.1
        return memory, Action(0.0 * memory, 0.0 * memory, memory, 0.0 * memory)


def scene(pilot=None, **trouble) -> Scene:
    drawn = DRAWN._replace(trouble=DRAWN.trouble._replace(**trouble))
    register((drawn, pilot))
    return Scene.of(TERMS, jax.tree.map(jnp.asarray, drawn), pilot)


@given(numbers=st.tuples(anything, anything, anything, anything))
def test_a_vehicle_takes_garbage_for_its_limit_and_no_number_for_nothing(numbers):
    command = VelocityCommand(*numbers)
    fleet = TERMS.rig.formation.fleet
    done = obeyed(TERMS.rig, Commands(command, (command,) * 3))
    for told, did, limit in zip(
        numbers,
        (done.uav.forward, done.uav.left, done.uav.up, done.uav.turn),
        (1.0, 1.0, 1.0, TURN_LIMIT),
        strict=True,
    ):
        assert did == (0.0 if np.isnan(told) else np.clip(told, -limit, limit))
    assert all(abs(c.forward) <= model.max_speed for c, model in zip(done.ugvs, fleet, strict=True))


def test_a_push_carries_a_hovering_uav_along_and_none_leaves_it_where_it_is():
    calm, blown = scene(share=0.0), scene(share=1.0, malice=0.0)
    still = Commands(HOVER, (HOVER,) * 3)

    def fly(around, ticks=30):
        bodies = begin(around)
        register(bodies)
        step = jax.jit(partial(move, around))
        for tick in range(ticks):
            bodies = step(bodies, still, float(tick))
        return bodies.world.uav.velocity

    register(still)
    assert abs(fly(calm).x) < 1e-3
    blow = fly(blown)
    way = DRAWN.trouble.way
    assert blow.x * way.x + blow.y * way.y + blow.z * way.z > 0.02


def test_chance_is_the_keys_and_within_bounds():
    key = jax.random.key(3)
    once, again = draw_chance(key, 4), draw_chance(key, 4)
    assert len(once) == 4
    for a, b in zip(once, again, strict=True):
        assert a == b
        assert abs(a.uniform.x) <= 1.0 and 0.0 <= a.odds <= 1.0
    assert once[0] != once[1]


def test_a_pilot_decides_every_fifth_tick_and_flies_the_uav_alone():
    around = scene(Counter())
    bodies = begin(around)
    register(bodies)
    chance = draw_chance(jax.random.key(0), 4)
    ticked, ups = jax.jit(partial(drive, around)), []
    for tick in range(11):
        mind, told = ticked(bodies, chance, float(tick))
        bodies = bodies._replace(mind=mind)
        ups.append(float(told.uav.up))
    assert ups == pytest.approx([0.05] * 5 + [0.1] * 5 + [0.15])
    _, attacked = around.attacker.act(
        bodies.mind.moods, DRAWN.nature, DRAWN.arena, DRAWN.world, bodies.near, chance
    )
    assert [float(c.forward) for c in told.ugvs] == pytest.approx([float(c.forward) for c in attacked.ugvs])
