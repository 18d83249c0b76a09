"""A gamepad as an operator: `sensor_msgs/Joy` to what a person says about every vehicle.

    right stick      forward, left
    left stick       up, turn
    START            arm; it stays so until LAND is pressed
    A  land          B  stop          X  hand back          Y  I fly (take-over switch)
    LB, held         dead man: my commands do not pass the net
    BACK and B       terminate: motors off, for good

The sticks fly the UAV alone. Arm, land, stop, hand back and terminate are said to all vehicles at once.

The numbers of axes and buttons are those of an Xbox 360 pad under Linux (the table on wiki.ros.org/joy): the driver
reports a stick as positive to the left and upwards. Let it repeat itself (`_autorepeat_rate:=50`): it speaks only when
something moves otherwise, and half a second of silence ends MANUAL.

A button is let go again, and an arming switch is not, so this has a memory of one bit; a second one sees to it that a
button that was held from the start arms nothing.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

from fledge.lab import Malformed
from fledge.lab.wire.messages import Joy
from fledge.observation import Action, StickScale
from fledge.scalars import maximum
from fledge.supervision.inputs import HOVER, Operator


@dataclass(frozen=True, slots=True)
class Layout:
    """Which axis and which button is which, counted from 0."""

    forward: int = 4
    left: int = 3
    up: int = 1
    turn: int = 0
    land: int = 0  # A
    stop: int = 1  # B
    hand_back: int = 2  # X
    switch: int = 3  # Y
    dead_man: int = 4  # LB
    arm: int = 7  # START
    terminate: tuple[int, int] = (6, 1)  # BACK and B

    @property
    def axes(self) -> int:
        """How many axes the device must have."""
        return 1 + max(self.forward, self.left, self.up, self.turn)

    @property
    def buttons(self) -> int:
        """How many buttons it must have."""
        singles = (self.land, self.stop, self.hand_back, self.switch, self.dead_man, self.arm)
        return 1 + max(*singles, *self.terminate)


class Memory(NamedTuple):
    """What is left of earlier messages."""

    armed: bool = False
    pressed: bool = True
    """Whether the arming button was down."""


@dataclass(frozen=True, slots=True)
class Gamepad:
    """Who holds it flies the first of so many vehicles."""

    vehicles: int
    sticks: StickScale = StickScale()
    layout: Layout = Layout()

    def init(self) -> Memory:
        """Nothing is armed."""
        return Memory()

    def step(self, memory: Memory, joy: Joy) -> tuple[Memory, tuple[Operator, ...] | Malformed]:
        """(memory, one operator per vehicle, the UAV first); another device says nothing."""
        layout = self.layout
        if len(joy.axes) < layout.axes or len(joy.buttons) < layout.buttons:
            got = f"a device of {len(joy.axes)} axes and {len(joy.buttons)} buttons"
            return memory, Malformed(f"{got}: valid is at least {layout.axes} and {layout.buttons}")
        memory = self._armed(memory, joy)
        everyone = self._to_all(memory, joy)
        uav = self._to_uav(everyone, joy)
        return memory, (uav, *(everyone,) * (self.vehicles - 1))

    def _armed(self, memory: Memory, joy: Joy) -> Memory:
        arm = joy.buttons[self.layout.arm] != 0
        armed = memory.armed or (arm and not memory.pressed)
        return Memory(armed and not joy.buttons[self.layout.land], arm)

    def _to_all(self, memory: Memory, joy: Joy) -> Operator:
        layout, buttons = self.layout, joy.buttons
        return Operator(
            HOVER,
            hand_back=_flag(buttons[layout.hand_back]),
            stop=_flag(buttons[layout.stop]),
            arm=_flag(memory.armed),
            land=_flag(buttons[layout.land]),
            terminate=_flag(all(buttons[i] for i in layout.terminate)),
        )

    def _to_uav(self, everyone: Operator, joy: Joy) -> Operator:
        layout, axes, buttons = self.layout, joy.axes, joy.buttons
        action = Action(axes[layout.forward], axes[layout.left], axes[layout.up], axes[layout.turn])
        plane = maximum(abs(action.forward), abs(action.left))
        return replace(
            everyone,
            command=self.sticks.command(action),
            deflection=maximum(plane, maximum(abs(action.up), abs(action.turn))),
            switch=_flag(buttons[layout.switch]),
            dead_man=_flag(buttons[layout.dead_man]),
        )


def _flag(pressed: int) -> float:
    return 1.0 if pressed else 0.0
