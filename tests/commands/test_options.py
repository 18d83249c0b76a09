"""What an option refuses, it refuses before any work begins, and says what would do."""

from pathlib import Path

import pytest
import tyro
from hypothesis import given
from hypothesis import strategies as st

from fledge.commands import options
from fledge.errors import BadFile, OutOfRange

BOUNDS = {
    "seed": (options.Seed, 0, options.LARGEST_SEED),
    "cases": (options.Cases, 2, options.MOST_CASES),
    "episodes": (options.Episodes, 1, 1000),
    "epochs": (options.Epochs, 1, 1_000_000),
    "steps": (options.Steps, options.LEAST_STEPS, 10**10),
}


def parsed(kind, word):
    return tyro.cli(kind, args=[word])


@pytest.mark.slow
@pytest.mark.parametrize("name", BOUNDS)
@given(number=st.integers())
def test_a_whole_number_is_taken_within_its_bounds_only(name, number):
    kind, least, most = BOUNDS[name]
    if least <= number <= most:
        assert parsed(kind, str(number)) == number
    else:
        with pytest.raises(
            OutOfRange, match=f"^{name} is {number}: valid is a whole number from {least:,} to {most:,}$"
        ):
            parsed(kind, str(number))


@pytest.mark.parametrize("word", ["", "1.5", "one", "nan", "None", "1e3"])
def test_what_is_no_whole_number_is_refused(word):
    with pytest.raises(OutOfRange, match="valid is a whole number"):
        parsed(options.Seed, word)


@pytest.mark.parametrize("word", ["0.09", "60.1", "nan", "inf", "-1", "ten"])
def test_minutes_have_bounds(word):
    assert parsed(options.Minutes, "0.5") == 0.5
    with pytest.raises(OutOfRange, match=f"^minutes is {word}: valid is 0.1 to 60.0$"):
        parsed(options.Minutes, word)


def test_keys_of_trainings_fit_32_bits_and_differ():
    assert 1000 * options.LARGEST_SEED + 999 < 2**32


def test_a_new_file_must_have_a_place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for word in ("-", "a.json", str(tmp_path / "b.json")):
        assert parsed(options.NewFile, word) == Path(word)
    for word in (".", "nowhere/a.json"):
        with pytest.raises(BadFile, match="valid is a file in a folder that exists"):
            parsed(options.NewFile, word)


@pytest.mark.parametrize(
    ("word", "address"),
    (("10.0.0.1", ("10.0.0.1", 51001)), ("host:1", ("host", 1)), ("a.b:65535", ("a.b", 65535))),
)
def test_an_address_has_the_protocol_s_port_unless_another_is_given(word, address):
    assert parsed(options.Mocap, word) == address


@pytest.mark.parametrize("word", ["", ":1", "host:", "host:0", "host:65536", "host:-1", "host:x"])
def test_what_is_no_address_is_refused(word):
    with pytest.raises(OutOfRange, match="valid is HOST or HOST:PORT, with a port from 1 to 65535"):
        parsed(options.Mocap, word)
