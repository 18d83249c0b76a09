"""What safety nets cost where nothing is amiss, and what they are worth where something is.

The same flights behind every net, with the same chance (see `bill` for what is counted):

* *combined*: the Combined test flights, among obstacles; the cost is the ratio of the errors to those without a net, on
  the flights in which nothing is touched without one;
* *reversed*: the same with all sticks reversed, as if somebody had mixed up a sign: what a net is for;
* *lab*: lateral flights in a room of the lab's size (D10).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np

from fledge.cores import cores
from fledge.engines import fly, prepare
from fledge.manoeuvres import AbstractManoeuvre, FixedAltitude
from fledge.manoeuvres.paths import HELD_OUT_FAMILIES
from fledge.observation import ROW_RATE, Axes
from fledge.pilots import AbstractPilot
from fledge.safety import NETS, AbstractNet
from fledge.simulation import Case, Crew, Rig, flight_key
from fledge.study.berth import reach, stand_off
from fledge.study.bill import HELD, HORIZON, Bill, billed, watched
from fledge.study.metrics import ERRORS
from fledge.study.setups import TEST_MANOEUVRES
from fledge.study.statistics import non_inferior, upper_bound
from fledge.world import Arena

NAMED = {type(net).__module__.rpartition(".")[2].replace("_", "-"): net for net in NETS}
"""The shipped nets by the names of their modules, as on the command line."""
AXES = {"combined": Axes(), "reversed": Axes(-1.0, -1.0, -1.0), "lab": Axes()}
"""What becomes of the sticks in each kind of flight. Nobody but the pilot holds the altitude, in the lab neither."""
LAB = tuple(
    FixedAltitude(HELD_OUT_FAMILIES, spread, reach=0.7, arena=Arena.lab()) for spread in (0.7, 0.75, 0.8)
)
"""In turn. Reach and spread leave every UGV 0.6 m to the walls; at 0.3 m/s the nets ask for 0.34 m."""
NEAR = 1.0
"""[m] from hull to wall or obstacle: where a net may have to say something."""
MARGIN = 0.02
"""By which a net may raise the errors."""
STAND_OFF = ("paper", "stop-tube")
"""The nets of the figure: the paper's and the default."""


class Trials(NamedTuple):
    """One kind of flights."""

    cases: Sequence[Case]
    keys: Sequence[Sequence[int]]

    @classmethod
    def draw(
        cls, manoeuvres: Sequence[AbstractManoeuvre], purpose: str, count: int, seed: int, rows: int
    ) -> "Trials":
        """So many of them, the manoeuvres in turn."""
        chosen = [manoeuvres[i % len(manoeuvres)] for i in range(count)]
        keys = [flight_key(seed, purpose, one.name, i) for i, one in enumerate(chosen)]
        cases = [Case.draw(one, key, rows) for one, key in zip(chosen, keys, strict=True)]
        return cls(cases, [(*key, 1) for key in keys])


def trials(cases: int, lab_cases: int, seed: int, rows: int) -> dict[str, Trials]:
    """The three kinds of flights; none of a kind that is not asked for."""
    combined = Trials.draw(TEST_MANOEUVRES[:1], "test", cases, seed, rows)
    found = {
        "combined": combined,
        "reversed": combined,
        "lab": Trials.draw(LAB, "lab", lab_cases, seed, rows),
    }
    return {kind: flights for kind, flights in found.items() if flights.cases}


class Entry(NamedTuple):
    """What came of one pilot's flights behind one net."""

    pilot: str
    net: str
    bills: dict[str, Bill]
    """By the kind of flights."""


def examine(
    name: str,
    pilot: AbstractPilot,
    nets: Mapping[str, AbstractNet],
    trials: Mapping[str, Trials],
    rig: Rig = Rig(),
) -> Iterator[Entry]:
    """Fly a pilot behind every net; the kinds of flights are those of `AXES`."""

    def entry(net: str) -> Entry:
        bills = {
            kind: fly(
                flights.cases, Crew(pilot, AXES[kind], nets[net]), flights.keys, rig, billed(rig), watched
            )
            for kind, flights in trials.items()
        }
        return Entry(name, net, bills)

    # Two at a time: the one's programs are compiled while the other flies.
    with cores(2) as pool:
        yield from pool.map(entry, nets)


def compile_ahead(pilot: AbstractPilot, nets: Sequence[str], rows: int, rig: Rig = Rig()) -> None:
    """Begin to compile what `examine` will need for flights of so many rows; of a network only the shape counts."""
    for kind, (cases, keys) in trials(1, 1, 0, rows).items():
        for net in nets:
            prepare(cases, Crew(pilot, AXES[kind], NAMED[net]), keys, rig, watched)


# In numbers.


def summarise(entries: Sequence[Entry], rows: int, seed: int) -> dict[str, Any]:
    """All that is told of nets, in plain JSON values; flights by pilot, kind and net."""
    nets = {entry.net: NAMED[entry.net] for entry in entries}
    return {
        "flights": _flights(entries, rows, seed),
        "reach": reach(nets, Arena.lab()),
        "stand_off": stand_off({name: net for name, net in nets.items() if name in STAND_OFF}),
        "settings": {
            "horizon_s": HORIZON / ROW_RATE,
            "held_s": HELD / ROW_RATE,
            "near_m": NEAR,
            "margin": MARGIN,
        },
    }


def _flights(entries: Sequence[Entry], rows: int, seed: int) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for entry in entries:
        free = next((one.bills for one in entries if (one.pilot, one.net) == (entry.pilot, "none")), None)
        for kind, bill in entry.bills.items():
            numbers = _numbers(bill, rows)
            if free is not None and entry.net != "none" and kind == "combined":
                numbers["cost"] = cost(bill, free[kind], seed)
            found.setdefault(entry.pilot, {}).setdefault(kind, {})[entry.net] = numbers
    return found


def _numbers(bill: Bill, rows: int) -> dict[str, Any]:
    flights = len(bill.gap)
    hours = flights * rows / ROW_RATE / 3600.0
    touched = int((bill.gap <= 0.0).any(axis=1).sum())
    people = int(bill.held.sum())
    return {
        "flights": flights,
        "interventions": _shares(bill.interventions, rows),
        "false_alarms": _shares(bill.needless, rows),
        "contacts": touched,
        "upper_bound_95": upper_bound(touched, flights),
        "least_gap_m": {"uav": float(bill.gap[:, 0].min()), "ugv": float(bill.gap[:, 1:].min())},
        "near": {
            "uav": float((bill.thing[:, 0] < NEAR).mean()),
            "ugv": float((bill.thing[:, 1:] < NEAR).any(axis=1).mean()),
        },
        "human_interventions": people,
        "human_interventions_per_hour": people / hours,
        "distance_rmse_px": float(bill.score.distance_rmse.mean()),
        "radius_rmse_px": float(bill.score.radius_rmse.mean()),
        "in_view": float(bill.score.in_view.mean()),
    }


def _shares(counts: np.ndarray, rows: int) -> dict[str, float]:
    """Of the UAV's steps, of the UGVs' and of all steps, whichever vehicle it was."""
    shares = np.asarray(counts).mean(axis=0) / rows
    return {"uav": float(shares[0]), "ugv": float(shares[1:-1].mean()), "any": float(shares[-1])}


def cost(bill: Bill, free: Bill, seed: int) -> dict[str, Any] | None:
    """How many times as large the errors are as without a net, on flights that go well without; None if none do."""
    well = (free.gap > 0.0).all(axis=1)
    if well.sum() < 2:
        return None
    found: dict[str, Any] = {"flights": int(well.sum())}
    for error in ERRORS:
        behind, without = (getattr(one.score, error)[None, well] for one in (bill, free))
        found[error] = asdict(non_inferior(behind, without, MARGIN, seed))
    return found
