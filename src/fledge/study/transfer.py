"""From the simulator to the lab: what flights in the digital twin came to, and whether the policy made it across.

`behind` sums up the flights behind one net. `compare` sets flights in the twin beside flights in the simulator, along
the same ways of the same formation: paired by the way, with the flight as the unit of inference. *Not worse* is claimed
only where a one-sided 95 % bound of the ratio of the errors says so; that no difference was found is no such claim.

The two differ in more than physics: in the simulator the policy holds its altitude itself, sees 50 to 150 ms late and
with a pixel of noise, in more wind; in the lab the controller holds the altitude, and what is seen is motion capture's.
So the radius tells of the controller there, and the distance is what is to be compared. The sticks are not: up is one
of them in the simulator alone.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from math import isfinite
from typing import Any

import numpy as np

from fledge.episode import Flight
from fledge.observation import ROW_RATE
from fledge.pytrees import stack
from fledge.simulation import Rig
from fledge.study import statistics
from fledge.study.evaluation import Score, score
from fledge.study.findings import MARGIN, SYNTHETIC, summarise_scores, to_json
from fledge.study.metrics import ERRORS, METRICS

COMPARED = (*ERRORS, "in_view")
FEWEST = statistics.SEEDS_NEEDED
"""Flights on each side, below which nothing is said of the two: a bootstrap of fewer is too narrow."""

Numbers = Mapping[str, Any]
"""What came of one flight, in plain JSON values (`lab.outing`)."""

NO_ROBOT = (
    "No robot flew: at the other end of every wire was a digital twin, whose vehicles, sensors and delays are not "
    "those of the training simulator. Nobody attended: wherever a person is said to be needed, nobody came."
)
LEARNT = (
    "Who flew the demonstrations that a policy learnt from, its file does not say; those that fledge collects by "
    "itself are by a synthetic operator, a model from the manual-control literature."
)


def sentences(pilot: str) -> list[str]:
    """What has to be said beside the results of whoever flew."""
    return [NO_ROBOT, SYNTHETIC if pilot == "human-model" else LEARNT]


def scored(flights: Sequence[Flight]) -> Score:
    """All flights' scores, leaves of shape (1, flights)."""
    found = stack([score(flight.episode, Rig()) for flight in flights])
    return Score(*(np.asarray(getattr(found, name))[None] for name in Score.names()))


def behind(found: Sequence[Numbers], begun: Sequence[Flight]) -> dict[str, Any]:
    """What came of the flights behind one net; those are scored whose pilot flew."""
    flights, minutes = len(found), sum(one["aloft_s"] for one in found) / 60.0
    touched = sum(one["contacts"] > 0 for one in found)
    people = sum(needed(one) for one in found)
    held = [one["held"] for one in found if one["held"] is not None]
    gaps = [one["least_gap_m"] for one in found if one["least_gap_m"]]
    return {
        "flights": flights,
        "began": len(held),
        "contacts": touched,
        "contacts_flying": sum(one["contacts"] > one["contacts_landing"] for one in found),
        "contacts_landing": sum(one["contacts_landing"] > 0 for one in found),
        "contacts_upper_bound_95": statistics.upper_bound(touched, flights),
        "touched": sorted({what for one in found for what in one["touched"]}),
        "least_gap_m": {who: min(gap[who] for gap in gaps) for who in ("uav", "ugv")} if gaps else None,
        "landed": sum(one["landed"] for one in found),
        "people_needed": people,
        "people_needed_upper_bound_95": statistics.upper_bound(people, flights),
        "takeovers": sum(one["takeovers"] for one in found),
        "minutes": minutes,
        "interventions_per_minute": _rates(found, minutes),
        "reasons": _reasons(found),
        "held": float(np.mean(held)) if held else None,
        "scores": _table(scored(begun)) if begun else None,
    }


def needed(one: Numbers) -> bool:
    """Whether a flight needed a person: a vehicle stopped, held or brought down unbidden, or not to be got down."""
    return one["human_interventions_needed"] > 0 or not one["landed"]


def _rates(found: Sequence[Numbers], minutes: float) -> dict[str, float | None]:
    """Interventions by layer, a minute of all vehicles' flight from the climb to the order to land."""
    layers = found[0]["interventions"]
    return {
        layer: sum(sum(one["interventions"][layer].values()) for one in found) / minutes if minutes else None
        for layer in layers
    }


def _reasons(found: Sequence[Numbers]) -> dict[str, int]:
    """How often each reason held a vehicle, in all flights."""
    counts: dict[str, int] = {}
    for one in found:
        for layer, reasons in one["interventions"].items():
            for reason, times in reasons.items():
                counts[f"{layer}: {reason}"] = counts.get(f"{layer}: {reason}", 0) + times
    return dict(sorted(counts.items()))


def _table(scores: Score) -> dict[str, Any]:
    """Means and standard deviations over flights; and every flight's number, in the order of the seeds."""
    values = {name: np.asarray(getattr(scores, name), dtype=float)[0] for name in Score.names()}
    return {
        name: {
            "mean": float(value.mean()),
            "sd": float(value.std(ddof=1)) if len(value) > 1 else None,
            "flights": value.tolist(),
        }
        for name, value in values.items()
    }


def compare(twin: Score, simulator: Score, seed: int, seconds: float) -> dict[str, Any]:
    """Twin against simulator, flight by flight along the same ways; leaves of both of shape (1, flights)."""
    rows = round(seconds * ROW_RATE)
    found: dict[str, Any] = {
        "simulator": summarise_scores(simulator, rows) | {"scores": _table(simulator)},
        "twin": summarise_scores(twin, rows) | {"scores": _table(twin)},
        "margin": MARGIN,
        "comparisons": {},
    }
    for name in COMPARED:
        a, b = (np.asarray(getattr(one, name), dtype=float) for one in (twin, simulator))
        entry = to_json(statistics.compare("twin", a, "simulator", b, name, seed))
        if METRICS[name].lower_is_better and b.mean() > 0.0:
            ratio = asdict(statistics.non_inferior(a, b, MARGIN, seed))
            entry["non_inferiority"] = {k: v if isfinite(v) else None for k, v in ratio.items()}
        found["comparisons"][name] = entry
    return found
