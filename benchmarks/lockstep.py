"""Flights in the digital twin by the thousand: controller and twin in lock-step, every byte through the codecs.

Each flight takes off from the pad, and is over when its pilot has flown for 30 s; with --landing, on the floor. All
nets meet the same days: the same seeds, the same ways of the formation, the same weather. What counts as touched is
the twin's to say.

    python benchmarks/lockstep.py [--flights N] [--net NAME ...] [--policy FILE] [--landing] [--jobs 2] [--json FILE]
"""

import argparse
import json
import os
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a process for every core, and a core for every process

from fledge import lookup
from fledge.lab.control.outfit import Outfit
from fledge.lab.control.phases import Phase
from fledge.lab.lockstep import Tick, fly_lockstep, judged
from fledge.lab.twin.twin import TICK, Twin
from fledge.world import Arena

NETS = ("stop-tube", "paper")
EACH = 25
"""Flights after which a line is printed."""


class Day(NamedTuple):
    """What all flights have in common."""

    seconds: float
    """For which the pilot flies."""
    landing: bool
    policy: Path | None


def flight(net: str, seed: int, day: Day) -> dict[str, Any]:
    """One flight."""
    arena = Arena.lab()
    pilot = lookup.pilot("servo") if day.policy is None else lookup.policy(day.policy)
    outfit = Outfit(arena, "", net, duration=day.seconds, unattended=True)
    twin = Twin(arena, seed)
    ticks = fly_lockstep(outfit.controller(pilot, lookup.lab_net(net)), twin)
    return judged(ticks if day.landing else _aloft(ticks), twin, arena) | {"seed": seed}


def _aloft(ticks: Iterator[Tick]) -> Iterator[Tick]:
    """Up to the first tick of the landing."""
    for tick in ticks:
        yield tick
        if tick.said.phase is Phase.LAND:
            return


def flights(net: str, seeds: Sequence[int], day: Day, jobs: int) -> Iterator[dict[str, Any]]:
    """All flights behind one net, as many at once as there are jobs."""
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
        yield from pool.map(flight, repeat(net), seeds, repeat(day), chunksize=2)


def total(found: Sequence[dict[str, Any]], wall: float, day: Day) -> dict[str, Any]:
    """What came of all flights behind one net; means are over flights, gaps the least of all."""
    flown = [one for one in found if one["in_view"] is not None]
    interventions: Counter[str] = Counter()
    for one in found:
        for layer, times in one["interventions"].items():
            interventions.update({f"{layer}: {reason}": number for reason, number in times.items()})
    simulated = TICK * sum(one["ticks"] for one in found)
    return {
        "flights": len(found),
        "flights_with_contact": sum(one["contacts"] > 0 for one in found),
        "contacts": sum(one["contacts"] for one in found),
        "touched": sorted({pair for one in found for pair in one["touched"]}),
        "seeds_with_contact": [one["seed"] for one in found if one["contacts"]],
        "human_interventions_needed": sum(one["human_interventions_needed"] for one in found),
        "seeds_with_need": [one["seed"] for one in found if one["human_interventions_needed"]],
        "not_finished": [one["seed"] for one in found if not _finished(one, day)],
        "flown_s": sum(one["flown_s"] for one in found),
        "in_view": _mean(flown, "in_view"),
        "least_in_view": min((one["in_view"] for one in flown), default=None),
        "distance_rmse_px": _mean(flown, "distance_rmse_px"),
        "radius_rmse_px": _mean(flown, "radius_rmse_px"),
        "interventions": dict(sorted(interventions.items())),
        "least_gap_m": {kind: min(one["least_gap_m"][kind] for one in found) for kind in ("uav", "ugv")},
        "simulated_s": simulated,
        "wall_s": wall,
        "times_real_time": simulated / wall,
    }


def _finished(one: dict[str, Any], day: Day) -> bool:
    """Whether the pilot had all of its time, and the UAV came down if it was to."""
    return one["flown_s"] >= day.seconds - 0.1 and (one["landed"] or not day.landing)


def _mean(flown: Sequence[dict[str, Any]], name: str) -> float | None:
    return sum(one[name] for one in flown) / len(flown) if flown else None


def measure(nets: Sequence[str], seeds: Sequence[int], day: Day, jobs: int) -> dict[str, Any]:
    """The totals of every net."""
    found: dict[str, Any] = {}
    for net in nets:
        began, flown = time.perf_counter(), []
        for one in flights(net, seeds, day, jobs):
            flown.append(one)
            found[net] = total(flown, time.perf_counter() - began, day)
            if len(flown) % EACH == 0 or len(flown) == len(seeds):
                print(_line(net, found[net]), flush=True)
    return found


def _line(net: str, sums: dict[str, Any]) -> str:
    view = "-" if sums["in_view"] is None else f"{100.0 * sums['in_view']:.2f} %"
    return (
        f"{net}: {sums['flights']} flights, {sums['flights_with_contact']} with contact, "
        f"{sums['human_interventions_needed']} people needed, in view {view}, "
        f"least gap UAV {sums['least_gap_m']['uav']:.2f} m, UGV {sums['least_gap_m']['ugv']:.2f} m; "
        f"{sums['times_real_time']:.1f} times real time, {sums['wall_s'] / 60.0:.1f} minutes"
    )


def main() -> None:
    """Fly, print, and write what came of it."""
    parser = argparse.ArgumentParser(description="Flights in the twin, in lock-step.")
    parser.add_argument("--flights", type=int, default=1000, help="behind each net")
    parser.add_argument("--net", nargs="+", default=NETS, help="the nets, by name")
    parser.add_argument("--policy", type=Path, help="who flies: an ONNX file; the servo by default")
    parser.add_argument("--seconds", type=float, default=30.0, help="for which the pilot flies")
    parser.add_argument("--landing", action="store_true", help="fly on to the floor")
    parser.add_argument("--seed", type=int, default=0, help="the first one")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes at once")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    day = Day(given.seconds, given.landing, given.policy)
    found = measure(given.net, range(given.seed, given.seed + given.flights), day, given.jobs)
    asked = {
        "pilot": str(given.policy or "servo"),
        "seconds": given.seconds,
        "landing": given.landing,
        "first_seed": given.seed,
    }
    if given.json:
        given.json.write_text(json.dumps(asked | {"jobs": given.jobs, "nets": found}, indent=1) + "\n")


if __name__ == "__main__":
    main()
