"""A campaign against a net: thousands of attacks, by every family in turn.

`falsify` is a stream: the toll so far, again and again. Families take turns, and so do the vehicles that are led away
at the end. The searching adversary has scenes of its own and several turns, since it learns from its own flights.
Policies share one turn, and fly in a program of their own, over UGVs that the families drive. Everything is drawn from
the campaign's seed and a flight's number.

`reenact` flies what should not have happened once more, and keeps it row by row.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from math import ceil
from typing import Any

import jax
import numpy as np

from fledge.episode import Episode, Flight, over
from fledge.errors import FledgeError
from fledge.falsification.attacks import FAMILIES
from fledge.falsification.melee import obeyed
from fledge.falsification.scenarios import Draw, Terms, draw_scenario
from fledge.falsification.search import Hunt
from fledge.falsification.sorties import Track, Trial, fly_sorties, traceable
from fledge.falsification.toll import Count, Salvo, Toll, Violation, violations
from fledge.observation import Action, observe
from fledge.pilots import AbstractPilot
from fledge.safety import AbstractNet
from fledge.scalars import clip
from fledge.simulation import TICK, TICKS_PER_ROW, Rig
from fledge.study.statistics import upper_bound

SEARCH, POLICY = "search", "policy"
TURNS = (*FAMILIES, SEARCH, SEARCH)
"""The families in their turn; the searching adversary has three."""
SMALLEST, LARGEST = 60, 480
"""Flights in the air at once: fewer are slower, more are no faster."""
GENERATIONS = 8
"""Salvos after which the searching adversary turns to other scenes."""
POPULATION = 15
"""Scripts for one scene in a salvo, about."""
FLIGHT, CHANCE, SCENES, SCRIPTS = range(4)
"""What is drawn, in the keys of chance; none of it depends on how flights are shared out among programs."""


@dataclass(frozen=True, slots=True)
class Campaign:
    """What is attacked, how much, and on which terms."""

    net: AbstractNet
    name: str
    """Of the net."""
    steps: int
    """To fly in all, at 100 Hz; every family and policy flies at least once."""
    seed: int
    policies: Mapping[str, AbstractPilot] = field(default_factory=dict)
    terms: Terms = Terms()

    @property
    def attacks(self) -> list[int]:
        """Flights of every salvo of the attackers."""
        turns = len(TURNS)
        share = turns / (turns + bool(self.policies))
        return _shared_out(ceil(self.steps * share / self.terms.ticks), turns)

    @property
    def piloted(self) -> list[int]:
        """Flights of every salvo of one policy."""
        left = self.steps / self.terms.ticks - sum(self.attacks)
        return _shared_out(max(1, ceil(left / len(self.policies))), 1) if self.policies else []

    @property
    def flights(self) -> int:
        """In all."""
        return sum(self.attacks) + sum(self.piloted) * len(self.policies)


def _shared_out(flights: int, multiple: int) -> list[int]:
    """At least so many flights in salvos of one size, since every size is compiled anew."""
    salvos = max(1, ceil(flights / LARGEST), min(GENERATIONS, flights // SMALLEST))
    return [ceil(flights / salvos / multiple) * multiple] * salvos


def checked(campaign: Campaign) -> Campaign:
    """The campaign itself, if it can be flown.

    Raises:
        FledgeError: its net cannot be compiled, or its arena has no room for the vehicles.
    """
    scenario = _draw(campaign, 0, 0).scenario
    if not traceable(campaign.net, scenario):
        raise FledgeError(
            f"{campaign.name}: JAX cannot compile this net: valid is one that decides with the functions of "
            "fledge.scalars (where, minimum) instead of if, and, or, min"
        )
    return campaign


def falsify(campaign: Campaign) -> Iterator[Toll]:
    """Attack a net: the toll after every salvo, until all steps are flown.

    Raises:
        FledgeError: the arena that was given has no room for the vehicles.
    """
    toll = Toll()
    for salvo in _salvos(campaign):
        toll = toll.after(salvo)
        yield toll


def _salvos(campaign: Campaign) -> Iterator[Salvo]:
    yield from _attacks(campaign)
    first = sum(campaign.attacks)
    for name in campaign.policies:
        for size in campaign.piloted:
            numbers = range(first, first + size)
            draws = [_draw(campaign, number, number % len(FAMILIES)) for number in numbers]
            yield _fly(campaign, numbers, [POLICY] * size, draws, name)
            first += size


def _attacks(campaign: Campaign) -> Iterator[Salvo]:
    names = list(FAMILIES)
    hunt = Hunt((), ())
    for i, size in enumerate(campaign.attacks):
        numbers = range(i * size, (i + 1) * size)
        families = [TURNS[number % len(TURNS)] for number in numbers]
        hunted = [j for j, family in enumerate(families) if family == SEARCH]
        if i % GENERATIONS == 0:
            scenes = max(1, len(hunted) // POPULATION)
            hunt = Hunt.begin(campaign.terms, (campaign.seed, SCENES, i), scenes)
        scripts = hunt.write(np.random.default_rng([campaign.seed, SCRIPTS, i]), len(hunted))
        search = iter(hunt.draw(scripts))
        draws = [
            next(search) if family == SEARCH else _draw(campaign, number, names.index(family))
            for number, family in zip(numbers, families, strict=True)
        ]
        salvo = _fly(campaign, numbers, families, draws)
        yield salvo
        hunt = hunt.learn(scripts, salvo.gaps[:, hunted])


def _draw(campaign: Campaign, number: int, family: int) -> Draw:
    rng = np.random.default_rng([campaign.seed, FLIGHT, number])
    return draw_scenario(rng, family, number // len(TURNS) % campaign.terms.vehicles, campaign.terms)


def _fly(
    campaign: Campaign,
    numbers: Sequence[int],
    families: Sequence[str],
    draws: Sequence[Draw],
    pilot: str | None = None,
    record: bool = False,
) -> Salvo:
    outcome = fly_sorties(
        Trial(campaign.net, campaign.terms, record),
        [draw.scenario for draw in draws],
        [(campaign.seed, CHANCE, number) for number in numbers],
        campaign.policies[pilot] if pilot else None,
    )
    return Salvo(numbers, families, pilot, draws, outcome, campaign.terms.attack_ticks * TICK)


# Once more.


def reenact(campaign: Campaign, found: Sequence[Violation]) -> Iterator[tuple[Violation, Flight]]:
    """Fly violations again, and keep those that happen again, row by row at 20 Hz.

    A program rounds by its size: what hangs by a hair may go well the second time.
    """
    for pilot in dict.fromkeys(one.pilot for one in found):
        mine = [one for one in found if one.pilot == pilot]
        numbers, families = [one.flight for one in mine], [one.family for one in mine]
        salvo = _fly(campaign, numbers, families, [one.draw for one in mine], pilot, record=True)
        for one in violations(salvo):
            i = numbers.index(one.flight)
            yield one, _flight(campaign, one, jax.tree.map(lambda leaf, i=i: leaf[i], salvo.outcome.track))


def _flight(campaign: Campaign, found: Violation, track: Track) -> Flight:
    rig = campaign.terms.rig
    return Flight(
        episode=_episode(track, rig),
        manoeuvre="attack",
        pilot=found.pilot or found.family,
        net=campaign.name,
        seed=campaign.seed,
        case=found.flight,
        axes=(0, 1, 2, 3),
        arena=found.draw.scenario.arena,
        lens=rig.lens,
        sticks=rig.sticks,
        ideal_radius=rig.ideal_radius,
    )


def _episode(track: Track, rig: Rig) -> Episode:
    """Every fifth tick as a row. The action is what the UAV made of what it was told, in [-1, 1]."""
    world, told = jax.tree.map(lambda leaf: leaf[::TICKS_PER_ROW], (track.world, track.told))
    uav, full = obeyed(rig, told).uav, rig.sticks
    said = (uav.forward / full.horizontal, uav.left / full.horizontal, uav.up / full.vertical)
    ticks = [
        jax.tree.map(lambda leaf, i=i: leaf[i::TICKS_PER_ROW], track.verdicts) for i in range(TICKS_PER_ROW)
    ]
    return Episode(
        world=world,
        observation=observe(world, rig.lens, rig.ideal_radius),
        action=Action(*(clip(stick, -1.0, 1.0) for stick in (*said, uav.turn / full.turn))),
        proposed=told,
        verdicts=tuple(map(over, zip(*ticks, strict=True))),
        ideal_spread=np.full(len(world.t), np.nan),
    )


# In numbers.


def summary(campaign: Campaign, toll: Toll) -> dict[str, Any]:
    """A campaign and its toll as plain JSON values."""
    total, terms = toll.total, campaign.terms
    return {
        "net": campaign.name,
        **_numbers(total, terms),
        "upper_bound_95": upper_bound(total.contacts, total.flights),
        "rejected_arenas": toll.rejected,
        "near_starts": toll.near / (total.flights * terms.vehicles),
        "families": {name: _numbers(count, terms) for name, count in toll.families.items()},
        "settings": {
            "steps": campaign.steps,
            "factor": terms.factor,
            "arena": None if terms.arena is None else asdict(terms.arena),
            "contract": asdict(terms.contract),
            "attack_ticks": terms.attack_ticks,
            "retreat_ticks": terms.retreat_ticks,
            "policies": list(campaign.policies),
        },
        "seed": campaign.seed,
        "version": version("fledge"),
    }


def _numbers(count: Count, terms: Terms) -> dict[str, Any]:
    return {
        "steps": count.flights * terms.ticks,
        "flights": count.flights,
        "contacts": count.contacts,
        "contacts_by_vehicle": {"uav": count.uav_contacts, "ugv": count.ugv_contacts},
        "breaches": count.breaches,
        "retreats": count.retreats,
        "deadlocks": count.deadlocks,
        "interventions": count.interventions,
        "alarms": count.alarms,
        "false_alarm_rate": count.false_alarms / count.alarms if count.alarms else None,
        "least_gap_m": {"uav": count.uav_gap_m, "ugv": count.ugv_gap_m},
    }
