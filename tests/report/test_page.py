"""What all pages have in common."""

import pytest
from matplotlib.figure import Figure

from fledge.errors import BadFile
from fledge.report import page
from fledge.report.figures import Plot


def plot(name="one"):
    figure = Figure(figsize=(2.0, 1.0))
    figure.add_subplot().plot([0.0, 1.0], [1.0, 0.0])
    return Plot(name, f"Figure {name}", figure)


def test_figures_are_kept_as_files_and_numbered_for_the_page(tmp_path):
    kept = page.keep(tmp_path, [plot("one"), plot("two")])
    assert [(one["name"], one["number"]) for one in kept.values()] == [("one", 1), ("two", 2)]
    assert (tmp_path / "figures" / "one.svg").read_bytes().startswith(b"<?xml")
    assert (tmp_path / "figures" / "two.png").read_bytes().startswith(b"\x89PNG")
    assert kept["two"]["svg"].startswith("<svg viewBox=") and 'aria-label="Figure two"' in kept["two"]["svg"]


def test_a_page_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "index.html").mkdir()
    with pytest.raises(BadFile, match=r"index\.html"):
        page.publish(tmp_path, "<!doctype html>")
    (tmp_path / "file").write_text("")
    with pytest.raises(BadFile, match="file"):
        page.publish(tmp_path / "file" / "folder", "")


def test_a_word_that_nobody_gave_is_an_error():
    with pytest.raises(Exception, match="undefined"):
        page.render("study.html.j2", {}, {})
