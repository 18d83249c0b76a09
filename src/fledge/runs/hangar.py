"""From what was typed to a lab flight that is ready: everything is found, checked, and only then opened.

Names become pilots and nets, files arenas and policies; a policy that was not trained for this vehicle is refused
before there is any socket. Then wires are opened, people are given their place, and a log is begun.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from hashlib import sha256
from importlib.metadata import version
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from fledge import lookup
from fledge.episode import Episode
from fledge.episode import Flight as Facts
from fledge.errors import FledgeError
from fledge.lab.control import keys
from fledge.lab.control.ardrone_ros import Meaning
from fledge.lab.control.outfit import AXES, Outfit
from fledge.lab.control.phases import Phase
from fledge.lab.control.tick import Controller, Said
from fledge.lab.shell import runtime
from fledge.lab.shell.desk import Desk, Device, Nobody, Typist
from fledge.lab.shell.keyboard import Terminal
from fledge.lab.shell.link import Link, Port
from fledge.lab.shell.logs import Log
from fledge.lab.shell.rerun import Comparison, Opening, read_opening, replay
from fledge.lab.shell.rows import Rows, together
from fledge.lab.shell.tally import Tally, summary
from fledge.lab.shell.udp import Address, Wire, controller_wires, is_loopback, opened
from fledge.lab.shell.view import Screen, View
from fledge.lab.shell.window import Window
from fledge.lab.wire import topics
from fledge.lab.wire.datagrams import GLANCES, VICON
from fledge.pilots import AbstractPilot
from fledge.storage import read_contract
from fledge.storage.records import from_json, to_json
from fledge.world import Arena

POLICY, CONTRACT = "policy.onnx", "contract.toml"
"""What a policy's file, and that of the net's contract, are called in a log."""
JOINING = 60.0
"""[s] for a cockpit to join; chosen: somebody starts it, and opens its page."""
LATE = 10_000
"""[us] A tick that takes longer misses its deadline."""


@dataclass(frozen=True, slots=True)
class Order:
    """What was typed."""

    policy: Path | None = None
    pilot: str | None = None
    arena: str | None = None
    mocap: Address | None = None
    """Where Vicon's frames come from, and to which port; None: over ROS."""
    vehicle: Address | None = None
    """Where the AR.Drone is, its AT port; None: over ROS."""
    velocity: bool = False
    """Over ROS: whether `/cmd_vel` is in m/s."""
    net: str = "stop-tube"
    contract: str = lookup.LAB_CONTRACT
    """On which the net relies: its name, or its file."""
    axes: tuple[int, ...] = AXES
    """Of the pilot's actions those that are in use."""
    operator: str = "keyboard"
    """keyboard, joy, udp, or ws, which is udp and shows the flight to a cockpit."""
    sticks: Address | None = None
    """For udp and ws: where datagrams of sticks come."""
    nobody: bool = False
    duration: float | None = None
    dry: bool = False
    seed: int = 0
    log: Path | None = None


class Crew(NamedTuple):
    """Who flies, and what it was read from."""

    name: str
    pilot: AbstractPilot
    files: Mapping[str, bytes]


def fly(order: Order) -> dict[str, Any]:
    """Fly, and say what came of it, in plain JSON values.

    Raises:
        FledgeError: something that was typed, found or plugged in is not right; before take-off.
    """
    made, controller, crew = _made(order)
    log = order.log or (
        None if order.dry else Path(time.strftime("flight-%Y%m%d-%H%M%S.mcap", time.gmtime()))
    )
    with runtime.urgent() as first, _ready(order, made, controller, crew, log) as flight:
        flown = False
        try:
            outcome = runtime.fly(flight)
            flown = outcome.said.phase is not Phase.WAIT
        finally:
            kept = _kept(flight.log, flown or order.log is not None)
    return told(outcome, flight) | {"log": kept and str(kept), "real_time_priority": first}


def told(outcome: runtime.Outcome, flight: runtime.Flight) -> dict[str, Any]:
    """What came of a run, in plain JSON values."""
    took = np.array(outcome.took_us)
    p50, p99, p999 = (float(np.percentile(took, share)) for share in (50.0, 99.0, 99.9))
    log = flight.log
    return summary(outcome.counted) | {
        "ticks": len(took),
        "deadline_misses": outcome.skipped + int((took > LATE).sum()),
        "tick_us": {"p50": p50, "p99": p99, "p999": p999, "max": int(took.max())},
        "phase": outcome.said.phase.value,
        "datagrams_not_sent": dict(flight.link.lost),
        "ticks_not_logged": log.lost if log else 0,
        "log_problem": log.problem if log else "",
    }


def rerun(path: Path, seen: Callable[[int], None] = lambda ticks: None) -> tuple[Facts | None, Comparison]:
    """Fly a log once more: (the flight, or None if the pilot had no turn; what came of it); `seen` is told each tick.

    Raises:
        FledgeError: it is no log, is damaged, or was made of something that is not known here.
    """
    opening = read_opening(path)
    with TemporaryDirectory() as folder:
        outfit, controller = restored(opening, Path(folder))
    rows, found, ticks = Rows(), [], count(1)
    memory = rows.init()

    def see(said: Said) -> None:
        nonlocal memory
        memory, row = rows.step(memory, said)
        found.extend([row] if row else [])
        seen(next(ticks))

    with runtime.one_thread():
        comparison = replay(path, controller, see)
    if comparison.difference and opening.brief.get("source") != _source():
        comparison = replace(
            comparison, difference=f"{comparison.difference}; it was flown by another fledge"
        )
    return _facts(outfit, together(found)) if found else None, comparison


def restored(opening: Opening, folder: Path) -> tuple[Outfit, Controller]:
    """The controller that a log tells of; `folder` is for files that have to be read from one.

    Raises:
        FledgeError: it was made of something that is not known here.
    """
    outfit = from_json(Outfit, opening.brief["outfit"])
    pilot = _pilot(outfit, opening, folder)
    net = lookup.net(outfit.net)
    if CONTRACT in opening.files:
        (folder / CONTRACT).write_bytes(opening.files[CONTRACT])
        net = read_contract(folder / CONTRACT).under(net)
    return outfit, outfit.controller(pilot, net)


def _pilot(outfit: Outfit, opening: Opening, folder: Path) -> AbstractPilot:
    if POLICY not in opening.files:
        return lookup.pilot(outfit.pilot)
    (folder / POLICY).write_bytes(opening.files[POLICY])
    return lookup.policy(folder / POLICY)


def _facts(outfit: Outfit, episode: Episode | None = None) -> Facts:
    """What a flight was, for those who read flights."""
    o = outfit
    return Facts(
        episode,  # pyright: ignore[reportArgumentType]
        "lab", o.pilot, o.net, o.seed, 0, o.axes, o.arena, o.lens, o.sticks, o.ideal_radius,
    )  # fmt: skip


def _source() -> str:
    """SHA-256 of all of fledge: another one may fly otherwise."""
    files = sorted(Path(__file__).parents[1].rglob("*.py"))
    return sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


def _made(order: Order) -> tuple[Outfit, Controller, Crew]:
    """All that can be made without opening anything."""
    crew = _crew(order)
    outfit = Outfit(
        arena=_arena(order),
        pilot=crew.name,
        net=order.net,
        topics=order.mocap is None,
        ros=order.vehicle is None,
        meaning=(Meaning.VELOCITY if order.velocity else Meaning.SHARES).value,
        axes=order.axes,
        duration=float("inf") if order.duration is None else order.duration,
        seed=order.seed,
    )
    path = lookup.contract_file(order.contract)
    net = lookup.lab_net(order.net, order.contract)
    crew = crew._replace(files={**crew.files, CONTRACT: path.read_bytes()})
    return outfit, outfit.controller(crew.pilot, net), crew


def _crew(order: Order) -> Crew:
    if (order.policy is None) == (order.pilot is None):
        raise FledgeError("who flies? valid is a policy's file, or --pilot NAME, and not both")
    if order.policy is None:
        assert order.pilot is not None
        return Crew(order.pilot, lookup.pilot(order.pilot), {})
    policy = lookup.policy(order.policy)
    return Crew(str(order.policy), policy, {POLICY: order.policy.read_bytes()})


def _arena(order: Order) -> Arena:
    """The one asked for; the one that comes along only where both ends are on this machine."""
    if order.arena is not None:
        return lookup.arena(order.arena)
    for end in (order.mocap, order.vehicle):
        if end is None or not is_loopback(end[0]):
            raise FledgeError(
                "no --arena: valid is the file of the room you fly in; the one that fledge brings along is for "
                "a twin on this machine"
            )
    return lookup.arena("lab")


@contextmanager
def _ready(
    order: Order, made: Outfit, controller: Controller, crew: Crew, log: Path | None
) -> Iterator[runtime.Flight]:
    """Everything opened; all of it is closed again, whatever happens."""
    with ExitStack() as stack:
        device = _device(order, made, stack)
        link = stack.enter_context(Link(_ports(order, made, device), (_waking(made),)))
        brief = {
            "fledge": version("fledge"),
            "source": _source(),
            "outfit": to_json(made),
            "order": _plain(order),
        }
        book = None if log is None else stack.enter_context(Log(log, _facts(made), brief, crew.files))
        commanded = len(made.subjects) if made.ros else 1
        title = f"{crew.name} behind {made.net}" + (", dry run" if order.dry else "")
        screen = Screen(title, made.subjects, commanded, keys.HELP if isinstance(device, Typist) else "")
        view = stack.enter_context(View(screen))
        window = Window(made, link.port(GLANCES))

        def show(now: runtime.Now) -> None:
            view.show(now)
            window.show(now)

        yield runtime.Flight(
            controller,
            link,
            Desk(len(made.subjects), device),
            Tally(made.arena, made.lens, made.ideal_radius),
            book,
            show,
            order.dry,
            order.duration or 0.0 if order.dry else 0.0,
            JOINING if order.operator == "ws" else runtime.PATIENCE,
        )


def _device(order: Order, made: Outfit, stack: ExitStack) -> Device | None:
    """Who has no wire of their own."""
    vehicles = len(made.subjects)
    if order.nobody:
        return Nobody(vehicles)
    if order.operator == "keyboard":
        return Typist(keys.Keyboard(vehicles, made.sticks), stack.enter_context(Terminal()))
    return None


def _ports(order: Order, made: Outfit, device: Device | None) -> list[Port]:
    ports: list[Port] = list(opened(_wires(order)))
    hears = [topics.pose(subject) for subject in made.subjects] if made.topics else []
    says: list[str] = []
    if made.ros:
        hears.append(topics.NAVDATA)
        says += [topics.FLY, topics.TAKE_OFF, topics.LAND, topics.RESET]
        says += [topics.drive(ugv) for ugv in made.subjects[1:]]
    if device is None and order.operator == "joy":
        hears.append(topics.JOY)
    if hears or says:
        from fledge.lab.shell.ros import RosPort

        try:
            ports.append(RosPort(hears, says, _waking(made) if made.topics else ""))
        except FledgeError:
            for port in ports:
                port.close()
            raise
    return ports


def _wires(order: Order) -> tuple[Wire, ...]:
    shown = order.operator == "ws" and not order.nobody
    return controller_wires(order.mocap, order.vehicle, order.sticks, shown)


def _waking(made: Outfit) -> str:
    """The channel for which a tick begins: of several topics the last, when all others are there."""
    return topics.pose(made.subjects[-1]) if made.topics else VICON


def _plain(order: Order) -> dict[str, Any]:
    """The order, for people who read a log."""
    paths = {name: str(path) for name in ("policy", "log") if (path := getattr(order, name)) is not None}
    return to_json(replace(order, policy=None, log=None)) | paths


def _kept(log: Log | None, worth: bool) -> Path | None:
    """The log's file; one that nobody asked for, of a flight that never began, goes."""
    if log is None:
        return None
    path = Path(log.path)
    if not worth:
        path.unlink(missing_ok=True)
        return None
    return path
