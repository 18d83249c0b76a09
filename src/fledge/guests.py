"""Pilots, manoeuvres and nets from outside: found by `package.module:Name`, tried once, and quoted when they fail.

A guest is a class that can be made without arguments, or an instance, in a module that Python can import; the
current folder counts. It is tried before any work begins, so that what every first attempt gets wrong (a memory not
returned, a plan too short) is said in one line. What it raises later is said with the file and line of its own code.
"""

import inspect
import sys
import sysconfig
import traceback
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from fledge.errors import FledgeError

if TYPE_CHECKING:
    from fledge.manoeuvres import AbstractManoeuvre
    from fledge.pilots import AbstractPilot
    from fledge.safety import AbstractNet

INSTALLED = (Path(sysconfig.get_path(name)) for name in ("stdlib", "purelib", "platlib"))
HOMES = (Path(__file__).parent, *INSTALLED)
"""Where code lies that is no guest's."""

TRIAL_ROWS = 200


def pilot(name: str) -> "AbstractPilot":
    """A pilot from outside that answers with a memory and an action.

    Raises:
        FledgeError: there is no such thing, or it is no pilot.
    """
    from fledge.observation import Action, Observation
    from fledge.pilots import AbstractPilot

    guest = _made(AbstractPilot, name)
    answer = (), Action(0.0, 0.0, 0.0, 0.0)
    with suppress(Exception):  # what it raises here it raises in flight, unless it wants arrays for numbers
        answer = guest.act(guest.init(), Observation(*(1.0,) * 11), (0.0,) * 4)
    if not (isinstance(answer, tuple) and len(answer) == 2 and isinstance(answer[1], Action)):
        raise FledgeError(f"{name}: act returned {_short(answer)}: valid is a pair (memory, Action)")
    return guest


def manoeuvre(name: str) -> "AbstractManoeuvre":
    """A manoeuvre from outside that plans as many rows as it is asked for.

    Raises:
        FledgeError: there is no such thing, or it is no manoeuvre.
    """
    import numpy as np

    from fledge.manoeuvres import AbstractManoeuvre, Plan

    guest = _made(AbstractManoeuvre, name)
    if not (axes := getattr(guest, "axes", ())) or not set(axes) <= {0, 1, 2, 3}:
        raise FledgeError(f"{name}: axes are {axes}: valid is a tuple of some of 0, 1, 2 and 3")
    plan = guest.plan(np.random.default_rng(0), TRIAL_ROWS)
    if not isinstance(plan, Plan):
        raise FledgeError(f"{name}: plan returned {_short(plan)}: valid is a Plan")
    shapes = {np.shape(getattr(plan.track, part)) for part in ("x", "y", "vx", "vy", "spread", "spread_rate")}
    if shapes != {(TRIAL_ROWS,)}:
        raise FledgeError(
            f"{name}: asked for {TRIAL_ROWS} rows, it planned {shapes}: valid is one number a row"
        )
    return guest


def net(name: str) -> "AbstractNet":
    """A safety net from outside that answers with a memory and a verdict per vehicle.

    Raises:
        FledgeError: there is no such thing, or it is no net.
    """
    from fledge.geometry import Quat, Vec3
    from fledge.safety import AbstractNet
    from fledge.world import Arena, Commands, UavState, UgvState, VelocityCommand, Verdict, WorldState

    guest = _made(AbstractNet, name)
    still, hover = Vec3(0.0, 0.0, 0.0), VelocityCommand.hover()
    ugvs = tuple(UgvState(x, 0.0, 0.0, 0.0, 0.0, 0.0) for x in (-2.0, 0.0, 2.0))
    world = WorldState(0.0, UavState(Vec3(0.0, 0.0, 3.0), still, Quat.from_yaw(0.0), still, 0.0), ugvs)
    answer = guest.filter(guest.init(Arena.square(), world), world, Commands(hover, (hover,) * len(ugvs)))
    verdicts = answer[1] if isinstance(answer, tuple) and len(answer) == 2 else None
    if not isinstance(verdicts, tuple) or [type(one) for one in verdicts] != [Verdict] * (1 + len(ugvs)):
        raise FledgeError(
            f"{name}: filter returned {_short(answer)}: valid is a pair (memory, verdicts), the UAV's "
            "Verdict first, then one per UGV"
        )
    return guest


def culprit(error: BaseException) -> str | None:
    """The innermost line of a guest's code that had a part in an error, "own.py, line 3" say."""
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        path = Path(frame.filename)
        if path.is_file() and not any(path.is_relative_to(home) for home in HOMES):
            return f"{path.name}, line {frame.lineno}"
    return None


def kinds(module: ModuleType, base: type) -> list[type]:
    """The classes of a kind that a module defines itself, those to derive from left out."""
    return [
        thing
        for thing in vars(module).values()
        if isinstance(thing, type)
        and issubclass(thing, base)
        and thing.__module__ == module.__name__
        and not inspect.isabstract(thing)
    ]


def _made(base: type, name: str) -> Any:
    kind = base.__name__.removeprefix("Abstract").lower()
    module_name, _, attribute = name.partition(":")
    module = _imported(kind, module_name)
    if not hasattr(module, attribute):
        known = ", ".join(one.__name__ for one in kinds(module, base))
        raise FledgeError(f"{name}: no such {kind}: {module_name} has {known or 'none'}")
    thing = getattr(module, attribute)
    try:
        guest = thing() if isinstance(thing, type) else thing
    except TypeError as error:
        raise FledgeError(f"{name}: cannot be made without arguments: {error}") from error
    if not isinstance(guest, base):
        raise FledgeError(f"{name}: a {type(guest).__name__}: valid is a subclass of fledge.{base.__name__}")
    if "name" in base.__annotations__ and not isinstance(getattr(guest, "name", None), str):
        raise FledgeError(f'{name}: it has no name: valid is a class with a line like name = "gentle"')
    return guest


def _imported(kind: str, name: str) -> ModuleType:
    if not all(part.isidentifier() for part in name.split(".")):
        raise FledgeError(f"{kind} {name!r}: valid is the name of a module, as in package.module:Name")
    if "" not in sys.path:
        sys.path.insert(0, "")  # the current folder, as for `python -m`
    try:
        return import_module(name)
    except ImportError as error:
        raise FledgeError(f"{kind} {name!r}: cannot be imported: {error}") from error
    except SyntaxError as error:
        raise FledgeError(f"{error.filename}, line {error.lineno}: {error.msg}") from error


def _short(value: Any) -> str:
    return repr(value)[:60]
