"""Debian's own ROS 1, where there is one: its Python, a master, and how a test that needs them is skipped."""

import os
import shutil
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from xmlrpc.client import ServerProxy

import pytest

PYTHON = "/usr/bin/python3"

needs_ros = pytest.mark.skipif(
    shutil.which("roscore") is None and os.environ.get("CI") != "true",
    reason="no ROS 1 here: apt-get install python3-rospy, and what .ci/run names beside it",
)


def environment(**more: str) -> dict[str, str]:
    """This process's, but for what would lead Debian's Python to other packages than its own."""
    return {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")} | more


def run(script: str, *arguments: str, timeout: float = 60.0, **more: str) -> str:
    """What a script prints, run by Debian's Python, which knows nothing of fledge."""
    done = subprocess.run(
        [PYTHON, "-c", script, *arguments],
        capture_output=True,
        text=True,
        timeout=timeout,
        env=environment(**more),
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


class Core:
    """A running `roscore`: a master, and what it starts beside it."""

    def __init__(self, folder: Path, port: int = 0) -> None:
        if not port:
            with socket.create_server(("127.0.0.1", 0)) as server:
                port = server.getsockname()[1]
        self.port = port
        self.variables = {
            "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
            "ROS_IP": "127.0.0.1",
            "ROS_HOME": str(folder),
            "ROS_LOG_DIR": str(folder / "log"),
        }
        self._log = (folder / "roscore.log").open("w")
        self._process = subprocess.Popen(
            ["roscore", "-p", str(port)],
            env=environment(**self.variables),
            stdout=self._log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        self._wait(30.0)
        self._pids = [self._process.pid, *_offspring(self._process.pid)]

    @property
    def master(self) -> int:
        """The process id of the master."""
        (pid,) = [pid for pid in self._pids if b"rosmaster" in _command(pid)]
        return pid

    def end(self) -> None:
        """End every process of it, by its number."""
        pids, self._pids = self._pids, []
        for pid in pids:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGCONT)
                os.kill(pid, signal.SIGKILL)
        self._process.wait()
        self._log.close()

    def _wait(self, patience: float) -> None:
        """Until the master and its log node are there."""
        late = time.monotonic() + patience
        while time.monotonic() < late:
            assert self._process.poll() is None, Path(self._log.name).read_text()
            with suppress(OSError), ServerProxy(self.variables["ROS_MASTER_URI"]) as master:
                code, _, _ = master.lookupNode("/tests", "/rosout")  # pyright: ignore
                if code == 1:
                    return
            time.sleep(0.05)
        pytest.fail(f"roscore does not come up: {Path(self._log.name).read_text()}")


@contextmanager
def core(folder: Path, port: int = 0) -> Iterator[Core]:
    """A `roscore` for as long as it is needed."""
    running = Core(folder, port)
    try:
        yield running
    finally:
        running.end()


def _offspring(pid: int) -> list[int]:
    """Every process that this one has started, or one of those."""
    found = []
    for path in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in path.read_text().split():
            found += [int(child), *_offspring(int(child))]
    return found


def _command(pid: int) -> bytes:
    return Path(f"/proc/{pid}/cmdline").read_bytes()
