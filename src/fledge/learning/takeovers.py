"""What people did who took a flight over, as demonstrations: a sub-task of its own for the composite set.

A policy that flies where nobody demonstrated drifts away from what it learnt on; a person who takes over there shows
what should have been done there. That is the idea of DAgger (Ross, Gordon, Bagnell 2011), with the person deciding when
(HG-DAgger: Kelly et al. 2019).

A row counts if the supervisor says that a person had the command in it and the net let it pass as it was: then the
action is what was sent, in sticks. Every take-over is an episode of its own; one shorter than a second is left out.
"""

from collections.abc import Sequence
from dataclasses import astuple

import numpy as np

from fledge.episode import Flight
from fledge.learning.demonstrations import Pair
from fledge.learning.fusion import SubTask
from fledge.observation import OBSERVATION_NAMES, ROW_RATE
from fledge.world import Reason

TAKE_OVERS = SubTask("take-overs", (0, 1, 2))
"""A person at the sticks may use them all; turning is never learnt (D1)."""
LEAST = round(ROW_RATE)
"""Rows of a take-over that counts."""


def corrections(flights: Sequence[Flight]) -> list[Pair]:
    """(states, actions) of every take-over in flights, shapes (rows, 11) and (rows, 3)."""
    return [pair for flight in flights for pair in _of_flight(flight)]


def _of_flight(flight: Flight) -> list[Pair]:
    seen, verdict = flight.episode.observation, flight.episode.verdicts[0]
    by_person = np.asarray(verdict.reason) == Reason.TAKE_OVER
    states = np.stack([np.asarray(getattr(seen, name), float) for name in OBSERVATION_NAMES], axis=1)
    action = flight.sticks.action(verdict.command)
    said = np.stack([np.asarray(axis, float) for axis in astuple(action)], axis=1)[
        :, list(TAKE_OVERS.actions)
    ]
    edges = np.flatnonzero(np.diff(by_person, prepend=False, append=False)).reshape(-1, 2)
    return [(states[begin:end], said[begin:end]) for begin, end in edges.tolist() if end - begin >= LEAST]
