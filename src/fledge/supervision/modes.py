"""Flight modes, and the one table of how a vehicle passes from one to another.

The table is data. Rows are tried from the top, which holds what is most severe, and the first that fits decides; if
none fits, the mode stays. So every mode has an answer to every input. `diagram` and `listing` draw it for people.

What was learnt from others: alarms rank by severity, and a clear condition belongs to each (PX4's fail-safe framework);
the first seconds of a hold are deaf to sticks, but never to the switch (PX4: a hold that anybody's hand can undo by
accident is none, one that nobody can leave is a trap); motors off is for good (Crazyflie's "locked"); an arming switch
that was set before anything was ready arms nothing.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import IntEnum, StrEnum

from fledge.scalars import Scalar, where
from fledge.world import Reason


class Mode(IntEnum):
    """Who flies a vehicle; the number stands in the supervisor's memory."""

    INIT = 0
    """Nobody, and something is missing."""
    READY = 1
    """Nobody; it may be armed."""
    AUTO = 2
    """The policy."""
    SHIELDED = 3
    """The policy, and the net or an alarm held something back a moment ago."""
    RECOVER = 4
    """The policy, faded in."""
    HOLD = 5
    """Nobody: brake, hold, until the fault has been gone for a while."""
    STOPPED = 6
    """Nobody: brake, hold, until a person decides."""
    MANUAL = 7
    """A person."""
    LAND = 8
    """Nobody: straight down. A UGV stands still."""
    TERMINATED = 9
    """Nobody, for good."""


class Trigger(StrEnum):
    """What can move a vehicle from one mode to another; the text stands in the diagram."""

    TERMINATE = "order to terminate"
    LAND = "order to land"
    STOP = "order to stop"
    ARM = "armed"
    DISARM = "disarmed"
    SWITCH = "take-over switch"
    STICKS = "sticks moved"
    HAND_BACK = "handed back"
    LINK_LOST = "link lost"
    ON_GROUND = "on the ground"
    ALARM_BRAKE = "alarm: brake or worse"
    ALARM_HOLD = "alarm: hold or worse"
    ALARM_STOP = "alarm: stop or worse"
    ALARM_LAND = "alarm: land"
    CALM = "no alarm for a while"
    HELD_BACK = "net or alarm held something back"
    QUIET = "nothing held back for a while"
    LASTED = "mode has lasted"
    HEARD_OUT = "sticks are heard again"


@dataclass(frozen=True, slots=True)
class Row:
    """From any of these modes, if all of this is so, to that mode."""

    modes: tuple[Mode, ...]
    when: tuple[Trigger, ...]
    to: Mode
    reason: Reason | None
    """What the vehicle is then said to be held back for; None: what the alarm says."""


M, T, R = Mode, Trigger, Reason
FADING = (M.AUTO, M.SHIELDED, M.RECOVER)
POLICY = (*FADING, M.HOLD, M.STOPPED)
FLYING = (*POLICY, M.MANUAL, M.LAND)

TABLE = (
    Row((M.INIT, M.READY, *FLYING), (T.TERMINATE,), M.TERMINATED, R.TERMINATED),
    Row((M.LAND,), (T.ON_GROUND,), M.INIT, R.NOT_READY),
    Row((*POLICY, M.MANUAL), (T.ON_GROUND, T.DISARM), M.INIT, R.NOT_READY),
    Row(FLYING, (T.LAND,), M.LAND, R.LANDING),
    Row((M.MANUAL,), (T.LINK_LOST,), M.STOPPED, R.LINK_LOST),
    Row((*POLICY, M.LAND), (T.SWITCH,), M.MANUAL, R.TAKE_OVER),
    Row(POLICY, (T.ALARM_LAND,), M.LAND, None),
    Row((*FADING, M.HOLD), (T.STOP,), M.STOPPED, R.STOPPED),
    Row((*FADING, M.HOLD), (T.ALARM_STOP,), M.STOPPED, None),
    Row((M.AUTO, M.SHIELDED), (T.ALARM_HOLD,), M.HOLD, None),
    Row((M.RECOVER,), (T.ALARM_BRAKE,), M.HOLD, None),
    Row(FADING, (T.STICKS,), M.MANUAL, R.TAKE_OVER),
    Row((M.HOLD, M.STOPPED), (T.STICKS, T.HEARD_OUT), M.MANUAL, R.TAKE_OVER),
    Row((M.MANUAL, M.STOPPED), (T.HAND_BACK,), M.RECOVER, R.RECOVERING),
    Row((M.HOLD,), (T.CALM,), M.RECOVER, R.RECOVERING),
    Row((M.RECOVER,), (T.LASTED,), M.AUTO, R.NONE),
    Row((M.AUTO,), (T.HELD_BACK,), M.SHIELDED, R.NONE),
    Row((M.SHIELDED,), (T.QUIET,), M.AUTO, R.NONE),
    Row((M.READY,), (T.ALARM_BRAKE,), M.INIT, R.NOT_READY),
    Row((M.READY,), (T.ARM, T.SWITCH), M.MANUAL, R.TAKE_OVER),
    Row((M.READY,), (T.ARM,), M.AUTO, R.NONE),
    Row((M.INIT,), (T.CALM, T.DISARM), M.READY, R.NOT_READY),
)


def advance(
    table: tuple[Row, ...],
    now: tuple[Scalar, Scalar],
    triggers: Mapping[Trigger, Scalar],
    alarm: Scalar,
) -> tuple[Scalar, Scalar]:
    """(mode, reason) after one tick, from the same before it; `alarm` is the reason that the alarm gives."""
    here = [now[0] == float(mode) for mode in Mode]
    # From the last row to the first, so that the first has the last word.
    after = now
    for row in reversed(table):
        fits, within = True, False
        for trigger in row.when:
            fits = fits & triggers[trigger]
        if fits is False:  # on plain floats most rows end here
            continue
        for mode in row.modes:
            within = within | here[mode]
        after = where(
            fits & within, (float(row.to), alarm if row.reason is None else float(row.reason)), after
        )
    return after


def listing(table: tuple[Row, ...] = TABLE) -> str:
    """The table in Markdown, in the order in which it is tried."""
    lines = ["| from | when | to | reason |", "|---|---|---|---|"]
    for row in table:
        modes = ", ".join(mode.name for mode in row.modes)
        reason = "the alarm's" if row.reason is None else row.reason.name
        lines.append(f"| {modes} | {_spoken(row)} | {row.to.name} | {reason} |")
    return "\n".join(lines)


def diagram(table: tuple[Row, ...] = TABLE) -> str:
    """The table as a Mermaid state diagram, one arrow for each pair of modes."""
    labels: dict[tuple[Mode, Mode], list[str]] = {}
    for row in table:
        for mode in row.modes:
            if mode != row.to:
                labels.setdefault((mode, row.to), []).append(_spoken(row))
    arrows = [f"    {a.name} --> {b.name} : {_or(texts)}" for (a, b), texts in sorted(labels.items())]
    return "\n".join(["stateDiagram-v2", f"    [*] --> {Mode.INIT.name}", *arrows])


def _spoken(row: Row) -> str:
    return " and ".join(trigger.value for trigger in row.when)


def _or(texts: Iterable[str]) -> str:
    return ", or ".join(texts)
