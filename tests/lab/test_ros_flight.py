"""A whole flight over ROS topics: `fledge fly` drives UAV and UGVs, `fledge twin` is the lab, a roscore in between."""

import json
import os
import subprocess
import sys
import time

import debian
import pytest

from fledge.runs import hangar


def fledge(core, folder, *arguments):
    code = "from fledge.cli import main; main()"
    return subprocess.Popen(
        [sys.executable, "-c", code, *arguments],
        cwd=folder, env={**os.environ, **core.variables}, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


@debian.needs_ros
@pytest.mark.slow
@pytest.mark.parametrize("meaning", ["shares", "velocity"])
def test_all_four_vehicles_are_flown_over_topics(meaning, tmp_path):
    """Both meanings of /cmd_vel; nobody is touched, the formation is followed, and the log replays."""
    ours = ["--velocity"] if meaning == "velocity" else []
    with debian.core(tmp_path) as core:
        twin = fledge(core, tmp_path, "twin", "--ros", meaning, "--seed", "3", "--json", "twin.json")
        time.sleep(4.0)
        fly = fledge(
            core, tmp_path, "fly", "--pilot", "servo", "--mocap", "ros", "--vehicle", "ros", "--arena", "lab", *ours,
            "--seed", "3", "--no-operator", "--duration", "15", "--log", "log.mcap", "--json", "fly.json",
        )  # fmt: skip
        try:
            out, err = fly.communicate(timeout=150)
        finally:
            fly.kill()
            fly.wait()
            twin.terminate()
            twin.communicate(timeout=20)
    assert fly.returncode == 0, err
    found, lab = (json.loads((tmp_path / name).read_text()) for name in ("fly.json", "twin.json"))
    assert found["flown_s"] == pytest.approx(15.0, abs=0.2) and found["phase"] == "over", out
    assert found["in_view"] > 0.9 and found["contacts"] == 0
    assert lab["contacts"] == [] and lab["phase"] == "landed"
    flight, again = hangar.rerun(tmp_path / "log.mcap")
    assert (again.difference, again.missing) == ("", "") and flight is not None
    driven = [max(abs(x) for x in verdict.command.forward) for verdict in flight.episode.verdicts[1:]]
    assert min(driven) > 0.05  # the UGVs went where they were told to, behind the net
