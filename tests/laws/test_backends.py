"""One core, two backends: plain floats and JAX fly the same scene the same way, given the same chance.

In double precision a whole flight is compared; in single precision every step on its own, since rounding that
enters a loop is not rounding any more.
"""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from fledge.conditions import NORMALS, UNIFORMS, Conditions, row_noise
from fledge.engines import COMPILED, PLAIN, stack_cases
from fledge.manoeuvres import Combined
from fledge.manoeuvres.base import FormationTrack
from fledge.observation import ACTION_NAMES
from fledge.pilots import HumanModel, Servo
from fledge.pilots.human_model import STICK_STEPS
from fledge.simulation import STEP, Case, Crew, Rig, fly_row, rollout, start

ROWS = 1200
"""60 s."""
QUICKLY = {"xla_backend_optimization_level": 1}
NOMINAL = Case.draw(Combined(), (1, 3), ROWS)
PERFECT = replace(NOMINAL, conditions=Conditions())


def chance(rows: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    return rng.normal(size=(rows, NORMALS)), rng.uniform(-1.0, 1.0, (rows, UNIFORMS))


def deal(drawn):
    normal, uniform = drawn
    return row_noise([normal[i] for i in range(NORMALS)], [uniform[i] for i in range(UNIFORMS)])


def differences(plain, jaxed) -> dict[str, np.ndarray]:
    """|plain - jax| of every leaf, relative to its size where that is above one; equal infinities differ by nothing."""
    found = {}
    for (path, a), b in zip(
        jax.tree_util.tree_flatten_with_path(plain)[0], jax.tree.leaves(jaxed), strict=True
    ):
        a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
        with np.errstate(invalid="ignore"):
            found[jax.tree_util.keystr(path)] = np.where(
                a == b, 0.0, np.abs(a - b) / np.maximum(np.abs(a), 1.0)
            )
    return found


@pytest.fixture(scope="module", params=(Servo(), HumanModel()), ids=lambda pilot: pilot.name)
def flights(request):
    """(pilot, flights on JAX in float64: a nominal day, a perfect one)."""
    crew = Crew(request.param)
    with jax.enable_x64(True):
        fly = jax.jit(
            jax.vmap(
                lambda case, drawn: rollout((case, crew, Rig()), drawn, deal, COMPILED), in_axes=(0, None)
            ),
            compiler_options=QUICKLY,
        )
        flown = fly(stack_cases([NOMINAL, PERFECT], boxes=2), chance(ROWS))
        assert flown.world.t.dtype == np.float64
        return crew, jax.tree.map(np.asarray, flown)


@pytest.mark.slow
@pytest.mark.parametrize("day", ("nominal", "perfect"))
def test_in_double_precision_a_minute_of_flight_agrees_to_nine_digits(flights, day):
    crew, flown = flights
    i = ("nominal", "perfect").index(day)
    plain = rollout(((NOMINAL, PERFECT)[i], crew, Rig()), chance(ROWS), deal, PLAIN)
    assert len(plain.world.t) == ROWS
    found = differences(plain, jax.tree.map(lambda leaf: leaf[i], flown))
    worst = max(found, key=lambda name: found[name].max())
    assert found[worst].max() <= 1e-9, worst


@pytest.fixture(scope="module", params=(Servo(), HumanModel()), ids=lambda pilot: pilot.name)
def single_steps(request):
    """Each row of a plain flight of 10 s, and the same rows flown one by one in float32."""
    rows, crew = 200, Crew(request.param)
    case, (normal, uniform) = NOMINAL.lasting(rows), chance(rows)
    scene = (case, crew, Rig())
    names = FormationTrack.__slots__
    inputs = [
        (
            FormationTrack(*(float(getattr(case.plan.track, n)[r]) for n in names)),
            (normal[r].tolist(), uniform[r].tolist()),
        )
        for r in range(rows)
    ]
    state, before, after = start(*scene), [], []
    for target, drawn in inputs:
        before.append(state)
        state, row = fly_row(state, target, deal(drawn), scene, PLAIN)
        after.append((state, row))
    plain, states, given = (
        jax.tree.map(lambda *leaves: np.array(leaves), *many) for many in (after, before, inputs)
    )
    step = jax.jit(
        jax.vmap(lambda state, target, drawn: fly_row(state, target, deal(drawn), scene, COMPILED)),
        compiler_options=QUICKLY,
    )
    single = step(*jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float32), (states, *given)))
    return plain, single


U = 2.0**-24
"""Half a unit in the last place of a single-precision number near one."""


@pytest.mark.slow
def test_in_single_precision_a_row_agrees_to_rounding(single_steps):
    """25 physics steps, each rounding positions of up to 8 m, headings and speeds: 25 x 8 U.

    The inner loops differentiate their set-points: a rounded velocity command, divided by the step of 2 ms and by
    g, is a rounded tilt; divided by the step and multiplied by the loop's 5 / s once more it is an angular
    acceleration, of which the rotors' lag lets 1 / 16 through at once. So rates, thrusts and accelerations carry
    5 U / (g STEP) / 16 for every U of the others. What a pilot remembers are differences of pixels of up to 512,
    and their lead: 10 x 512 U.
    """
    plain, single = single_steps
    (state, row), (got_state, got_row) = plain, single
    tight, remembered = 25 * 8 * U, 10 * 512 * U
    differentiated = tight * 5.0 / (9.81 * STEP) / 16.0
    assert max(remembered, differentiated) < 4e-4
    said = differences(row.action, got_row.action)
    # A stick that stands between two of its steps may fall to either side.
    agreed = np.all([value <= tight for value in said.values()], axis=0)
    assert agreed.mean() > 0.95
    for value in said.values():
        assert value.max() <= 1.0 / STICK_STEPS + tight
    assert set(name.strip(".") for name in said) == set(ACTION_NAMES)
    for name, value in {**differences(state, got_state), **differences(row, got_row)}.items():
        rough = any(part in name for part in ("rates", "thrusts", "acceleration", "turn"))
        allowed = remembered if ".pilot" in name else differentiated if rough else tight
        assert value[agreed].max() <= allowed, name


@pytest.mark.slow
def test_single_precision_is_really_single(single_steps):
    _, (state, row) = single_steps
    for leaf in jax.tree.leaves((state, row)):
        assert leaf.dtype == np.float32
