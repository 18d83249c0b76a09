"""What all pages have in common: templates and words, figures on disk and in the page, one style.

A page is one file: no script, nothing loaded from elsewhere. The templates lie beside this file; `page.html.j2` has the
pieces, `page.css.j2` the style, in light and dark.
"""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from fledge.errors import BadFile
from fledge.report import figures
from fledge.report.figures import Plot
from fledge.report.figures.looks import Look
from fledge.report.wording import flat, listed, number, p_value, percent, shown, signed, word
from fledge.storage import write

FILTERS = {
    "number": number,
    "signed": signed,
    "percent": percent,
    "p": p_value,
    "shown": shown,
    "listed": listed,
    "word": word,
    "flat": flat,
}


def render(template: str, plots: Mapping[str, Any], looks: Mapping[str, Look], **context: Any) -> str:
    """A page as HTML.

    Args:
        template: its file's name.
        plots: its figures, as `keep` returns them.
        looks: how things look whose names are shown with their line and marker.
        context: what else it speaks of.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        autoescape=True, undefined=StrictUndefined, loader=PackageLoader("fledge.report", package_path="")
    )
    environment.filters |= FILTERS
    page = environment.get_template(template).render(
        plots={name: plot | {"svg": Markup(plot["svg"])} for name, plot in plots.items()},
        swatches={name: Markup(figures.swatch(how)) for name, how in looks.items()},
        palette=figures.palette(),
        **context,
    )
    return re.sub(r"\s*\n\s*", "\n", page).lstrip()


def keep(folder: Path, plots: Iterable[Plot]) -> dict[str, Any]:
    """Write figures into `folder`/figures, as SVG and PNG; returns them by name, numbered, to be put into a page.

    Raises:
        BadFile: one cannot be written.
    """
    kept = {}
    for i, plot in enumerate(plots, start=1):
        svg = figures.to_svg(plot.figure)
        _write(folder / "figures" / f"{plot.name}.svg", svg.encode())
        _write(folder / "figures" / f"{plot.name}.png", figures.to_png(plot.figure))
        drawn = figures.inline(svg, plot.name, plot.title)
        kept[plot.name] = {"name": plot.name, "title": plot.title, "svg": drawn, "number": i}
    return kept


def publish(folder: Path, html: str) -> Path:
    """Write `folder`/index.html; returns it.

    Raises:
        BadFile: it cannot be written.
    """
    page = folder / "index.html"
    _write(page, html.encode())
    return page


def _write(path: Path, data: bytes) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadFile(path, f"cannot be written: {error.strerror or error}") from error
    write(path, data)
