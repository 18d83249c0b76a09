"""The searching adversary: writes scripts of attacks, and writes the next ones about those that came nearest.

The cross-entropy method (Rubinstein and Kroese, The Cross-Entropy Method, Springer 2004): scripts are drawn from normal
distributions, one per number; after each generation mean and spread move to those of the best. A script has
`attacks.SEGMENTS` vectors whose numbers are shares of full speed in [-1, 1].
"""

from typing import NamedTuple

import numpy as np

from fledge.falsification.attacks import FAMILIES, SEGMENTS
from fledge.falsification.scenarios import Draw, Terms, draw_scenario
from fledge.geometry import Vec3

FAMILY = list(FAMILIES).index("search")
ELITE = 0.2
"""Share of a generation about which the next is written; at least two scripts."""
HASTE = 0.7
"""How far mean and spread move towards theirs."""
SPREAD, LEAST_SPREAD = 1.5, 0.1
"""At first half of the numbers are full speed one way or the other; a search never settles altogether."""


class Search(NamedTuple):
    """What was learnt about one scene; arrays of shape (segments, 3)."""

    mean: np.ndarray
    spread: np.ndarray

    @classmethod
    def begin(cls) -> "Search":
        """Nothing yet."""
        return cls(np.zeros((SEGMENTS, 3)), np.full((SEGMENTS, 3), SPREAD))

    def write(self, rng: np.random.Generator, scripts: int) -> np.ndarray:
        """A generation of scripts, shape (scripts, segments, 3)."""
        return np.clip(rng.normal(self.mean, self.spread, (scripts, SEGMENTS, 3)), -1.0, 1.0)

    def learn(self, scripts: np.ndarray, gaps: np.ndarray) -> "Search":
        """From how near [m] each script of a generation brought the vehicle to something."""
        best = scripts[np.argsort(gaps)[: max(2, round(ELITE * len(scripts)))]]
        return Search(
            self.mean + HASTE * (best.mean(axis=0) - self.mean),
            np.maximum(self.spread + HASTE * (best.std(axis=0) - self.spread), LEAST_SPREAD),
        )


class Hunt(NamedTuple):
    """Searches on some scenes at once, each after one vehicle; flights take the scenes in turn."""

    draws: tuple[Draw, ...]
    searches: tuple[Search, ...]

    @classmethod
    def begin(cls, terms: Terms, key: tuple[int, ...], scenes: int) -> "Hunt":
        """On scenes drawn anew, after every vehicle in turn."""
        rngs = [np.random.default_rng([*key, i]) for i in range(scenes)]
        draws = (draw_scenario(rng, FAMILY, i % terms.vehicles, terms) for i, rng in enumerate(rngs))
        return cls(tuple(draws), (Search.begin(),) * scenes)

    def write(self, rng: np.random.Generator, flights: int) -> np.ndarray:
        """A script per flight, shape (flights, segments, 3)."""
        scripts = np.empty((flights, SEGMENTS, 3))
        for i, search in enumerate(self.searches):
            mine = scripts[i :: len(self.searches)]
            mine[:] = search.write(rng, len(mine))
        return scripts

    def draw(self, scripts: np.ndarray) -> list[Draw]:
        """The flights that follow these scripts; none costs another arena."""
        return [_following(self.draws[i % len(self.draws)], script) for i, script in enumerate(scripts)]

    def learn(self, scripts: np.ndarray, gaps: np.ndarray) -> "Hunt":
        """From the gaps [m] of every vehicle in these flights, shape (vehicles, flights)."""
        n = len(self.searches)
        learnt = (
            search.learn(scripts[i::n], gaps[int(draw.scenario.focus), i::n])
            for i, (draw, search) in enumerate(zip(self.draws, self.searches, strict=True))
        )
        return Hunt(self.draws, tuple(learnt))


def _following(draw: Draw, script: np.ndarray) -> Draw:
    scenario = draw.scenario
    nature = scenario.nature._replace(script=tuple(Vec3(*line) for line in script.tolist()))
    return draw._replace(scenario=scenario._replace(nature=nature), rejected=0)
