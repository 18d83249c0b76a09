"""The trained network: 11-300-300-4, ReLU inside, tanh outside (section "Experiments"), and what it was made for.

A `Policy` is a `Pilot`: normalise, three layers, done; no memory. The same record flies in the simulator (its arrays
are JAX's) and in the lab (NumPy's, some ten microseconds a call). The normaliser is part of it, so it cannot be
lost on the way. A `Contract` says for which eyes and hands it was trained; a rig that differs refuses it.

A policy need not know anything of drones: without a contract it is a map from states to actions.
"""

from dataclasses import asdict, dataclass, field, fields
from itertools import pairwise
from typing import Any

import numpy as np

from fledge.camera import Lens
from fledge.errors import ContractMismatch, FledgeError
from fledge.observation import (
    ACTION_NAMES,
    IDEAL_RADIUS_PX,
    OBSERVATION_NAMES,
    OBSERVATION_UNITS,
    ROW_RATE,
    Action,
    Observation,
    StickScale,
)
from fledge.pilots.base import AbstractPilot, Noise
from fledge.scalars import stack, unstack

HIDDEN = (300, 300)
"""Two hidden layers of 300 nodes. The paper says the output layer has 300 too; it must have one per action."""


@dataclass(frozen=True, slots=True)
class Contract:
    """What a policy expects of the vehicle that flies it; everything but `data` must match to the letter."""

    observation: tuple[str, ...] = OBSERVATION_NAMES
    units: tuple[str, ...] = OBSERVATION_UNITS
    actions: tuple[str, ...] = ACTION_NAMES
    rate: float = ROW_RATE
    """Decisions per second [Hz]."""
    lens: Lens = Lens()
    ideal_radius: float = IDEAL_RADIUS_PX
    """[px]."""
    sticks: StickScale = StickScale()
    data: str = ""
    """SHA-256 of the composite set it was trained on."""

    def check(self, wanted: "Contract") -> None:
        """Refuse a rig this policy was not trained for.

        Raises:
            ContractMismatch: names what differs, what the policy has and what the rig wants.
        """
        for part in fields(self):
            mine, theirs = getattr(self, part.name), getattr(wanted, part.name)
            if part.name != "data" and mine != theirs:
                raise ContractMismatch(
                    f"the policy was trained with {part.name} = {_shown(mine)}, "
                    f"but is to fly with {_shown(theirs)}"
                )


def _shown(value: Any) -> str:
    return str(asdict(value)) if hasattr(value, "__dataclass_fields__") else str(value)


@dataclass(frozen=True, slots=True)
class Policy(AbstractPilot):
    """A multi-layer perceptron with its normaliser; arrays of float32.

    Calling it maps a state, shape (states,), or many, shape (rows, states), to actions of shape (actions,) or
    (rows, actions), NumPy in and NumPy out.
    """

    weights: tuple[Any, ...]
    """One matrix per layer, shape (inputs, outputs)."""
    biases: tuple[Any, ...]
    """One vector per layer, shape (outputs,)."""
    mean: Any
    """Of the inputs read, shape (inputs,)."""
    scale: Any
    """Of the inputs read, shape (inputs,); 1 where the training data did not vary."""
    inputs: tuple[int, ...] = field(metadata={"static": True})
    """Which entries of the state it reads."""
    states: int = field(metadata={"static": True})
    """How many entries a state has."""
    contract: Contract | None = field(default=None, metadata={"static": True})
    name = "policy"

    @classmethod
    def blank(cls, inputs: tuple[int, ...]) -> "Policy":
        """A network that reads these entries of an `Observation`, and has learnt nothing: all sticks stay at rest."""
        sizes = (len(inputs), *HIDDEN, len(ACTION_NAMES))
        return cls(
            weights=tuple(np.zeros(shape, np.float32) for shape in pairwise(sizes)),
            biases=tuple(np.zeros(size, np.float32) for size in sizes[1:]),
            mean=np.zeros(len(inputs), np.float32),
            scale=np.ones(len(inputs), np.float32),
            inputs=inputs,
            states=len(OBSERVATION_NAMES),
        )

    def __call__(self, state: Any) -> np.ndarray:
        """Actions in [-1, 1] for one state or many."""
        state = np.asarray(state, dtype=np.float32)
        if state.shape[-1:] != (self.states,):
            raise FledgeError(
                f"a state of shape {state.shape} does not fit this policy: valid is "
                f"({self.states},) or (rows, {self.states})"
            )
        return np.asarray(self._forward(state[..., list(self.inputs)], np))

    def act(self, memory: tuple[()], observation: Observation, noise: Noise) -> tuple[tuple[()], Action]:
        """One decision; the noise is ignored."""
        entries = [getattr(observation, OBSERVATION_NAMES[i]) for i in self.inputs]
        x = stack(entries, like=self.mean)
        forward, left, up, turn = unstack(self._forward(x, x.__array_namespace__()))
        return memory, Action(forward, left, up, turn)

    def _forward(self, x: Any, xp: Any) -> Any:
        x = (x - self.mean) / self.scale
        for weight, bias in zip(self.weights[:-1], self.biases[:-1], strict=True):
            x = xp.maximum(x @ weight + bias, 0.0)
        return xp.tanh(x @ self.weights[-1] + self.biases[-1])
