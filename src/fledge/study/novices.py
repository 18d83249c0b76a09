"""Two policies that have seen little, for want of better ones to put behind a net.

One is trained by the default method, one by the paper's to the letter, on sub-tasks that the synthetic operator
demonstrates on the spot. What they cannot do yet is what makes them worth catching.
"""

from collections.abc import Iterator
from dataclasses import replace

from fledge.learning.demonstrations import PAPER_ORDERS, Order, collect
from fledge.learning.policy import Policy
from fledge.learning.training import member
from fledge.pilots import HumanModel
from fledge.simulation import Rig
from fledge.study.experiments import Progress, by_sub_task, learn
from fledge.study.setups import BASIC, Study

ORDERS = tuple(Order(order.manoeuvre, 4, 2000) for order in PAPER_ORDERS[:3])
"""A good third of the paper's demonstrations."""
SETUPS = tuple(setup for setup in BASIC if setup.trained_on == "sub-tasks")


def novices(seed: int, rig: Rig = Rig()) -> Iterator[Progress | dict[str, Policy]]:
    """Progress, and in the end the policies by the names of their set-ups."""
    demonstrations = by_sub_task(list(collect(ORDERS, HumanModel(), seed, rig)), "sub-tasks")
    study = Study("novices", SETUPS, 0, 0, training_seeds=1, seed=seed)
    trained: dict[str, Policy] = {}
    for setup in SETUPS:
        for event in learn(setup, demonstrations, study, rig):
            if isinstance(event, Progress):
                yield event
            else:
                trained[setup.name] = replace(member(event.policy, 0), contract=None)
    yield trained
