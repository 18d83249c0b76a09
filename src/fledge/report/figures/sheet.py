"""The sheet that figures are drawn on: style, panels, legend, axes. Drawing loads matplotlib, importing does not."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fledge.observation import ROW_RATE
from fledge.report.figures.looks import CARD, FAINT, INK, MUTED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, RIGHT = 8.0, 0.12
"""[in] of every figure, and what stays free on its right."""
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


def panels(
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
    axes = figure.subplots(rows, columns, squeeze=False, gridspec_kw=place | gaps, **shared)
    return figure, list(axes.ravel())


def beside(wide: float, height: float, above: float = 0.25) -> tuple["Figure", list["Axes"]]:
    """A figure with one panel on the left and two on the right that share their time; all measures in inches."""
    from matplotlib.figure import Figure

    left, below, between, apart = 0.55, 0.75, 0.75, 0.3
    total = above + height + below
    figure = Figure(figsize=(WIDTH, total))
    start = left + wide + between
    small, each = WIDTH - RIGHT - start, (height - apart) / 2.0
    places = (
        (left, below, wide, height),
        (start, below + each + apart, small, each),
        (start, below, small, each),
    )
    return figure, [figure.add_axes((x / WIDTH, y / total, w / WIDTH, h / total)) for x, y, w, h in places]


def legend(figure: "Figure", *handles: Any) -> None:
    """A line below all panels that says what is what."""
    place = {"loc": "lower center", "bbox_to_anchor": (0.5, 0.0), "borderaxespad": 0.2}
    figure.legend(handles=list(handles), ncols=len(handles), columnspacing=1.8, **place)


def line(label: str, **style: Any) -> Any:
    """A line in the legend."""
    from matplotlib.lines import Line2D

    return Line2D([], [], label=label, **style)


def patch(label: str, **style: Any) -> Any:
    """A patch in the legend."""
    from matplotlib.patches import Patch

    return Patch(label=label, **style)


def logarithmic(panel: "Axes", axis: str, marks: Sequence[float]) -> None:
    """A logarithmic axis whose numbers read as numbers; fewer of them where it spans many."""
    from matplotlib.ticker import LogLocator, NullLocator

    getattr(panel, f"set_{axis}scale")("log")
    scale = getattr(panel, f"{axis}axis")
    low, high = getattr(panel, f"get_{axis}lim")()
    scale.set_major_locator(LogLocator(subs=marks if high <= 30.0 * low else (1.0, 3.0)))
    scale.set_minor_locator(NullLocator())
    scale.set_major_formatter(lambda value, _: f"{value:g}")


def seconds(t: np.ndarray) -> tuple[float, float]:
    """From the first row to the end of the last."""
    return float(t[0]), float(t[-1]) + 1.0 / ROW_RATE
