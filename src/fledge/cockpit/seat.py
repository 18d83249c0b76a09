"""The operator's seat: who sits in it, and what they say, as the supervisor hears it.

One client at a time has the seat; whoever asks meanwhile waits, and gets it when it is given up, when its holder
leaves, or when the holder has said nothing for `patience`. All others are spectators: their sticks are dropped and
counted.

Of the holder's sticks only what is new counts. A sequence number must be larger than the last; a message that was under
way longer than `silence`, by the page's own stamps, is dropped, too: what a frozen tab sends all at once when it wakes
up is nothing that a person wants now. Two clocks differ a little, so the shortest way ever seen is forgotten slowly
(`creep`). A page whose clock stood still, as in a suspended computer, stays late until it asks for the seat anew.

The supervisor hears one `Operator` per vehicle. The sticks are with one vehicle at a time; of all others, and after
`silence` of all, what is said becomes hover: everything is let go but the arming switch. What was ordered before, a
stop or a landing, the supervisor remembers itself.

Times are in seconds of the server's clock, and come in as arguments. Who arms, arms all vehicles.
"""

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from fledge.cockpit.asks import Sticks
from fledge.observation import Action, StickScale
from fledge.supervision.inputs import Operator

HANDS_OFF = Action(0.0, 0.0, 0.0, 0.0)


class Dropped(NamedTuple):
    """How many messages did not count, and why."""

    spectators: int = 0
    """Not the holder's."""
    replayed: int = 0
    """Not newer than the last."""
    late: int = 0
    """Too long under way."""
    flooded: int = 0
    """Too many a second."""
    strange: int = 0
    """Of a vehicle that there is not."""


class Memory(NamedTuple):
    """Who is there, and what the holder of the seat said."""

    clients: tuple[int, ...] = ()
    holder: int | None = None
    waiting: tuple[int, ...] = ()
    """In the order in which they asked."""
    sticks: Sticks | None = None
    """The last that counted, of this holder."""
    armed: bool = False
    """As last said by anybody: a change of hands disarms nothing."""
    heard: float = -inf
    """When sticks last counted, whoever's [s]."""
    since: float = -inf
    """When the holder sat down [s]."""
    way: float = inf
    """Shortest from the page's stamp to here, of this holder [s]; it has an arbitrary part, the clocks' difference."""
    room: float = 0.0
    """Messages that may still come at once."""
    refilled: float = -inf
    """When that was counted [s]."""
    dropped: Dropped = Dropped()


class Spoken(NamedTuple):
    """What the seat says at one instant."""

    operators: tuple[Operator, ...]
    """One per vehicle, the UAV first."""
    action: Action
    """The UAV's sticks, for whom a person is the pilot."""
    silent: float
    """How long nothing was heard [s]."""
    lost: bool
    """Whether that is too long."""


@dataclass(frozen=True, slots=True)
class Seats:
    """Limits."""

    vehicles: int = 4
    scale: StickScale = StickScale()
    silence: float = 0.4  # [s]; chosen below PX4's COM_RC_LOSS_T of 0.5: a browser sends 60 times a second
    patience: float = 10.0  # [s] that a silent holder keeps the seat while others wait; PX4's COM_DL_LOSS_T
    rate: float = 120.0  # [1/s] messages that count; chosen: twice what a page sends
    burst: float = 30.0  # messages at once; chosen: what TCP holds back in a quarter of a second
    creep: float = 1e-3  # [s/s] by which the shortest way is forgotten; chosen: clocks differ by 1e-4 at most

    def init(self) -> Memory:
        """Nobody is there."""
        return Memory()

    def join(self, memory: Memory, client: int) -> Memory:
        """Somebody comes, as a spectator."""
        known = client in memory.clients
        return memory if known else memory._replace(clients=(*memory.clients, client))

    def leave(self, memory: Memory, client: int, t: float) -> Memory:
        """Somebody goes, for good."""
        memory = self.give_up(memory, client, t)
        return memory._replace(clients=tuple(one for one in memory.clients if one != client))

    def ask(self, memory: Memory, client: int, t: float) -> Memory:
        """Somebody wants the seat; who has it already begins anew."""
        if client not in memory.clients:
            return memory
        if memory.holder == client:
            return self._seated(memory, client, t)
        if client not in memory.waiting:
            memory = memory._replace(waiting=(*memory.waiting, client))
        return self._passed_on(memory, t)

    def give_up(self, memory: Memory, client: int, t: float) -> Memory:
        """Somebody does not want it any more."""
        memory = memory._replace(waiting=tuple(one for one in memory.waiting if one != client))
        if memory.holder != client:
            return memory
        return self._passed_on(memory._replace(holder=None, sticks=None), t)

    def hear(self, memory: Memory, client: int, sticks: Sticks, t: float) -> Memory:
        """Somebody's sticks, at time `t` [s]."""
        memory = self._passed_on(memory, t)
        if client != memory.holder:
            return _dropped(memory, "spectators")
        memory = self._refilled(memory, t)
        if memory.room < 1.0:
            return _dropped(memory, "flooded")
        memory = memory._replace(room=memory.room - 1.0)
        if sticks.vehicle >= self.vehicles:
            return _dropped(memory, "strange")
        if memory.sticks is not None and sticks.sequence <= memory.sticks.sequence:
            return _dropped(memory, "replayed")
        way = t - sticks.stamp / 1e3
        shortest = memory.way + self.creep * (t - max(memory.heard, memory.since))
        if way - shortest > self.silence:
            return _dropped(memory, "late")
        return memory._replace(sticks=sticks, armed=sticks.arm, heard=t, way=min(way, shortest))

    def say(self, memory: Memory, t: float) -> Spoken:
        """What the supervisor hears at time `t` [s]."""
        sticks, silent = memory.sticks, t - memory.heard
        lost = not silent <= self.silence
        rest = Operator(arm=float(memory.armed))
        operators = [rest] * self.vehicles
        if sticks is None or lost:
            return Spoken(tuple(operators), HANDS_OFF, silent, lost)
        operators[sticks.vehicle] = self._operator(sticks)
        action = HANDS_OFF if sticks.vehicle else Action(*sticks.axes)
        return Spoken(tuple(operators), action, silent, lost)

    def tick(self, memory: Memory, t: float) -> Memory:
        """Time goes on: who waits may get the seat of somebody who has gone silent."""
        return self._passed_on(memory, t)

    def _operator(self, sticks: Sticks) -> Operator:
        return Operator(
            command=self.scale.command(Action(*sticks.axes)),
            deflection=max(map(abs, sticks.axes)),
            switch=float(sticks.switch),
            hand_back=float(sticks.hand_back),
            stop=float(sticks.stop),
            dead_man=float(sticks.dead_man),
            arm=float(sticks.arm),
            land=float(sticks.land),
            terminate=float(sticks.terminate),
        )

    def _passed_on(self, memory: Memory, t: float) -> Memory:
        """The first who waits has the seat, if it is free or its holder has long been silent."""
        # Sticks of an earlier holder say nothing of this one, who has the same time to begin with.
        silent = t - max(memory.heard, memory.since)
        if not memory.waiting or (memory.holder is not None and silent <= self.patience):
            return memory
        first, *others = memory.waiting
        return self._seated(memory._replace(waiting=tuple(others)), first, t)

    def _seated(self, memory: Memory, client: int, t: float) -> Memory:
        return memory._replace(
            holder=client, sticks=None, since=t, way=inf, room=self.burst, refilled=max(t, memory.refilled)
        )

    def _refilled(self, memory: Memory, t: float) -> Memory:
        more = self.rate * max(t - memory.refilled, 0.0)
        return memory._replace(room=min(memory.room + more, self.burst), refilled=max(t, memory.refilled))


def _dropped(memory: Memory, why: str) -> Memory:
    counts = memory.dropped._replace(**{why: getattr(memory.dropped, why) + 1})
    return memory._replace(dropped=counts)
