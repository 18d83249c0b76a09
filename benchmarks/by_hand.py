"""Demonstrations flown through the cockpit: do they train as good a policy as those of `fledge demonstrate`?

A scripted operator sits where a person would: it sees the frames that a page sees, thirty a second, and says sticks,
twenty a second, in real time. It is the synthetic operator (`human-model`), so nothing but the way in differs. Both
sets have the paper's episodes and rows; of each eight networks are trained by the default method, and all fly the same
200 Combined test flights.

    python benchmarks/by_hand.py [--seed N] [--json FILE]     (a quarter of an hour in real time, then three minutes)
"""

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
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
from fledge.study.findings import MARGIN, compare_pairs
from fledge.study.proving import fly_tests
from fledge.study.setups import Study

ROW = 0.05
"""[s] between two decisions."""
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


def main() -> None:
    """Demonstrate both ways, train, fly, compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    study = Study.of("brief", asked.seed)
    with TemporaryDirectory() as folder:
        ours = by_hand(Path(folder), asked.seed)
        theirs = logbook.fill(Path(folder) / "logbook", PAPER_ORDERS, HumanModel(), asked.seed)
        combined = [flight for flight in theirs if flight.manoeuvre == "combined"]  # nobody learns from these
        scores = {
            "cockpit": flown(ours, combined, study),
            "demonstrate": flown([one for one in theirs if one.manoeuvre != "combined"], combined, study),
        }
    found: dict[str, Any] = {"rows": sum(flight.rows for flight in ours), "seed": asked.seed, "metrics": {}}
    for metric in ("distance_rmse", "radius_rmse", "in_view"):
        of = {name: getattr(score, metric) for name, score in scores.items()}
        (difference,) = compare_pairs([("cockpit", "demonstrate")], [metric], scores, asked.seed)
        found["metrics"][metric] = {
            **{name: float(values.mean()) for name, values in of.items()},
            "difference": difference.difference,
            "interval": list(difference.interval),
            "p": difference.p,
        }
        if metric != "in_view":
            bound = statistics.non_inferior(of["cockpit"], of["demonstrate"], MARGIN, asked.seed)
            found["metrics"][metric] |= {"ratio": bound.ratio, "upper_bound": bound.upper}
    print(json.dumps(found, indent=1))
    if asked.json:
        asked.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
