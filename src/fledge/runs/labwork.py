"""The physical experiment, flown in the digital twin: many flights behind every net, and the same in the simulator.

Flights in the twin are lock-step flights (`lab.outing`), in processes of their own (`outings`); the simulator flies its
own meanwhile, here. All nets see the same days: the same seeds, the same ways of the
formation, the same weather. What is made of it stands in `transfer`; the page is written by `report.lab`.

Kinds of flights: `lab`, an ordinary day; `reversed`, the same days with both sticks of the pilot reversed.
"""

import hashlib
import platform
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fledge.conditions import Conditions
from fledge.episode import Flight
from fledge.lab.control import tilt
from fledge.lab.outing import Found, Outing, track
from fledge.lab.twin import drone, twin
from fledge.observation import ROW_RATE, Axes
from fledge.pilots import AbstractPilot
from fledge.runs.outings import flying, landed
from fledge.safety import AbstractNet
from fledge.simulation import Case, Crew, Rig, flight_key
from fledge.storage import sweep, write_flight, write_json
from fledge.storage.records import to_json
from fledge.storage.results import plain
from fledge.study import transfer
from fledge.study.evaluation import Score, evaluate
from fledge.study.setups import FLYING_AXES
from fledge.world import Arena

KINDS = ("lab", "reversed")
SEEDS = 10_000
"""Twins of a study: more than the most flights there may be."""


@dataclass(frozen=True, slots=True)
class Plan:
    """What is to be flown."""

    pilot: AbstractPilot
    name: str
    """Of the pilot, or of a policy's file."""
    nets: Mapping[str, AbstractNet]
    arena: Arena
    flights: int = 20
    """Behind each net, of each kind."""
    seconds: float = 30.0
    """That the pilot flies in each."""
    seed: int = 0
    kinds: tuple[str, ...] = KINDS

    @property
    def seeds(self) -> range:
        """Of the twins."""
        return range(SEEDS * self.seed, SEEDS * self.seed + self.flights)

    def outings(self) -> Iterator[tuple[tuple[str, str], Outing]]:
        """((kind, net), flight) of every flight; those of a net follow each other."""
        for kind in self.kinds:
            for net, judge in self.nets.items():
                for seed in self.seeds:
                    names = (Path(self.name).stem, net)
                    aside = (self.arena, self.seconds, kind == "reversed")
                    yield (kind, net), Outing(self.pilot, judge, seed, names, *aside)


class Harvest(NamedTuple):
    """What was flown."""

    twin: Mapping[tuple[str, str], Sequence[Found]]
    """By kind and net."""
    simulator: Score
    """Leaves of shape (1, flights)."""


def conduct(plan: Plan, jobs: int | None = None) -> Iterator[tuple[int, int] | Harvest]:
    """Fly all of it: (flights done, of how many) over and over, and at the end what came of them."""
    orders = list(plan.outings())
    found: dict[int, Found] = {}
    with flying([order for _, order in orders], jobs) as under_way:
        simulator = in_simulator(plan)
        for place, one in landed(under_way):
            found[place] = one
            yield len(found), len(orders)
    twin: dict[tuple[str, str], list[Found]] = {}
    for place, (key, _) in enumerate(orders):
        twin.setdefault(key, []).append(found[place])
    yield Harvest(twin, simulator)


def in_simulator(plan: Plan) -> Score:
    """The same ways of the formation in the training simulator, without a net; leaves of shape (1, flights)."""
    cases, keys = [], []
    for number, seed in enumerate(plan.seeds):
        key = flight_key(plan.seed, "lab-study", "lab", number)
        way = track(seed, plan.arena, plan.seconds)
        cases.append(Case(way, Conditions.draw(np.random.default_rng(list(key)))))
        keys.append((*key, 1))
    crew = Crew(plan.pilot.for_axes(FLYING_AXES), Axes.of(FLYING_AXES))
    scores, _ = evaluate(cases, crew, keys)
    return scores


def summarise(plan: Plan, harvest: Harvest, command: str) -> dict[str, Any]:
    """All that goes into results.json but the times."""
    nets: dict[str, Any] = {}
    begun = {key: _flights(found) for key, found in harvest.twin.items()}
    for (kind, net), found in harvest.twin.items():
        numbers = [one.numbers for one in found]
        told = transfer.behind(numbers, begun[kind, net])
        nets.setdefault(kind, {})[net] = told | {"each": numbers}
    return {
        "version": version("fledge"),
        "seed": plan.seed,
        "sentences": transfer.sentences(plan.name),
        "settings": _settings(plan, command),
        "flights": nets,
        "transfer": _transfer(plan, begun, harvest.simulator),
    }


def _transfer(plan: Plan, begun: Mapping[tuple[str, str], Sequence[Flight]], simulator: Score) -> Any:
    """Twin beside simulator, without a net if there are such flights; None if they are too few, or one never began."""
    net = "none" if "none" in plan.nets else next(iter(plan.nets))
    flights = begun.get(("lab", net), ())
    if len(flights) < max(plan.flights, transfer.FEWEST):
        return None
    return {"net": net} | transfer.compare(transfer.scored(flights), simulator, plan.seed, plan.seconds)


def _flights(found: Sequence[Found]) -> list[Flight]:
    return [one.flight for one in found if one.flight is not None]


def _settings(plan: Plan, command: str) -> dict[str, Any]:
    file = Path(plan.name)
    return {
        "command": command,
        "pilot": plan.name,
        "policy_sha256": hashlib.sha256(file.read_bytes()).hexdigest() if file.is_file() else None,
        "nets": list(plan.nets),
        "flights": plan.flights,
        "flight_seconds": plan.seconds,
        "row_rate_hz": ROW_RATE,
        "arena": to_json(plan.arena),
        "twin": twin_settings(),
        "simulator": simulator_settings(),
        "versions": {"python": platform.python_version()}
        | {name: version(name) for name in ("fledge", "jax", "mujoco", "numpy", "scipy")},
    }


def twin_settings() -> dict[str, Any]:
    """All that the twin's vehicles, sensors, cameras and weather are made of."""
    options = twin.Options()
    return {
        "drone": asdict(options.drone),
        "cameras": asdict(options.cameras),
        "draught": asdict(options.draught),
        "link_delay_s": options.link_delay,
        "sag": drone.SAG,
        "most_tilt_rad": tilt.Tilt().most_tilt,
    }


def simulator_settings() -> dict[str, Any]:
    """The training simulator's vehicle, and what is the same on all of its days."""
    day = asdict(Conditions.draw(np.random.default_rng(0)))
    same = ("gust", "command_noise", "command_drift", "pixel_noise", "motion_noise")
    return {"uav": asdict(Rig().uav), "day": {name: day[name] for name in same}}


def store(folder: Path, harvest: Harvest, summary: Mapping[str, Any], times: Mapping[str, float]) -> Any:
    """Store results.json, whose content is returned, and the first flight of every kind behind every net.

    Raises:
        BadFile: a file cannot be written.
    """
    for part in (folder, folder / "flights"):
        part.mkdir(parents=True, exist_ok=True)
        sweep(part)
    for (kind, net), found in harvest.twin.items():
        first = next((one.flight for one in found if one.flight is not None), None)
        if first is not None:
            write_flight(folder / "flights" / f"{kind}-{net}.mcap", first)
    results = plain(dict(summary) | {"times": dict(times)})
    write_json(folder / "results.json", results)
    return results
