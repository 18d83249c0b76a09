"""A tape: a flight's rows on disk while it is flown, kept or thrown away afterwards.

The file is hidden, `.NAME.<random>.tape`, and locked as long as its writer lives, so that nobody takes it for a flight.
`keep` ends it and gives it its name in one step: the first free `MANOEUVRE-NNN.mcap`, never one that is taken.
`discard` removes it. Every half a second of flight goes to the system, so a server that is killed loses less than its
last second; `recover` makes whole flights of what was left behind, at the next start.

If the disk refuses, being full, say, the tape ends there and `problem` says so; the flight goes on without.
"""

import fcntl
import os
import re
import secrets
from contextlib import suppress
from itertools import count
from pathlib import Path

from fledge.episode import Episode, Flight
from fledge.errors import BadFile
from fledge.observation import ROW_RATE
from fledge.storage import FlightLog, recover_flight
from fledge.storage.atomic import AnyPath
from fledge.storage.flights import write_flight

FLUSH = round(0.5 * ROW_RATE)
"""Rows between two times that the file is handed to the system."""


class Tape:
    """A flight being recorded."""

    def __init__(self, folder: AnyPath, about: Flight) -> None:
        """Begin a tape in a folder, which is made if need be; of `about` all is taken but its episode.

        Raises:
            BadFile: it cannot be written.
        """
        self.rows = 0
        self.problem = ""
        """Why it ended before the flight, if it did."""
        self._name = _stem(about.manoeuvre)
        self._folder = Path(folder)
        self._path = self._folder / f".{self._name}.{secrets.token_hex(4)}.tape"
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            self._stream = open(self._path, "xb")
            with suppress(OSError):  # not every file system has locks
                fcntl.flock(self._stream, fcntl.LOCK_EX)
            self._log = FlightLog(self._stream, about)
            self._log.writer.flush()
        except OSError as error:
            raise BadFile(self._path, f"cannot be written: {error.strerror or error}") from error

    def add(self, row: Episode) -> None:
        """One row more; its leaves are numbers."""
        if self.problem:
            return
        try:
            self._log.add(row)
            self.rows += 1
            if self.rows % FLUSH == 0:
                self._log.writer.flush()
        except OSError as error:
            self.problem = f"cannot be written any more: {error.strerror or error}"

    def keep(self) -> Path:
        """The flight, whole, under its name. What was written before a problem is kept, too.

        Raises:
            BadFile: it cannot be written, or there are no rows.
        """
        if not self.rows:
            self.discard()
            raise BadFile(self._folder / self._name, "nothing was recorded: valid is a flight with a row")
        try:
            if self.problem:
                flight = recover_flight(self._path)
                return _stored(self._folder, self._name, flight, self._path)
            self._log.__exit__(None, None, None)
            self._stream.flush()
            os.fsync(self._stream.fileno())
            return _named(self._path, self._folder, self._name)
        except OSError as error:
            raise BadFile(self._path, f"cannot be written: {error.strerror or error}") from error
        finally:
            with suppress(OSError):
                self._stream.close()

    def leave(self) -> None:
        """Nobody decided: what was recorded stays as it is, for `recover`."""
        with suppress(OSError):
            self._log.writer.flush()
        with suppress(OSError):
            self._stream.close()

    def discard(self) -> None:
        """Nothing was recorded."""
        with suppress(OSError):
            self._path.unlink()
        with suppress(OSError):
            self._stream.close()


def recover(folder: AnyPath) -> list[Path]:
    """Whole flights of the tapes that killed writers left in a folder; one without a whole row is removed.

    Raises:
        BadFile: a flight cannot be written; its tape is still there.
    """
    found = []
    for tape in sorted(Path(folder).glob(".*.tape")):
        with suppress(OSError), open(tape, "r+b") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            try:
                flight = recover_flight(tape)
            except BadFile:
                tape.unlink()
                continue
            found.append(_stored(Path(folder), _stem(flight.manoeuvre), flight, tape))
    return found


def _stored(folder: Path, name: str, flight: Flight, tape: Path) -> Path:
    """A recovered flight under its name, in the place of its tape."""
    whole = folder / f".{name}.{secrets.token_hex(4)}.partial"
    write_flight(whole, flight)
    path = _named(whole, folder, name)
    tape.unlink()
    return path


def _named(hidden: Path, folder: Path, name: str) -> Path:
    """A hidden file under the first free name; a link, other than a rename, never replaces a file."""
    for number in count():
        path = folder / f"{name}-{number:03d}.mcap"
        with suppress(FileExistsError):
            os.link(hidden, path)
            hidden.unlink()
            return path
    raise AssertionError("numbers have no end")


def _stem(manoeuvre: str) -> str:
    """A manoeuvre's name as that of a file: letters, digits, and what cannot lead elsewhere."""
    return re.sub(r"[^A-Za-z0-9_-]+", "-", manoeuvre).strip("-")[:80] or "flight"
