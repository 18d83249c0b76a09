"""The doctor finds what is wrong, says what to type, and invents nothing."""

import importlib.metadata
import json
import os
import re
import shutil
from types import SimpleNamespace

import debian
import pytest

from fledge.cli import main
from fledge.commands import doctor
from fledge.commands.doctor import Finding
from fledge.errors import FledgeError


def finding(name):
    (one,) = [one for one in doctor.examine() if one.what.startswith(name)]
    return one


def test_a_machine_on_which_tests_run_is_well(capsys):
    main(["doctor"])
    lines = [line for line in capsys.readouterr().out.splitlines() if not line.startswith(" ")]
    assert len(lines) == len(doctor.USES) + len(doctor.EXTRAS) + 4
    dispensable = (*doctor.EXTRAS, "ROS 1")
    assert all(line.startswith("ok ") for line in lines if not line[9:].startswith(dispensable))


def test_it_knows_every_dependency():
    needs = importlib.metadata.requires("fledge")
    for known, some in (
        (doctor.USES, [need for need in needs if "extra ==" not in need]),
        (doctor.EXTRAS, [need for need in needs if "extra ==" in need]),
    ):
        assert sorted(re.match(r"[\w-]+", need)[0] for need in some) == sorted(known)


def test_what_few_need_is_minded_and_does_not_fail(monkeypatch, capsys):
    version = importlib.metadata.version

    def without_mujoco(name):
        if name == "mujoco":
            raise importlib.metadata.PackageNotFoundError(name)
        return version(name)

    def without_ros():
        raise FledgeError("ROS 1 is not installed: valid is Debian's")

    monkeypatch.setattr(importlib.metadata, "version", without_mujoco)
    monkeypatch.setattr(doctor.ros, "load", without_ros)
    main(["doctor"])
    text = capsys.readouterr().out
    assert "mind     mujoco (the lab's twin): not installed\n         pip install" in text
    assert (
        "mind     ROS 1 (a lab that speaks ROS): ROS 1 is not installed\n         valid is Debian's" in text
    )


@debian.needs_ros
def test_debians_ros_is_found():
    assert finding("ROS 1").found == "rospy, in /usr/lib/python3/dist-packages"


def test_a_missing_package_is_found_and_fails_the_command(monkeypatch, capsys):
    version = importlib.metadata.version

    def without_mcap(name):
        if name == "mcap":
            raise importlib.metadata.PackageNotFoundError(name)
        return version(name)

    monkeypatch.setattr(importlib.metadata, "version", without_mcap)
    assert finding("mcap").found == "not installed"
    assert re.fullmatch(r'pip install "mcap[^"]*>=[^"]*"', finding("mcap").remedy)
    with pytest.raises(SystemExit) as left:
        main(["doctor", "--json", "-"])
    report = json.loads(capsys.readouterr().out)
    assert left.value.code == 1
    assert report["well"] is False
    assert [one["what"] for one in report["findings"] if not one["ok"]] == ["mcap (flights on disk)"]


def test_a_package_that_is_there_but_broken_is_found(monkeypatch):
    def broken(name):
        if name == "onnx":
            raise OSError("libprotobuf.so: cannot open shared object file\nand more")

    monkeypatch.setattr(doctor, "import_module", broken)
    one = finding("onnx (")
    assert not one.ok and one.needed
    assert one.found.endswith("broken (OSError: libprotobuf.so: cannot open shared object file)")
    assert one.remedy.endswith("--force-reinstall")


@pytest.mark.parametrize("version", ["0.1", "99.0"])
def test_an_untested_version_is_minded_but_does_not_fail(version, monkeypatch, capsys):
    monkeypatch.setattr(importlib.metadata, "version", lambda name: version)
    monkeypatch.setattr(doctor, "import_module", lambda name: None)
    assert finding("scipy").found == f"{version}, not tested with fledge"
    main(["doctor"])
    untested = [line for line in capsys.readouterr().out.splitlines() if "not tested with fledge" in line]
    assert len(untested) == len(doctor.USES) + len(doctor.EXTRAS)
    assert all(line.startswith("mind ") for line in untested)


@pytest.mark.parametrize(
    ("version", "bounds", "within"),
    [
        ("2.1", ">=2.1,<3", True),
        ("2.1.0", ">=2.1,<3", True),
        ("2.10.5", "<3,>=2.9", True),
        ("2.0.9", ">=2.1,<3", False),
        ("3", ">=2.1,<3", False),
        ("3.0.0rc1", ">=2.1,<3", False),
        ("0.10.2", ">=0.7,<0.11", True),
        ("0.11.0", ">=0.7,<0.11", False),
        ("1.0", "", True),
    ],
)
def test_versions_are_compared_as_numbers(version, bounds, within):
    assert doctor._within(version, bounds) == within


def test_a_platform_that_is_not_there_is_named(monkeypatch):
    import jax

    def absent():
        raise RuntimeError("Unable to initialize backend 'cuda'\nand more")

    monkeypatch.setattr(jax, "devices", absent)
    monkeypatch.setenv("JAX_PLATFORMS", "cuda")
    one = finding("JAX device")
    assert (one.ok, one.needed, one.found) == (False, True, "Unable to initialize backend 'cuda'")
    assert one.remedy == "unset JAX_PLATFORMS, which is 'cuda'"


def test_a_full_or_closed_folder_is_minded_but_does_not_fail(monkeypatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda path: SimpleNamespace(free=1e6))
    one = finding("this folder")
    assert (one.ok, one.needed, one.found) == (False, False, "0.0 GB free")
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    assert finding("this folder").found == "cannot be written to"


def test_an_old_python_is_found(monkeypatch):
    monkeypatch.setattr(doctor, "OLDEST_PYTHON", (9, 9))
    assert finding("Python").remedy == "install Python 9.9 or newer"


def test_a_finding_reads_as_one_would_say_it():
    assert str(Finding("disk", True, "80 GB free")) == "ok       disk: 80 GB free"
    missing = Finding("onnx", False, "not installed", "pip install onnx")
    assert str(missing) == "missing  onnx: not installed\n         pip install onnx"
