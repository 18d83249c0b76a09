"""What there is to choose from, where things lie on disk, and the work on them that is not the flight's.

    DEMOS/*.mcap            demonstrations: what `fledge train DEMOS` reads
    DEMOS/flights/*.mcap    flights of others, with people who took over: `--include-takeovers`
    POLICIES/*.onnx         what was trained here, and whatever else lies there

Only what is on offer can be chosen: a page cannot make the server import or open anything else. What takes long,
reading flights back and flying the synthetic operator's for comparison, is done by a clerk, one thing after the other.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache, partial
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from typing import Any

from fledge import lookup
from fledge.cockpit import asks, tells
from fledge.cockpit.attached import Attached
from fledge.cockpit.flight import Choice, Live, Person
from fledge.cockpit.scene import PERSON, Scene
from fledge.cockpit.school import School, Subject
from fledge.cockpit.shelf import UAV, UGV, Shelf, hall, lens, marks
from fledge.cockpit.tape import Tape, recover
from fledge.engines import fly_plain
from fledge.episode import Flight
from fledge.errors import BadFile, FledgeError, UnknownName
from fledge.lab.shell.udp import Address
from fledge.learning.demonstrations import PAPER_ORDERS
from fledge.observation import Axes
from fledge.pilots import FOLLOWERS, AbstractPilot, HumanModel
from fledge.runs.logbook import FLIGHTS
from fledge.safety import AbstractNet, StopTube
from fledge.simulation import Case, Crew, flight_key
from fledge.storage import read_flight
from fledge.study.berth import margin
from fledge.study.setups import FLIGHT_ROWS

TWIN = "twin"
SETUPS = ("primitive", "primitive-zero", "dnn-combined")
"""Those that the default recipe trains in seconds."""
ORDERS = {order.manoeuvre.name: order for order in PAPER_ORDERS}
VEHICLES = 4


class Stock:
    """Menus, folders, and the clerk."""

    def __init__(
        self,
        demos: Path,
        policies: Path,
        post: Callable[[int | None, Any], None],
        attached: Address | None = None,
    ) -> None:
        """Make the folders, and whole flights of what a killed server left.

        `attached` is where the sticks of the one flight are that there is to see, if there is one only.

        Raises:
            BadFile: a folder or a recovered flight cannot be written.
        """
        self._demos, self._flights, self._policies = demos, demos / FLIGHTS, policies
        self._post, self.attached = post, attached
        for folder in (self._flights, policies):
            _made(folder)
        self.recovered = [*recover(demos), *recover(self._flights)]
        first = Choice(PAPER_ORDERS[0].manoeuvre, Person(), StopTube(), "stop-tube", FLIGHT_ROWS)
        self._example = Live.draw(first)
        """What pages are told before there is a flight."""
        self.shelf = Shelf(demos, self._flights)
        self.school = School(self._learnt)
        self.clerk = ThreadPoolExecutor(1, thread_name_prefix="clerk")
        """Who does what takes long, one thing after the other."""

    def close(self) -> None:
        """End what is under way."""
        self.school.cancel()
        self.clerk.shutdown(cancel_futures=True)

    # What there is.

    def welcome(self) -> tells.Welcome:
        """What one may choose."""
        tasks = tuple(
            tells.Task(order.manoeuvre.name, order.manoeuvre.axes, order.rows) for order in PAPER_ORDERS
        )
        worlds = ("simulator", TWIN) if find_spec("mujoco") else ("simulator",)
        if self.attached is not None:
            return tells.Welcome(tasks, (), (), ("attached",), SETUPS)
        return tells.Welcome(tasks, self._pilots(), _nets(), worlds, SETUPS)

    def harvest(self) -> tells.Harvest:
        """What was demonstrated so far."""
        found = {name: [0, 0] for name in ORDERS}
        for one in self.shelf.listing():
            if "/" not in one["name"] and one["manoeuvre"] in found:
                found[one["manoeuvre"]][0] += 1
                found[one["manoeuvre"]][1] += one["rows"]
        return tells.Harvest(tuple(tells.Heap(name, *numbers) for name, numbers in found.items()))

    def flight(self, state: str, fly: asks.Fly | None, scene: Scene | None) -> tells.Flight:
        """What pages are told of a flight, or of none."""
        if fly is None or scene is None:
            fly = asks.Fly(PAPER_ORDERS[0].manoeuvre.name, PERSON, "stop-tube")
            scene = self._example
        about = scene.about
        room = hall(about.arena)
        return tells.Flight(
            state,
            *(fly.manoeuvre, fly.pilot, fly.net, fly.world, fly.speed, fly.seed, fly.record),
            tells.Block(**room["arena"]),
            tuple(tells.Block(**box) for box in room["obstacles"]),
            _margins(scene.net),
            tells.View(**lens(about)),
            about.axes,
            (UAV, *(f"{UGV} {i}" for i in range(1, VEHICLES))),
        )

    def _pilots(self) -> tuple[str, ...]:
        files = sorted(self._policies.glob("*.onnx"), key=lambda path: (-path.stat().st_mtime, path.name))
        return (PERSON, *map(str, files), *(pilot.name for pilot in FOLLOWERS))

    # A flight.

    def scene(self, fly: asks.Fly) -> Scene:
        """The flight that was chosen.

        Raises:
            UnknownName: something is not on offer.
            BadFile: a policy cannot be read, or was not trained for this vehicle.
        """
        if self.attached is not None:
            return Attached.open(self.attached)
        pilot, net = self._pilot(fly.pilot), _offered("net", fly.net, _nets(), lookup.net)
        if fly.world == TWIN:
            from fledge.cockpit.twinned import Twinned

            shown = partial(self._post, None)
            return Twinned.draw(pilot, lookup.lab_net(fly.net), (fly.pilot, fly.net), fly.seed, shown)
        if fly.world != "simulator":
            raise UnknownName("world", fly.world, self.welcome().worlds)
        manoeuvre = _offered("manoeuvre", fly.manoeuvre, tuple(ORDERS), lookup.manoeuvre)
        number, rows = 0, FLIGHT_ROWS
        if fly.record == "demonstration":
            number = sum(heap.flights for heap in self.harvest().heaps if heap.manoeuvre == fly.manoeuvre)
            rows = _length(fly.manoeuvre, number)
        return Live.draw(Choice(manoeuvre, pilot, net, fly.net, rows, fly.seed, number))

    def tape(self, fly: asks.Fly, about: Flight) -> Tape | None:
        """Where it is recorded, if it is.

        Raises:
            FledgeError: it cannot be.
        """
        if fly.record == "nothing":
            return None
        if fly.record == "flight":
            return Tape(self._flights, about)
        if fly.pilot != PERSON or fly.world != "simulator":
            raise FledgeError("a demonstration is flown by a person, in the simulator")
        return Tape(self._demos, about)

    def _pilot(self, name: str) -> AbstractPilot:
        def found(name: str) -> AbstractPilot:
            return Person() if name == PERSON else lookup.contestant(name)

        return _offered("pilot", name, self._pilots(), found)

    # The clerk.

    def stored(self, path: Path) -> None:
        """A flight is on disk: let pages know what it is worth."""
        self.clerk.submit(self._tell_stored, path)

    def teach(self, said: asks.Train) -> None:
        """Begin a training.

        Raises:
            FledgeError: there is one already, or the set-up is not on offer.
        """
        if said.setup not in SETUPS:
            raise UnknownName("set-up", said.setup, SETUPS)
        names = (self._policies / f"{said.setup}-{number:03d}.onnx" for number in count())
        policy = next(path for path in names if not path.exists())
        self.school.teach(Subject(self._demos, said.setup, policy, said.epochs, said.takeovers))

    def _learnt(self, news: tells.Lesson) -> None:
        self._post(None, news)
        if news.state == "done":
            self._post(None, self.welcome())

    def _tell_stored(self, path: Path) -> None:
        try:
            flight = read_flight(path)
            name = str(path.relative_to(self._demos).with_suffix(""))
            beside = _synthetic(flight) if path.parent == self._demos else None
            told = tells.Stored(name, flight.manoeuvre, flight.rows, marks(flight), beside)
            self._post(None, told)
        except FledgeError as error:
            self._post(None, tells.Notice(str(error)[:500], "error"))
        self._post(None, self.harvest())


def _made(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadFile(folder, f"cannot be made: {error.strerror or error}") from error


def _offered(what: str, name: str, offered: tuple[str, ...], found: Callable[[str], Any]) -> Any:
    if name not in offered:
        raise UnknownName(what, name, offered)
    return found(name)


@cache
def _nets() -> tuple[str, ...]:
    return tuple(lookup.shipped("fledge.safety", AbstractNet))


@cache
def _margins(net: AbstractNet) -> tuple[float, ...]:
    """How far the net keeps the UAV at rest from walls [m]; none: it keeps it away from nothing."""
    found = round(margin(net, 0, 0.0), 3)
    return (found,) if found else ()


def _length(manoeuvre: str, number: int) -> int:
    """Rows of a demonstration: the paper's, as `fledge demonstrate` shares them out; further ones are like the last."""
    return [*ORDERS[manoeuvre].lengths()][: number + 1][-1]


def _synthetic(flight: Flight) -> tells.Marks:
    """The synthetic operator's, as far as this demonstration of the same scene goes."""
    key = flight_key(flight.seed, "demonstration", flight.manoeuvre, flight.case)
    rows = _length(flight.manoeuvre, flight.case)
    case = Case.draw(ORDERS[flight.manoeuvre].manoeuvre, key, rows).lasting(flight.rows)
    crew = Crew(HumanModel().for_axes(flight.axes), Axes.of(flight.axes))
    return marks(replace(flight, episode=fly_plain(case, crew, (*key, 1))))
