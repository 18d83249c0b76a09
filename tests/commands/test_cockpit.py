"""The command of the cockpit, as somebody types it."""

import json
import os
import signal
import socket
import time
from threading import Thread

import pytest
from visitor import Visitor

from fledge.cli import main
from fledge.cockpit.asks import Fly
from fledge.cockpit.server import address, recipe
from fledge.cockpit.tells import Welcome


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def visit(port, visited):
    """Somebody comes as soon as it is open, flies a little, and ends it as Ctrl-C does."""
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        try:
            socket.create_connection(("127.0.0.1", port), 1.0).close()
            break
        except OSError:
            time.sleep(0.1)
    try:
        with Visitor(f"http://127.0.0.1:{port}") as visitor:
            visitor.sits().begins(Fly("fixed-altitude", "servo", "stop-tube"))
            visitor.until(lambda: visitor.frame.t > 1.0)
            visited.append(visitor.last(Welcome))
    finally:
        os.kill(os.getpid(), signal.SIGINT)


@pytest.mark.slow
def test_it_says_where_it_is_open_and_what_came_of_it(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    port, visited = free_port(), []
    thread = Thread(target=visit, args=(port, visited))
    thread.start()
    main(["cockpit", "--port", str(port), "--json", "found.json"])
    thread.join()
    out, err = capsys.readouterr()
    assert f"open http://127.0.0.1:{port}/fly ; Ctrl-C ends" in err
    assert "sticks were answered in" in out
    found = json.loads((tmp_path / "found.json").read_text())
    assert found["ticks"] >= 100 and visited and "servo" in visited[0].pilots
    assert {path.name for path in tmp_path.iterdir()} == {"demos", "policies", "found.json"}


def test_only_beyond_this_machine_there_is_a_token_and_a_recipe():
    for host in ("127.0.0.1", "localhost", "::1"):
        assert address(host, 80, None, None).token == "" and recipe(address(host, 80, None, None)) == []
    one, two = (address("192.0.2.7", 80, None, None) for _ in range(2))
    assert one.token and one.token != two.token and f"?token={one.token}" in one.url
    assert any("192.0.2.7" in line for line in recipe(one))
    safe = address("192.0.2.7", 443, __file__, __file__)
    assert recipe(safe) == [] and safe.url.startswith("https://192.0.2.7:443/fly?token=")
    assert address("::1", 80, None, None).url == "http://[::1]:80/fly"
