"""Flights and results that are quickly made up."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import charged
import numpy as np
import pytest

from fledge.episode import Episode, Flight
from fledge.geometry import Box, Quat, Vec3
from fledge.observation import Action
from fledge.report.figures.looks import FLOWN, LOOKS, PARTS
from fledge.world import Arena, Obstacle, UavState, UgvState, WorldState

ROWS = 60


def hover(pilot: str, spread: float = 0.8, height: float = 2.0, aside: float = 0.0) -> Flight:
    """A UAV that hovers `aside` metres east of a triangle of UGVs, its nose to the east."""
    one, zero = np.ones(ROWS), np.zeros(ROWS)
    t = np.arange(ROWS) / 20.0
    still = Vec3(zero, zero, zero)
    corners = [2.0 * np.pi * i / 3.0 for i in range(3)]
    ugvs = tuple(
        UgvState(spread * np.cos(a) * one, spread * np.sin(a) * one, zero, zero, zero, t) for a in corners
    )
    uav = UavState(Vec3(aside * one, zero, height * one), still, Quat.from_yaw(zero), still, t)
    action = Action(np.sin(t), np.cos(t), zero, zero)
    unseen = cast(Any, None)
    episode = Episode(WorldState(t, uav, ugvs), unseen, action, unseen, (), spread * one)
    arena = replace(Arena.square(), obstacles=(Obstacle(Box(1.0, 1.4, 1.0, 1.3), 0.5),)).padded(3)
    return Flight(episode, "combined", pilot, "none", 0, 0, (0, 1, 2), arena)


@pytest.fixture(scope="session")
def still_flight() -> Callable[..., Flight]:
    return hover


@pytest.fixture(scope="session")
def flights() -> dict[str, Flight]:
    return {name: hover(name) for name in FLOWN}


@pytest.fixture(scope="session")
def results() -> dict[str, Any]:
    rng = np.random.default_rng(0)
    losses = {name: (0.1 / np.arange(1, 21)).tolist() for name in ("all", *PARTS)}
    curve = {"epochs": list(range(1, 21)), "training": losses, "validation": losses}
    setups = {
        name: {
            "curve": curve if name.startswith("primitive") else None,
            "scores": {
                metric: rng.uniform(5.0, 50.0, (2, 9)).tolist() for metric in ("distance_rmse", "radius_rmse")
            },
        }
        for name in (*LOOKS, "somebody's", "own")
    }
    comparisons = [
        {
            "family": family,
            "a": "primitive",
            "b": b,
            "metric": metric,
            "difference": 1.0,
            "interval": [-1.0, 3.0],
        }
        for family in ("primary", "exploratory")
        for b in ("human-combined", "own")
        for metric in ("distance_rmse", "radius_rmse", "in_view")
    ]
    return {"setups": setups, "comparisons": comparisons, "nets": charged.nets()}
