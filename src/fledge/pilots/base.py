"""The protocol of a pilot: synthetic operator, servo, trained network and person are all one.

A pilot sees only the `Observation`, as the person in the paper did, never the world. It holds parameters; its
memory is passed, so one pilot can fly ten thousand scenes at once. Chance comes in as an argument: four
independent standard normal numbers per decision, to use or to ignore.

A pilot written with `fledge.scalars` (or with `jax.numpy`) is compiled; any other Python is flown too, in
plain Python, one flight after the other.
"""

from abc import ABC, abstractmethod
from typing import Any

from fledge.observation import Action, Observation
from fledge.scalars import Scalar

Noise = tuple[Scalar, Scalar, Scalar, Scalar]


class AbstractPilot(ABC):
    """Turns what is seen into what is said, 20 times a second."""

    name: str
    """What the command line and the files call it."""
    restless = False
    """Whether it flies to see how vehicles stop; UGVs that are ours then stop every now and then, too."""

    def init(self) -> Any:
        """The memory at the start of a flight: numbers in tuples or records; `()` for none."""
        return ()

    @abstractmethod
    def act(self, memory: Any, observation: Observation, noise: Noise) -> tuple[Any, Action]:
        """(memory, action): decide on what is seen now."""

    def for_axes(self, axes: tuple[int, ...]) -> "AbstractPilot":
        """The pilot as it flies when only these actions are in use; most do not care."""
        return self
