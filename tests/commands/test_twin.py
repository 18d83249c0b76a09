"""The commands of the lab, as somebody types them."""

import json

import pytest
from loopback import own_host

from fledge.cli import main

pytestmark = pytest.mark.slow


def run(capsys, *arguments):
    main(arguments)
    return capsys.readouterr()


def refused(capsys, *arguments):
    """The one line of a command that must fail."""
    with pytest.raises(SystemExit) as left:
        main(arguments)
    out, err = capsys.readouterr()
    assert (left.value.code, out, err.count("\n")) == (2, "", 1)
    return err.removeprefix("fledge: ").rstrip()


def test_a_twin_says_where_it_is_and_what_came_of_it(capsys, tmp_path):
    host, file = own_host(), tmp_path / "twin.json"
    duration = ["--duration", "0.5", "--seed", "3", "--json", str(file)]
    out, err = run(capsys, "twin", "--drone", host, "--mocap", f"{host}:50123", *duration)
    assert f"AR.Drone at {host}, ports 5556 and 5554" in err
    assert f"Vicon's frames go to {host}, port 50123" in err
    assert out.startswith("0.5 s in 50 ticks") and out.rstrip().endswith("contacts: 0")
    summary = json.loads(file.read_text())
    assert (summary["ticks"], summary["contacts"], summary["phase"]) == (50, [], "landed")
    assert summary["tick_us"]["p50"] <= summary["tick_us"]["max"]


def test_a_machine_that_reads_along_gets_nothing_but_json(capsys):
    host = own_host()
    out, _ = run(capsys, "twin", "--drone", host, "--mocap", host, "--duration", "0.1", "--json", "-")
    assert json.loads(out)["ticks"] == 10


def test_a_port_that_is_taken_is_told_of(capsys):
    from fledge.lab.shell.link import Link
    from fledge.lab.shell.udp import opened, twin_wires

    host = own_host()
    with Link(opened(twin_wires((host, 51001), (host, 5556)))):
        line = refused(capsys, "twin", "--drone", host, "--mocap", host, "--duration", "0.1")
    assert f"UDP port 5554 of {host} is taken" in line


@pytest.mark.parametrize(
    ("words", "line"),
    (
        (("--speed", "0"), "speed is 0: valid is 0.01 to 50.0"),
        (
            ("--mocap", "host:port"),
            "address is 'host:port': valid is HOST or HOST:PORT, with a port from 1 to 65535",
        ),
        (("--drone", ":5556"), "address is ':5556': valid is HOST or HOST:PORT, with a port from 1 to 65535"),
        (("--arena", "moon"), "unknown arena 'moon': valid are FILE.toml, lab, square"),
        (("--spell", "5:4:dropout=0.5"), "a spell from 5.0 to 4.0 s: valid is one that ends after it began"),
    ),
)
def test_what_makes_no_sense_is_refused_before_anything_begins(capsys, words, line):
    assert refused(capsys, "twin", *words) == line


def test_an_arena_without_room_is_refused(capsys, tmp_path):
    file = tmp_path / "cell.toml"
    file.write_text("[bounds]\nx_min_m = -1\nx_max_m = 1\ny_min_m = -1\ny_max_m = 1\nceiling_m = 3\n")
    assert "found no place to begin" in refused(capsys, "twin", "--arena", str(file))
