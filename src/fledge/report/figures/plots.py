"""All plots of a study, in the order of the page; as PNG, as SVG, as elements of a page.

A figure is drawn once, in the light colours. `inline` makes an element of a page of it: every colour becomes a CSS
variable, so that the same drawing shows on a light or a dark page, and every id gets the figure's name, so that many
fit into one page. Text stays text. The same results give the same bytes.
"""

import io
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fledge.report.figures.flights import Flights, altitude, circles, sticks, top_view
from fledge.report.figures.looks import COMPARED, DUEL, FLOWN, variables
from fledge.report.figures.nets import pareto, stand_off
from fledge.report.figures.results import Results, distributions, forest, training
from fledge.report.figures.sheet import STYLE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DOTS_PER_INCH = 150
QUICKLY = {"compress_level": 3}
"""For PNG: a tenth more bytes in half the time."""


@dataclass(frozen=True, slots=True)
class Plot:
    """A figure and its name."""

    name: str
    """Of its files."""
    title: str
    """What is shown, in a few words."""
    figure: "Figure"


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
    if results.get("nets"):
        yield Plot("pareto", "Safety against performance", pareto(results["nets"]))
        yield Plot("stand-off", "Flown at a wall and called back", stand_off(results["nets"]))


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
