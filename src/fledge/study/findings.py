"""What a study found: scores of flights become tables, comparisons and one JSON-able summary.

The unit of inference is the flight, training seed by test case, never the time step. The family of tests is fixed in
advance: `PRIMARY` pairs by `ERRORS`, Holm over the four; everything else is called exploratory (D12).
"""

import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from math import isfinite
from typing import Any

import numpy as np

from fledge.episode import Flight
from fledge.learning.demonstrations import Demonstrations
from fledge.learning.policy import Policy
from fledge.learning.recipe import Recipe
from fledge.learning.training import LossCurve, member_curve
from fledge.manoeuvres.paths import DEVELOPMENT_FAMILIES, HELD_OUT_FAMILIES, TRAINING_FAMILIES
from fledge.observation import OBSERVATION_NAMES, ROW_RATE
from fledge.pilots import HumanModel, Servo
from fledge.simulation import Rig
from fledge.study import statistics
from fledge.study.crossover import BANDS
from fledge.study.evaluation import Score
from fledge.study.metrics import ERRORS, METRICS
from fledge.study.setups import DEFAULT_METHOD, Setup, Study


@dataclass(frozen=True, slots=True)
class SetupResult:
    """What one set-up did."""

    setup: Setup
    scores: dict[str, Score]
    """By manoeuvre; leaves (seeds, cases)."""
    sample: Flight
    """The first test case, flown by the first seed."""
    policy: Policy | None = None
    """All seeds' policies, stacked."""
    curve: LossCurve | None = None
    learning: dict[str, Any] | None = None


PRIMARY = (("primitive", "dnn-combined"), ("primitive", "human-combined"))
"""The family of tests fixed in advance: two pairs by two errors, Holm over the four."""
EXPLORATORY = (
    ("primitive", "primitive-paper"),
    ("primitive", "servo"),
    ("primitive-paper", "human-combined"),
    ("dnn-combined", "human-combined"),
    ("human-combined", "human-combined-undivided"),
    ("primitive", "primitive-zero"),
    ("primitive-matched", "dnn-combined"),
    ("primitive", "dnn-combined-matched"),
)
COMPARED = (*ERRORS, "in_view")
"""In the exploratory family, and whenever somebody compares pilots."""
MARGIN = 0.10
"""Non-inferior: at most 10 % worse (D12)."""

PAPER_TABLE = {
    "human-combined": {"distance": (14.2, 9.0), "radius": (12.9, 21.9)},
    "dnn-combined": {"distance": (12.6, 8.1), "radius": (26.2, 19.1)},
    "primitive": {"distance": (12.9, 8.2), "radius": (10.9, 9.9)},
}
"""Table 4: mean and standard deviation over ten test runs; no unit given."""

SYNTHETIC = (
    "No person flew in this study: every demonstration, and every flight called human, is by a synthetic operator, "
    "a model from the manual-control literature."
)


def summarise(
    study: Study,
    results: Mapping[str, SetupResult],
    operator: list[dict[str, Any]],
    development: list[dict[str, Any]] | None,
    demos: Mapping[str, Demonstrations],
    rig: Rig,
) -> dict[str, Any]:
    """Everything in results.json but the times."""
    scores = {name: result.scores["combined"] for name, result in results.items()}
    primary = compare_pairs(PRIMARY, ERRORS, scores, study.seed)
    exploratory = compare_pairs(EXPLORATORY, COMPARED, scores, study.seed)
    return {
        "version": version("fledge"),
        "seed": study.seed,
        "settings": _settings(study, demos, rig),
        "operator": {"sentence": SYNTHETIC, "axes": operator, "bands": BANDS},
        "setups": {name: _setup_summary(result, study.rows) for name, result in results.items()},
        "comparisons": [
            to_json(comparison) | {"family": family}
            for family, found in (("primary", primary), ("exploratory", exploratory))
            for comparison in found
        ],
        "non_inferiority": [
            _non_inferior(metric, scores, study.seed) for metric in ERRORS if set(PRIMARY[1]) <= set(scores)
        ],
        "paper": {"table": PAPER_TABLE, "welch": _welch()},
        "development": development,
    }


def to_json(found: statistics.Comparison | statistics.NonInferiority) -> dict[str, Any]:
    """Its fields; None where a number is infinite, which JSON cannot say (all flights differed by the same)."""
    return {
        name: None if isinstance(value, float) and not isfinite(value) else value
        for name, value in asdict(found).items()
    }


def compare_pairs(
    pairs: Sequence[tuple[str, str]], metrics: Sequence[str], scores: Mapping[str, Score], seed: int
) -> tuple[statistics.Comparison, ...]:
    """Each pair on each metric, p-values adjusted over all of them; pairs that did not fly are left out."""
    return statistics.with_holm(
        _compare(a, b, metric, scores, seed)
        for a, b in pairs
        if a in scores and b in scores
        for metric in metrics
    )


def _compare(a: str, b: str, metric: str, scores: Mapping[str, Score], seed: int) -> statistics.Comparison:
    """Statistics take lower for better; where higher is, what says who is better is taken the other way round."""
    of_a, of_b = (getattr(scores[name], metric) for name in (a, b))
    found = statistics.compare(a, of_a, b, of_b, metric, seed)
    if METRICS[metric].lower_is_better:
        return found
    return replace(
        found,
        effect_size=statistics.effect_size(of_b, of_a),
        probability_of_improvement=statistics.probability_of_improvement(of_b, of_a),
    )


def _non_inferior(metric: str, scores: Mapping[str, Score], seed: int) -> dict[str, Any]:
    a, b = PRIMARY[1]
    found = statistics.non_inferior(getattr(scores[a], metric), getattr(scores[b], metric), MARGIN, seed)
    return {"a": a, "b": b, "metric": metric} | to_json(found)


def _welch() -> list[dict[str, Any]]:
    """The tests the paper's own printed numbers allow: Welch on mean, sd and n = 10, Holm over the six."""
    pairs = [
        ("human-combined", "dnn-combined"),
        ("human-combined", "primitive"),
        ("dnn-combined", "primitive"),
    ]
    named = [(a, b, metric) for metric in ("distance", "radius") for a, b in pairs]
    found = [
        statistics.welch_p(*PAPER_TABLE[a][metric], 10, *PAPER_TABLE[b][metric], 10) for a, b, metric in named
    ]
    return [
        {"a": a, "b": b, "metric": metric, "p": p, "p_holm": adjusted}
        for (a, b, metric), p, adjusted in zip(named, found, statistics.holm(found), strict=True)
    ]


def summarise_scores(scores: Score, rows: int) -> dict[str, Any]:
    """One line of a table; means over flights."""

    def spread(values: np.ndarray) -> dict[str, float]:
        return {"mean": float(values.mean()), "sd": float(values.std(ddof=1))}

    seconds = rows / ROW_RATE
    return {
        "flights": int(scores.distance.size),
        "distance": spread(scores.distance),
        "radius": spread(scores.radius),
        "distance_rmse_px": float(scores.distance_rmse.mean()),
        "radius_rmse_px": float(scores.radius_rmse.mean()),
        "distance_integral_px_s": float(scores.distance.mean()) * seconds,
        "radius_integral_px2_s": float(scores.radius.mean()) * seconds,
        "in_view": float(scores.in_view.mean()),
        "smoothness": float(scores.smoothness.mean()),
        "effort": float(scores.effort.mean()),
    }


def _setup_summary(result: SetupResult, rows: int) -> dict[str, Any]:
    combined = result.scores["combined"]
    return summarise_scores(combined, rows) | {
        "title": result.setup.title,
        "trained_on": result.setup.trained_on,
        "seeds": len(combined.distance),
        "manoeuvres": {name: summarise_scores(scores, rows) for name, scores in result.scores.items()},
        "scores": {name: np.asarray(getattr(combined, name)).tolist() for name in Score.names()},
        "curve": None if result.curve is None else _curve(member_curve(result.curve, 0)),
        "learning": result.learning,
    }


def _curve(curve: LossCurve) -> dict[str, Any]:
    names = ("all", *curve.names)
    return {
        "epochs": curve.epochs.tolist(),
        "training": {name: curve.training[:, i].tolist() for i, name in enumerate(names)},
        "validation": {name: curve.validation[:, i].tolist() for i, name in enumerate(names)},
    }


def _settings(study: Study, demos: Mapping[str, Demonstrations], rig: Rig) -> dict[str, Any]:
    return {
        "mode": study.mode,
        "command": f"fledge reproduce{'' if study.mode == 'brief' else f' --{study.mode}'} --seed {study.seed}",
        "cases": study.cases,
        "manoeuvre_cases": study.manoeuvre_cases,
        "training_seeds": study.training_seeds,
        "flight_seconds": study.rows / ROW_RATE,
        "row_rate_hz": ROW_RATE,
        "families": {
            "training": TRAINING_FAMILIES,
            "development": DEVELOPMENT_FAMILIES,
            "test": HELD_OUT_FAMILIES,
        },
        "lens": asdict(rig.lens),
        "sticks": asdict(rig.sticks),
        "uav": asdict(rig.uav),
        "ideal_radius_px": rig.ideal_radius,
        "method": asdict(DEFAULT_METHOD) | {"inputs": [OBSERVATION_NAMES[i] for i in DEFAULT_METHOD.inputs]},
        "recipes": {"fast": asdict(Recipe.fast()), "paper": asdict(Recipe.paper())},
        "operator": asdict(HumanModel()),
        "servo": asdict(Servo()),
        "demonstrations": {
            name: {"episodes": len(data.episodes), "rows": data.rows} for name, data in demos.items()
        },
        "versions": {"python": platform.python_version()}
        | {name: version(name) for name in ("fledge", "jax", "jaxlib", "numpy", "optax", "scipy")},
    }
