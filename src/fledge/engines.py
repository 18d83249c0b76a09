"""What a flight runs on: plain Python, or one compiled program for many flights.

`simulation` says once what happens in a flight. `fly_plain` runs it on plain floats: any pilot, any Python. `fly` runs
it compiled by JAX, in batches of one size on all cores, so that a flight does not depend on who flies beside it.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import fields, replace
from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.experimental.xla_metadata import set_xla_metadata

from fledge.conditions import NORMALS, UNIFORMS, RowNoise, row_noise
from fledge.cores import cores
from fledge.episode import Episode
from fledge.observation import Observation
from fledge.pilots.base import AbstractPilot
from fledge.pytrees import register, stack
from fledge.simulation import Case, Crew, Engine, Rig, Rollout, rollout

BATCH = 40
"""Flights of a program, always; a batch that is not full is filled up. More make a core no faster."""
BOXES = 2
"""Obstacles for which a program has room, if no arena has more: one program for flights with and without them."""


def apart(piece: Callable[..., Any], *inputs: Any) -> Any:
    """`piece(*inputs)` inside a compiled program, as a function of its own.

    Left to itself XLA fuses a tick into a few kernels that compute the same things many times over; with a net kept
    apart a program compiles in a tenth of the time and runs three times faster.
    """
    register(inputs)
    with set_xla_metadata(inlineable="false"):
        return jax.jit(piece)(*inputs)


def _plain_scan(step: Callable[[Any, Any], tuple[Any, Any]], carry: Any, inputs: Any) -> tuple[Any, Any]:
    """`jax.lax.scan` without JAX's arrays: a loop over plain floats, its outputs stacked by NumPy."""
    leaves, shape = jax.tree.flatten(inputs)
    outputs = []
    for row in zip(*(np.asarray(leaf).tolist() for leaf in leaves), strict=True):
        carry, output = step(carry, jax.tree.unflatten(shape, row))
        outputs.append(output)
    return carry, jax.tree.map(lambda *values: np.array(values), *outputs)


def scan(step: Callable[[Any, Any], tuple[Any, Any]], carry: Any, inputs: Any) -> tuple[Any, Any]:
    """`jax.lax.scan` over something of which at least the first number differs from scene to scene.

    As if all of it did from the start. Else `vmap` finds out by and by what does, and traces the step anew each time:
    ten times for a pilot who remembers ten rows.
    """
    register(carry)
    differs = jnp.ravel(jax.tree.leaves(carry)[0])[0] > 0.0
    carry = jax.tree.map(lambda leaf: jnp.where(differs, leaf, leaf), carry)
    return jax.lax.scan(step, carry, inputs)


COMPILED = Engine(scan, apart)
PLAIN = Engine(_plain_scan, lambda piece, *inputs: piece(*inputs))


def fly_plain(case: Case, crew: Crew, key: Sequence[int], rig: Rig = Rig(), roll: Rollout = rollout) -> Any:
    """Fly one case in plain Python, with the chance of `key`; leaves of shape (rows,). Any pilot will do."""
    register((case, crew))
    case = jax.tree.map(lambda leaf: leaf if np.ndim(leaf) else float(leaf), case)
    return roll((case, crew, rig), _chance(key, len(case.plan.track.x)), _deal, PLAIN)


def noises(key: Sequence[int], rows: int) -> list[RowNoise]:
    """The chance of `key`, row by row on plain floats, as `fly_plain` has it."""
    drawn = (part.tolist() for part in map(np.asarray, _chance(key, rows)))
    return [_deal(row) for row in zip(*drawn, strict=True)]


def fly(
    cases: Sequence[Case],
    crew: Crew | Sequence[Crew],
    keys: Sequence[Sequence[int]],
    rig: Rig = Rig(),
    reduce: Callable[[Any], Any] | None = None,
    roll: Rollout = rollout,
) -> Any:
    """Fly many cases, compiled; NumPy leaves of shape (flights, rows).

    Args:
        cases: one per flight, all with the same number of rows.
        crew: who flies them all, or one crew of the same kind per flight.
        keys: the chance of each flight.
        rig: vehicles and lens.
        reduce: makes something smaller of a batch of episodes, leaves (flights, rows): scores, say. What it
            makes of the batches is strung together.
        roll: what is done with each scene; a program is compiled for each.
    """
    inputs, flown = _set_up(cases, crew, keys, rig, roll)

    def batch(begin: int) -> Any:
        episodes = flown.result()(*inputs(begin))
        return jax.tree.map(np.asarray, episodes if reduce is None else reduce(episodes))

    with cores() as pool:
        parts = list(pool.map(batch, range(0, len(cases), BATCH)))
    return jax.tree.map(lambda *leaves: np.concatenate(leaves)[: len(cases)], *parts)


def prepare(
    cases: Sequence[Case],
    crew: Crew | Sequence[Crew],
    keys: Sequence[Sequence[int]],
    rig: Rig = Rig(),
    roll: Rollout = rollout,
) -> None:
    """Begin to compile what `fly` will need for such arguments: of theirs, only kinds and shapes count."""
    _set_up(cases, crew, keys, rig, roll)


def _set_up(
    cases: Sequence[Case], crew: Crew | Sequence[Crew], keys: Sequence[Sequence[int]], rig: Rig, roll: Rollout
) -> tuple[Callable[[int], tuple[Case, Crew, jax.Array]], Future[Any]]:
    """(the inputs of the batch that begins with a flight, the program for such batches)."""
    register(tuple(crew) if isinstance(crew, Sequence) else crew)
    crews = [crew] * len(cases) if isinstance(crew, Crew) else crew
    # Numbers are dealt out to the flights, so that one program does, whoever flies; a network is one for all.
    alike = isinstance(crew, Crew) and any(map(np.ndim, jax.tree.leaves(crew)))
    boxes = max(BOXES, *(len(case.plan.arena.obstacles) for case in cases))

    def inputs(begin: int) -> tuple[Case, Crew, jax.Array]:
        some = np.minimum(np.arange(begin, begin + BATCH), len(cases) - 1)
        aboard = jax.tree.map(jnp.asarray, crews[0]) if alike else stack([crews[i] for i in some])
        return stack_cases([cases[i] for i in some], boxes), aboard, _seeds([keys[i] for i in some])

    shapes = jax.tree.map(lambda leaf: jax.ShapeDtypeStruct(leaf.shape, leaf.dtype), inputs(0))
    return inputs, _program(rig, roll, alike, shapes)


def take(episodes: Episode, flight: int, rows: int) -> Episode:
    """One flight of many, its first `rows` rows."""
    return jax.tree.map(lambda leaf: leaf[flight, :rows], episodes)


# Half the compile time for the same speed: LLVM's costlier passes find nothing to do in small kernels.
_QUICKLY = {"xla_backend_optimization_level": 1}


def compiled(program: Callable[..., Any]) -> Any:
    """A program of many scenes, compiled."""
    return jax.jit(program, compiler_options=_QUICKLY)


_COMPILERS = ThreadPoolExecutor()


@cache
def _program(rig: Rig, roll: Rollout, alike: bool, shapes: tuple[Any, ...]) -> Future[Any]:
    """What flies a batch of inputs of these shapes, one crew for all of it if they are `alike`.

    To be: whoever asks while it is being compiled gets the same one.
    """

    def one(case: Case, crew: Crew, seed: jax.Array) -> Any:
        keys = jax.random.split(jax.random.wrap_key_data(seed), len(case.plan.track.x))
        flown = roll((case, crew, rig), keys, lambda key: _deal(_draw(key)), COMPILED)
        # Of one dtype, but not "weakly" here and there: else what is made of it is compiled anew for every crew.
        return jax.tree.map(lambda leaf: leaf.astype(leaf.dtype), flown)

    program = compiled(jax.vmap(one, in_axes=(0, None if alike else 0, 0)))
    return _COMPILERS.submit(lambda: program.lower(*shapes).compile())


def _chance(key: Sequence[int], rows: int) -> tuple[jax.Array, jax.Array]:
    keys = jax.random.split(jax.random.wrap_key_data(_seeds([key])[0]), rows)
    return jax.vmap(_draw)(keys)


def _draw(key: jax.Array) -> tuple[jax.Array, jax.Array]:
    """The chance of one row: standard normal numbers, and uniform ones in [-1, 1]."""
    one, two = jax.random.split(key)
    normal = jax.random.normal(one, (NORMALS,))
    return normal, jax.random.uniform(two, (UNIFORMS,), minval=-1.0, maxval=1.0)


def _deal(chance: tuple[Any, Any]) -> RowNoise:
    normal, uniform = chance
    return row_noise([normal[i] for i in range(NORMALS)], [uniform[i] for i in range(UNIFORMS)])


def traceable(pilot: AbstractPilot) -> bool:
    """Whether JAX can compile a pilot; one that cannot be compiled is flown by `fly_plain`."""
    number = jax.ShapeDtypeStruct((), jnp.float32)
    seen = Observation(*(number for _ in fields(Observation)))
    memory = pilot.init()
    register((pilot, seen, memory))
    noise = (number, number, number, number)
    try:
        # As in a flight: the memory goes through a scan, so it is traced, too, and must keep its kind.
        jax.eval_shape(
            lambda m, o, n: jax.lax.scan(lambda m, _: (pilot.act(m, o, n)[0], ()), m, length=1),
            memory,
            seen,
            noise,
        )
    except (TypeError, ValueError):  # JAX's own errors are TypeErrors
        return False
    return True


def stack_cases(cases: Sequence[Case], boxes: int) -> Case:
    """One Case with a leading axis of flights; arenas padded to so many obstacles."""
    return stack([
        replace(case, plan=replace(case.plan, arena=case.plan.arena.padded(boxes))) for case in cases
    ])


def _seeds(keys: Sequence[Sequence[int]]) -> jax.Array:
    words = [np.random.SeedSequence(list(key)).generate_state(2) for key in keys]
    return jnp.asarray(np.array(words, dtype=np.uint32))
