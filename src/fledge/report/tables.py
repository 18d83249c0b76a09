"""The tables that the command line shows: records in, text in rows and columns out.

They fit a terminal of 80 columns where names are short. Means over flights come with their standard deviations.
"sticks" is how fast the pilot moves them: their mean absolute change per second.
"""

import textwrap
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from fledge.study.metrics import CREDIBILITY, METRICS, Metric

WIDTH = 10
"""Of the lines of a head, in letters."""

IN_LAB = ("distance_rmse", "radius_rmse", "in_view")
"""What is shown of flights in the lab."""


@dataclass(frozen=True, slots=True)
class Table:
    """A title, heads, and rows as long as the heads; a head may have two lines."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def scores(title: str, entries: Mapping[str, Mapping[str, Any]]) -> Table:
    """How well each flew, over all its flights."""
    shown = ("distance", "radius", "distance_rmse", "radius_rmse", "in_view", "smoothness")
    heads = ("", *(_head(METRICS[name]) for name in shown))
    return Table(title, heads, tuple(_scores(name, entry) for name, entry in entries.items()))


def _scores(name: str, entry: Mapping[str, Any]) -> tuple[str, ...]:
    return (
        name,
        _spread(METRICS["distance"], entry["distance"]),
        _spread(METRICS["radius"], entry["radius"]),
        _number(METRICS["distance_rmse"], entry["distance_rmse_px"]),
        _number(METRICS["radius_rmse"], entry["radius_rmse_px"]),
        _number(METRICS["in_view"], entry["in_view"]),
        _number(METRICS["smoothness"], entry["smoothness"]),
    )


def comparisons(found: Iterable[Mapping[str, Any]]) -> list[Table]:
    """Paired differences and what may be claimed of them, a table for each pair."""
    heads = ("", "difference", "95 % interval", "p (Holm)", "effect d_z")
    pairs = groupby(found, lambda one: f"{one['a']} minus {one['b']}")
    return [Table(title, heads, tuple(map(_comparison, group))) for title, group in pairs]


def _comparison(one: Mapping[str, Any]) -> tuple[str, ...]:
    metric = METRICS[one["metric"]]
    low, high = (metric.factor * edge for edge in one["interval"])
    return (
        metric.head(difference=True),
        f"{metric.factor * one['difference']:+.2f}",
        f"{low:+.2f} to {high:+.2f}",
        f"{one['p_holm']:.4f}" if one["p_holm"] >= 1e-4 else "< 0.0001",
        "-" if one["effect_size"] is None else f"{one['effect_size']:+.2f}",
    )


def attacks(title: str, found: Mapping[str, Any]) -> Table:
    """What came of the attacks of every family, and of all."""
    heads = ("", "flights", "contacts", "dead-locks", "breaches", "false\nalarms [%]") + (
        "least gap\nUAV [m]",
        "least gap\nUGV [m]",
    )
    rows = [*found["families"].items(), ("all", found)]
    return Table(title, heads, tuple(_attacks(name, one) for name, one in rows))


def _attacks(name: str, one: Mapping[str, Any]) -> tuple[str, ...]:
    return (
        name,
        *(f"{one[key]:,}" for key in ("flights", "contacts", "deadlocks", "breaches")),
        "-" if one["false_alarm_rate"] is None else f"{100.0 * one['false_alarm_rate']:.1f}",
        f"{one['least_gap_m']['uav']:.2f}",
        f"{one['least_gap_m']['ugv']:.2f}",
    )


def lab(title: str, found: Mapping[str, Mapping[str, Any]]) -> Table:
    """What came of the flights of the physical experiment, net by net."""
    heads = ("", "contacts", "people\nneeded", "held back\na minute") + tuple(
        _head(METRICS[name]) for name in IN_LAB
    )
    return Table(title, heads, tuple(_lab(net, one) for net, one in found.items()))


def _lab(net: str, one: Mapping[str, Any]) -> tuple[str, ...]:
    rates = [rate for rate in one["interventions_per_minute"].values() if rate is not None]
    scores = one["scores"]
    return (
        net,
        str(one["contacts"]),
        str(one["people_needed"]),
        f"{sum(rates):.2f}",
        *("-" if scores is None else _number(METRICS[name], scores[name]["mean"]) for name in IN_LAB),
    )


def transfer(found: Mapping[str, Any]) -> Table:
    """Simulator and twin, and whether the policy is shown to be no worse in the twin."""
    heads = ("", "simulator", "twin", "95 % interval\nof the difference", "times,\nat most")
    rows = tuple(_transfer(name, found) for name in found["comparisons"])
    return Table("the same ways in the simulator and in the twin, without a net", heads, rows)


def _transfer(name: str, found: Mapping[str, Any]) -> tuple[str, ...]:
    metric, one = METRICS[name], found["comparisons"][name]
    low, high = (metric.factor * edge for edge in one["interval"])
    upper = (one.get("non_inferiority") or {}).get("upper")
    return (
        metric.head(),
        *(_number(metric, found[side]["scores"][name]["mean"]) for side in ("simulator", "twin")),
        f"{low:+.2f} to {high:+.2f}",
        "-" if upper is None else f"{upper:.2f}",
    )


def operator(found: Mapping[str, Any]) -> Table:
    """Whether the operator is credible: what was measured of it, beside the bands that people reach."""
    heads = ("", *map(_head, CREDIBILITY.values()), "inside")
    axes = tuple(
        (
            one["axis"],
            *(_number(metric, one[name]) for name, metric in CREDIBILITY.items()),
            "yes" if one["inside"] else "no",
        )
        for one in found["axes"]
    )
    bands = (
        " to ".join(_number(metric, edge) for edge in found["bands"][name])
        for name, metric in CREDIBILITY.items()
    )
    return Table(found["sentence"], heads, (*axes, ("people", *bands, "")))


def flight(title: str, found: Mapping[str, float]) -> Table:
    """One flight's score."""
    rows = (
        (one.meaning, f"{_number(one, found[name])} {one.unit}".rstrip()) for name, one in METRICS.items()
    )
    return Table(title, ("", ""), tuple(rows))


def _head(metric: Metric) -> str:
    return textwrap.fill(metric.head(), WIDTH)


def _number(metric: Metric, value: float) -> str:
    return f"{metric.factor * value:.{metric.digits}f}"


def _spread(metric: Metric, value: Mapping[str, float]) -> str:
    return f"{_number(metric, value['mean'])} ± {_number(metric, value['sd'])}"
