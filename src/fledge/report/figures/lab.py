"""Flights of the physical experiment -> figures: the paper's last one, what nets do to a flight gone wrong, the gap."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from fledge.episode import Flight
from fledge.report.figures import sheet
from fledge.report.figures.flights import IDEAL, draw_arena, draw_circle, draw_tracks
from fledge.report.figures.looks import CARD, INK, MUTED, NETS, STRANGERS, Look
from fledge.report.figures.plots import Plot
from fledge.report.figures.results import ecdf
from fledge.study.metrics import ERRORS, METRICS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Flown = Mapping[str, Mapping[str, Flight]]
"""Sample flights by kind and net."""
TELLING = 0.25
"""[m] beyond the walls that is shown of a room."""
TWIN, SIMULATOR = NETS["stop-tube"], NETS["none"]
"""Looks of the two sides of the gap."""


def draw(results: Mapping[str, Any], flown: Flown) -> list[Plot]:
    """All figures that there is something for, in the order of the page."""
    from matplotlib import rc_context

    with rc_context(sheet.STYLE):
        return list(_plots(results, flown))


def _plots(results: Mapping[str, Any], flown: Flown) -> Iterator[Plot]:
    if flown.get("lab"):
        net, flight = next(iter(flown["lab"].items()))
        yield Plot("physical", "UAV and UGVs in the lab", physical(flight, look_of(net)))
    if flown.get("reversed"):
        yield Plot("reversed", "With both sticks reversed", rooms(flown["reversed"]))
    if results.get("transfer"):
        yield Plot("transfer", "Simulator and twin", gap(results["transfer"]))


def look_of(net: str) -> Look:
    """How a net looks, ours or not."""
    return NETS.get(net, STRANGERS[0])


def physical(flight: Flight, how: Look) -> "Figure":
    """The paper's last figure: real positions in the plane, and the UGVs' circle on both axes of the image."""
    figure, (room, across, down) = sheet.beside(3.9, 2.95, above=0.28)
    draw_room(room, flight, how)
    room.set_title("real positions")
    for panel, axis, name in ((across, "horizontal", "u [px]"), (down, "vertical", "v [px]")):
        draw_circle(panel, flight, how, axis)
        panel.set(title=f"{axis} image", ylabel=name)
    down.invert_yaxis()
    down.set_xlabel("time [s]")
    across.tick_params(labelbottom=False)
    sheet.legend(
        figure,
        sheet.line("UAV; centre of the UGVs", color=how.light),
        sheet.line("UGVs", color=MUTED, linewidth=0.9),
        sheet.line("ideal circle", color=INK, linewidth=0.9, linestyle=IDEAL),
        sheet.patch("actual circle", facecolor=how.light, alpha=0.28),
        sheet.line("safe area, image border", color=MUTED, linewidth=1.6),
    )
    return figure


def rooms(flights: Mapping[str, Flight]) -> "Figure":
    """The same flight behind every net, from above, one panel each."""
    columns = min(len(flights), 3)
    width = (sheet.WIDTH - 0.62 - sheet.RIGHT - 0.12 * (columns - 1)) / columns
    bounds = next(iter(flights.values())).arena.bounds
    height = width * (bounds.y_max - bounds.y_min + 2 * TELLING) / (bounds.x_max - bounds.x_min + 2 * TELLING)
    shared = {"sharex": True, "sharey": True}
    figure, panels = sheet.panels(-(-len(flights) // columns), columns, height, apart=(0.12, 0.3), **shared)
    for panel, (net, flight) in zip(panels, flights.items(), strict=False):
        draw_room(panel, flight, look_of(net))
        panel.set(title=net, ylabel="")
    for panel in panels[len(flights) :]:
        panel.set_visible(False)
    for panel in panels[::columns]:
        panel.set_ylabel("y [m]")
    sheet.legend(
        figure,
        sheet.line("UAV, from the ring to the marker", color=INK),
        sheet.line("UGVs", color=MUTED, linewidth=0.9),
        sheet.line("safe area", color=MUTED, linewidth=1.6),
    )
    return figure


def draw_room(panel: "Axes", flight: Flight, how: Look) -> None:
    """The safe area from above, and who moved how in it; who left it is cut off, with an arrow where."""
    draw_arena(panel, flight)
    draw_tracks(panel, flight, how)
    b = flight.arena.bounds
    panel.set(
        xlim=(b.x_min - TELLING, b.x_max + TELLING), ylim=(b.y_min - TELLING, b.y_max + TELLING),
        xlabel="x [m]", ylabel="y [m]", aspect="equal",
    )  # fmt: skip
    panel.locator_params(nbins=7, integer=True)
    _mark_exit(panel, flight, how)


def _mark_exit(panel: "Axes", flight: Flight, how: Look) -> None:
    """Where the UAV leaves what is shown, if it does."""
    b, p = flight.arena.bounds, flight.episode.world.uav.position
    x, y = np.asarray(p.x), np.asarray(p.y)
    wide, high = 0.9 * TELLING, 0.9 * TELLING
    out = (x < b.x_min - wide) | (x > b.x_max + wide) | (y < b.y_min - high) | (y > b.y_max + high)
    if not out.any():
        return
    i = int(np.argmax(out))
    before = max(i - 12, 0)
    style = {"arrowstyle": "-|>", "color": how.light, "linewidth": 1.3, "shrinkA": 0.0, "shrinkB": 0.0}
    panel.annotate("", (x[i], y[i]), (x[before], y[before]), arrowprops=style | {"mutation_scale": 12.0})
    far = max(float(np.abs(x).max()) - b.x_max, float(np.abs(y).max()) - b.y_max)
    panel.text(
        0.5 * (b.x_min + b.x_max), b.y_max - 0.15, f"out of the room, by {far:.0f} m", fontsize=8.0,
        ha="center", va="top", color=INK, bbox={"facecolor": CARD, "edgecolor": "none", "pad": 1.5},
    )  # fmt: skip


def gap(found: Mapping[str, Any]) -> "Figure":
    """Both errors over flights, in the simulator and in the twin, as empirical distribution functions."""
    figure, panels = sheet.panels(1, 2, 2.1, above=0.1, apart=(0.1, 0.0), sharey=True)
    for panel, metric in zip(panels, ERRORS, strict=True):
        for name, how in (("simulator", SIMULATOR), ("twin", TWIN)):
            ecdf(panel, np.array(found[name]["scores"][metric]["flights"]), how, name)
        panel.set(xlabel=METRICS[metric].head(), ylim=(0.0, 1.0))
        panel.set_xlim(left=0.0)
    panels[0].set_ylabel("share of flights")
    sheet.legend(figure, *panels[0].get_legend_handles_labels()[0])
    return figure
