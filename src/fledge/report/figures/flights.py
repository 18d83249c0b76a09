"""Sample flights -> figures: what the camera saw, the ways from above, altitude and sticks."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from fledge.camera import look
from fledge.episode import Flight
from fledge.observation import ROW_RATE
from fledge.report.figures import sheet
from fledge.report.figures.looks import CARD, DUEL, FAINT, INK, LOOKS, MUTED, Look
from fledge.world import Obstacle

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Flights = Mapping[str, Flight]
"""A sample flight by set-up, all of the same test case."""

STICK_WINDOW = 20.0
"""[s] of sticks, in the middle of the flight."""
IDEAL = (0.0, (5.0, 3.0))
"""Dashes of what should be, in every panel."""


def circles(flights: Flights, axis: str) -> "Figure":
    """Ideal and actual UGV circle over time on one axis of the image, one panel per set-up."""
    figure, panels = sheet.panels(len(flights), 1, 0.92, apart=(0.0, 0.3), sharex=True, sharey=True)
    for panel, (name, flight) in zip(panels, flights.items(), strict=True):
        draw_circle(panel, flight, LOOKS[name], axis)
        panel.set(title=name, ylabel="u [px]" if axis == "horizontal" else "v [px]")
        panel.spines["bottom"].set_visible(False)
        panel.tick_params(axis="x", length=0.0)
    panels[-1].set_xlabel("time [s]")
    if axis == "vertical":
        panels[0].invert_yaxis()
    sheet.legend(
        figure,
        sheet.line("ideal circle", color=INK, linewidth=0.9, linestyle=IDEAL),
        sheet.patch("actual circle", facecolor=MUTED, alpha=0.28),
        sheet.line("its centre", color=MUTED),
        sheet.line("image border", color=MUTED, linewidth=1.6),
    )
    return figure


def draw_circle(panel: "Axes", flight: Flight, how: Look, axis: str) -> None:
    """The UGVs' circle over time on one image axis, and where it should be [px]."""
    t, picture = np.asarray(flight.episode.world.t), look(flight.lens, flight.episode.world)
    horizontal = axis == "horizontal"
    size = flight.lens.width_px if horizontal else flight.lens.height_px
    some = slice(None, None, 3)  # every third row: closer together than the eye can tell
    centre, radius = (np.asarray(of)[some] for of in (picture.u if horizontal else picture.v, picture.radius))
    low, high = centre - radius, centre + radius
    panel.fill_between(t[some], low, high, color=how.light, alpha=0.28, linewidth=0.0)
    panel.plot(t[some], np.stack([low, high], axis=1), color=how.light, linewidth=0.6)
    panel.plot(t[some], centre, color=how.light, linestyle=how.line)
    for edge in (size / 2.0 - flight.ideal_radius, size / 2.0 + flight.ideal_radius):
        panel.axhline(edge, color=INK, linewidth=0.9, linestyle=IDEAL)
    for border, beyond in ((0.0, -0.09 * size), (size, 1.09 * size)):
        panel.axhline(border, color=MUTED, linewidth=1.6)
        panel.axhspan(border, beyond, facecolor="none", edgecolor=FAINT, hatch="////", linewidth=0.0)
    lost = t[~np.asarray(picture.all_in_view, dtype=bool)]
    panel.vlines(lost, 0.9, 1.0, color=INK, linewidth=0.8, transform=panel.get_xaxis_transform())
    panel.set(xlim=sheet.seconds(t), ylim=(-0.09 * size, 1.09 * size), yticks=[0.0, size / 2.0, size])


def top_view(flights: Flights) -> "Figure":
    """Obstacles and tracks from above, one panel per set-up."""
    xlim, ylim = _frame(list(flights.values()))
    columns = min(len(flights), 2)
    height = (sheet.WIDTH - 1.0) / 2.0 * (ylim[1] - ylim[0]) / (xlim[1] - xlim[0])
    shared = {"sharex": True, "sharey": True}
    figure, panels = sheet.panels(-(-len(flights) // columns), columns, height, apart=(0.12, 0.32), **shared)
    for panel, (name, flight) in zip(panels, flights.items(), strict=False):
        draw_arena(panel, flight)
        draw_tracks(panel, flight, LOOKS[name])
        panel.set(title=name, xlim=xlim, ylim=ylim, aspect="equal")
        panel.locator_params(nbins=6, integer=True)
    for panel in panels[len(flights) :]:
        panel.set_visible(False)
    for panel in panels[::columns]:
        panel.set_ylabel("y, north [m]")
    for panel in panels[-columns:]:
        panel.set_xlabel("x, east [m]")
    sheet.legend(
        figure,
        sheet.line("UAV, from the ring to the marker", color=INK),
        sheet.line("UGVs, to the dot", color=MUTED, linewidth=0.6),
        sheet.patch("obstacle, height [m]", facecolor=MUTED, alpha=0.45),
    )
    return figure


def draw_arena(panel: "Axes", flight: Flight) -> None:
    """Walls, and boxes with their heights [m]."""
    from matplotlib.patches import Rectangle

    walls = {"fill": False, "edgecolor": MUTED, "linewidth": 1.6}
    solid = {"facecolor": MUTED, "alpha": 0.45, "linewidth": 0.0}
    boxes = [(flight.arena.bounds, walls)]
    for obstacle in _obstacles(flight):
        box = obstacle.footprint
        boxes.append((box, solid))
        middle = (box.x_min + box.x_max) / 2.0
        text = f"{obstacle.height:.1f}"
        panel.text(middle, box.y_max + 0.04, text, fontsize=7.0, ha="center", va="bottom", clip_on=True)
    for box, style in boxes:
        panel.add_patch(
            Rectangle((box.x_min, box.y_min), box.x_max - box.x_min, box.y_max - box.y_min, **style)
        )


def _obstacles(flight: Flight) -> list[Obstacle]:
    """Without those that only pad the arena, out of reach."""
    return [one for one in flight.arena.obstacles if one.footprint.x_min < flight.arena.bounds.x_max]


def draw_tracks(panel: "Axes", flight: Flight, how: Look) -> None:
    """The ways of UAV and UGVs, seen from above."""
    world = flight.episode.world
    some = slice(None, None, 5)
    for ugv in world.ugvs:
        panel.plot(ugv.x[some], ugv.y[some], color=MUTED, linewidth=0.6)
        panel.plot(ugv.x[-1:], ugv.y[-1:], color=MUTED, marker="o", markersize=2.5)
    x, y = np.asarray(world.uav.position.x), np.asarray(world.uav.position.y)
    panel.plot(x[some], y[some], color=how.light)
    panel.plot(x[:1], y[:1], color=how.light, marker="o", markersize=5.0, markerfacecolor=CARD)
    panel.plot(x[-1:], y[-1:], color=how.light, marker=how.marker, markersize=5.5)


def _frame(flights: Sequence[Flight]) -> list[tuple[float, float]]:
    """Limits along x and y that hold every track and obstacle: at most twice as wide as high, never higher."""
    sides = []
    for name in ("x", "y"):
        worlds = [flight.episode.world for flight in flights]
        tracks = [
            np.asarray(getattr(body, name)) for world in worlds for body in (world.uav.position, *world.ugvs)
        ]
        boxes = [obstacle.footprint for obstacle in _obstacles(flights[0])]
        edges = [getattr(box, f"{name}_{side}") for box in boxes for side in ("min", "max")]
        reached = np.concatenate([*tracks, edges])
        sides.append((float(reached.min() + reached.max()) / 2.0, float(np.ptp(reached)) / 2.0 + 0.3))
    (x, half_x), (y, half_y) = sides
    half_x = max(half_x, half_y)
    half_y = max(half_y, half_x / 2.0)
    return [(x - half_x, x + half_x), (y - half_y, y + half_y)]


def altitude(flights: Flights) -> "Figure":
    """Altitude over time, and the ideal one."""
    figure, (panel,) = sheet.panels(1, 1, 1.9, above=0.1)
    one = next(iter(flights.values()))
    t = np.asarray(one.episode.world.t)
    panel.plot(t[::3], ideal_altitude(one)[::3], color=INK, linewidth=3.2, alpha=0.25, label="ideal")
    for name, flight in flights.items():
        z = np.asarray(flight.episode.world.uav.position.z)
        panel.plot(t[::3], z[::3], color=LOOKS[name].light, linestyle=LOOKS[name].line, label=name)
    panel.set(xlim=sheet.seconds(t), xlabel="time [s]", ylabel="altitude [m]")
    sheet.legend(figure, *panel.get_legend_handles_labels()[0])
    return figure


def ideal_altitude(flight: Flight) -> np.ndarray:
    """Where the radius would be ideal for the UGVs as they stand, f spread / ideal radius; shape (rows,) [m]."""
    ugvs = flight.episode.world.ugvs
    x, y = (np.array([getattr(ugv, name) for ugv in ugvs], dtype=float) for name in ("x", "y"))
    spread = np.hypot(x - x.mean(axis=0), y - y.mean(axis=0)).max(axis=0)
    return flight.lens.focal_px * spread / flight.ideal_radius


def sticks(flights: Flights) -> "Figure":
    """Sticks over time: operator against ABS-DL."""
    axes = ("forward", "left", "up")
    figure, panels = sheet.panels(len(axes), 1, 0.95, above=0.1, apart=(0.0, 0.12), sharex=True, sharey=True)
    for panel, axis in zip(panels, axes, strict=True):
        panel.axhline(0.0, color=MUTED, linewidth=0.6)
        for name in (name for name in DUEL if name in flights):
            rows = _middle(flights[name])
            t, stick = (
                np.asarray(of)[rows]
                for of in (flights[name].episode.world.t, getattr(flights[name].episode.action, axis))
            )
            style = {"color": LOOKS[name].light, "linestyle": LOOKS[name].line, "linewidth": 1.1}
            panel.plot(t, stick, drawstyle="steps-post", label=name, **style)
            panel.set(xlim=sheet.seconds(t), ylabel=axis, ylim=(-1.05, 1.05))
    panels[-1].set_xlabel("time [s]")
    panels[-1].locator_params(axis="x", steps=[1, 2, 5, 10])
    sheet.legend(figure, *panels[0].get_legend_handles_labels()[0])
    return figure


def _middle(flight: Flight) -> slice:
    window = min(round(STICK_WINDOW * ROW_RATE), flight.rows)
    start = (flight.rows - window) // 2
    return slice(start, start + window)
