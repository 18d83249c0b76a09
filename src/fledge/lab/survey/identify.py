"""What a safety net relies on, found out from flights of one's own vehicles.

| of the terms | how it is found |
|---|---|
| `latency` | the delay of the tilt behind the wire (`answers`), and a period: the vehicle has ticks, too |
| `velocity_error`, `rate_error` | the most by which estimates differ from smoothed poses, and a tenth more |
| `position_error`, `angle_error` | five deviations of the poses' noise, but not less than the contract has: see below |
| `disturbance` | the strongest push after any stop, and a tenth more, but not less than the contract has |
| `speed` to `error_up` | the linear law of stops, with bounds on what it misses (`stops`, `bounds`) |
| `hold` | as the simulated vehicle's, in proportion to `speed` (how soft the loop is) and `disturbance` |
| `most`, `most_up` | the largest commands flown; of larger ones nothing is known |
| of UGVs | the least deceleration of any stop (`brakes`); as the simulated ones' where they said nothing |

The rest stays as the contract has it: the net's own period and the age beyond which it believes nothing, hulls, what a
vehicle does when its link is lost, `error_turn`, since the exciter does not turn. A calibration that is wrong by a
centimetre looks right from inside, and weather changes: so noise and pushes that were seen can only raise a bound.

Flights that show too little are refused. So nothing here is a guess, but for what is said above.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil, isfinite
from typing import NamedTuple

import numpy as np

from fledge.errors import FledgeError
from fledge.lab.survey.answers import Answer, answer, delay
from fledge.lab.survey.bounds import MORE, most
from fledge.lab.survey.brakes import Brakes, brakes
from fledge.lab.survey.smoothing import smooth
from fledge.lab.survey.stops import Flown, Law, fit, flown, found, pushes
from fledge.lab.survey.traces import Driven, Trace
from fledge.safety.contract import Contract, UavStop, UgvStop
from fledge.safety.terms import Terms
from fledge.supervision.watchdog import TICK

STOPS, FAST_STOPS, CLIMBS = 40, 12, 40
"""Stops in the plane, those of them that begin at `FAST`, and stops in height: fewer say nothing of the one in a
thousand. Chosen: two minutes of the exciter have fifty of each."""
FAST = 0.3
"""[m/s]."""
LATEST = 0.15
"""[s] of delay at most with which the nets' law still fits; chosen, beyond it a loop would swing."""
DEVIATIONS = 5.0
"""Standard deviations of a pose's noise that count as its error."""
RECIPE = "fly two minutes or more of `fledge fly --pilot exciter --axes forward left up`"


@dataclass(frozen=True, slots=True)
class Findings:
    """What was found beside the terms, for people."""

    flights: int
    seconds: float
    """That the vehicle was ours to lead."""
    stops: int
    fast_stops: int
    """Those that began at `FAST` or more."""
    fastest: float
    """[m/s] of a stop's beginning."""
    climbs: int
    """Stops in height."""
    delay: float
    """From a command's sending to its effect [s]."""
    pose_age: float
    """Of the newest pose when it was used, in the mean [s], by its stamp."""
    oldest_pose: float
    """[s]."""
    answer: Answer
    """Ramp and tracking error."""
    drift: float
    """Of a vehicle told to hover, in the mean [m/s]."""
    most_drift: float
    """[m/s]."""
    push: float
    """The strongest [m/s^2]."""
    missed: float
    """Mean of how far stops went beyond the prediction, in the plane [m]."""
    most_missed: float
    """[m]."""
    ugv_stops: tuple[int, ...]
    """Of each UGV; 0 where it was not ours to command."""


class Identified(NamedTuple):
    """All of it."""

    terms: Terms
    findings: Findings


def identify(traces: Sequence[Trace], lag: float, before: Terms = Terms()) -> Identified:
    """Terms for the vehicles of these flights; `lag` [s] is that of the velocity loop's command filter.

    Raises:
        FledgeError: the flights show too little; says what there was and what it takes.
    """
    flights = [flown(trace) for trace in traces]
    _check_enough(flights)
    dead = delay(traces)
    contract = _contract(traces, flights, dead, before.contract)
    law = fit(flights, contract, lag)
    drifts, pushed = pushes(flights, contract, law.stop)
    contract = replace(contract, disturbance=max(before.contract.disturbance, MORE * float(pushed.max())))
    stop = _stop(law, flights, contract, before)
    braked = _braked(traces, contract)
    ugvs = tuple(_ugv(one, of) for one, of in zip(before.ugvs, braked, strict=True))
    ages = np.concatenate([trace.t - trace.stamp for trace in traces])
    findings = Findings(
        flights=len(traces),
        seconds=TICK * sum(int(np.isfinite(trace.told[:, 0]).sum()) for trace in traces),
        stops=len(law.level),
        fast_stops=int((law.speeds >= FAST).sum()),
        fastest=float(law.speeds.max()),
        climbs=len(law.height),
        delay=dead,
        pose_age=float(ages.mean()),
        oldest_pose=float(ages.max()),
        answer=answer(flights, dead if isfinite(dead) else contract.latency),
        drift=float(drifts.mean()),
        most_drift=float(drifts.max()),
        push=float(pushed.max()),
        missed=float(law.level.mean()),
        most_missed=float(law.level.max()),
        ugv_stops=tuple(one.stops for one in braked),
    )
    return Identified(Terms(contract, stop, ugvs), findings)


def _check_enough(flights: Sequence[Flown]) -> None:
    level = [(flight, one) for flight in flights for one in found(flight, (0, 1))]
    climbs = sum(len(found(flight, (2,))) for flight in flights)
    speeds = [np.hypot(f.state.velocity.x[one.begin], f.state.velocity.y[one.begin]) for f, one in level]
    fast = sum(bool(speed >= FAST) for speed in speeds)
    if len(level) < STOPS or fast < FAST_STOPS or climbs < CLIMBS:
        raise FledgeError(
            f"{len(flights)} flights with {len(level)} stops in the plane, {fast} of them from {FAST:g} m/s or more, "
            f"and {climbs} in height: valid are {STOPS}, {FAST_STOPS} and {CLIMBS} or more; {RECIPE}"
        )


def _contract(traces: Sequence[Trace], flights: Sequence[Flown], dead: float, before: Contract) -> Contract:
    """What the data are like."""
    if dead > LATEST:
        raise FledgeError(
            f"the vehicle answers {dead:.3f} s after it was told: valid is {LATEST:g} s or less; look to the link"
        )
    # A tick may end up to a period after a command has come; rounded up, since commands are sent in periods.
    late = (ceil(dead / before.period - 1e-6 - 0.2) + 1) * before.period if isfinite(dead) else before.latency
    velocity, rate, place, angle = (np.array([]),) * 4
    for trace, flight in zip(traces, flights, strict=True):
        seen = flight.known & np.isfinite(trace.told[:, 0])
        s = flight.state
        v = np.stack([s.velocity.x, s.velocity.y, s.velocity.z], axis=1)
        w = np.stack([s.rates.x, s.rates.y, s.rates.z], axis=1)
        p = np.stack([s.position.x, s.position.y, s.position.z], axis=1)
        velocity = np.append(velocity, (trace.velocity - v)[seen])
        rate = np.append(rate, (trace.rates - w)[seen])
        place = np.append(place, (trace.position - p)[seen])
        angle = np.append(angle, 2.0 * (trace.attitude - smooth(trace.stamp, trace.attitude).value)[seen])
        for ugv in trace.ugvs:
            speed, turn = _driving(ugv)
            velocity, rate = np.append(velocity, speed[seen]), np.append(rate, turn[seen])
    return replace(
        before,
        latency=late,
        velocity_error=most(velocity),
        rate_error=most(rate),
        position_error=max(before.position_error, DEVIATIONS * float(place.std())),
        angle_error=max(before.angle_error, DEVIATIONS * float(angle.std())),
    )


def _driving(ugv: Driven) -> tuple[np.ndarray, np.ndarray]:
    """By how much a UGV's speed and turn rate were estimated wrong."""
    moved = smooth(ugv.stamp, np.stack([ugv.x, ugv.y, ugv.heading], axis=1))
    nose = moved.value[:, 2]
    speed = moved.slope[:, 0] * np.cos(nose) + moved.slope[:, 1] * np.sin(nose)
    return ugv.speed - speed, ugv.turn_rate - moved.slope[:, 2]


def _stop(law: Law, flights: Sequence[Flown], contract: Contract, before: Terms) -> UavStop:
    """The law, with what it does not say."""
    told = np.concatenate([np.abs(np.nan_to_num(flight.commands)) for flight in flights])
    soft = law.stop.speed / before.uav.speed * contract.disturbance / before.contract.disturbance
    return replace(
        before.uav,
        most=min(before.uav.most, float(np.hypot(told[:, 0], told[:, 1]).max())),
        most_up=min(before.uav.most_up, float(told[:, 2].max())),
        hold=before.uav.hold * soft,
        **{name: float(getattr(law.stop, name)) for name in FITTED},
    )


FITTED = (
    "speed",
    "tilt",
    "rate",
    "followed",
    "error",
    "error_speed",
    "speed_up",
    "followed_up",
    "error_up",
    "lag",
)
"""What a law says of a `UavStop`."""


def _braked(traces: Sequence[Trace], contract: Contract) -> list[Brakes]:
    """Of each UGV, what all flights say."""
    reaction = contract.latency + contract.period
    each = []
    for ugv in zip(*(trace.ugvs for trace in traces), strict=True):
        said = [brakes(one, reaction) for one in ugv]
        least = [np.array([getattr(one, name) for one in said]) for name in Brakes._fields]
        hard, turning = (
            float(np.nanmin(one)) if np.isfinite(one).any() else float("nan") for one in least[:2]
        )
        each.append(Brakes(hard, turning, int(least[2].sum()), int(least[3].sum()), float(least[4].max())))
    return each


def _ugv(before: UgvStop, said: Brakes) -> UgvStop:
    """As it brakes, where it said so."""
    return replace(
        before,
        acceleration=said.acceleration if isfinite(said.acceleration) else before.acceleration,
        turn_acceleration=said.turn_acceleration
        if isfinite(said.turn_acceleration)
        else before.turn_acceleration,
    )
