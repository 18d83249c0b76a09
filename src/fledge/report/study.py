"""A finished study -> one self-contained page.

`write_report` reads `results.json` and the sample flights of a folder and writes `index.html` beside them: abstract,
tables, figures and every setting, with no script and nothing loaded from elsewhere. The words stand in
`study.html.j2`, the figures in `figures`, the verdicts on the paper's claims in `claims`.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fledge.episode import Flight
from fledge.errors import BadFile
from fledge.report import figures, page
from fledge.report.claims import by_fate, claims
from fledge.report.figures import Results
from fledge.storage import read_flight, read_json
from fledge.study.metrics import CREDIBILITY, METRICS

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
    plots = page.keep(folder, figures.draw(results, flights))
    return page.publish(folder, render(results, flights, plots))


def render(results: Results, flights: Mapping[str, Flight], plots: Mapping[str, Any]) -> str:
    """The page as HTML."""
    looks, found = figures.looks(list(results["setups"])), claims(results)
    return page.render(
        "study.html.j2",
        plots,
        looks,
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
        flight=next(iter(flights.values()), None),
        window=figures.STICK_WINDOW,
        row=1.0 / results["settings"]["row_rate_hz"],
        altitudes=_altitudes(flights),
    )


def _sample(path: Path) -> Flight:
    if not path.is_file():
        raise BadFile(
            path, "is missing; the report shows one sample flight of every set-up, stored beside the results"
        )
    return read_flight(path)


def _altitudes(flights: Mapping[str, Flight]) -> tuple[float, float] | None:
    """Lowest and highest ideal altitude of the sample flight [m]."""
    if not flights:
        return None
    ideal = figures.ideal_altitude(next(iter(flights.values())))
    return float(ideal.min()), float(ideal.max())
