"""A flight as the terminal shows it while it is flown: who flies, where, what was held back, how long ticks take.

It is drawn five times a second by a thread of its own, in the pause that follows a tick; the loop only leaves that tick
there. Where nobody looks, on no terminal, nothing is drawn.
"""

from collections import deque
from threading import Event, Thread
from typing import NamedTuple

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.table import Table
from rich.text import Text

from fledge.lab.shell.runtime import Now
from fledge.lab.shell.tally import summary
from fledge.supervision.modes import Mode
from fledge.supervision.posts import Decision
from fledge.world import Reason, UgvState

EVERY = 20
"""Ticks from one picture to the next."""

WHO = {
    Mode.INIT: "nobody: something is missing",
    Mode.READY: "nobody: may be armed",
    Mode.AUTO: "policy",
    Mode.SHIELDED: "policy, held back",
    Mode.RECOVER: "policy, faded in",
    Mode.HOLD: "nobody: holds, until the fault is gone",
    Mode.STOPPED: "nobody: waits for a person",
    Mode.MANUAL: "a person",
    Mode.LAND: "nobody: lands",
    Mode.TERMINATED: "nobody: motors off",
}
"""Who is in command, by the mode."""


class Screen(NamedTuple):
    """What does not change."""

    title: str
    names: tuple[str, ...]
    """The vehicles', the UAV first; those that are not ours to command are shown without a commander."""
    commanded: int
    """How many of them are ours."""
    help: str = ""
    """Last line."""


class View:
    """A context in which a flight is shown."""

    def __init__(self, screen: Screen, console: Console | None = None) -> None:
        self._screen, self._console = screen, console or Console(stderr=True)
        self._last: deque[Now] = deque(maxlen=1)
        self._ticks = 0
        self._turn, self._ending = Event(), False
        self._thread = Thread(target=self._run, name="view", daemon=True)

    def __enter__(self) -> "View":
        if self._console.is_terminal:
            self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ending = True
        self._turn.set()
        if self._thread.ident is not None:
            self._thread.join()

    def show(self, now: Now) -> None:
        """From now on, show this."""
        self._last.append(now)
        self._ticks += 1
        if self._ticks % EVERY == 1:
            self._turn.set()

    def _run(self) -> None:
        with Live(console=self._console, auto_refresh=False, transient=True) as live:
            while not self._ending:
                self._turn.wait()
                self._turn.clear()
                if self._last:
                    live.update(drawn(self._screen, self._last[0]), refresh=True)


def drawn(screen: Screen, now: Now) -> RenderableType:
    """One picture."""
    course = f"{screen.title}: {now.said.phase.value}, {now.t:.1f} s"
    order = "  landing, as ordered; Ctrl-C once more leaves the vehicle to itself" if now.landing else ""
    lines = [
        Text(course + order, style="bold"),
        _vehicles(screen, now),
        Text(_counts(now)),
        Text(_times(now)),
    ]
    if now.wires:
        lines.append(Text(now.wires, style="red"))
    if now.said.complaint:
        lines.append(Text(now.said.complaint, style="yellow"))
    elif not now.ready and not now.landing:
        lines.append(Text("not to be armed yet", style="yellow"))
    if screen.help:
        lines.append(Text(screen.help, style="dim"))
    return Group(*lines)


def _vehicles(screen: Screen, now: Now) -> Table:
    world, decisions = now.said.world, now.said.decisions
    table = Table.grid(padding=(0, 2))
    for i, name in enumerate(screen.names):
        place = "not seen yet"
        if world is not None:
            place = _place(world.uav.position if i == 0 else world.ugvs[i - 1])
        commander = _who(decisions[i]) if i < min(len(decisions), screen.commanded) else ""
        table.add_row(name, place, commander)
    return table


def _place(at: object) -> str:
    x, y = getattr(at, "x"), getattr(at, "y")  # noqa: B009
    return f"{x:6.2f} {y:6.2f}" + ("" if isinstance(at, UgvState) else f" {getattr(at, 'z'):5.2f}") + " m"  # noqa: B009


def _who(decision: Decision) -> str:
    reason, alarm = Reason(int(decision.verdict.reason)), Reason(int(decision.alarm.reason))
    why = {_word(one) for one in (reason, alarm)} - {"none"}
    return WHO[Mode(int(decision.mode))] + (f" ({', '.join(sorted(why))})" if why else "")


def _word(reason: Reason) -> str:
    return reason.name.lower().replace("_", " ")


def _counts(now: Now) -> str:
    found = summary(now.counted)
    layers = ", ".join(f"{layer} {sum(times.values())}" for layer, times in found["interventions"].items())
    view = "" if found["in_view"] is None else f"   in view {100.0 * found['in_view']:.1f} %"
    return f"interventions: {layers}   take-overs {found['takeovers']}   contacts {found['contacts']}{view}"


def _times(now: Now) -> str:
    lost = f"   {now.lost} datagrams not sent" if now.lost else ""
    return f"tick {now.took_us / 1e3:.2f} ms   {now.missed} slots missed{lost}"
