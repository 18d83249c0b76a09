"""Every command explains every option of its own; what they do is tested in test_cli."""

import inspect
import re

import pytest

from fledge.cli import COMMANDS

EVERY_COMMAND = pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS.keys())


@EVERY_COMMAND
def test_its_help_names_every_option_once(command):
    explained = re.findall(r"^    (\w+): ", inspect.cleandoc(command.__doc__).split("Args:")[1], re.MULTILINE)
    assert explained == list(inspect.signature(command).parameters)


@EVERY_COMMAND
def test_its_help_begins_with_one_sentence(command):
    first, empty, *_ = command.__doc__.split("\n")
    assert first[0].isupper() and first.endswith(".") and empty == ""


@EVERY_COMMAND
def test_machines_can_read_what_it_found(command):
    assert "json" in inspect.signature(command).parameters
