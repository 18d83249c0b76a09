"""What the documents tell to type, to copy and to expect is so."""

import functools
import inspect
import re
import shlex
from pathlib import Path

import pytest

from fledge import cli
from fledge.report.lab import differences
from fledge.runs.labwork import simulator_settings, twin_settings
from fledge.storage import read_arena

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
FENCED = re.compile(r"^ *```(\w*)\n(.*?)^ *```", re.MULTILINE | re.DOTALL)


def typed():
    """Every line of a block of code that begins with `fledge`."""
    for page in PAGES:
        for kind, block in FENCED.findall(page.read_text(encoding="utf-8")):
            for line in map(str.strip, block.splitlines()):
                if not kind and line.startswith("fledge "):
                    yield pytest.param(line, id=f"{page.name}: {line}")


@pytest.mark.parametrize("line", list(typed()))
def test_what_is_to_be_typed_can_be_typed(line, monkeypatch, tmp_path):
    ran = []
    for name, command in cli.COMMANDS.items():
        stub = functools.wraps(command)(lambda *_, **__: ran.append(True))
        monkeypatch.setitem(cli.COMMANDS, name, stub)
    monkeypatch.chdir(tmp_path)
    cli.run(shlex.split(line, comments=True)[1:])
    assert ran == [True]


def test_commands_and_options_that_are_spoken_of_are_there():
    for page in PAGES:
        for name, rest in re.findall(r"`fledge ([\w-]+)([^`]*)`", page.read_text(encoding="utf-8")):
            assert name in cli.COMMANDS, f"{page.name}: fledge {name}"
            options = inspect.signature(cli.COMMANDS[name]).parameters
            for option in re.findall(r"--([\w-]+)", rest):
                assert option.replace("-", "_") in options, f"{page.name}: fledge {name} --{option}"


def test_links_lead_somewhere():
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_arenas_to_copy_are_arenas(tmp_path):
    blocks = [block for page in PAGES for kind, block in FENCED.findall(page.read_text()) if kind == "toml"]
    assert len(blocks) >= 2
    for block in blocks:
        (tmp_path / "arena.toml").write_text(block)
        assert read_arena(tmp_path / "arena.toml").ceiling > 0.0


def test_what_differs_between_simulator_and_twin_is_what_the_guide_says():
    text = (ROOT / "docs" / "lab.md").read_text(encoding="utf-8")
    told = text.split("<!-- differences")[1].split("<!-- end")[0]
    for one in differences({"twin": twin_settings(), "simulator": simulator_settings()}):
        assert f"| {one.what} | {one.simulator} | {one.twin} |" in told
    assert told.count("\n|") == 2 + len(
        differences({"twin": twin_settings(), "simulator": simulator_settings()})
    )
