"""A real terminal, the other end of which is held here."""

import os
import pty
import termios
import time

import pytest

from fledge.errors import FledgeError
from fledge.lab.control.keys import UP
from fledge.lab.shell.keyboard import Terminal


@pytest.fixture
def person():
    """(where a person types, the terminal as a program sees it)."""
    hands, program = pty.openpty()
    stream = os.fdopen(program, "r")
    yield hands, stream
    stream.close()
    try:
        os.close(hands)
    except OSError:
        pass  # a test hung up


def typed(terminal, hands, data):
    os.write(hands, data)
    time.sleep(0.02)
    return terminal.keys()


def test_keys_come_one_by_one_without_enter_and_unseen(person):
    hands, stream = person
    with Terminal(stream) as terminal:
        assert terminal.keys() == []
        assert typed(terminal, hands, b"gw\x1b[A") == ["g", "w", UP]
        assert typed(terminal, hands, b"\x1b") == []
        assert typed(terminal, hands, b"[A") == [UP]
        os.set_blocking(hands, False)
        with pytest.raises(BlockingIOError):
            os.read(hands, 100)  # nothing is echoed


@pytest.mark.parametrize("error", [None, RuntimeError, KeyboardInterrupt, SystemExit])
def test_the_terminal_is_as_it_was_whatever_happens(person, error):
    _, stream = person
    before = termios.tcgetattr(stream)
    try:
        with Terminal(stream):
            assert termios.tcgetattr(stream) != before
            if error:
                raise error
    except BaseException as raised:
        assert error and isinstance(raised, error)
    assert termios.tcgetattr(stream) == before


def test_interrupts_stay_interrupts(person):
    _, stream = person
    with Terminal(stream):
        assert termios.tcgetattr(stream)[3] & termios.ISIG


def test_who_hangs_up_is_gone(person):
    hands, stream = person
    with Terminal(stream) as terminal:
        assert not terminal.gone
        os.close(hands)
        assert terminal.keys() == [] and terminal.gone
        assert terminal.keys() == []


def test_what_is_no_terminal_is_no_keyboard(tmp_path):
    with (
        open(tmp_path / "file", "w+") as file,
        pytest.raises(FledgeError, match="standard input is no terminal"),
    ):
        Terminal(file)
