"""What results.json says of nets, made up: what the tests of page and figures have in common."""

from typing import Any

NAMES = ("none", "paper", "stop-tube")
COSTS = {"paper": 1.689, "stop-tube": 1.007}
CONTACTS = {"none": 20, "paper": 17, "stop-tube": 0}


def nets() -> dict[str, Any]:
    """One pilot, three nets, three kinds of flights."""
    return {
        "flights": {"primitive": {kind: _flights(kind) for kind in ("combined", "reversed", "lab")}},
        "reach": {
            name: {"uav": _reach((0.0, 0.25, 0.5, 1.0)), "ugv": _reach((0.0, 0.25, 0.5))} for name in NAMES
        },
        "stand_off": {
            "t_s": [0.0, 0.05, 0.1],
            "gap_m": {"paper": [0.4, 0.1, -0.1], "stop-tube": [0.4, 0.3, 0.6]},
            "called_back_s": 0.05,
        },
        "settings": {"horizon_s": 3.0, "held_s": 5.0, "near_m": 1.0, "margin": 0.02},
    }


def _flights(kind: str) -> dict[str, Any]:
    found = {name: _one(name, kind) for name in NAMES}
    if kind == "combined":
        for name, ratio in COSTS.items():
            error = {"ratio": ratio, "upper": ratio + 0.011, "margin": 0.02, "holds": ratio < 1.02}
            found[name]["cost"] = {"flights": 19, "distance_rmse": error, "radius_rmse": error}
    return found


def _one(name: str, kind: str) -> dict[str, Any]:
    share = 0.0 if name == "none" else 0.0123
    return {
        "flights": 20,
        "interventions": {"uav": share, "ugv": 2.0 * share, "any": 3.0 * share},
        "false_alarms": {"uav": 0.0, "ugv": share, "any": share},
        "contacts": CONTACTS[name] if kind == "reversed" else 0,
        "least_gap_m": {"uav": 0.1, "ugv": 0.2},
        "near": {"uav": 0.05, "ugv": 0.95},
        "human_interventions": 7,
        "human_interventions_per_hour": 21.5,
        "distance_rmse_px": 21.5,
        "radius_rmse_px": 6.1,
        "in_view": 1.0,
    }


def _reach(speeds: tuple[float, ...]) -> list[dict[str, float]]:
    return [{"speed": speed, "margin_m": 0.38 + speed, "share": 0.74 - 0.2 * speed} for speed in speeds]
