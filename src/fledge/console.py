"""What the command line shows: progress, results, one clear line for an error.

Results go to standard output; progress and remarks go to standard error. Progress is drawn on a terminal only, so a log
stays quiet. Where a machine reads along (`--json -`), standard output holds the JSON and nothing else.
"""

import json
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table as Grid

from fledge.report.tables import Table

STANDARD_OUTPUT = Path("-")
"""As a file's name."""


class Bar:
    """How far a job is: one line per stage."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._stages: dict[str, TaskID] = {}

    def update(self, stage: str, done: float, total: float) -> None:
        """Show how far a stage is; a new stage gets a new line."""
        if stage not in self._stages:
            self._stages[stage] = self._progress.add_task(stage, total=total)
        self._progress.update(self._stages[stage], completed=done, total=total)


@contextmanager
def progress() -> Iterator[Bar]:
    """Bars with the time left, on a terminal; nothing elsewhere."""
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), disable=not sys.stderr.isatty()) as drawn:
        yield Bar(drawn)


def show(summary: Mapping[str, Any], file: Path | None, *shown: Table | str) -> None:
    """The result of a command: tables and lines for people, the summary as JSON for machines.

    Args:
        summary: plain JSON values.
        file: where to store the summary, if anywhere; `STANDARD_OUTPUT` shows it in place of all else.
        shown: what people read.
    """
    if file == STANDARD_OUTPUT:
        _line(json.dumps(summary, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False))
        return
    if file is not None:
        from fledge.storage import write_json

        write_json(file, summary)
    for part in shown:
        _grid(part) if isinstance(part, Table) else _line(part)


def note(text: str) -> None:
    """A remark on standard error."""
    _line(text, Console(stderr=True))


def _line(text: str, console: Console | None = None) -> None:
    """A line as it is: no colours, no emoji codes, wrapped nowhere."""
    (console or Console()).print(text, markup=False, highlight=False, emoji=False, soft_wrap=True)


def _grid(table: Table) -> None:
    """The first column is text, the others are numbers; in a pipe it is as wide as it needs to be."""
    heads = any(table.columns)
    grid = Grid(box=box.SIMPLE, show_edge=False, pad_edge=False, collapse_padding=True, show_header=heads)
    for i, column in enumerate(table.columns):
        grid.add_column(column, justify="right" if i else "left", no_wrap=bool(i), overflow="fold")
    for row in table.rows:
        grid.add_row(*row)
    console = Console() if sys.stdout.isatty() else Console(width=1000)
    _line(table.title, console)
    console.print(grid, markup=False, highlight=False, emoji=False)
    _line("", console)
