"""What the command line shows: progress with time left, tables, one clear line for an error.

Progress goes to standard error, and only to a terminal; results go to standard output.
"""

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

_OUT = Console()
_ERR = Console(stderr=True)


class Bar:
    """One line of progress whose stage may change."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._tasks: dict[str, Any] = {}

    def update(self, stage: str, done: float, total: float) -> None:
        """Show how far a stage is."""
        if stage not in self._tasks:
            self._tasks[stage] = self._progress.add_task(stage, total=total)
        self._progress.update(self._tasks[stage], completed=done, total=total)


@contextmanager
def progress() -> Iterator[Bar]:
    """Progress bars with time left on a terminal; nothing elsewhere."""
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=_ERR, disable=not sys.stderr.isatty()) as shown:
        yield Bar(shown)


def table(title: str, columns: Iterable[str], rows: Iterable[Iterable[str]]) -> None:
    """A table on standard output; the first column is text, the others numbers."""
    drawn = Table(title=title, title_justify="left")
    for i, column in enumerate(columns):
        drawn.add_column(column, justify="left" if i == 0 else "right", no_wrap=True)
    for row in rows:
        drawn.add_row(*row)
    # Piped, a table is as wide as it needs to be.
    wide = _OUT if _OUT.is_terminal else Console(width=200)
    wide.print(drawn)


def say(text: str) -> None:
    """A line of results, wrapped nowhere."""
    _OUT.print(text, markup=False, highlight=False, soft_wrap=True)


def note(text: str) -> None:
    """A remark on standard error."""
    _ERR.print(text, markup=False, highlight=False, soft_wrap=True)
