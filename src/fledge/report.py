"""A finished study -> one self-contained page.

`write_report` reads `results.json` and the sample flights of a folder and writes `index.html` beside them: abstract,
tables, figures and every setting, with no script and nothing loaded from elsewhere. The words stand in
`report.html.j2`, the figures in `figures`, the verdicts on the paper's claims in `claims`.
"""

import re
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from fledge import figures
from fledge.claims import by_fate, claims
from fledge.episode import Flight
from fledge.errors import BadFile
from fledge.figures import Results
from fledge.metrics import CREDIBILITY, METRICS
from fledge.storage import read_flight, read_json, write
from fledge.wording import flat, listed, number, p_value, percent, shown, signed, word

MAIN = ("human-combined", "dnn-combined", "primitive-paper", "primitive", "servo")
"""The set-ups of the first table; all others stand in the second."""
PRINTED = {
    "human-combined": "human-combined",
    "dnn-combined": "dnn-combined",
    "primitive-paper": "primitive",
    "primitive": "primitive",
}
"""Which line of the paper's Table 4 speaks of a set-up."""
MANOEUVRES = ("fixed-altitude", "climb", "descend", "combined")


def write_report(folder: Path) -> Path:
    """Write the page of a study and its figures; returns the page.

    Raises:
        BadFile: the results or a sample flight are missing or damaged, or the page cannot be written.
    """
    folder = Path(folder)
    results = read_json(folder / "results.json")
    flown = [name for name in figures.FLOWN if name in results["setups"]]
    flights = {name: _sample(folder / "flights" / f"{name}.mcap") for name in flown}
    plots = {}
    for i, plot in enumerate(figures.draw(results, flights), start=1):
        svg = figures.to_svg(plot.figure)
        _write(folder / "figures" / f"{plot.name}.svg", svg.encode())
        _write(folder / "figures" / f"{plot.name}.png", figures.to_png(plot.figure))
        drawn = figures.inline(svg, plot.name, plot.title)
        plots[plot.name] = {"name": plot.name, "title": plot.title, "svg": drawn, "number": i}
    page = folder / "index.html"
    _write(page, render(results, flights, plots).encode())
    return page


def render(results: Results, flights: Mapping[str, Flight], plots: Mapping[str, Any]) -> str:
    """The page as HTML."""
    from jinja2 import Environment, StrictUndefined
    from markupsafe import Markup

    looks, found = figures.looks(list(results["setups"])), claims(results)
    samples = {name: Markup(figures.swatch(how)) for name, how in looks.items()}
    environment = Environment(autoescape=True, undefined=StrictUndefined)
    environment.filters |= {"number": number, "signed": signed, "percent": percent, "p": p_value}
    environment.filters |= {"shown": shown, "listed": listed, "word": word, "flat": flat}
    template = environment.from_string(files("fledge").joinpath("report.html.j2").read_text(encoding="utf-8"))
    page = template.render(
        r=results,
        setups={name: results["setups"][name] for name in looks},
        main=[name for name in MAIN if name in looks],
        further=[name for name in looks if name not in MAIN],
        printed=PRINTED,
        manoeuvres=MANOEUVRES,
        metrics=METRICS,
        credibility=CREDIBILITY,
        claims=found,
        fates={name: by_fate(found, name) for name in ("primitive", "primitive-paper") if name in looks},
        swatches=samples,
        palette=figures.palette(),
        plots={name: plot | {"svg": Markup(plot["svg"])} for name, plot in plots.items()},
        flight=next(iter(flights.values()), None),
        window=figures.STICK_WINDOW,
        row=1.0 / results["settings"]["row_rate_hz"],
        altitudes=_altitudes(flights),
    )
    return re.sub(r"\s*\n\s*", "\n", page).lstrip()


def _sample(path: Path) -> Flight:
    if not path.is_file():
        raise BadFile(
            path, "is missing; the report shows one sample flight of every set-up, stored beside the results"
        )
    return read_flight(path)


def _write(path: Path, data: bytes) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadFile(path, f"cannot be written: {error.strerror or error}") from error
    write(path, data)


def _altitudes(flights: Mapping[str, Flight]) -> tuple[float, float] | None:
    """Lowest and highest ideal altitude of the sample flight [m]."""
    if not flights:
        return None
    ideal = figures.ideal_altitude(next(iter(flights.values())))
    return float(ideal.min()), float(ideal.max())
