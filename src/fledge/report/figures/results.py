"""What results.json holds -> figures: losses, errors over flights, comparisons."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from fledge.report.figures import sheet
from fledge.report.figures.looks import COMPARED, INK, LOOKS, PARTS, Look, looks
from fledge.study.metrics import ERRORS, METRICS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Results = Mapping[str, Any]
"""What results.json holds."""

VALIDATION = (0.0, (4.0, 1.5))
"""Dashes of what was held out, in every panel."""


def training(results: Results) -> "Figure":
    """Training and validation loss over epochs, one panel per trained set-up."""
    setups = results["setups"]
    trained = {name: setups[name]["curve"] for name in looks(list(setups)) if setups[name]["curve"]}
    columns = min(len(trained), 4)
    figure, panels = sheet.panels(-(-len(trained) // columns), columns, 1.6, apart=(0.12, 0.74), sharey=True)
    for panel, (name, curve) in zip(panels, trained.items(), strict=False):
        _losses(panel, curve)
        panel.set(title=name, xlabel="epoch")
    for panel in panels[len(trained) :]:
        panel.set_visible(False)
    for panel in panels[::columns]:
        panel.set_ylabel("mean squared error")
    shown = [part for part in PARTS if any(part in curve["training"] for curve in trained.values())]
    thin = {"linewidth": 0.9, "markersize": 3.5}
    sheet.legend(
        figure,
        sheet.line("all rows, training", color=INK, linewidth=1.5),
        sheet.line("all rows, validation", color=INK, linewidth=1.5, linestyle=VALIDATION),
        *(sheet.line(part, color=PARTS[part].light, marker=PARTS[part].marker, **thin) for part in shown),
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
    sheet.logarithmic(panel, "y", (1.0, 2.0, 5.0))
    panel.locator_params(axis="x", nbins=4, integer=True)


def distributions(results: Results) -> "Figure":
    """Both errors over flights, as empirical distribution functions."""
    shown = {name: results["setups"][name]["scores"] for name in COMPARED if name in results["setups"]}
    figure, panels = sheet.panels(1, 2, 2.3, above=0.1, apart=(0.1, 0.0), sharey=True)
    for panel, metric in zip(panels, ERRORS, strict=True):
        for name, scores in shown.items():
            ecdf(panel, np.ravel(scores[metric]), LOOKS[name], name)
        sheet.logarithmic(panel, "x", (1.0, 2.0, 3.0, 5.0, 7.0))
        panel.set(xlabel=METRICS[metric].head(), ylim=(0.0, 1.0))
    panels[0].set_ylabel("share of flights")
    sheet.legend(figure, *panels[0].get_legend_handles_labels()[0])
    return figure


def ecdf(panel: "Axes", values: np.ndarray, how: Look, name: str) -> None:
    """The share of values up to each value; the marker stands at the median."""
    ordered = np.sort(values)
    share = np.arange(1, len(ordered) + 1) / len(ordered)
    some = np.unique(np.linspace(0, len(ordered) - 1, 200).astype(int))
    style = {"color": how.light, "linestyle": how.line, "marker": how.marker, "markersize": 5.0}
    panel.plot(ordered[some], share[some], markevery=[len(some) // 2], label=name, **style)


def forest(results: Results) -> "Figure":
    """The primary comparisons with their intervals."""
    primary = [one for one in results["comparisons"] if one["family"] == "primary"]
    pairs = list(dict.fromkeys((one["a"], one["b"]) for one in primary))
    metrics = [name for name in METRICS if any(one["metric"] == name for one in primary)]
    how = looks(list(results["setups"]))
    height = 0.36 * len(pairs) + 0.1
    figure, panels = sheet.panels(
        1, len(metrics), height, left=2.1, apart=(0.1, 0.0), sharey=True, keyed=False
    )
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
