"""How much of the default net's margin is needed, and what happens beyond its contract.

*Tightness.* Vehicles capped to a speed are flown at what is nearest with every error and delay of the contract at its
worst. The net keeps a share of its proven margin only; the least share at which nothing is touched, found by bisection,
is what was needed over what was proven. Vehicles' radii do not count: the margin begins at the hull.

*Sharpness.* The same attacks overstep the contract by a factor on every bound at once; contacts should appear beyond
a factor of 1 only.

    python benchmarks/margins.py [--flights N] [--json FILE]
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fledge.attacks import FAMILIES
from fledge.observation import StickScale
from fledge.safety import StopTube
from fledge.scenarios import Scenario, Terms, draw_scenario
from fledge.simulation import Rig
from fledge.sorties import Trial, fly_sorties

WORST_FAMILIES = ("nearest-wall", "late-reverse", "corner", "delayed", "stuck")
SPEEDS = (0.5, 1.0)
FACTORS = (1.0, 1.25, 1.5, 2.0, 2.5, 3.0)
BISECTIONS = 5
SEED = 20


def capped(speed: float) -> Rig:
    """Vehicles that go no faster."""
    rig = Rig()
    fleet = tuple(replace(model, max_speed=min(speed, model.max_speed)) for model in rig.formation.fleet)
    sticks = StickScale(horizontal=speed, vertical=min(speed, rig.sticks.vertical))
    return replace(rig, sticks=sticks, formation=replace(rig.formation, fleet=fleet))


def worst(terms: Terms, flights: int) -> list[Scenario]:
    """Scenarios that use every bound of the contract to the full."""
    names = list(FAMILIES)
    drawn = []
    for i in range(flights):
        family = names.index(WORST_FAMILIES[i % len(WORST_FAMILIES)])
        scenario = draw_scenario(np.random.default_rng([SEED, i]), family, i % terms.vehicles, terms).scenario
        c = terms.contract
        trouble = scenario.trouble._replace(
            age=float(round(terms.late(c.age))),
            latency=float(round(terms.late(c.latency))),
            share=terms.factor,
            malice=1.0,
            cut=float(i % 2),
        )
        drawn.append(scenario._replace(trouble=trouble))
    return drawn


def contacts(net: StopTube, terms: Terms, flights: int) -> dict[str, int]:
    """Flights in which a vehicle touched something."""
    keys = [(SEED, i, 1) for i in range(flights)]
    least = np.array(fly_sorties(Trial(net, terms), worst(terms, flights), keys).tally.least)
    return {"uav": int((least[0] <= 0.0).sum()), "ugv": int((least[1:].min(axis=0) <= 0.0).sum())}


def needed(speed: float, kind: str, flights: int) -> float:
    """The least share of the proven margin at which that kind of vehicle touches nothing."""
    terms = Terms(rig=capped(speed), retreat_ticks=1)
    low, high = 0.4, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        touched = contacts(StopTube(scale=middle), terms, flights)[kind]
        low, high = (middle, high) if touched else (low, middle)
    return high


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--flights", type=int, default=400)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    found: dict[str, Any] = {"flights": given.flights, "tightness": {}, "sharpness": {}}
    for speed in SPEEDS:
        shares = {kind: needed(speed, kind, given.flights) for kind in ("uav", "ugv")}
        found["tightness"][f"{speed:g} m/s"] = shares
        print(
            f"{speed:g} m/s: margin needed / proven: UAV {shares['uav']:.2f}, UGV {shares['ugv']:.2f}",
            flush=True,
        )
    for factor in FACTORS:
        touched = contacts(StopTube(), Terms(factor=factor, retreat_ticks=1), given.flights)
        found["sharpness"][f"{factor:g}"] = touched
        print(f"contract x {factor:g}: contacts in {given.flights} flights: {touched}", flush=True)
    if given.json:
        given.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
