"""The terminal as a keyboard: keys as they are pressed, and the terminal as it was afterwards.

Ctrl-C stays what it is, since it lands. The terminal gives keys one by one and shows none of them while the context
lasts, whatever ends it; nothing but SIGKILL leaves it in that state, and then `stty sane` mends it.
"""

import os
import select
import sys
import termios
import tty
from contextlib import suppress
from typing import TextIO

from fledge.errors import FledgeError
from fledge.lab.control.keys import split

MOST = 1024
"""[bytes] that are read at once."""


class Terminal:
    """A context in which keys can be read."""

    def __init__(self, stream: TextIO | None = None) -> None:
        """Standard input, or another terminal.

        Raises:
            FledgeError: it is no terminal.
        """
        stream = stream or sys.stdin
        if stream is None or not stream.isatty():
            raise FledgeError(
                "standard input is no terminal, so there is no keyboard: valid is a terminal, "
                "another --operator, or --no-operator"
            )
        self.gone = False
        """Whether the terminal was closed: nobody can say anything any more."""
        self._file = stream.fileno()
        self._before = termios.tcgetattr(self._file)
        self._rest = ""

    def __enter__(self) -> "Terminal":
        tty.setcbreak(self._file, termios.TCSANOW)
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(termios.error):  # it was closed, and nothing is left to mend
            termios.tcsetattr(self._file, termios.TCSANOW, self._before)

    def keys(self) -> list[str]:
        """Those pressed since the last call; does not wait."""
        if self.gone or not select.select([self._file], (), (), 0.0)[0]:
            return []
        try:
            data = os.read(self._file, MOST)
        except OSError:  # what a terminal says whose other end is closed
            data = b""
        self.gone = not data
        keys, self._rest = split(self._rest + data.decode("latin-1"))
        return keys
