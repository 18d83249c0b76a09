"""What the server says to a page: a record for each kind of message."""

from dataclasses import dataclass

from fledge.cockpit.asks import MOST_VEHICLES, NAME, RECORDS, STAMP, WORLDS
from fledge.lab import UINT32
from fledge.lab.wire.fields import flag, listed, nested, number, of, one_of, or_null, text, whole

FAR = 1e6
"""Largest number in a pose, a pixel or a command; chosen: beyond anything that flies."""
MOST_CHOICES = 200
MOST_POINTS = 500
"""Of a loss curve in one message; chosen: half of the longest message, and more than a screen shows."""
FLIGHTS = ("none", "running", "paused", "over")
LESSONS = ("none", "running", "done", "failed", "cancelled")
LEVELS = ("info", "warning", "error")
SEATS = ("free", "mine", "taken", "waiting")

_FAR = number(-FAR, FAR)


@dataclass(frozen=True, slots=True)
class Block:
    """A box that stands on the floor [m]."""

    x_min: float = of(_FAR)
    x_max: float = of(_FAR)
    y_min: float = of(_FAR)
    y_max: float = of(_FAR)
    height: float = of(_FAR)
    """For the arena itself, its ceiling."""


@dataclass(frozen=True, slots=True)
class View:
    """The lens: what a page needs to draw the picture [px]."""

    focal: float = of(_FAR)
    width: float = of(_FAR)
    height: float = of(_FAR)


@dataclass(frozen=True, slots=True)
class Task:
    """A manoeuvre that one may choose."""

    name: str = of(NAME)
    axes: tuple[int, ...] = of(listed(whole(0, 3), 1, 4))
    """Of the sticks, those that a pilot may use: 0 forward, 1 left, 2 up, 3 turn."""
    goal: int = of(whole(0, UINT32), 0)
    """Rows of demonstrations that the paper has of it; 0: it has none."""


@dataclass(frozen=True, slots=True)
class Welcome:
    """What one may choose."""

    tasks: tuple[Task, ...] = of(listed(nested(Task), 0, MOST_CHOICES))
    pilots: tuple[str, ...] = of(listed(NAME, 0, MOST_CHOICES))
    """"person", names of pilots, and files of policies, the newest first."""
    nets: tuple[str, ...] = of(listed(NAME, 0, MOST_CHOICES))
    worlds: tuple[str, ...] = of(listed(one_of(*WORLDS), 1, len(WORLDS)))
    setups: tuple[str, ...] = of(listed(NAME, 0, MOST_CHOICES))
    """What may be trained."""


@dataclass(frozen=True, slots=True)
class Flight:
    """What is flown, and what stays as it is while it is flown."""

    state: str = of(one_of(*FLIGHTS))
    manoeuvre: str = of(NAME)
    pilot: str = of(NAME)
    net: str = of(NAME)
    world: str = of(one_of(*WORLDS))
    speed: float = of(_FAR)
    seed: int = of(whole(0, UINT32))
    record: str = of(one_of(*RECORDS))
    arena: Block = of(nested(Block))
    obstacles: tuple[Block, ...] = of(listed(nested(Block), 0, MOST_VEHICLES))
    margins: tuple[float, ...] = of(listed(_FAR, 0, 1))
    """How far the net keeps the centre of a UAV at rest from walls and obstacles [m]; none: it has no margin."""
    lens: View = of(nested(View))
    axes: tuple[int, ...] = of(listed(whole(0, 3), 1, 4))
    """Of the sticks, those that the pilot may use."""
    names: tuple[str, ...] = of(listed(NAME, 1, MOST_VEHICLES))
    """The vehicles', the UAV first."""


@dataclass(frozen=True, slots=True)
class Vehicle:
    """One vehicle at one instant."""

    x: float = of(_FAR)
    """[m]."""
    y: float = of(_FAR)
    """[m]."""
    z: float = of(_FAR)
    """[m]; 0 of a UGV."""
    heading: float = of(_FAR)
    """Counter-clockwise from east [rad]."""
    mode: str = of(NAME)
    """Of `supervision.modes.Mode`."""
    reason: str = of(NAME)
    """Of `world.Reason`."""
    commander: str = of(NAME)
    """Who flies it: "pilot", "guidance", "person", "net" or "nobody"."""
    sent: tuple[float, ...] = of(listed(_FAR, 4, 4))
    """Forward, left, up [m/s], turn [rad/s]."""
    clearance: float | None = of(or_null(_FAR))
    """Free distance the net saw [m]; null if it does not look."""
    stop: tuple[float, ...] = of(listed(_FAR, 0, 3), ())
    """Where it comes to rest if it is told to stop now, as its net says: x, y and by how much it may miss that [m]."""


@dataclass(frozen=True, slots=True)
class Picture:
    """What is seen of the UGVs [px]; u to the right, v down."""

    u: float = of(_FAR)
    """Of their centre."""
    v: float = of(_FAR)
    radius: float = of(_FAR)
    ideal_radius: float = of(_FAR)
    marks: tuple[tuple[float, ...], ...] = of(listed(listed(_FAR, 2, 2), 0, MOST_VEHICLES))
    """(u, v) of each UGV."""


@dataclass(frozen=True, slots=True)
class Frame:
    """The flight at one instant, UAV first."""

    t: float = of(_FAR)
    """[s] of flight."""
    vehicles: tuple[Vehicle, ...] = of(listed(nested(Vehicle), 1, MOST_VEHICLES))
    picture: Picture = of(nested(Picture))
    rows: int = of(whole(0, UINT32), 0)
    """Recorded so far."""
    over: bool = of(flag, False)
    """Whether the manoeuvre is."""
    armable: bool = of(flag, True)
    """Whether arming counts, as far as it is not the supervisor's to say."""
    factor: float = of(_FAR, 1.0)
    """Flight time over real time, as measured."""
    battery: float | None = of(or_null(number(0.0, 1.0)), None)
    """What is left, as a share; null if nobody knows."""
    sequence: int = of(whole(-1, UINT32), -1)
    """Of the newest sticks of this page that were heard; -1 for none."""
    stamp: float = of(STAMP, 0.0)
    """The page's, of the same [ms]."""
    silent: float | None = of(or_null(_FAR), None)
    """How long nobody was heard at the sticks [s]; null if nobody ever was."""
    answer: float | None = of(or_null(_FAR), None)
    """From sticks that came in to the command that went out, the median of late [ms]."""
    note: str = of(text(500), "")
    """What is missing or wrong, in one line for people."""


@dataclass(frozen=True, slots=True)
class Seating:
    """Whose the operator's seat is, as this page sees it."""

    seat: str = of(one_of(*SEATS))
    spectators: int = of(whole(0, UINT32))


@dataclass(frozen=True, slots=True)
class Heap:
    """What there is of one manoeuvre's demonstrations."""

    manoeuvre: str = of(NAME)
    flights: int = of(whole(0, UINT32))
    rows: int = of(whole(0, UINT32))


@dataclass(frozen=True, slots=True)
class Harvest:
    """What was demonstrated so far."""

    heaps: tuple[Heap, ...] = of(listed(nested(Heap), 0, MOST_CHOICES))


@dataclass(frozen=True, slots=True)
class Marks:
    """How well somebody flew."""

    distance: float = of(_FAR)
    """Root mean square of the pixel distance [px]."""
    radius: float = of(_FAR)
    """Root mean square of the radius error [px]."""
    in_view: float = of(number(0.0, 1.0))
    """Share of frames with all UGVs in the picture."""


@dataclass(frozen=True, slots=True)
class Stored:
    """A flight is on disk."""

    name: str = of(NAME)
    manoeuvre: str = of(NAME)
    rows: int = of(whole(0, UINT32))
    marks: Marks = of(nested(Marks))
    synthetic: Marks | None = of(or_null(nested(Marks)), None)
    """The synthetic operator's, in the same flight."""


@dataclass(frozen=True, slots=True)
class Lesson:
    """How far a training is."""

    state: str = of(one_of(*LESSONS))
    setup: str = of(NAME, "")
    policy: str = of(NAME, "")
    """What it made, once it is done: a pilot's name."""
    epoch: int = of(whole(0, UINT32), 0)
    epochs: int = of(whole(0, UINT32), 0)
    """Of all."""
    points: tuple[tuple[float, ...], ...] = of(listed(listed(_FAR, 3, 3), 0, MOST_POINTS), ())
    """(epoch, training loss, held-out loss), those that are new since the last such message to this page."""
    problem: str = of(text(500), "")


@dataclass(frozen=True, slots=True)
class Notice:
    """A line for people."""

    text: str = of(text(500))
    level: str = of(one_of(*LEVELS), "info")
