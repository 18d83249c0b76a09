"""The kinds of options: how each looks in the help, and what is refused before any work begins."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

from tyro.conf import FlagCreatePairsOff, Positional, arg
from tyro.constructors import PrimitiveConstructorSpec

from fledge.errors import BadFile, OutOfRange

LEAST_STEPS = 24_000
"""Every family of attacks flies at least once."""

LARGEST_SEED = 2**32 // 1000 - 1
"""The key of a training is 1000 seed + its number, in 32 bits."""

MOST_CASES = 10_000
"""All flights of an evaluation are in the air at once: about 3 GB."""


def _kind(metavar: str, read: Callable[[str], Any]) -> PrimitiveConstructorSpec[Any]:
    """An option of one word."""
    return PrimitiveConstructorSpec(
        nargs=1,
        metavar=metavar,
        instance_from_str=lambda words: read(words[0]),
        is_instance=lambda value: True,
        str_from_instance=lambda value: [str(value)],
    )


def _number(name: str, kind: type, least: float, most: float) -> PrimitiveConstructorSpec[Any]:
    """A number within bounds."""

    def read(word: str) -> Any:
        try:
            number = kind(word)
        except ValueError:
            number = None
        if number is None or not least <= number <= most:
            whole = "a whole number from " if kind is int else ""
            raise OutOfRange(name, word, f"{whole}{least:,} to {most:,}")
        return number

    return _kind("N", read)


def _file(word: str) -> Path:
    """A file that can be written when all work is done, as far as can be told before."""
    path = Path(word)
    if path.is_dir() or not path.parent.is_dir():
        raise BadFile(path, "cannot be written: valid is a file in a folder that exists")
    return path


SILENT = arg(help_behavior_hint="")
"""The help says in words what happens by default."""

Flag = Annotated[bool, FlagCreatePairsOff, SILENT]
Seed = Annotated[int, _number("seed", int, 0, LARGEST_SEED)]
Cases = Annotated[int, _number("cases", int, 2, MOST_CASES)]
Episodes = Annotated[int | None, _number("episodes", int, 1, 1000), SILENT]
Epochs = Annotated[int | None, _number("epochs", int, 1, 1_000_000), SILENT]
Steps = Annotated[int, _number("steps", int, LEAST_STEPS, 10**10)]
Factor = Annotated[float, _number("factor", float, 0.0, 5.0)]
Minutes = Annotated[float | None, _number("minutes", float, 0.1, 60.0), SILENT]
Name = Annotated[str, arg(metavar="NAME")]
Hall = Annotated[str | None, _kind("NAME|FILE", str), SILENT]
Files = Annotated[tuple[Path, ...], arg(metavar="FILE ...", help_behavior_hint="")]
Names = Annotated[tuple[str, ...], arg(metavar="NAME ...", help_behavior_hint="")]
Contestants = Annotated[tuple[str, ...], Positional, arg(metavar="FILE|PILOT ...", help_behavior_hint="")]
Folder = Annotated[Path, arg(metavar="FOLDER")]
File = Annotated[Path, arg(metavar="FILE")]
NewFile = Annotated[Path | None, _kind("FILE", _file), SILENT]
