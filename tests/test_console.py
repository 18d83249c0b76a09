"""People read tables and lines, machines read JSON, and nobody reads a progress bar in a log."""

import io
import json
import sys
from pathlib import Path

import pytest

from fledge import console
from fledge.errors import FledgeError
from fledge.report.tables import Table

TABLE = Table(
    "flights of [bold] :warning:", ("", "error\n[px]"), (("a long name indeed " * 8, "1.0"), ("b", "22.5"))
)
SUMMARY = {"b": [1, 2.5, None], "a": "± :warning: [bold]"}


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_people_read_what_is_shown_as_it_is(capsys):
    console.show(SUMMARY, None, TABLE, "report: [bold] :warning: " + 200 * "x")
    out, err = capsys.readouterr()
    title, *head, _, first, second, blank, line = out.splitlines()
    assert title == TABLE.title
    assert [part.strip() for part in head] == ["error", "[px]"]
    assert first.split() == [*("a long name indeed " * 8).split(), "1.0"]
    assert second.split() == ["b", "22.5"]
    assert first.index("1.0") + 3 == second.index("22.5") + 4, "numbers end in one column"
    assert line == "report: [bold] :warning: " + 200 * "x"
    assert (blank, err) == ("", "")


def test_a_table_without_heads_has_none(capsys):
    console.show({}, None, Table("title", ("", ""), (("a", "1"),)))
    assert [line.split() for line in capsys.readouterr().out.splitlines()] == [["title"], ["a", "1"], []]


def test_machines_read_nothing_but_json(capsys):
    console.show(SUMMARY, console.STANDARD_OUTPUT, TABLE, "a line")
    out, err = capsys.readouterr()
    assert (json.loads(out), err) == (SUMMARY, "")


def test_a_file_holds_what_standard_output_would(tmp_path, capsys):
    console.show(SUMMARY, tmp_path / "summary.json", "a line")
    assert capsys.readouterr().out == "a line\n"
    console.show(SUMMARY, Path("-"))
    assert (tmp_path / "summary.json").read_text() == capsys.readouterr().out


@pytest.mark.parametrize("to_file", [True, False])
def test_what_json_cannot_hold_is_refused(to_file, tmp_path):
    with pytest.raises((FledgeError, ValueError)):
        console.show({"a": float("nan")}, tmp_path / "summary.json" if to_file else console.STANDARD_OUTPUT)
    assert list(tmp_path.iterdir()) == []


def test_remarks_keep_out_of_the_results(capsys):
    console.note("no checkpoint [here]")
    assert capsys.readouterr() == ("", "no checkpoint [here]\n")


def test_progress_is_quiet_in_a_log(capsys):
    with console.progress() as bar:
        bar.update("training", 1, 2)
    assert capsys.readouterr() == ("", "")


def test_progress_on_a_terminal_names_every_stage(capsys, monkeypatch):
    monkeypatch.setattr(sys, "stderr", Terminal())
    with console.progress() as bar:
        for stage in ("demonstrations", "training"):
            bar.update(stage, 0, 2)
            bar.update(stage, 2, 2)
    drawn = sys.stderr.getvalue()
    assert "demonstrations" in drawn and "training" in drawn
    assert capsys.readouterr().out == ""
