"""Made-up flights of the physical experiment: what came of them, and a flight to be drawn and stored."""

import numpy as np

from fledge.episode import Episode, Flight
from fledge.geometry import Quat, Vec3
from fledge.lab.outing import Found
from fledge.observation import Action, Observation
from fledge.world import Arena, Commands, UavState, UgvState, VelocityCommand, Verdict, WorldState

ROWS = 40


def numbers(**changes):
    """Of one flight in which nothing was amiss."""
    quiet = {"net": {}, "watchdog": {}, "people": {}}
    return {
        "flown_s": 2.0,
        "in_view": 1.0,
        "interventions": quiet,
        "takeovers": 0,
        "human_interventions_needed": 0,
        "contacts": 0,
        "contacts_landing": 0,
        "touched": [],
        "least_gap_m": {"uav": 0.5, "ugv": 0.3},
        "ticks": 900,
        "landed": True,
        "seed": 0,
        "rows": ROWS,
        "aloft_s": 6.0,
        "held": 0.0,
    } | changes


def flight(net="stop-tube", aside=0.0, leaving=0.0, seed=0):
    """A UAV that hovers `aside` metres east of three UGVs, or leaves eastwards at `leaving` m/s."""
    t, one, zero = np.arange(ROWS) / 20.0, np.ones(ROWS), np.zeros(ROWS)
    still, hover = Vec3(zero, zero, zero), VelocityCommand(zero, zero, zero, zero)
    corners = [2.0 * np.pi * i / 3.0 for i in range(3)]
    ugvs = tuple(UgvState(0.7 * np.cos(a) * one, 0.7 * np.sin(a) * one, zero, zero, zero, t) for a in corners)
    uav = UavState(Vec3(aside + leaving * t, zero, 2.4 * one), still, Quat.from_yaw(zero), still, t)
    episode = Episode(
        WorldState(t, uav, ugvs),
        Observation(*(one,) * 11),
        Action(zero, zero, zero, zero),
        Commands(hover, (hover,) * 3),
        (Verdict(hover, zero, zero, one),) * 4,
        0.7 * one,
    )
    return Flight(episode, "lab", "servo", net, seed, 0, (0, 1), Arena.lab())


def found(net="stop-tube", aside=0.0, leaving=0.0, seed=0, **changes):
    """Both."""
    return Found(numbers(seed=seed, **changes), flight(net, aside, leaving, seed))
