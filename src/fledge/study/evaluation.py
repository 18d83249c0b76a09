"""How well a flight kept the UGVs in view: the paper's two objectives, and what it only describes.

With d the pixel distance between the image centre and the UGVs' centre of mass and e the radius error (Eq. 2 and 3,
there as integrals over time; D11), a flight's

* `distance` is the time mean of d [px], `distance_rmse` the root of the time mean of d^2 [px];
* `radius` is the time mean of e^2 [px^2], `radius_rmse` its root [px];
* `in_view` is the share of frames with every UGV in the picture;
* `smoothness` is the mean absolute change of the sticks per second [1/s], lower is smoother, and `effort` their mean
  absolute deflection: "smoother" and "less energy", in numbers.

All are computed from the exact poses, not from what the pilot saw. The unit of inference is the flight.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from fledge.camera import look
from fledge.engines import fly, fly_plain, take, traceable
from fledge.episode import Episode
from fledge.observation import ROW_RATE
from fledge.pytrees import pytree, register, stack
from fledge.simulation import Case, Crew, Rig


@pytree
@dataclass(frozen=True, slots=True)
class Score:
    """Of one flight; arrays of shape (seeds, cases) for many."""

    distance: Any
    """Time mean of the pixel distance, Eq. 2 / T [px]."""
    distance_rmse: Any
    """[px]."""
    radius: Any
    """Time mean of the squared radius error, Eq. 3 / T [px^2]."""
    radius_rmse: Any
    """[px]."""
    in_view: Any
    """Share of frames with all UGVs in the picture."""
    smoothness: Any
    """Mean absolute stick change [1/s]."""
    effort: Any
    """Mean absolute stick deflection."""

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """What is scored."""
        return tuple(field.name for field in fields(cls))


def score(episode: Episode, rig: Rig) -> Score:
    """Score one flight, leaves (rows,), or many, leaves (flights, rows)."""
    picture = look(rig.lens, episode.world)
    u, v = rig.lens.centre
    d2 = (picture.u - u) ** 2 + (picture.v - v) ** 2
    e2 = (picture.radius - rig.ideal_radius) ** 2
    a = episode.action
    sticks = jnp.stack([jnp.asarray(axis) for axis in (a.forward, a.left, a.up)])
    return Score(
        distance=jnp.sqrt(d2).mean(axis=-1),
        distance_rmse=jnp.sqrt(d2.mean(axis=-1)),
        radius=e2.mean(axis=-1),
        radius_rmse=jnp.sqrt(e2.mean(axis=-1)),
        in_view=picture.all_in_view.mean(axis=-1),
        smoothness=jnp.abs(jnp.diff(sticks, axis=-1)).mean(axis=(0, -1)) * ROW_RATE,
        effort=jnp.abs(sticks).mean(axis=(0, -1)),
    )


def evaluate(
    cases: Sequence[Case],
    crew: Crew,
    keys: Sequence[Sequence[int]],
    rig: Rig = Rig(),
    team: bool = False,
) -> tuple[Score, Episode]:
    """Fly a crew on cases.

    Returns:
        (scores, leaves of shape (seeds, cases); the first case's flight by the first seed, leaves (rows,)).
        There is one seed unless the crew's pilot is a `team`, with a leading axis of seeds on its arrays.
    """
    if not traceable(crew.pilot):
        flown = [fly_plain(case, crew, key, rig) for case, key in zip(cases, keys, strict=True)]
        return _table([stack([score(episode, rig) for episode in flown])]), flown[0]
    crews = _members(crew) if team else [crew]
    scores, samples = zip(*(fly(cases, each, keys, rig, _scored(rig)) for each in crews), strict=True)
    return _table(scores), take(samples[0], 0, len(cases[0].plan.track.x))


def _members(crew: Crew) -> list[Crew]:
    register(crew)
    leaves, shape = jax.tree.flatten(crew.pilot)
    return [replace(crew, pilot=jax.tree.unflatten(shape, member)) for member in zip(*leaves, strict=True)]


def _table(scores: Sequence[Score]) -> Score:
    return Score(*(np.array([getattr(score, name) for score in scores]) for name in Score.names()))


@cache
def _scored(rig: Rig) -> Callable[[Episode], tuple[Score, Episode]]:
    """Scores a batch of flights, and keeps the first one whole."""

    def reduce(episodes: Episode) -> tuple[Score, Episode]:
        return score(episodes, rig), jax.tree.map(lambda leaf: leaf[:1], episodes)

    return jax.jit(reduce)
