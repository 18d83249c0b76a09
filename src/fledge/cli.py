"""The command line: finds the command, and makes one line of whatever goes wrong.

Exit codes: 0, all is well; 1, `doctor` misses something, or nobody read on; 2, the user can mend it, and the one
line on standard error says what; 130, interrupted. A traceback is a bug of ours.
"""

import os
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, Union

import tyro

from fledge import console, guests
from fledge.commands import cockpit, fly, identify, lab_study, study, twin
from fledge.errors import FledgeError

ABOUT = """Teach a drone a composite skill from demonstrations of its simple parts.

Everything at once: fledge reproduce. Step by step:
  fledge demonstrate
  fledge train demos
  fledge evaluate policy.onnx servo
  fledge replay demos/combined-000.mcap
  fledge falsify --net stop-tube"""

COMMANDS: dict[str, Callable[..., None]] = {
    "reproduce": study.reproduce,
    "demonstrate": study.demonstrate,
    "train": study.train,
    "evaluate": study.evaluate,
    "replay": study.replay,
    "falsify": study.falsify,
    "twin": twin.twin,
    "fly": fly.fly,
    "identify": identify.identify,
    "lab-study": lab_study.lab_study,
    "cockpit": cockpit.cockpit,
    "doctor": study.examine,
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a command; leave with one line if it fails."""
    # What JAX compiles, some seconds a program, is kept for the next run; JAX reads this when it is imported.
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "fledge"
    os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(cache))
    try:
        run(sys.argv[1:] if arguments is None else arguments)
    except BrokenPipeError:  # whoever read along has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except KeyboardInterrupt:
        _note("interrupted; every file is whole")
        with suppress(BrokenPipeError):
            sys.stdout.flush()
        os._exit(130)  # at once: a compiler in another thread cannot be told to stop
    except Exception as error:
        line = explain(error)
        if line is None:
            raise
        _leave(line, 2)


def run(arguments: Sequence[str]) -> None:
    """Run the command that the arguments ask for."""
    kinds = [Annotated[Any, _subcommand(name, arguments)] for name in COMMANDS]
    tyro.cli(Union[tuple(kinds)], prog="fledge", description=ABOUT, args=arguments)  # pyright: ignore  # noqa: UP007


def explain(error: Exception) -> str | None:
    """What the user reads; None for a bug of ours."""
    if isinstance(error, FledgeError):
        return str(error)
    if isinstance(error, ImportError):
        return f"{error}; `fledge doctor` says what to install"
    if isinstance(error, (FileExistsError, NotADirectoryError)):
        return f"{error.filename}: a file is in the way of this folder"
    if isinstance(error, OSError):
        return f"{error.filename or 'standard output'}: {error.strerror}"
    where = guests.culprit(error)
    return where and f"{where}: {type(error).__name__}: {error}"


def _subcommand(name: str, arguments: Sequence[str]) -> Any:
    """A command with its whole help if it was asked for, else with the first line of it."""
    first = (COMMANDS[name].__doc__ or "").split("\n")[0]
    description = None if name in arguments[:1] else first
    return tyro.conf.subcommand(name, constructor=COMMANDS[name], description=description)


def _leave(line: str, code: int) -> None:
    _note(line)
    sys.exit(code)


def _note(line: str) -> None:
    console.note("fledge: " + " ".join(line.split()))
