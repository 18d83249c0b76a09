"""Results and sample flights -> figures.

All are drawn with matplotlib's objects: no pyplot, no state but style defaults that are put back. The first drawing
loads matplotlib, not the import of this folder. The captions stand on the report's page.
"""

from fledge.report.figures.flights import (
    STICK_WINDOW,
    Flights,
    draw_arena,
    draw_circle,
    draw_tracks,
    ideal_altitude,
)
from fledge.report.figures.looks import FLOWN, LOOKS, looks, palette, swatch
from fledge.report.figures.plots import Plot, draw, inline, to_png, to_svg
from fledge.report.figures.results import Results

__all__ = [
    "FLOWN",
    "LOOKS",
    "STICK_WINDOW",
    "Flights",
    "Plot",
    "Results",
    "draw",
    "draw_arena",
    "draw_circle",
    "draw_tracks",
    "ideal_altitude",
    "inline",
    "looks",
    "palette",
    "swatch",
    "to_png",
    "to_svg",
]
