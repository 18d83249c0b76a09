"""Results and sample flights -> figures.

Eight plots, in the order of the page, each with the caption that says what it shows. All are drawn with matplotlib's
objects (no pyplot, no global state but style defaults that are put back), so nothing remains when they are done; matplotlib
is loaded by the first drawing and not before.

**One look per set-up.** `LOOKS` gives every set-up a colour, a dash pattern and a marker, the same in every figure and
beside its name in every table. The hues are those of Okabe and Ito (2008), darkened to a contrast of at least 3:1 on
the page, which colour-blind readers tell apart; dash and marker say the same again without colour.

**One drawing, two themes.** A figure is drawn once, in the light colours. `inline` then replaces each colour of the
SVG by a CSS variable, so that a page may show the same drawing light or dark, and prefixes every id, so that
many drawings fit into one page. Text stays text. The same results give the same bytes.
"""

import io
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fledge.camera import Lens, Picture, look
from fledge.episode import Flight
from fledge.observation import ROW_RATE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Results = Mapping[str, Any]
"""results.json, read."""


@dataclass(frozen=True, slots=True)
class Look:
    """How something looks in every figure and table."""

    light: str
    """Colour on a light page."""
    dark: str
    """The same hue on a dark page."""
    dashes: tuple[float, ...] = ()
    """On and off lengths, in line widths; none for a solid line."""
    marker: str = "o"
    """In matplotlib's letters."""

    @property
    def line(self) -> Any:
        """The dashes as matplotlib's `linestyle`."""
        return (0.0, self.dashes) if self.dashes else "-"


LOOKS = {
    "human-combined": Look("#6a6e73", "#a9aeb5", (3.0, 0.9), "o"),
    "dnn-combined": Look("#c95000", "#f29255", (6.0, 1.6), "s"),
    "primitive-paper": Look("#a6498f", "#dd8dc9", (1.4, 1.0), "^"),
    "primitive": Look("#0068a8", "#5fb0ec", (), "D"),
    "servo": Look("#00795b", "#3fc29c", (6.0, 1.6, 1.2, 1.6), "v"),
    "human-combined-undivided": Look("#7b7264", "#b8ae9d", (1.0, 2.2), "p"),
    "primitive-zero": Look("#4b64c0", "#93a7f2", (4.0, 1.0, 1.0, 1.0), "<"),
    "primitive-matched": Look("#0b84a5", "#4fc1dd", (8.0, 1.4), "h"),
    "dnn-combined-matched": Look("#916400", "#d8a83f", (5.0, 1.2, 1.0, 1.2, 1.0, 1.2), "X"),
    "primitive-paper-10000": Look("#7a3e9d", "#c19be2", (2.2, 2.0), ">"),
    "dnn-combined-10000": Look("#8f3208", "#e79f80", (4.0, 3.0), "d"),
}
"""Of the set-ups."""

STRANGERS = (
    Look("#5b7a00", "#a8cb4b", (7.0, 1.0, 2.0, 1.0), "*"),
    Look("#b0394c", "#ee8f9c", (3.0, 2.0, 1.0, 2.0), "P"),
    Look("#33696b", "#7fbfc1", (9.0, 2.0), "8"),
)
"""Of set-ups that are not ours, in turn."""

PARTS = {
    "fixed-altitude": Look("#7d6d00", "#cbb63f", (), "s"),
    "climb": Look("#007a87", "#4bc2cc", (), "^"),
    "descend": Look("#9a2f57", "#e489a8", (), "v"),
}
"""Of the sub-tasks, in the training curves only."""

INK, MUTED, FAINT, CARD = "#1d2125", "#5d646c", "#d9dce0", "#ffffff"
THEME = {
    "ink": (INK, "#e7e5e0"),
    "muted": (MUTED, "#a2a9b1"),
    "faint": (FAINT, "#3a4047"),
    "card": (CARD, "#1b1f23"),
}
"""Of everything else: (light, dark)."""

FLOWN = ("human-combined", "dnn-combined", "primitive-paper", "primitive")
"""The set-ups whose sample flights are shown, of those that were run."""
COMPARED = (*FLOWN, "servo")
"""The set-ups whose distributions are shown."""
STICK_WINDOW = 20.0
"""[s] of sticks that are shown, in the middle of the flight."""
METRICS = {
    "distance_rmse": ("distance RMSE [px]", 1.0),
    "radius_rmse": ("radius RMSE [px]", 1.0),
    "in_view": ("in view [percentage points]", 100.0),
}
"""What is compared: (name with unit, factor into that unit)."""

WIDTH = 8.0
"""[in] of every figure."""
STYLE = {
    "font.family": ["DejaVu Sans"],  # comes with matplotlib, so every machine lays out alike
    "font.size": 8.5,
    "axes.titlesize": 8.5,
    "axes.labelsize": 8.5,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.fontsize": 8.0,
    "legend.frameon": False,
    "legend.handlelength": 3.2,
    "figure.facecolor": CARD,
    "axes.facecolor": CARD,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": MUTED,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlelocation": "left",
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": FAINT,
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.3,
    "lines.scale_dashes": True,
    "path.simplify": True,
    "svg.fonttype": "none",
    "svg.hashsalt": "fledge",
}
DOTS_PER_INCH = 150


@dataclass(frozen=True, slots=True)
class Plot:
    """A figure and what to say below it."""

    name: str
    """Of its files."""
    title: str
    """What is shown, in a few words."""
    caption: str
    """How to read it: n, units, what an interval covers."""
    figure: "Figure"


def looks(names: Sequence[str]) -> dict[str, Look]:
    """The look of each set-up; strangers get theirs in the order in which they come."""
    strangers = [name for name in names if name not in LOOKS]
    lent = {name: STRANGERS[i % len(STRANGERS)] for i, name in enumerate(strangers)}
    return {name: LOOKS.get(name) or lent[name] for name in names}


def draw(results: Results, flights: Mapping[str, Flight]) -> list[Plot]:
    """All figures that these results have something for.

    Args:
        results: results.json, read.
        flights: a sample flight of each set-up of `FLOWN` that was run, all of the same test case.
    """
    from matplotlib import rc_context

    with rc_context(STYLE):
        return [plot for plot in _plots(results, flights) if plot is not None]


def _plots(results: Results, flights: Mapping[str, Flight]) -> Iterator[Plot | None]:
    yield training(results)
    yield circles(flights, "horizontal")
    yield circles(flights, "vertical")
    yield top_view(flights)
    yield altitude(flights)
    yield distributions(results)
    yield sticks(flights)
    yield forest(results)


def training(results: Results) -> Plot | None:
    """Training and validation loss over epochs, one panel per trained set-up."""
    trained = {name: setup for name, setup in results["setups"].items() if setup["curve"]}
    if not trained:
        return None
    columns = min(len(trained), 4)
    rows = -(-len(trained) // columns)
    figure = _figure(0.5 + 2.0 * rows)
    panels = figure.subplots(rows, columns, sharey=True, squeeze=False).ravel()
    for panel, (name, setup) in zip(panels, trained.items(), strict=False):
        _losses(panel, setup["curve"])
        panel.set_title(name)
    for panel in panels[len(trained) :]:
        panel.set_visible(False)
    for panel in panels[::columns]:
        panel.set_ylabel("mean squared error")
    shown = {name for setup in trained.values() for name in setup["curve"]["training"]}
    _legend(figure, _loss_key(shown))
    seeds = max(setup["seeds"] for setup in trained.values())
    return Plot(
        "training",
        "Training and validation loss",
        "Mean squared error of the stick deflections (full stick = 1) over epochs, logarithmic, for each trained set-up: "
        "over all rows, and over the rows of each sub-task. Solid: training rows; dashed: held-out rows. First training "
        f"seed of {seeds}. Panels share the vertical axis, but a loss that skips what was not demonstrated (mask) and one "
        "that does not (zero fill) are not the same quantity; compare within a panel.",
        figure,
    )


def _losses(panel: "Axes", curve: Mapping[str, Any]) -> None:
    parts = [name for name in curve["training"] if name in PARTS]
    for kind, line in (("training", "-"), ("validation", (0.0, (4.0, 1.5)))):
        for name in [*parts, "all"]:
            colour = PARTS[name].light if name in PARTS else INK
            panel.plot(
                curve["epochs"], curve[kind][name], color=colour, linestyle=line,
                linewidth=0.9 if name in PARTS else 1.5,
                marker=PARTS[name].marker if name in PARTS and kind == "training" else "",
                markersize=3.5, markevery=max(len(curve["epochs"]) // 5, 1),
            )  # fmt: skip
    panel.set_yscale("log")
    panel.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    panel.yaxis.set_minor_formatter(lambda value, _: f"{value:g}" if f"{value:e}"[0] in "25" else "")
    panel.set_xlabel("epoch")
    panel.locator_params(axis="x", nbins=4, integer=True)


def _loss_key(shown: set[str]) -> list[Any]:
    from matplotlib.lines import Line2D

    return [
        Line2D([], [], color=INK, linewidth=1.5, label="all rows, training"),
        Line2D([], [], color=INK, linewidth=1.5, linestyle=(0.0, (4.0, 1.5)), label="all rows, validation"),
        *(
            Line2D([], [], color=part.light, linewidth=0.9, marker=part.marker, markersize=3.5, label=name)
            for name, part in PARTS.items()
            if name in shown
        ),
    ]


def circles(flights: Mapping[str, Flight], axis: str) -> Plot | None:
    """Ideal and actual UGV circle over time on one axis of the image, one panel per set-up."""
    shown = {name: flights[name] for name in FLOWN if name in flights}
    if not shown:
        return None
    figure = _figure(0.6 + 1.25 * len(shown))
    panels = figure.subplots(len(shown), 1, sharex=True, sharey=True, squeeze=False).ravel()
    for panel, (name, flight) in zip(panels, shown.items(), strict=True):
        _circle(panel, flight, LOOKS[name], axis)
        panel.set_title(name)
        panel.set_ylabel("u [px]" if axis == "horizontal" else "v [px]")
    panels[-1].set_xlabel("time [s]")
    if axis == "vertical":
        panels[0].invert_yaxis()
    _legend(figure, _circle_key())
    direction = "u to the right" if axis == "horizontal" else "v downwards, the UAV's nose being up"
    return Plot(
        f"circle-{axis}",
        f"Ideal and actual circle of the UGVs on the image's {axis} axis",
        f"Sample flight: the first Combined test case, the same for every set-up; {direction}. Between the dashed lines: the "
        "ideal circle, about the image centre. Coloured band: the actual one, the UGVs' centre of mass (line) plus and minus "
        "the distance of the farthest UGV. Heavy lines: the image's borders, hatched beyond. Ticks along the top: frames "
        "in which a UGV's centre is out of the picture (on either axis). Computed from exact poses.",
        figure,
    )


def _circle(panel: "Axes", flight: Flight, appearance: Look, axis: str) -> None:
    t, picture = np.asarray(flight.episode.world.t), look(flight.lens, flight.episode.world)
    lens, horizontal = flight.lens, axis == "horizontal"
    size = lens.width_px if horizontal else lens.height_px
    middle, centre = size / 2.0, np.asarray(picture.u if horizontal else picture.v)
    radius = np.asarray(picture.radius)
    for edge in (middle - flight.ideal_radius, middle + flight.ideal_radius):
        panel.axhline(edge, color=INK, linewidth=0.9, linestyle=(0.0, (5.0, 3.0)))
    panel.fill_between(t, centre - radius, centre + radius, color=appearance.light, alpha=0.28, linewidth=0.0)
    for edge in (centre - radius, centre + radius):
        panel.plot(t, edge, color=appearance.light, linewidth=0.6)
    panel.plot(t, centre, color=appearance.light, linewidth=1.3, linestyle=appearance.line)
    for border, beyond in ((0.0, -0.09 * size), (size, 1.09 * size)):
        panel.axhline(border, color=MUTED, linewidth=1.6)
        panel.axhspan(border, beyond, facecolor="none", edgecolor=FAINT, hatch="////", linewidth=0.0)
    panel.set_ylim(-0.09 * size, 1.09 * size)
    panel.set_xlim(t[0], t[-1])
    panel.set_yticks([0.0, middle, size])
    _lost(panel, t, picture)


def _lost(panel: "Axes", t: np.ndarray, picture: Picture) -> None:
    """A rug along the top of the panel where a UGV is out of view."""
    lost = t[~np.asarray(picture.all_in_view, dtype=bool)]
    panel.vlines(lost, 0.94, 1.0, color=INK, linewidth=0.7, transform=panel.get_xaxis_transform())


def _circle_key() -> list[Any]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    return [
        Line2D([], [], color=INK, linewidth=0.9, linestyle=(0.0, (5.0, 3.0)), label="ideal circle"),
        Patch(facecolor=MUTED, alpha=0.28, label="actual circle"),
        Line2D([], [], color=MUTED, label="its centre"),
        Line2D([], [], color=MUTED, linewidth=1.6, label="image border"),
    ]


def top_view(flights: Mapping[str, Flight]) -> Plot | None:
    """Arena, obstacles and tracks from above, one panel per set-up."""
    shown = {name: flights[name] for name in FLOWN if name in flights}
    if not shown:
        return None
    figure = _figure(0.9 + 1.9 * 4.0 / max(len(shown), 3))
    panels = figure.subplots(1, len(shown), sharex=True, sharey=True, squeeze=False).ravel()
    for panel, (name, flight) in zip(panels, shown.items(), strict=True):
        _arena(panel, flight)
        _tracks(panel, flight, LOOKS[name])
        panel.set_title(name)
        panel.set_xlabel("x, east [m]")
    panels[0].set_ylabel("y, north [m]")
    _legend(figure, _top_key())
    return Plot(
        "top-view",
        "The sample flight from above",
        "Thin lines: the three UGVs; coloured: the UAV, from the ring to the filled marker. Grey boxes: obstacles, with their height "
        "in metres; frame: the 10 x 10 m arena's walls. Dotted: what lies in the picture at the end of the flight. "
        "The same test case for every set-up, so the UGVs do the same in all panels.",
        figure,
    )


def _arena(panel: "Axes", flight: Flight) -> None:
    from matplotlib.patches import Rectangle

    walls = flight.arena.bounds
    wide, high = walls.x_max - walls.x_min, walls.y_max - walls.y_min
    panel.add_patch(Rectangle((walls.x_min, walls.y_min), wide, high, fill=False, edgecolor=MUTED, linewidth=1.2))
    for obstacle in flight.arena.obstacles:
        box = obstacle.footprint
        if box.x_min > walls.x_max:  # padding, out of reach
            continue
        sides = (box.x_max - box.x_min, box.y_max - box.y_min)
        panel.add_patch(Rectangle((box.x_min, box.y_min), *sides, facecolor=MUTED, alpha=0.45, linewidth=0.0))
        panel.text(box.x_max + 0.12, (box.y_min + box.y_max) / 2.0, f"{obstacle.height:.1f}", fontsize=6.5, va="center")
    panel.set_xlim(walls.x_min - 0.3, walls.x_max + 0.3)
    panel.set_ylim(walls.y_min - 0.3, walls.y_max + 0.3)
    panel.set_aspect("equal")
    panel.locator_params(nbins=5)


def _tracks(panel: "Axes", flight: Flight, appearance: Look) -> None:
    world = flight.episode.world
    for ugv in world.ugvs:
        panel.plot(ugv.x, ugv.y, color=MUTED, linewidth=0.6)
        panel.plot(ugv.x[-1:], ugv.y[-1:], color=MUTED, marker="o", markersize=2.5)
    x, y = np.asarray(world.uav.position.x), np.asarray(world.uav.position.y)
    panel.plot(x, y, color=appearance.light, linewidth=1.2)
    panel.plot(x[:1], y[:1], color=appearance.light, marker="o", markersize=5.0, markerfacecolor=CARD)
    panel.plot(x[-1:], y[-1:], color=appearance.light, marker=appearance.marker, markersize=5.0)
    if flight.lens.levelled:
        corners = _footprint(flight.lens, flight)
        panel.plot(*corners, color=appearance.light, linewidth=0.9, linestyle=":")


def _footprint(lens: Lens, flight: Flight) -> tuple[np.ndarray, np.ndarray]:
    """(x, y) of the corners of what a levelled lens sees of the floor in the last row, closed [m]."""
    uav = flight.episode.world.uav
    nose = uav.attitude.heading()
    c, s = float(np.asarray(nose.cos)[-1]), float(np.asarray(nose.sin)[-1])
    metres = float(np.asarray(uav.position.z)[-1]) / lens.focal_px
    ahead = np.array([1.0, 1.0, -1.0, -1.0, 1.0]) * metres * lens.height_px / 2.0
    aside = np.array([1.0, -1.0, -1.0, 1.0, 1.0]) * metres * lens.width_px / 2.0
    x, y = float(np.asarray(uav.position.x)[-1]), float(np.asarray(uav.position.y)[-1])
    return x + c * ahead - s * aside, y + s * ahead + c * aside


def _top_key() -> list[Any]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    return [
        Line2D([], [], color=INK, linewidth=1.2, label="UAV"),
        Line2D([], [], color=MUTED, linewidth=0.6, marker="o", markersize=2.5, markevery=[1], label="UGVs"),
        Patch(facecolor=MUTED, alpha=0.45, label="obstacle, height [m]"),
        Line2D([], [], color=INK, linewidth=0.9, linestyle=":", label="picture at the end"),
    ]


def altitude(flights: Mapping[str, Flight]) -> Plot | None:
    """Altitude over time, and the ideal one."""
    shown = {name: flights[name] for name in FLOWN if name in flights}
    if not shown:
        return None
    figure = _figure(2.7)
    panel = figure.subplots()
    one = next(iter(shown.values()))
    t = np.asarray(one.episode.world.t)
    panel.plot(t, ideal_altitude(one), color=INK, linewidth=3.0, alpha=0.25, solid_capstyle="butt", label="ideal")
    for name, flight in shown.items():
        z = np.asarray(flight.episode.world.uav.position.z)
        panel.plot(t, z, color=LOOKS[name].light, linestyle=LOOKS[name].line, label=name)
    panel.set_xlim(t[0], t[-1])
    panel.set_xlabel("time [s]")
    panel.set_ylabel("altitude [m]")
    _legend(figure, panel.get_legend_handles_labels()[0])
    return Plot(
        "altitude",
        "Altitude over time in the sample flight",
        "Broad line: the ideal altitude f s / r, at which the UGVs, the farthest of them s metres from their centre, would appear "
        f"with the ideal radius of r = {one.ideal_radius:g} px through a lens of f = {one.lens.focal_px:g} px. "
        "The same flight as above.",
        figure,
    )


def ideal_altitude(flight: Flight) -> np.ndarray:
    """Where the radius would be ideal for the UGVs as they stand, shape (rows,) [m]."""
    ugvs = flight.episode.world.ugvs
    x, y = (np.array([getattr(ugv, name) for ugv in ugvs], dtype=float) for name in ("x", "y"))
    spread = np.hypot(x - x.mean(axis=0), y - y.mean(axis=0)).max(axis=0)
    return flight.lens.focal_px * spread / flight.ideal_radius


def distributions(results: Results) -> Plot | None:
    """Both errors over flights, as empirical distribution functions."""
    shown = {name: results["setups"][name] for name in COMPARED if name in results["setups"]}
    if not shown:
        return None
    figure = _figure(3.2)
    for panel, metric in zip(figure.subplots(1, 2, sharey=True), ("distance_rmse", "radius_rmse"), strict=True):
        for name, setup in shown.items():
            _ecdf(panel, np.ravel(setup["scores"][metric]), LOOKS[name], name)
        panel.set_xscale("log")
        panel.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        panel.xaxis.set_minor_formatter(lambda value, _: f"{value:g}" if f"{value:e}"[0] in "235" else "")
        panel.set_xlabel(METRICS[metric][0])
        panel.set_ylim(0.0, 1.0)
    figure.axes[0].set_ylabel("share of flights")
    _legend(figure, figure.axes[0].get_legend_handles_labels()[0])
    counts = "; ".join(f"{name} {setup['flights']}" for name, setup in shown.items())
    return Plot(
        "distributions",
        "Errors over flights",
        "Empirical distribution functions: the share of Combined test flights with at most this error; further left is better, "
        f"the marker stands at the median. Logarithmic. Flights, all training seeds pooled: {counts}.",
        figure,
    )


def _ecdf(panel: "Axes", values: np.ndarray, appearance: Look, name: str) -> None:
    ordered = np.sort(values)
    share = np.arange(1, len(ordered) + 1) / len(ordered)
    keep = np.unique(np.linspace(0, len(ordered) - 1, 400).astype(int))
    panel.plot(
        ordered[keep], share[keep], color=appearance.light, linestyle=appearance.line, drawstyle="steps-post",
        marker=appearance.marker, markersize=5.0, markevery=[len(keep) // 2], label=name,
    )  # fmt: skip


def sticks(flights: Mapping[str, Flight]) -> Plot | None:
    """Sticks over time: operator against ABS-DL."""
    shown = {name: flights[name] for name in ("human-combined", "primitive") if name in flights}
    if not shown:
        return None
    figure = _figure(3.9)
    axes = ("forward", "left", "up")
    panels = figure.subplots(len(axes), 1, sharex=True, sharey=True)
    for panel, axis in zip(panels, axes, strict=True):
        for name, flight in shown.items():
            rows = _middle(flight)
            t = np.asarray(flight.episode.world.t)[rows]
            panel.plot(
                t, np.asarray(getattr(flight.episode.action, axis))[rows], color=LOOKS[name].light,
                linestyle=LOOKS[name].line, linewidth=1.1, drawstyle="steps-post", label=name,
            )  # fmt: skip
            panel.set_xlim(t[0], t[-1])
        panel.axhline(0.0, color=MUTED, linewidth=0.6)
        panel.set_ylabel(axis)
    panels[-1].set_xlabel("time [s]")
    _legend(figure, panels[0].get_legend_handles_labels()[0])
    return Plot(
        "sticks",
        "The sticks: operator and ABS-DL",
        f"Stick deflections (full stick = 1) over the middle {STICK_WINDOW:g} s of the sample flight, each held for one row of "
        f"{1.0 / ROW_RATE:g} s. Smoothness in the tables is the mean absolute change of these per second, over whole flights.",
        figure,
    )


def _middle(flight: Flight) -> slice:
    window = min(round(STICK_WINDOW * ROW_RATE) + 1, flight.rows)
    start = (flight.rows - window) // 2
    return slice(start, start + window)


def forest(results: Results) -> Plot | None:
    """The primary comparisons with their intervals."""
    primary = [one for one in results["comparisons"] if one["family"] == "primary"]
    if not primary:
        return None
    pairs = list(dict.fromkeys((one["a"], one["b"]) for one in primary))
    metrics = [metric for metric in METRICS if metric in {one["metric"] for one in primary}]
    appearance = looks(list(results["setups"]))
    figure = _figure(1.2 + 0.38 * len(pairs))
    panels = figure.subplots(1, len(metrics), sharey=True, squeeze=False).ravel()
    for panel, metric in zip(panels, metrics, strict=True):
        for one in (one for one in primary if one["metric"] == metric):
            row = pairs.index((one["a"], one["b"]))
            _whisker(panel, row, one, METRICS[metric][1], appearance[one["a"]])
        _forest_axes(panel, METRICS[metric][0], better="right" if metric == "in_view" else "left")
    panels[0].set_yticks(range(len(pairs)), [f"{a} \N{MINUS SIGN} {b}" for a, b in pairs])
    panels[0].set_ylim(len(pairs) - 0.5, -0.5)
    units = sorted({one["units"] for one in primary})
    return Plot(
        "comparisons",
        "The primary comparisons",
        "Differences of means over paired Combined test flights, with 95 % bootstrap intervals over training seeds and test cases; "
        f"not adjusted for the number of comparisons. What they cover: {'; '.join(units)}.",
        figure,
    )


def _whisker(panel: "Axes", row: int, one: Mapping[str, Any], factor: float, appearance: Look) -> None:
    low, high = (factor * edge for edge in one["interval"])
    panel.hlines(row, low, high, color=appearance.light, linewidth=2.2)
    panel.plot(factor * one["difference"], row, color=appearance.light, marker=appearance.marker, markersize=6.5)


def _forest_axes(panel: "Axes", name: str, better: str) -> None:
    panel.axvline(0.0, color=INK, linewidth=0.9)
    panel.grid(visible=False, axis="y")
    panel.margins(x=0.15)
    panel.set_xlabel(f"difference in {name}")
    panel.set_title("\N{LEFTWARDS ARROW} the first is better" if better == "left" else "the first is better \N{RIGHTWARDS ARROW}")
    panel.tick_params(axis="y", length=0.0)


def _figure(height: float) -> "Figure":
    from matplotlib.figure import Figure

    return Figure(figsize=(WIDTH, height), layout="constrained")


def _legend(figure: "Figure", handles: Sequence[Any]) -> None:
    figure.legend(handles=list(handles), loc="outside lower center", ncols=len(handles), columnspacing=1.8)


# Bytes


def to_png(figure: "Figure") -> bytes:
    """The figure as PNG, on the light page."""
    from matplotlib import rc_context

    file = io.BytesIO()
    with rc_context(STYLE):
        figure.savefig(file, format="png", dpi=DOTS_PER_INCH, metadata={"Software": None})
    return file.getvalue()


def to_svg(figure: "Figure") -> str:
    """The figure as an SVG document, on the light page."""
    from matplotlib import rc_context

    file = io.StringIO()
    nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
    with rc_context(STYLE):
        figure.savefig(file, format="svg", metadata=nothing)
    return file.getvalue()


def inline(svg: str, name: str, title: str) -> str:
    """An SVG document as an element of a page: themed by CSS variables, with ids of its own, as wide as its place."""
    box = re.search(r'viewBox="[^"]+"', svg)
    assert box
    body = svg[svg.index(">", svg.index("<svg")) + 1 :]
    body = re.sub(r"<style.*?</style>|<metadata.*?</metadata>|<!--.*?-->", "", body, flags=re.DOTALL)
    body = re.sub(r'\bid="', f'id="{name}-', body)
    body = re.sub(r'xlink:href="#', f'href="#{name}-', body)
    body = re.sub(r"url\(#", f"url(#{name}-", body)
    for colour, variable in variables().items():
        body = body.replace(colour, f"var({variable})")
    return f'<svg {box[0]} role="img" aria-label="{title}">{body}'


def variables() -> dict[str, str]:
    """Every colour of the light page and the CSS variable that stands for it."""
    return {light: f"--{name}" for name, (light, _) in palette().items()}


def palette() -> dict[str, tuple[str, str]]:
    """(light, dark) of every colour, by name."""
    strangers = {f"stranger-{i}": look for i, look in enumerate(STRANGERS)}
    known = {**LOOKS, **PARTS, **strangers}
    return THEME | {name: (look.light, look.dark) for name, look in known.items()}


def swatch(appearance: Look) -> str:
    """A small sample of line and marker, as an element of a page."""
    from matplotlib.markers import MarkerStyle

    style = MarkerStyle(appearance.marker)
    path = style.get_path().transformed(style.get_transform())
    outline = "".join(
        "M" + "L".join(f"{16.0 + 7.0 * x:.1f},{6.0 - 7.0 * y:.1f}" for x, y in polygon) + "Z"
        for polygon in path.to_polygons()
    )
    colour = f"var({variables()[appearance.light]})"
    dashes = " ".join(f"{1.6 * length:g}" for length in appearance.dashes)
    return (
        f'<svg class="swatch" viewBox="0 0 32 12" aria-hidden="true"><path d="M0,6H32" stroke="{colour}" '
        f'stroke-width="1.6" stroke-dasharray="{dashes or "none"}"/><path d="{outline}" fill="{colour}"/></svg>'
    )
