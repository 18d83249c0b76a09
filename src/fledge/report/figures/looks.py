"""Who is shown, and what looks how, in every figure and beside its name in every table.

`LOOKS` gives every set-up a colour, a dash pattern and a marker. The hues are those of Okabe and Ito (2008), which
colour-blind readers tell apart, darkened to a contrast of at least 3:1 with the page; dash and marker say the same
again without colour. Every colour has a twin for a dark page, and a CSS variable that stands for both.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np


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

NETS = {
    "none": Look("#767d75", "#a8b0a6", (3.0, 0.9), "o"),
    "paper": Look("#b8441f", "#ef8a63", (6.0, 1.6), "s"),
    "paper-repaired": Look("#a34d78", "#dc93b8", (1.4, 1.0), "^"),
    "stop-tube": Look("#0b6fa4", "#62b2e6", (), "D"),
    "conformal": Look("#4a6bb0", "#97adee", (4.0, 1.0, 1.0, 1.0), "v"),
    "barrier": Look("#1f7a55", "#4cc79a", (6.0, 1.6, 1.2, 1.6), "P"),
}
"""Of the safety nets, in figures of their own."""

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


def looks(names: Sequence[str]) -> dict[str, Look]:
    """The look of each set-up, ours first; strangers get theirs in the order in which they come."""
    strangers = [name for name in names if name not in LOOKS]
    lent = {name: STRANGERS[i % len(STRANGERS)] for i, name in enumerate(strangers)}
    return {name: how for name, how in LOOKS.items() if name in names} | lent


def palette() -> dict[str, tuple[str, str]]:
    """(light, dark) of every colour, by name."""
    lent = {f"stranger-{i}": how for i, how in enumerate(STRANGERS)}
    nets = {f"net-{name}": how for name, how in NETS.items()}
    return PAGE | {name: (how.light, how.dark) for name, how in (LOOKS | PARTS | lent | nets).items()}


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
