"""A flight in the lab's digital twin: controller and twin in lock-step, 10 ms at a time, and a person at the sticks.

The controller is `fledge fly`'s and hears the person as it would hear anybody, as datagrams of sticks: so everything
that holds of a lab flight holds here. It begins on the pad: arming takes off, an order to land comes down, and that was
the flight. UGVs drive themselves.

A person may be the pilot, too: then the sticks are the pilot's action, on forward and left alone, and moving them takes
nothing over; the switch still does.

While the twin is on, its bottom camera is drawn in a process of its own, and handed on as JPEG.
"""

import io
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass, field, replace
from threading import Thread
from typing import Any, NamedTuple, cast

from PIL import Image

from fledge.camera import look
from fledge.cockpit.flight import Person, without_sticks
from fledge.cockpit.scene import PILOTS_OWN, Shown, commander
from fledge.cockpit.seat import Spoken
from fledge.episode import Episode, Flight
from fledge.lab.control.outfit import AXES, Outfit
from fledge.lab.control.phases import ALOFT, Phase
from fledge.lab.control.tick import Controller
from fledge.lab.control.tick import Memory as Controlling
from fledge.lab.lockstep import Tick
from fledge.lab.outing import TICKS_PER_ROW, as_row
from fledge.lab.twin.picture import Frame, Pictures
from fledge.lab.twin.twin import Twin
from fledge.lab.wire import sticks
from fledge.lab.wire.datagrams import STICKS, Datagram, Heard
from fledge.pilots import AbstractPilot
from fledge.safety import AbstractNet, Halt
from fledge.supervision.modes import Mode
from fledge.supervision.posts import Decision
from fledge.supervision.watchdog import TICK, Alarm
from fledge.world import Arena, Reason, VelocityCommand, Verdict

QUALITY = 70
"""Of a JPEG; chosen: 15 kB a picture."""


class Memory(NamedTuple):
    """All that changes, but for the twin itself, which changes in place."""

    twin: Twin
    controlling: Controlling
    said: tuple[Datagram, ...] = ()
    ticks: int = 0
    row: tuple[Tick, ...] = ()
    heard: bool = True
    """Whether a person was, in all ticks of the row."""


@dataclass(frozen=True, slots=True)
class Twinned:
    """One flight: what stays as it is during it."""

    controller: Controller
    pilot: AbstractPilot
    names: tuple[str, str]
    """What pilot and net are called."""
    seed: int
    arena: Arena
    show: Callable[[bytes], None] = lambda jpeg: None
    """Is handed every picture."""
    _pictures: list[Pictures] = field(default_factory=list)
    """The one of the twin that is on; to be closed."""

    @classmethod
    def draw(
        cls,
        pilot: AbstractPilot,
        net: AbstractNet,
        names: tuple[str, str],
        seed: int,
        show: Callable[[bytes], None],
    ) -> "Twinned":
        """A day in the lab."""
        arena = Arena.lab()
        controller = Outfit(arena, *names).controller(pilot, net)
        return cls(controller, pilot, names, seed, arena, show)

    @property
    def about(self) -> Flight:
        """What the flight is, for its file; there is no episode yet."""
        return Flight(cast(Any, None), "lab", *self.names, self.seed, 0, AXES, self.arena)

    @property
    def net(self) -> AbstractNet:
        """Behind which it is flown."""
        return self.controller.supervisor.net

    def init(self) -> Memory:
        """The lab in the morning, and its camera switched on."""
        self.close()
        pictures = Pictures(self.arena, tell=lambda line: None)
        self._pictures.append(pictures)
        Thread(target=_screen, args=(pictures, self.show), name="camera", daemon=True).start()
        return Memory(Twin(self.arena, self.seed), self.controller.init())

    def tick(self, memory: Memory, spoken: Spoken) -> tuple[Memory, Shown]:
        """10 ms later, with what people said."""
        twin, t = memory.twin, memory.ticks * TICK
        heard = Heard(t, (*twin.tick(Heard(t, memory.said)), *self._spoken(spoken, memory.ticks)))
        controlling, said = self._with(spoken).step(memory.controlling, heard)
        if self._pictures[0].watched:
            self._pictures[0].show(t, twin.poses())
        world = twin.world()
        row, flown, memory = self._rowed(memory, Tick(heard, said, world), spoken)
        decisions = said.decisions or (NOBODY,) * (1 + len(world.ugvs))
        by_person, leads = isinstance(self.pilot, Person), said.phase is not Phase.FLY
        shown = Shown(
            world,
            decisions,
            tuple(commander(i, decision, by_person, leads) for i, decision in enumerate(decisions)),
            look(self.controller.guidance.lens, world),
            row,
            flown,
            said.phase is Phase.OVER,
            controlling.cleared,
            twin.battery,
            said.complaint or said.phase.value,
        )
        memory = memory._replace(controlling=controlling, said=said.datagrams, ticks=memory.ticks + 1)
        return memory, shown

    def halts(self, memory: Memory) -> tuple[Halt, ...]:
        """Where vehicles would come to rest; none if the net does not say."""
        supervision = memory.controlling.supervision
        return self.net.halts(supervision.net, memory.twin.world()) if supervision else ()

    def close(self) -> None:
        """The camera off."""
        while self._pictures:
            self._pictures.pop().close()

    def _with(self, spoken: Spoken) -> Controller:
        """The controller, a person's sticks being the pilot's if a person is the pilot."""
        if not isinstance(self.pilot, Person):
            return self.controller
        guidance = replace(self.controller.guidance, pilot=Person(spoken.action))
        return replace(self.controller, guidance=guidance)

    def _spoken(self, spoken: Spoken, number: int) -> Iterator[Datagram]:
        """What people say, as often as they say it."""
        if spoken.silent > TICK:
            return
        uav, *ugvs = spoken.operators
        if isinstance(self.pilot, Person):
            uav = without_sticks(uav)
        yield Datagram(STICKS, sticks.encode(sticks.Sticks(number, number * TICK, (uav, *ugvs))))

    def _rowed(self, memory: Memory, tick: Tick, spoken: Spoken) -> tuple[Episode | None, bool, Memory]:
        """(the row that is over, whether it was the pilot's, memory); rows are of a flight that is in the air."""
        said = tick.said
        if said.phase not in ALOFT or said.action is None:
            return None, False, memory._replace(row=(), heard=True)
        row, heard = (*memory.row, tick), memory.heard and not spoken.lost
        if len(row) < TICKS_PER_ROW:
            return None, False, memory._replace(row=row, heard=heard)
        own = all(one.said.phase is Phase.FLY and one.said.decisions[0].mode in PILOTS_OWN for one in row)
        flown = own and (heard or not isinstance(self.pilot, Person))
        return as_row(row), flown, memory._replace(row=(), heard=True)


_HOVER = Verdict(VelocityCommand.hover(), 1.0, float(Reason.NOT_READY), 0.0)
NOBODY = Decision(float(Mode.INIT), _HOVER, Alarm(0.0, 0.0))
"""Of a vehicle before everybody was seen."""


def _screen(pictures: Pictures, show: Callable[[bytes], None]) -> None:
    with closing(pictures.frames()) as frames:
        for frame in frames:
            show(_jpeg(frame))


def _jpeg(frame: Frame) -> bytes:
    picture, out = Image.frombytes("RGB", (frame.width, frame.height), frame.pixels), io.BytesIO()
    picture.save(out, "JPEG", quality=QUALITY)
    return out.getvalue()
