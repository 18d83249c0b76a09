"""The AR.Drone of the twin put together: ports, sensors, firmware, loops and battery, around a body that is elsewhere.

A tick of 10 ms is `hear` once, then `fly` for each step of 2 ms, then `rest`; `say` whenever navdata may be due. The
caller moves the body (`plant`) between the steps and tells how it moved. Rotors lose thrust as the battery empties.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from fledge.lab.twin import firmware, telemetry
from fledge.lab.twin.firmware import Firmware
from fledge.lab.twin.loops import RESTED, STILL, Inside, Loops, Thrusts, Wish
from fledge.lab.twin.plant import Motion
from fledge.lab.twin.senses import Errors, Senses
from fledge.lab.twin.telemetry import Telemetry

SAG = 0.12
"""Share of a rotor's thrust that is gone with an empty battery; chosen, for a pack of three cells from 12.4 to 11 V."""


class Memory(NamedTuple):
    """What the drone remembers."""

    knows: firmware.Memory
    inside: Inside
    errors: Errors
    told: telemetry.Memory
    wish: Wish
    power: float
    """What the rotors drew since the last rest, as a share of hovering, times its steps."""


@dataclass(frozen=True, slots=True)
class Drone:
    """Its parts."""

    firmware: Firmware = Firmware()
    loops: Loops = Loops()
    senses: Senses = Senses()
    telemetry: Telemetry = Telemetry()

    def init(self, heading: float, normal: list[float], aloft: bool = False, battery: float = 1.0) -> Memory:
        """Switched on, its nose pointing at `heading` [rad]; `senses.BIRTH_NORMALS` standard normal numbers.

        One that begins in the air was told on the floor that it stands level.
        """
        start = self.firmware.aloft if aloft else self.firmware.init
        errors = self.senses.init(heading, normal)
        errors = self.senses.trim(errors, normal) if aloft else errors
        return Memory(start(0.0, battery), RESTED, errors, telemetry.Memory(), Wish(motors=aloft), 0.0)

    def hear(
        self,
        memory: Memory,
        t: float,
        commands: Sequence[bytes],
        asked: bool,
        motion: Motion,
        normal: list[float],
        dt: float,
    ) -> Memory:
        """What came in until `t` [s], and what to do until the next tick, `dt` [s] later."""
        errors = self.senses.wander(memory.errors, normal, dt)
        knows = self.firmware.hear(memory.knows, t, commands)
        if knows.trimmed > memory.knows.trimmed:
            errors = self.senses.trim(errors, normal)
        knows, wish = self.firmware.decide(knows, t, self.senses.sense(errors, motion))
        told = memory.told._replace(asked=True) if asked else memory.told
        return memory._replace(knows=knows, wish=wish, errors=errors, told=told)

    def fly(self, memory: Memory, motion: Motion, dt: float) -> tuple[Memory, Thrusts]:
        """(memory, the thrusts of the rotors [N]) for one step of `dt` [s]."""
        if not memory.wish.motors:
            return memory._replace(inside=RESTED), STILL
        sensed = self.senses.sense(memory.errors, motion)
        most = memory.knows.settings.euler_angle_max
        inside, thrusts = self.loops.step(memory.inside, memory.wish, sensed, most, dt)
        a, b, c, d = thrusts
        left = 1.0 - SAG * (1.0 - memory.knows.battery)
        drawn = dt * ((a + b + c + d) / self.loops.airframe.weight) ** 1.5
        return memory._replace(inside=inside, power=memory.power + drawn), (
            a * left,
            b * left,
            c * left,
            d * left,
        )

    def rest(self, memory: Memory, dt: float) -> Memory:
        """After `dt` [s] of flying: the battery."""
        knows = self.firmware.drain(memory.knows, memory.power / dt, dt)
        return memory._replace(knows=knows, power=0.0)

    def say(self, memory: Memory, t: float, motion: Motion) -> tuple[Memory, bytes | None]:
        """(memory, the navdata that are due at `t` [s], if any)."""
        if not self.telemetry.is_due(memory.told, t):
            return memory, None
        sensed, silent = self.senses.sense(memory.errors, motion), self.firmware.silent(memory.knows, t)
        told, data = self.telemetry.say(memory.told, t, memory.knows, sensed, silent)
        return memory._replace(told=told), data
