"""What a physical experiment brings home, without flying it."""

import numpy as np
from field import found

from fledge.pilots import Servo
from fledge.runs.labwork import Harvest, Plan
from fledge.safety import NoNet, StopTube
from fledge.study.evaluation import Score
from fledge.world import Arena

NETS = {"stop-tube": StopTube(), "none": NoNet()}
PLAN = Plan(Servo(), "servo", NETS, Arena.lab(), flights=6, seconds=2.0)


def harvest(plan=PLAN):
    """Flights that nobody flew: behind `none` those reversed leave the room."""
    twin = {
        (kind, net): [
            found(net, aside=0.1 * i, leaving=2.0 * (kind == "reversed" and net == "none"), seed=seed)
            for i, seed in enumerate(plan.seeds)
        ]
        for kind in plan.kinds
        for net in plan.nets
    }
    return Harvest(twin, Score(*(np.full((1, plan.flights), 7.0) for _ in Score.names())))
