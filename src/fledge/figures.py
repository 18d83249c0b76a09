"""Results and sample flights -> figures.

Eight plots, in the order of the page; the captions stand there. All are drawn with matplotlib's objects: no pyplot, no
state but style defaults that are put back. The first drawing loads matplotlib, not the import of this module.

**One look per set-up.** `LOOKS` gives every set-up a colour, a dash pattern and a marker, the same in every figure and
beside its name in every table. The hues are those of Okabe and Ito (2008), which colour-blind readers tell apart,
darkened to a contrast of at least 3:1 with the page; dash and marker say the same again without colour.

**One drawing, two themes.** A figure is drawn once, in the light colours. `inline` makes an element of a page of it:
every colour becomes a CSS variable, so that the same drawing shows on a light or a dark page, and every id gets the
figure's name, so that many fit into one page. Text stays text. The same results give the same bytes.
"""

import io
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fledge.camera import look
from fledge.episode import Flight
from fledge.metrics import ERRORS, METRICS
from fledge.observation import ROW_RATE
from fledge.world import Obstacle

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Results = Mapping[str, Any]
"""What results.json holds."""
Flights = Mapping[str, Flight]
"""A sample flight by set-up, all of the same test case."""


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
    "human-combined": Look("#7b8087", "#aab0b8", (3.0, 0.9), "o"),
    "dnn-combined": Look("#c95000", "#f29255", (6.0, 1.6), "s"),
    "primitive-paper": Look("#a6498f", "#dd8dc9", (1.4, 1.0), "^"),
    "primitive": Look("#0068a8", "#5fb0ec", (), "D"),
    "servo": Look("#006e52", "#3fc29c", (6.0, 1.6, 1.2, 1.6), "v"),
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
    "fixed-altitude": Look("#7d6d00", "#cbb63f", marker="s"),
    "climb": Look("#007a87", "#4bc2cc", marker="^"),
    "descend": Look("#9a2f57", "#e489a8", marker="v"),
}
"""Of the sub-tasks, in the training curves."""

INK, MUTED, FAINT, CARD = "#1d2125", "#5d646c", "#d9dce0", "#ffffff"
PAGE = {
    "ink": (INK, "#e7e5e0"),
    "muted": (MUTED, "#a2a9b1"),
    "faint": (FAINT, "#3a4047"),
    "card": (CARD, "#1b1f23"),
}
"""(light, dark) of everything else."""

FLOWN = ("human-combined", "dnn-combined", "primitive-paper", "primitive")
"""The set-ups whose sample flights are shown, of those that were run."""
COMPARED = (*FLOWN, "servo")
"""The set-ups whose distributions are shown, likewise."""
DUEL = ("human-combined", "primitive")
"""The set-ups whose sticks are shown, likewise."""
STICK_WINDOW = 20.0
"""[s] of sticks, in the middle of the flight."""
WIDTH, RIGHT = 8.0, 0.12
"""[in] of every figure, and what stays free on its right."""
DOTS_PER_INCH = 150
QUICKLY = {"compress_level": 3}
"""For PNG: a tenth more bytes in half the time."""
VALIDATION = (0.0, (4.0, 1.5))
IDEAL = (0.0, (5.0, 3.0))
"""Dashes that mean the same in every panel."""
STYLE: dict[Any, Any] = {
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
    "hatch.linewidth": 0.6,
    "lines.linewidth": 1.3,
    "svg.fonttype": "none",
    "svg.hashsalt": "fledge",
}


@dataclass(frozen=True, slots=True)
class Plot:
    """A figure and its name."""

    name: str
    """Of its files."""
    title: str
    """What is shown, in a few words."""
    figure: "Figure"


def looks(names: Sequence[str]) -> dict[str, Look]:
    """The look of each set-up, ours first; strangers get theirs in the order in which they come."""
    strangers = [name for name in names if name not in LOOKS]
    lent = {name: STRANGERS[i % len(STRANGERS)] for i, name in enumerate(strangers)}
    return {name: how for name, how in LOOKS.items() if name in names} | lent


def draw(results: Results, flights: Flights) -> list[Plot]:
    """All figures that there is something for, in the order of the page."""
    from matplotlib import rc_context

    with rc_context(STYLE):
        return list(_plots(results, {name: flights[name] for name in FLOWN if name in flights}))


def _plots(results: Results, flights: Flights) -> Iterator[Plot]:
    if any(setup["curve"] for setup in results["setups"].values()):
        yield Plot("training", "Training and validation loss", training(results))
    if flights:
        title = (
            "Ideal and actual circle of the UGVs on the image\N{RIGHT SINGLE QUOTATION MARK}s {} axis".format
        )
        yield Plot("circle-horizontal", title("horizontal"), circles(flights, "horizontal"))
        yield Plot("circle-vertical", title("vertical"), circles(flights, "vertical"))
        yield Plot("top-view", "The sample flight from above", top_view(flights))
        yield Plot("altitude", "Altitude in the sample flight", altitude(flights))
    if set(COMPARED) & set(results["setups"]):
        yield Plot("distributions", "Errors over flights", distributions(results))
    if set(DUEL) & set(flights):
        yield Plot("sticks", "The sticks: operator and ABS-DL", sticks(flights))
    if any(one["family"] == "primary" for one in results["comparisons"]):
        yield Plot("comparisons", "The primary comparisons", forest(results))


def training(results: Results) -> "Figure":
    """Training and validation loss over epochs, one panel per trained set-up."""
    setups = results["setups"]
    trained = {name: setups[name]["curve"] for name in looks(list(setups)) if setups[name]["curve"]}
    columns = min(len(trained), 4)
    figure, panels = _panels(-(-len(trained) // columns), columns, 1.6, apart=(0.12, 0.74), sharey=True)
    for panel, (name, curve) in zip(panels, trained.items(), strict=False):
        _losses(panel, curve)
        panel.set(title=name, xlabel="epoch")
    for panel in panels[len(trained) :]:
        panel.set_visible(False)
    for panel in panels[::columns]:
        panel.set_ylabel("mean squared error")
    shown = [part for part in PARTS if any(part in curve["training"] for curve in trained.values())]
    thin = {"linewidth": 0.9, "markersize": 3.5}
    _legend(
        figure,
        _line("all rows, training", color=INK, linewidth=1.5),
        _line("all rows, validation", color=INK, linewidth=1.5, linestyle=VALIDATION),
        *(_line(part, color=PARTS[part].light, marker=PARTS[part].marker, **thin) for part in shown),
    )
    return figure


def _losses(panel: "Axes", curve: Mapping[str, Any]) -> None:
    every = max(len(curve["epochs"]) // 5, 1)
    for kind, line in (("validation", VALIDATION), ("training", "-")):
        for name, how in PARTS.items():
            if name in curve[kind]:
                marker = how.marker if kind == "training" else ""
                style = {
                    "color": how.light,
                    "linestyle": line,
                    "linewidth": 0.9,
                    "marker": marker,
                    "markersize": 3.5,
                }
                panel.plot(curve["epochs"], curve[kind][name], markevery=every, **style)
        panel.plot(curve["epochs"], curve[kind]["all"], color=INK, linestyle=line, linewidth=1.5)
    _logarithmic(panel, "y", (1.0, 2.0, 5.0))
    panel.locator_params(axis="x", nbins=4, integer=True)


def circles(flights: Flights, axis: str) -> "Figure":
    """Ideal and actual UGV circle over time on one axis of the image, one panel per set-up."""
    figure, panels = _panels(len(flights), 1, 0.92, apart=(0.0, 0.3), sharex=True, sharey=True)
    for panel, (name, flight) in zip(panels, flights.items(), strict=True):
        draw_circle(panel, flight, LOOKS[name], axis)
        panel.set(title=name, ylabel="u [px]" if axis == "horizontal" else "v [px]")
        panel.spines["bottom"].set_visible(False)
        panel.tick_params(axis="x", length=0.0)
    panels[-1].set_xlabel("time [s]")
    if axis == "vertical":
        panels[0].invert_yaxis()
    _legend(
        figure,
        _line("ideal circle", color=INK, linewidth=0.9, linestyle=IDEAL),
        _patch("actual circle", facecolor=MUTED, alpha=0.28),
        _line("its centre", color=MUTED),
        _line("image border", color=MUTED, linewidth=1.6),
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
    panel.set(xlim=_seconds(t), ylim=(-0.09 * size, 1.09 * size), yticks=[0.0, size / 2.0, size])


def top_view(flights: Flights) -> "Figure":
    """Obstacles and tracks from above, one panel per set-up."""
    xlim, ylim = _frame(list(flights.values()))
    columns = min(len(flights), 2)
    height = (WIDTH - 1.0) / 2.0 * (ylim[1] - ylim[0]) / (xlim[1] - xlim[0])
    shared = {"sharex": True, "sharey": True}
    figure, panels = _panels(-(-len(flights) // columns), columns, height, apart=(0.12, 0.32), **shared)
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
    _legend(
        figure,
        _line("UAV, from the ring to the marker", color=INK),
        _line("UGVs, to the dot", color=MUTED, linewidth=0.6),
        _patch("obstacle, height [m]", facecolor=MUTED, alpha=0.45),
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
    figure, (panel,) = _panels(1, 1, 1.9, above=0.1)
    one = next(iter(flights.values()))
    t = np.asarray(one.episode.world.t)
    panel.plot(t[::3], ideal_altitude(one)[::3], color=INK, linewidth=3.2, alpha=0.25, label="ideal")
    for name, flight in flights.items():
        z = np.asarray(flight.episode.world.uav.position.z)
        panel.plot(t[::3], z[::3], color=LOOKS[name].light, linestyle=LOOKS[name].line, label=name)
    panel.set(xlim=_seconds(t), xlabel="time [s]", ylabel="altitude [m]")
    _legend(figure, *panel.get_legend_handles_labels()[0])
    return figure


def ideal_altitude(flight: Flight) -> np.ndarray:
    """Where the radius would be ideal for the UGVs as they stand, f spread / ideal radius; shape (rows,) [m]."""
    ugvs = flight.episode.world.ugvs
    x, y = (np.array([getattr(ugv, name) for ugv in ugvs], dtype=float) for name in ("x", "y"))
    spread = np.hypot(x - x.mean(axis=0), y - y.mean(axis=0)).max(axis=0)
    return flight.lens.focal_px * spread / flight.ideal_radius


def distributions(results: Results) -> "Figure":
    """Both errors over flights, as empirical distribution functions."""
    shown = {name: results["setups"][name]["scores"] for name in COMPARED if name in results["setups"]}
    figure, panels = _panels(1, 2, 2.3, above=0.1, apart=(0.1, 0.0), sharey=True)
    for panel, metric in zip(panels, ERRORS, strict=True):
        for name, scores in shown.items():
            _ecdf(panel, np.ravel(scores[metric]), LOOKS[name], name)
        _logarithmic(panel, "x", (1.0, 2.0, 3.0, 5.0, 7.0))
        panel.set(xlabel=METRICS[metric].head(), ylim=(0.0, 1.0))
    panels[0].set_ylabel("share of flights")
    _legend(figure, *panels[0].get_legend_handles_labels()[0])
    return figure


def _ecdf(panel: "Axes", values: np.ndarray, how: Look, name: str) -> None:
    ordered = np.sort(values)
    share = np.arange(1, len(ordered) + 1) / len(ordered)
    some = np.unique(np.linspace(0, len(ordered) - 1, 200).astype(int))
    style = {"color": how.light, "linestyle": how.line, "marker": how.marker, "markersize": 5.0}
    panel.plot(ordered[some], share[some], markevery=[len(some) // 2], label=name, **style)


def sticks(flights: Flights) -> "Figure":
    """Sticks over time: operator against ABS-DL."""
    axes = ("forward", "left", "up")
    figure, panels = _panels(len(axes), 1, 0.95, above=0.1, apart=(0.0, 0.12), sharex=True, sharey=True)
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
            panel.set(xlim=_seconds(t), ylabel=axis, ylim=(-1.05, 1.05))
    panels[-1].set_xlabel("time [s]")
    panels[-1].locator_params(axis="x", steps=[1, 2, 5, 10])
    _legend(figure, *panels[0].get_legend_handles_labels()[0])
    return figure


def _middle(flight: Flight) -> slice:
    window = min(round(STICK_WINDOW * ROW_RATE), flight.rows)
    start = (flight.rows - window) // 2
    return slice(start, start + window)


def forest(results: Results) -> "Figure":
    """The primary comparisons with their intervals."""
    primary = [one for one in results["comparisons"] if one["family"] == "primary"]
    pairs = list(dict.fromkeys((one["a"], one["b"]) for one in primary))
    metrics = [name for name in METRICS if any(one["metric"] == name for one in primary)]
    how = looks(list(results["setups"]))
    height = 0.36 * len(pairs) + 0.1
    figure, panels = _panels(1, len(metrics), height, left=2.1, apart=(0.1, 0.0), sharey=True, keyed=False)
    for panel, name in zip(panels, metrics, strict=True):
        metric = METRICS[name]
        for one in (one for one in primary if one["metric"] == name):
            _whisker(panel, pairs.index((one["a"], one["b"])), one, metric.factor, how[one["a"]])
        panel.axvline(0.0, color=INK, linewidth=0.9)
        panel.grid(visible=False, axis="y")
        panel.margins(x=0.15)
        better = "the first is better"
        lower = metric.lower_is_better
        arrow = f"\N{LEFTWARDS ARROW} {better}" if lower else f"{better} \N{RIGHTWARDS ARROW}"
        panel.set(xlabel=f"difference in {metric.head(difference=True)}", title=arrow)
        panel.tick_params(axis="y", length=0.0)
        panel.locator_params(axis="x", nbins=6)
    panels[0].set_yticks(range(len(pairs)), [f"{a} \N{MINUS SIGN} {b}" for a, b in pairs])
    panels[0].set_ylim(len(pairs) - 0.5, -0.5)
    return figure


def _whisker(panel: "Axes", row: int, one: Mapping[str, Any], factor: float, how: Look) -> None:
    low, high = (factor * edge for edge in one["interval"])
    panel.hlines(row, low, high, color=how.light, linewidth=2.2)
    panel.plot(factor * one["difference"], row, color=how.light, marker=how.marker, markersize=6.5)


# What all figures share


def _panels(
    rows: int, columns: int, height: float, *, left: float = 0.62, above: float = 0.25,
    apart: tuple[float, float] = (0.0, 0.0), keyed: bool = True, **shared: Any,
) -> tuple["Figure", list["Axes"]]:  # fmt: skip
    """A figure and its panels, row by row; all measures in inches.

    Set by hand, since matplotlib's layout engines take longer than all the drawing.
    """
    from matplotlib.figure import Figure

    below = 0.75 if keyed else 0.48
    total = above + rows * height + (rows - 1) * apart[1] + below
    width = (WIDTH - left - RIGHT - (columns - 1) * apart[0]) / columns
    figure = Figure(figsize=(WIDTH, total))
    place = {
        "left": left / WIDTH,
        "right": 1.0 - RIGHT / WIDTH,
        "bottom": below / total,
        "top": 1.0 - above / total,
    }
    gaps = {"wspace": apart[0] / width, "hspace": apart[1] / height}
    panels = figure.subplots(rows, columns, squeeze=False, gridspec_kw=place | gaps, **shared)
    return figure, list(panels.ravel())


def _legend(figure: "Figure", *handles: Any) -> None:
    place = {"loc": "lower center", "bbox_to_anchor": (0.5, 0.0), "borderaxespad": 0.2}
    figure.legend(handles=list(handles), ncols=len(handles), columnspacing=1.8, **place)


def _line(label: str, **style: Any) -> Any:
    from matplotlib.lines import Line2D

    return Line2D([], [], label=label, **style)


def _patch(label: str, **style: Any) -> Any:
    from matplotlib.patches import Patch

    return Patch(label=label, **style)


def _logarithmic(panel: "Axes", axis: str, marks: Sequence[float]) -> None:
    """A logarithmic axis whose numbers read as numbers."""
    from matplotlib.ticker import LogLocator, NullLocator

    getattr(panel, f"set_{axis}scale")("log")
    scale = getattr(panel, f"{axis}axis")
    scale.set_major_locator(LogLocator(subs=marks))
    scale.set_minor_locator(NullLocator())
    scale.set_major_formatter(lambda value, _: f"{value:g}")


def _seconds(t: np.ndarray) -> tuple[float, float]:
    """From the first row to the end of the last."""
    return float(t[0]), float(t[-1]) + 1.0 / ROW_RATE


# Bytes


def to_png(figure: "Figure") -> bytes:
    """The figure as PNG, on a light page."""
    from matplotlib import rc_context

    file = io.BytesIO()
    with rc_context(STYLE):
        figure.savefig(file, format="png", dpi=DOTS_PER_INCH, metadata={"Software": None}, pil_kwargs=QUICKLY)
    return file.getvalue()


def to_svg(figure: "Figure") -> str:
    """The figure as an SVG document, on a light page."""
    from matplotlib import rc_context

    file = io.StringIO()
    with rc_context(STYLE):
        figure.savefig(file, format="svg", metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
    # Verdana is as wide as DejaVu, its daughter.
    return file.getvalue().replace("'DejaVu Sans'", "'DejaVu Sans', Verdana, sans-serif")


def inline(svg: str, name: str, title: str) -> str:
    """An SVG document as an element of a page: themed by CSS variables, with ids of its own, as wide as its place."""
    box = re.search(r'viewBox="[^"]+"', svg)
    assert box
    body = svg[svg.index(">", svg.index("<svg")) + 1 :]
    body = re.sub(r"<style.*?</style>|<metadata.*?</metadata>|<!--.*?-->", "", body, flags=re.DOTALL)
    body = re.sub(r'\bid="', f'id="{name}-', body)
    body = body.replace('xlink:href="#', f'href="#{name}-').replace("url(#", f"url(#{name}-")
    body = re.sub(
        r"<[^>]+>", lambda tag: re.sub(r"(\.\d\d)\d+", r"\1", tag[0]), body
    )  # hundredths of a point
    body = re.sub(r"\s+", " ", body)
    for light, variable in variables().items():
        body = body.replace(light, f"var({variable})")
    return f'<svg {box[0]} role="img" aria-label="{title}">{body.strip()}'


def palette() -> dict[str, tuple[str, str]]:
    """(light, dark) of every colour, by name."""
    lent = {f"stranger-{i}": how for i, how in enumerate(STRANGERS)}
    return PAGE | {name: (how.light, how.dark) for name, how in (LOOKS | PARTS | lent).items()}


def variables() -> dict[str, str]:
    """The CSS variable that stands for each colour of the light page."""
    return {light: f"--{name}" for name, (light, _) in palette().items()}


def swatch(how: Look) -> str:
    """A small sample of line and marker, as an element of a page."""
    from matplotlib.markers import MarkerStyle

    style = MarkerStyle(how.marker)
    path = style.get_path().transformed(style.get_transform())
    outline = "".join(
        "M" + "L".join(f"{16.0 + 7.0 * x:.1f},{6.0 - 7.0 * y:.1f}" for x, y in np.asarray(polygon)) + "Z"
        for polygon in path.to_polygons()
    )
    colour, dashes = variables()[how.light], " ".join(f"{1.6 * length:g}" for length in how.dashes)
    return (
        f'<svg class="swatch" viewBox="0 0 32 12" aria-hidden="true"><path d="M0,6H32" stroke="var({colour})" '
        f'stroke-width="1.6" stroke-dasharray="{dashes or "none"}"/><path d="{outline}" fill="var({colour})"/></svg>'
    )
