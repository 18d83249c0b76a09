"""The tables that the command line shows: records in, text in rows and columns out.

They fit a terminal of 80 columns where names are short. Means over flights come with their standard deviations.
"sticks" is how fast the pilot moves them: their mean absolute change per second.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import Any

METRICS = {
    "distance_rmse": ("distance RMSE [px]", 1.0),
    "radius_rmse": ("radius RMSE [px]", 1.0),
    "in_view": ("in view [%]", 100.0),
}
"""What is compared: (name with unit, factor into that unit)."""


@dataclass(frozen=True, slots=True)
class Table:
    """A title, heads, and rows as long as the heads; a head may have two lines."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def scores(title: str, entries: Mapping[str, Mapping[str, Any]]) -> Table:
    """How well each flew, over all its flights."""
    heads = (
        "",
        "distance\nmean [px]",
        "radius\nmean [px²]",
        "distance\nRMSE [px]",
        "radius\nRMSE [px]",
        "in view\n[%]",
        "sticks\n[1/s]",
    )
    return Table(title, heads, tuple(_scores(name, entry) for name, entry in entries.items()))


def _scores(name: str, entry: Mapping[str, Any]) -> tuple[str, ...]:
    return (
        name,
        _spread(entry["distance"]),
        _spread(entry["radius"]),
        f"{entry['distance_rmse_px']:.2f}",
        f"{entry['radius_rmse_px']:.2f}",
        f"{100.0 * entry['in_view']:.2f}",
        f"{entry['smoothness']:.2f}",
    )


def _spread(value: Mapping[str, float]) -> str:
    return f"{value['mean']:.1f} ± {value['sd']:.1f}"


def comparisons(found: Iterable[Mapping[str, Any]]) -> list[Table]:
    """Paired differences and what may be claimed of them, a table for each pair."""
    heads = ("", "difference", "95 % interval", "p (Holm)", "effect d_z")
    pairs = groupby(found, lambda one: f"{one['a']} minus {one['b']}")
    return [Table(title, heads, tuple(map(_comparison, group))) for title, group in pairs]


def _comparison(one: Mapping[str, Any]) -> tuple[str, ...]:
    name, factor = METRICS[one["metric"]]
    low, high = (factor * edge for edge in one["interval"])
    return (
        name,
        f"{factor * one['difference']:+.2f}",
        f"{low:+.2f} to {high:+.2f}",
        f"{one['p_holm']:.4f}" if one["p_holm"] >= 1e-4 else "< 0.0001",
        "-" if one["effect_size"] is None else f"{one['effect_size']:+.2f}",
    )


def flight(title: str, found: Mapping[str, float]) -> Table:
    """One flight's score."""
    rows = (
        ("distance of the UGVs' centre from the image's, mean", f"{found['distance']:.2f} px"),
        ("  root mean square", f"{found['distance_rmse']:.2f} px"),
        ("squared radius error, mean", f"{found['radius']:.2f} px²"),
        ("  root", f"{found['radius_rmse']:.2f} px"),
        ("all UGVs in view", f"{100.0 * found['in_view']:.2f} %"),
        ("sticks: change per second, mean", f"{found['smoothness']:.2f}"),
        ("sticks: deflection, mean", f"{found['effort']:.3f}"),
    )
    return Table(title, ("", ""), rows)
