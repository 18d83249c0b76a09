"""How much of the default net's margin is needed, and what happens beyond its contract.

*Tightness.* Vehicles capped to a speed are flown at what is nearest with every error and delay of the contract at its
worst; where that touches nothing, an adversary that searches is let loose on them. The net keeps a share of its proven
margin only; the least share at which nothing is touched, found by bisection, is what was needed over what was proven.
Vehicles' radii do not count: the margin begins at the hull.

*Sharpness.* The same attacks overstep the contract by a factor: in its delays, in its errors (of measurements, pushes
and brakes), or in both. Contacts should appear beyond a factor of 1 only.

    python benchmarks/margins.py [--flights N] [--json FILE] [--figure FILE.png]
"""

import argparse
import json
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fledge.falsification.attacks import FAMILIES
from fledge.falsification.scenarios import Scenario, Terms, draw_scenario
from fledge.falsification.search import Hunt
from fledge.falsification.sorties import Trial, fly_sorties
from fledge.observation import StickScale
from fledge.report import figures
from fledge.report.figures import sheet
from fledge.report.figures.looks import MUTED
from fledge.safety import StopTube
from fledge.simulation import Rig

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WORST_FAMILIES = ("nearest-wall", "late-reverse", "corner", "delayed", "stuck")
SPEEDS = (0.5, 1.0)
FACTORS = (1.0, 1.25, 1.5, 2.0, 2.5, 3.0)
BISECTIONS = 5
SEED = 20
KINDS = ("uav", "ugv")

HUNT_TICKS = 250
"""[10 ms] a hunt's flight lasts: each of its script's eight parts is about as long as a stop."""
SCENES, SCRIPTS, GENERATIONS = 40, 20, 30
"""Of a hunt: places where it begins, scripts for each in a generation."""


def capped(speed: float) -> Rig:
    """Vehicles that go no faster."""
    rig = Rig()
    fleet = tuple(replace(model, max_speed=min(speed, model.max_speed)) for model in rig.formation.fleet)
    sticks = StickScale(horizontal=speed, vertical=min(speed, rig.sticks.vertical))
    return replace(rig, sticks=sticks, formation=replace(rig.formation, fleet=fleet))


class Overstep(NamedTuple):
    """By which factors the contract is overstepped."""

    delays: float = 1.0
    errors: float = 1.0


CAUSES = {
    "delays": lambda factor: Overstep(delays=factor),
    "errors": lambda factor: Overstep(errors=factor),
    "both": lambda factor: Overstep(factor, factor),
}


def strained(scenario: Scenario, terms: Terms, number: int, by: Overstep) -> Scenario:
    """The scenario with every bound of the contract used to the full, or more; of every other one links are cut."""
    c = terms.contract
    trouble = scenario.trouble._replace(
        age=float(round(c.age * by.delays / c.period)),
        latency=float(round(c.latency * by.delays / c.period)),
        share=by.errors,
        malice=1.0,
        cut=float(number % 2),
    )
    return scenario._replace(trouble=trouble)


def worst(terms: Terms, flights: int, by: Overstep) -> list[Scenario]:
    """Scenarios of the families that come nearest."""
    names = list(FAMILIES)
    drawn = []
    for i in range(flights):
        family = names.index(WORST_FAMILIES[i % len(WORST_FAMILIES)])
        scenario = draw_scenario(np.random.default_rng([SEED, i]), family, i % terms.vehicles, terms).scenario
        drawn.append(strained(scenario, terms, i, by))
    return drawn


@cache
def contacts(net: StopTube, terms: Terms, flights: int, by: Overstep = Overstep()) -> dict[str, int]:
    """Flights in which a vehicle touched something."""
    keys = [(SEED, i, 1) for i in range(flights)]
    return touched(fly_sorties(Trial(net, terms), worst(terms, flights, by), keys).tally.least)


def touched(least: Sequence[np.ndarray]) -> dict[str, int]:
    """Flights in which a UAV, and a UGV, touched something, of the smallest gaps [m] of every vehicle."""
    gaps = np.array(least)
    return {"uav": int((gaps[0] <= 0.0).sum()), "ugv": int((gaps[1:].min(axis=0) <= 0.0).sum())}


def hunted(net: StopTube, terms: Terms, kind: str) -> bool:
    """Whether an adversary that searches gets that kind of vehicle to touch something."""
    terms = replace(terms, attack_ticks=HUNT_TICKS)
    hunt = lurking(terms, kind)
    for generation in range(GENERATIONS):
        scripts = hunt.write(np.random.default_rng([SEED, 2, generation]), SCENES * SCRIPTS)
        scenarios = [draw.scenario for draw in hunt.draw(scripts)]
        keys = [(SEED, 2, generation, i) for i in range(len(scenarios))]
        least = fly_sorties(Trial(net, terms), scenarios, keys).tally.least
        if touched(least)[kind]:
            return True
        hunt = hunt.learn(scripts, np.array(least))
    return False


def lurking(terms: Terms, kind: str) -> Hunt:
    """A hunt on that kind of vehicle which has not yet begun."""
    hunt = Hunt.begin(terms, (SEED, 2), SCENES * terms.vehicles)
    prey = [draw for draw in hunt.draws if KINDS[draw.scenario.focus > 0.0] == kind][:SCENES]
    draws = (
        draw._replace(scenario=strained(draw.scenario, terms, i, Overstep())) for i, draw in enumerate(prey)
    )
    return Hunt(tuple(draws), hunt.searches[:SCENES])


def needed(speed: float, kind: str, flights: int) -> float:
    """The least share of the proven margin at which that kind of vehicle touches nothing."""
    terms = Terms(rig=capped(speed), retreat_ticks=1)
    low, high = 0.4, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        net = StopTube(scale=middle)
        if contacts(net, terms, flights)[kind] or hunted(net, terms, kind):
            low = middle
        else:
            high = middle
    return high


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Tightness and sharpness of the default net.")
    parser.add_argument("--flights", type=int, default=400)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--figure", type=Path)
    given = parser.parse_args()
    found: dict[str, Any] = {"flights": given.flights, "tightness": {}, "sharpness": {}}
    for speed in SPEEDS:
        shares = {kind: needed(speed, kind, given.flights) for kind in KINDS}
        found["tightness"][f"{speed:g} m/s"] = shares
        print(
            f"{speed:g} m/s: margin needed / proven: UAV {shares['uav']:.2f}, UGV {shares['ugv']:.2f}",
            flush=True,
        )
    terms = Terms(factor=max(FACTORS), retreat_ticks=1)
    for cause, overstep in CAUSES.items():
        for factor in FACTORS:
            hit = contacts(StopTube(), terms, given.flights, overstep(factor))
            found["sharpness"].setdefault(cause, {})[f"{factor:g}"] = hit
            print(f"{cause} x {factor:g}: contacts in {given.flights} flights: {hit}", flush=True)
    if given.json:
        given.json.write_text(json.dumps(found, indent=1) + "\n")
    if given.figure:
        given.figure.write_bytes(figures.to_png(draw(found)))


def draw(found: dict[str, Any]) -> "Figure":
    """Share of flights with a contact over the factor, for both kinds of vehicles."""
    from matplotlib import rc_context

    with rc_context(sheet.STYLE):
        return _drawn(found)


def _drawn(found: dict[str, Any]) -> "Figure":
    figure, panels = sheet.panels(1, 2, 2.2, left=0.8, apart=(0.12, 0.0), sharex=True, sharey=True)
    for panel, (kind, title) in zip(panels, (("uav", "UAV"), ("ugv", "UGVs")), strict=True):
        for (cause, by_factor), line in zip(found["sharpness"].items(), ("-", "--", ":"), strict=True):
            share = [100.0 * hit[kind] / found["flights"] for hit in by_factor.values()]
            panel.plot([float(f) for f in by_factor], share, line, marker="o", markersize=3.5, label=cause)
        panel.axvline(1.0, color=MUTED, linewidth=0.9)
        panel.set(title=title, xlabel="times the contract's bounds", xticks=FACTORS)
    panels[0].set_ylabel("flights with a contact [%]")
    sheet.legend(figure, *panels[0].get_legend_handles_labels()[0])
    return figure


if __name__ == "__main__":
    main()
