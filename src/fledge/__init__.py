"""fledge: robots that learn a composite skill from demonstrations of its simple parts.

The public names. Each is imported when it is first used: importing fledge loads neither JAX nor matplotlib.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fledge.camera import Lens
    from fledge.engines import fly, fly_plain
    from fledge.errors import FledgeError
    from fledge.learning.demonstrations import Demonstrations
    from fledge.learning.fusion import CompositeSet, SubTask, estimate_delay, fuse
    from fledge.learning.policy import Contract, Policy
    from fledge.learning.recipe import Recipe
    from fledge.learning.training import LossCurve, fit
    from fledge.manoeuvres import AbstractManoeuvre
    from fledge.observation import Action, Observation
    from fledge.pilots import AbstractPilot
    from fledge.safety import AbstractNet
    from fledge.simulation import Case, Crew, Rig
    from fledge.storage import read_flight, read_policy, write_flight, write_policy

_HOME = {
    "AbstractManoeuvre": "manoeuvres",
    "AbstractNet": "safety",
    "AbstractPilot": "pilots",
    "Action": "observation",
    "Case": "simulation",
    "CompositeSet": "learning.fusion",
    "Contract": "learning.policy",
    "Crew": "simulation",
    "Demonstrations": "learning.demonstrations",
    "FledgeError": "errors",
    "Lens": "camera",
    "LossCurve": "learning.training",
    "Observation": "observation",
    "Policy": "learning.policy",
    "Recipe": "learning.recipe",
    "Rig": "simulation",
    "SubTask": "learning.fusion",
    "estimate_delay": "learning.fusion",
    "fit": "learning.training",
    "fly": "engines",
    "fly_plain": "engines",
    "fuse": "learning.fusion",
    "read_flight": "storage",
    "read_policy": "storage",
    "write_flight": "storage",
    "write_policy": "storage",
}

__all__ = [
    "AbstractManoeuvre",
    "AbstractNet",
    "AbstractPilot",
    "Action",
    "Case",
    "CompositeSet",
    "Contract",
    "Crew",
    "Demonstrations",
    "FledgeError",
    "Lens",
    "LossCurve",
    "Observation",
    "Policy",
    "Recipe",
    "Rig",
    "SubTask",
    "estimate_delay",
    "fit",
    "fly",
    "fly_plain",
    "fuse",
    "read_flight",
    "read_policy",
    "write_flight",
    "write_policy",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'fledge' has no attribute {name!r}")
    return getattr(import_module(f"fledge.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return __all__
