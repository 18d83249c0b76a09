"""Demonstrations flown through the cockpit: do they train as good a policy as those of `fledge demonstrate`?

A scripted operator sits where a person would: it sees the frames that a page sees, thirty a second, and says sticks,
twenty a second, in real time. It is the synthetic operator (`human-model`), so nothing but the way in differs. All
sets have the paper's episodes and rows; of each eight networks are trained by the default method, and all fly the same
200 Combined test flights.

Sets by one and the same operator differ by chance, too, and so do the policies they make. So the cockpit's set stands
beside eight by `fledge demonstrate`, of as many seeds, the first of them with the cockpit's own scenes: it is as good
as one of theirs if its error lies in, or below, the interval in which the next one would lie (95 %, Student's t).

    python benchmarks/by_hand.py [--seed N] [--json FILE]   (a quarter of an hour in real time, then ten minutes)
"""

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from statistics import fmean, stdev
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.stats import t
from visitor import Server, Visitor, visiting

from fledge.cockpit.asks import Fly, Keep
from fledge.cockpit.tells import Frame, Stored
from fledge.episode import Flight
from fledge.learning.demonstrations import PAPER_ORDERS, Order
from fledge.observation import Observation
from fledge.pilots import HumanModel
from fledge.runs import logbook
from fledge.simulation import Rig
from fledge.study import statistics
from fledge.study.evaluation import Score
from fledge.study.experiments import Learnt, by_sub_task, learn
from fledge.study.findings import COMPARED, MARGIN
from fledge.study.metrics import ERRORS
from fledge.study.proving import fly_tests
from fledge.study.setups import Study

ROW = 0.05
"""[s] between two decisions."""
SETS = 8
"""By `fledge demonstrate`."""
SUB_TASKS = [order for order in PAPER_ORDERS if order.manoeuvre.name != "combined"]


def seen(frame: Frame) -> Observation:
    """What the operator looks at: the picture, and the height."""
    p, z = frame.picture, frame.vehicles[0].z
    return Observation(320.0, 180.0, p.u, p.v, z, p.ideal_radius, p.radius, 0.0, 0.0, 0.0, 0.0)


def demonstrate(visitor: Visitor, order: Order, seed: int, rng: np.random.Generator) -> None:
    """One flight, to its end; kept."""
    pilot = HumanModel().for_axes(order.manoeuvre.axes)
    memory: Any = pilot.init()
    visitor.begin(Fly(order.manoeuvre.name, "person", "stop-tube", seed=seed, record="demonstration"))
    due = time.monotonic()
    while visitor.flight is None or visitor.flight.state != "over":
        assert visitor.frame is not None
        noise = tuple(rng.standard_normal(4).tolist())
        memory, action = pilot.act(memory, seen(visitor.frame), noise)
        visitor.sticks((action.forward, action.left, action.up, action.turn), arm=True)
        due += ROW
        time.sleep(max(due - time.monotonic(), 0.0))
    kept = sum(isinstance(one, Stored) for one in visitor.told)
    visitor.say(Keep())
    while sum(isinstance(one, Stored) for one in visitor.told) == kept:
        time.sleep(0.02)


def by_hand(folder: Path, seed: int) -> list[Flight]:
    """The paper's demonstrations of all sub-tasks."""
    server, rng = Server(folder), np.random.default_rng(seed)
    with visiting(server) as visitor:
        for order in SUB_TASKS:
            for number in range(order.episodes):
                demonstrate(visitor, order, seed, rng)
                print(f"{order.manoeuvre.name} {number + 1} of {order.episodes}", flush=True)
    server.stop()
    return logbook.read(folder / "demos")


def flown(flights: list[Flight], combined: list[Flight], study: Study) -> Score:
    """Scores of all networks on all test cases, leaves (seeds, cases)."""
    setup = next(one for one in study.setups if one.name == "primitive")
    *_, learnt = learn(setup, by_sub_task([*flights, *combined]), study, Rig())
    assert isinstance(learnt, Learnt)
    return fly_tests(setup, study, replace(learnt.policy, contract=None), Rig())[0]


def next_one(values: list[float]) -> tuple[float, float]:
    """The interval in which one more of a kind would lie, with 95 %."""
    n = len(values)
    low, high = t.interval(0.95, n - 1, fmean(values), stdev(values) * (1.0 + 1.0 / n) ** 0.5)
    return float(low), float(high)


def main() -> None:
    """Demonstrate both ways, train, fly, compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    study = Study.of("brief", asked.seed)
    with TemporaryDirectory() as name:
        folder = Path(name)
        ours = by_hand(folder, asked.seed)
        theirs = [
            logbook.fill(folder / str(seed), PAPER_ORDERS, HumanModel(), seed)
            for seed in range(asked.seed, asked.seed + SETS)
        ]
    combined = [flight for flight in theirs[0] if flight.manoeuvre == "combined"]  # nobody learns from these
    cockpit = flown(ours, combined, study)
    others = []
    for number, flights in enumerate(theirs):
        others.append(flown([one for one in flights if one.manoeuvre != "combined"], combined, study))
        print(f"fledge demonstrate, set {number + 1} of {SETS}: trained and flown", flush=True)
    found: dict[str, Any] = {"rows": sum(flight.rows for flight in ours), "seed": asked.seed, "metrics": {}}
    for metric in COMPARED:
        mine, values = getattr(cockpit, metric), [float(getattr(one, metric).mean()) for one in others]
        low, high = next_one(values)
        as_good = mine.mean() >= low if metric == "in_view" else mine.mean() <= high
        found["metrics"][metric] = {
            "cockpit": float(mine.mean()),
            "demonstrate": values,
            "interval": [low, high],
            "as_good": bool(as_good),
        }
        if metric in ERRORS:  # of the policies of these two sets, not of sets: the one with the same scenes
            bound = statistics.non_inferior(mine, getattr(others[0], metric), MARGIN, asked.seed)
            found["metrics"][metric] |= {"ratio_to_first": bound.ratio, "upper_bound": bound.upper}
    print(json.dumps(found, indent=1))
    if asked.json:
        asked.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
