"""A finished physical experiment -> one self-contained page: `index.html` beside its results.json and sample flights.

The words stand in `lab.html.j2`, the figures in `figures.lab`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fledge.errors import BadFile
from fledge.report import page
from fledge.report.figures import lab
from fledge.storage import read_flight, read_json
from fledge.study.metrics import METRICS
from fledge.study.statistics import SEEDS_NEEDED

SHOWN = ("distance_rmse", "radius_rmse", "in_view")
"""The metrics of the tables of flights."""


def write_report(folder: Path) -> Path:
    """Write the page of an experiment and its figures; returns the page.

    Raises:
        BadFile: the results or a sample flight are missing or damaged, or the page cannot be written.
    """
    folder = Path(folder)
    results = read_json(folder / "results.json")
    plots = page.keep(folder, lab.draw(results, _samples(folder, results)))
    return page.publish(folder, render(results, plots))


def render(results: Mapping[str, Any], plots: Mapping[str, Any]) -> str:
    """The page as HTML."""
    nets = results["settings"]["nets"]
    return page.render(
        "lab.html.j2",
        plots,
        {net: lab.look_of(net) for net in nets},
        r=results,
        ordinary=_in_order(results, "lab"),
        wrong=_in_order(results, "reversed"),
        metrics=METRICS,
        shown=SHOWN,
        fewest=SEEDS_NEEDED,
        differences=differences(results["settings"]),
    )


@dataclass(frozen=True, slots=True)
class Difference:
    """Between the training simulator and the twin, in one respect."""

    what: str
    simulator: str
    twin: str


def differences(settings: Mapping[str, Any]) -> list[Difference]:
    """What the policy learnt with, and what it flies with here; from a study's settings."""
    ours, theirs = settings["simulator"]["uav"], settings["twin"]
    loops = theirs["drone"]["loops"]
    body = loops["airframe"]
    sight, air = theirs["cameras"]["usual"], theirs["draught"]
    day = settings["simulator"]["day"]
    inertia = ", ".join(f"{1e3 * one:.1f}" for one in body["inertia"])
    return [
        Difference("mass [kg]", f"{ours['mass']:g}", f"{body['mass']:g}"),
        Difference(
            "inertia about x, y, z [g m²]",
            f"{1e3 * ours['inertia_xy']:.1f}, {1e3 * ours['inertia_xy']:.1f}, {1e3 * ours['inertia_z']:.1f}",
            inertia,
        ),
        Difference(
            "most thrust of all rotors [N]", f"{ours['max_thrust']:g}", f"{4 * body['most_thrust']:g}"
        ),
        Difference("lag of a rotor [s]", f"{ours['rotor_lag']:g}", f"{body['rotor_lag']:g}"),
        Difference("drag [1/s]", f"{ours['drag']:g}", f"{body['drag']:g}"),
        Difference("most tilt [rad]", f"{ours['tilt']['limit']:g}", f"{theirs['most_tilt_rad']:g}"),
        Difference(
            "what it is told",
            "a velocity",
            "a tilt, by the controller's own velocity loop; climb and turn rates",
        ),
        Difference(
            "its loops",
            "tum_simulator's, P and D",
            f"the firmware's: attitude {loops['angle']:g} 1/s over rates {loops['rate']:g} 1/s; climb with an integral",
        ),
        Difference("commands under way [s]", "none", f"{theirs['link_delay_s']:g}, and up to a tick of 0.01"),
        Difference(
            "what is seen",
            f"0.05 to 0.15 s late, {day['pixel_noise']:g} px of noise",
            f"motion capture: {1e3 * sight['latency']:g} ms late, {1e3 * sight['noise']:g} mm of noise",
        ),
        Difference("velocities", f"true, {day['motion_noise']:g} m/s of noise", "from poses 40 ms apart"),
        Difference("wind [m/s]", f"up to 0.5, gusts of {day['gust']:g}", _wind(air)),
        Difference("who holds the altitude", "the policy", "the controller, through the net"),
        Difference("UGVs", "unicycles with bounded accelerations", "wheels on a floor, with contacts"),
        Difference(
            "battery", "none", f"empties: rotors lose up to {100 * theirs['sag']:g} % of their thrust"
        ),
    ]


def _wind(air: Mapping[str, Any]) -> str:
    mean = (air["mean"]["x"] ** 2 + air["mean"]["y"] ** 2) ** 0.5
    return f"{mean:.2f}, gusts of {air['gust']:g}"


def _in_order(results: Mapping[str, Any], kind: str) -> dict[str, Any]:
    """What came of the flights of a kind by net, in the order of the settings: on disk names are sorted."""
    nets = results["flights"].get(kind, {})
    return {net: nets[net] for net in results["settings"]["nets"] if net in nets}


def _samples(folder: Path, results: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    for kind in results["flights"]:
        for net in (net for net, one in _in_order(results, kind).items() if one["began"]):
            path = folder / "flights" / f"{kind}-{net}.mcap"
            if not path.is_file():
                raise BadFile(path, "is missing; the page shows one flight of every kind behind every net")
            found.setdefault(kind, {})[net] = read_flight(path)
    return found
