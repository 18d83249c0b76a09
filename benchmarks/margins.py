"""How much of the default net's margin is needed, and what happens beyond its contract.

*Tightness.* Vehicles capped to a speed are flown at what is nearest with every error and delay of the contract at its
worst. The net keeps a share of its proven margin only; the least share at which nothing is touched, found by bisection,
is what was needed over what was proven. Vehicles' radii do not count: the margin begins at the hull.

*Sharpness.* The same attacks overstep the contract by a factor: in its delays, in its errors (of measurements, pushes
and brakes), or in both. Contacts should appear beyond a factor of 1 only.

    python benchmarks/margins.py [--flights N] [--json FILE] [--figure FILE.png]
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fledge.falsification.attacks import FAMILIES
from fledge.falsification.scenarios import Scenario, Terms, draw_scenario
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


def worst(terms: Terms, flights: int, by: Overstep) -> list[Scenario]:
    """Scenarios that use every bound of the contract to the full, or more."""
    names, c = list(FAMILIES), terms.contract
    drawn = []
    for i in range(flights):
        family = names.index(WORST_FAMILIES[i % len(WORST_FAMILIES)])
        scenario = draw_scenario(np.random.default_rng([SEED, i]), family, i % terms.vehicles, terms).scenario
        trouble = scenario.trouble._replace(
            age=float(round(c.age * by.delays / c.period)),
            latency=float(round(c.latency * by.delays / c.period)),
            share=by.errors,
            malice=1.0,
            cut=float(i % 2),
        )
        drawn.append(scenario._replace(trouble=trouble))
    return drawn


def contacts(net: StopTube, terms: Terms, flights: int, by: Overstep = Overstep()) -> dict[str, int]:
    """Flights in which a vehicle touched something."""
    keys = [(SEED, i, 1) for i in range(flights)]
    least = np.array(fly_sorties(Trial(net, terms), worst(terms, flights, by), keys).tally.least)
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
    parser = argparse.ArgumentParser(description="Tightness and sharpness of the default net.")
    parser.add_argument("--flights", type=int, default=400)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--figure", type=Path)
    given = parser.parse_args()
    found: dict[str, Any] = {"flights": given.flights, "tightness": {}, "sharpness": {}}
    for speed in SPEEDS:
        shares = {kind: needed(speed, kind, given.flights) for kind in ("uav", "ugv")}
        found["tightness"][f"{speed:g} m/s"] = shares
        print(
            f"{speed:g} m/s: margin needed / proven: UAV {shares['uav']:.2f}, UGV {shares['ugv']:.2f}",
            flush=True,
        )
    terms = Terms(factor=max(FACTORS), retreat_ticks=1)
    for cause, overstep in CAUSES.items():
        for factor in FACTORS:
            touched = contacts(StopTube(), terms, given.flights, overstep(factor))
            found["sharpness"].setdefault(cause, {})[f"{factor:g}"] = touched
            print(f"{cause} x {factor:g}: contacts in {given.flights} flights: {touched}", flush=True)
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
            share = [100.0 * touched[kind] / found["flights"] for touched in by_factor.values()]
            panel.plot([float(f) for f in by_factor], share, line, marker="o", markersize=3.5, label=cause)
        panel.axvline(1.0, color=MUTED, linewidth=0.9)
        panel.set(title=title, xlabel="times the contract's bounds", xticks=FACTORS)
    panels[0].set_ylabel("flights with a contact [%]")
    sheet.legend(figure, *panels[0].get_legend_handles_labels()[0])
    return figure


if __name__ == "__main__":
    main()
