"""The tables that the command line shows: records in, text in rows and columns out.

They fit a terminal of 80 columns where names are short. Units stand in the heads; a mean comes with its standard deviation.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
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
    heads = ("", "flights", "distance\n[px]", "radius\n[px²]", "RMSE\n[px]", "RMSE\n[px]", "in view\n[%]", "sticks\n[1/s]")
    return Table(title, heads, tuple(_scores(name, entry) for name, entry in entries.items()))


def _scores(name: str, entry: Mapping[str, Any]) -> tuple[str, ...]:
    return (
        name,
        str(entry["flights"]),
        _spread(entry["distance"]),
        _spread(entry["radius"]),
        f"{entry['distance_rmse_px']:.2f}",
        f"{entry['radius_rmse_px']:.2f}",
        f"{100.0 * entry['in_view']:.2f}",
        f"{entry['smoothness']:.2f}",
    )


def _spread(value: Mapping[str, float]) -> str:
    return f"{value['mean']:.1f} ± {value['sd']:.1f}"


def comparisons(title: str, found: Sequence[Mapping[str, Any]]) -> Table:
    """Paired differences with what may be claimed of them."""
    heads = ("", "difference", "95 % interval", "p (Holm)", "effect d_z")
    return Table(title, heads, tuple(_comparison(one) for one in found))


def _comparison(one: Mapping[str, Any]) -> tuple[str, ...]:
    name, factor = METRICS[one["metric"]]
    low, high = (factor * edge for edge in one["interval"])
    return (
        f"{one['a']} - {one['b']}\n  {name}",
        f"{factor * one['difference']:+.2f}",
        f"{low:+.2f} to {high:+.2f}",
        f"{one['p_holm']:.4f}" if one["p_holm"] >= 1e-4 else "< 0.0001",
        f"{one['effect_size']:+.2f}",
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
