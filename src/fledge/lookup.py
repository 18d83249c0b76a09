"""From a name on the command line to the thing it names.

A name is a module in its folder (`servo` is `fledge/pilots/servo.py`, `fixed-altitude` is
`fledge/manoeuvres/fixed_altitude.py`) or `package.module:Name` from anywhere Python can import, the current folder
included. There is no registry: whatever has the right base class will do.
"""

import importlib
import sys
from typing import Any

from fledge.errors import FledgeError, UnknownName


def find(folder: str, base: type, name: str) -> Any:
    """An instance of the class that `name` names.

    Args:
        folder: the package of the shipped ones, "fledge.pilots" say.
        base: the abstract class it must have.
        name: a module name with dashes, or `package.module:Name`.

    Raises:
        UnknownName: no such module; lists those that exist.
        FledgeError: it exists, but is of another kind or cannot be made.
    """
    kind = folder.rsplit(".", 1)[-1].removesuffix("s")
    if ":" in name:
        return _made(kind, base, name, _outside(kind, name))
    for found in importlib.import_module(folder).__dict__.values():
        if isinstance(found, type) and issubclass(found, base) and getattr(found, "name", None) == name:
            return found()
    raise UnknownName(kind, name, [*shipped(folder, base), "package.module:Name"])


def shipped(folder: str, base: type) -> list[str]:
    """The names of those in the folder."""
    found = importlib.import_module(folder).__dict__.values()
    return sorted(
        thing.name
        for thing in found
        if isinstance(thing, type) and issubclass(thing, base) and thing is not base and hasattr(thing, "name")
    )


def _outside(kind: str, name: str) -> Any:
    module_name, _, attribute = name.partition(":")
    if "" not in sys.path:
        sys.path.insert(0, "")
    try:
        module = importlib.import_module(module_name)
    except ImportError as error:
        raise FledgeError(f"{kind} {name!r}: cannot import {module_name}: {error}") from error
    if not hasattr(module, attribute):
        raise UnknownName(f"{kind} in {module_name}", attribute, [n for n in dir(module) if n[0] != "_"])
    return getattr(module, attribute)


def _made(kind: str, base: type, name: str, thing: Any) -> Any:
    made = thing() if isinstance(thing, type) else thing
    if not isinstance(made, base):
        raise FledgeError(f"{kind} {name!r} is a {type(made).__name__}: valid is a subclass of {base.__name__}")
    return made

