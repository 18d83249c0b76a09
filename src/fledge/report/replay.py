"""One flight, drawn: from above, its altitude, and the circle of the UGVs on both axes of the image.

A still picture shows the whole flight; a .gif plays it, with a ring around every vehicle and a line at the time
that is shown. The same flight gives the same bytes.
"""

import io
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fledge.episode import Flight
from fledge.errors import BadFile
from fledge.report.figures import LOOKS, draw_arena, draw_circle, draw_tracks, ideal_altitude
from fledge.report.figures.looks import INK, MUTED
from fledge.report.figures.sheet import STYLE
from fledge.storage import write

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STILLS = {
    ".png": {"metadata": {"Software": None}, "dpi": 150},
    ".svg": {"metadata": dict.fromkeys(("Date", "Creator", "Format", "Type"))},
    ".pdf": {"metadata": {"CreationDate": None, "Producer": None, "Creator": None}},
}
"""What is said to matplotlib beside the format: no date, no version."""

FRAMES, FRAME_MS, FRAME_DPI = 150, 100, 80
"""Of an animation: at most so many, each shown for so long; a minute of flight in 15 s."""

LOOK = LOOKS["primitive"]
"""Of the UAV."""


def draw_flight(flight: Flight, path: Path) -> Path:
    """Draw a flight as .png, .svg or .pdf, or play it as .gif; returns the path.

    Raises:
        BadFile: another format, or the file cannot be written.
    """
    from matplotlib import rc_context

    path = Path(path)
    kind = path.suffix.lower()
    if kind not in (*STILLS, ".gif"):
        raise BadFile(path, f"no such picture: valid are {', '.join(STILLS)} and .gif")
    file = io.BytesIO()
    with rc_context(STYLE):
        figure, panels = _draw(flight)
        if kind == ".gif":
            first, *others = _frames(flight, figure, panels)
            first.save(file, format="GIF", save_all=True, append_images=others, duration=FRAME_MS, loop=0)
        else:
            figure.savefig(file, format=kind[1:], **STILLS[kind])
    write(path, file.getvalue())
    return path


def _draw(flight: Flight) -> tuple["Figure", dict[str, "Axes"]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 5.6), layout="constrained")
    panels = figure.subplot_mosaic([["top", "altitude"], ["top", "u"], ["top", "v"]], width_ratios=[1.0, 1.1])
    draw_arena(panels["top"], flight)
    draw_tracks(panels["top"], flight, LOOK)
    panels["top"].set(aspect="equal", xlabel="x, east [m]", ylabel="y, north [m]", title="from above")
    panels["top"].autoscale()
    t = np.asarray(flight.episode.world.t)
    panels["altitude"].plot(t, ideal_altitude(flight), color=INK, linewidth=3.2, alpha=0.25)
    panels["altitude"].plot(t, flight.episode.world.uav.position.z, color=LOOK.light)
    panels["altitude"].set(xlim=(t[0], t[-1]), ylabel="z [m]", title="altitude, and where it would be ideal")
    draw_circle(panels["u"], flight, LOOK, "horizontal")
    draw_circle(panels["v"], flight, LOOK, "vertical")
    panels["u"].set(ylabel="u [px]", title="circle of the UGVs in the image; dashed: as it should be")
    panels["v"].set(ylabel="v [px]", xlabel="time [s]")
    panels["v"].invert_yaxis()
    figure.suptitle(f"{flight.manoeuvre}, flown by {flight.pilot}", ha="left", x=0.01)
    return figure, panels


def _frames(flight: Flight, figure: "Figure", panels: dict[str, "Axes"]) -> Iterator[Any]:
    """The pictures of an animation. Only what moves is drawn again, which is ten times as fast."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    figure.set_dpi(FRAME_DPI)
    canvas = FigureCanvasAgg(figure)
    ring = {"marker": "o", "markersize": 11.0, "fillstyle": "none", "linestyle": ""}
    (uav,) = panels["top"].plot([], [], color=LOOK.light, **ring, animated=True)
    (ugvs,) = panels["top"].plot([], [], color=MUTED, **ring, animated=True)
    cursor = {"color": INK, "linewidth": 0.8, "animated": True}
    times = [panels[name].axvline(0.0, **cursor) for name in ("altitude", "u", "v")]
    canvas.draw()
    still = canvas.copy_from_bbox(figure.bbox)
    world = flight.episode.world
    for row in range(0, flight.rows, -(-flight.rows // FRAMES)):
        canvas.restore_region(still)
        uav.set_data([world.uav.position.x[row]], [world.uav.position.y[row]])
        ugvs.set_data([ugv.x[row] for ugv in world.ugvs], [ugv.y[row] for ugv in world.ugvs])
        for line in times:
            line.set_xdata([world.t[row]])
        for artist in (uav, ugvs, *times):
            artist.draw(canvas.get_renderer())
        yield Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("P", palette=Image.Palette.ADAPTIVE)
