"""What the supervisor knows of one vehicle: what it remembers, what it finds in a tick, what it decides."""

from typing import Any, NamedTuple

from fledge.geometry import Vec3
from fledge.scalars import Scalar
from fledge.supervision.inputs import Operator
from fledge.supervision.modes import Mode
from fledge.supervision.watchdog import Alarm, Watch
from fledge.world import VelocityCommand, Verdict


class Post(NamedTuple):
    """What is remembered of one vehicle."""

    mode: Scalar
    """A `Mode`, as a number."""
    reason: Scalar
    """Why it is in this mode: a `Reason`, as a number."""
    since: Scalar
    """When it came into this mode [s]."""
    alarmed: Scalar
    """When there was last an alarm that acts [s]."""
    held_back: Scalar
    """When something of the policy's was last held back, or a landing [s]."""
    at_rest: Scalar
    """When the sticks were last near their middle [s]."""
    free: Scalar
    """Whether the net had nothing against a person's last command; a flag."""
    origin: VelocityCommand
    """The last command sent; in RECOVER, the last one sent before it."""


class Memory(NamedTuple):
    """The supervisor's memory."""

    watch: Watch
    net: Any
    posts: tuple[Post, ...]
    pad: Vec3
    """Towards which a landing goes aside that is held back [m]."""


class Decision(NamedTuple):
    """What layer two decided on one vehicle."""

    mode: Scalar
    """A `Mode`, as a number."""
    verdict: Verdict
    """What is really sent. The reason is the net's in AUTO, SHIELDED and MANUAL, where only the net acts, and
    otherwise names the fault or the person that took the command away."""
    alarm: Alarm


class Situation(NamedTuple):
    """One vehicle in one tick."""

    now: Scalar
    """[s]."""
    alarm: Alarm
    proposed: VelocityCommand
    operator: Operator
    braking: Scalar
    """Whether the alarm asks for a brake, or worse."""
    silent: Scalar
    """How long the operator's link has been [s]."""
    on_ground: Scalar
    blind: Scalar
    """Whether its pose is too old for a net."""
    descent: VelocityCommand
    """How it lands."""
    aside: VelocityCommand
    """Where it goes while something is in the way of that."""


class Passed(NamedTuple):
    """What became of a command."""

    sent: VelocityCommand
    instead: VelocityCommand
    """What of it is not the net's; NaN elsewhere."""
    filtered: Scalar
    """Whether the net changed it."""
    broken: Scalar
    """Whether somebody flies, and it is no number."""


def is_in(post: Post, *modes: Mode) -> Scalar:
    """Whether it is in one of these modes."""
    found = post.mode == float(modes[0])
    for mode in modes[1:]:
        found = found | (post.mode == float(mode))
    return found
