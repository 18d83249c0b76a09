"""What fledge finds on a machine: what it needs, whether that works, and what to type where it does not.

Every package is imported, because one that is installed may still be broken. Nothing is mended here.
"""

import os
import platform
import re
import shutil
import sys
from dataclasses import dataclass, replace
from importlib import import_module, metadata

from fledge.errors import FledgeError
from fledge.lab.shell import ros

USES = {
    "numpy": "everything",
    "scipy": "paths, statistics",
    "jax": "the simulator, training",
    "optax": "training",
    "mcap": "flights on disk",
    "onnx": "policies on disk",
    "onnxruntime": "policies elsewhere",
    "tyro": "the command line",
    "rich": "the command line",
    "matplotlib": "figures",
    "jinja2": "the report",
    "threadpoolctl": "flights in a lab",
}
"""What each package is for."""

EXTRAS = {
    "mujoco": "the lab's twin",
    "starlette": "the cockpit",
    "uvicorn": "the cockpit",
    "websockets": "the cockpit",
    "pillow": "the cockpit's pictures",
}
"""Likewise, of those that few need."""

MODULES = {"pillow": "PIL"}
"""What is imported of a package, where that has another name."""

OLDEST_PYTHON = (3, 11)

FREE_GB = 0.5
"""A full study leaves about a tenth of this."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was looked at."""

    what: str
    ok: bool
    found: str
    remedy: str = ""
    """What to type or to do."""
    needed: bool = True
    """Whether fledge cannot work without it."""

    def __str__(self) -> str:
        word = "ok" if self.ok else "missing" if self.needed else "mind"
        return f"{word:8} {self.what}: {self.found}" + (f"\n{'':8} {self.remedy}" if self.remedy else "")


def examine() -> list[Finding]:
    """Look at Python, the packages, ROS, the accelerator and the folder one stands in."""
    packages = [_package(name) for name in USES]
    extras = [replace(_package(name), needed=False) for name in EXTRAS]
    return [_python(), *packages, *extras, _ros(), _device(), _folder()]


def _python() -> Finding:
    ok = sys.version_info >= OLDEST_PYTHON
    oldest = ".".join(map(str, OLDEST_PYTHON))
    return Finding("Python", ok, platform.python_version(), "" if ok else f"install Python {oldest} or newer")


def _package(name: str) -> Finding:
    what, bounds = f"{name} ({(USES | EXTRAS)[name]})", _bounds().get(name, "")
    remedy = f'pip install "{name}{bounds}"'
    try:
        version = metadata.version(name)
    except metadata.PackageNotFoundError:
        return Finding(what, False, "not installed", remedy)
    try:
        import_module(MODULES.get(name, name))
    except Exception as error:  # a broken package raises as it pleases
        reason = f"{type(error).__name__}: {error}".split("\n")[0]
        return Finding(what, False, f"{version}, broken ({reason})", f"{remedy} --force-reinstall")
    if not _within(version, bounds):
        return Finding(what, False, f"{version}, not tested with fledge", remedy, needed=False)
    return Finding(what, True, version)


def _bounds() -> dict[str, str]:
    """The versions that fledge was tested with, ">=2.1,<3" say, by package."""
    try:
        needs = metadata.requires("fledge") or []
    except metadata.PackageNotFoundError:
        return {}
    split = (re.match(r"([\w.-]+)\s*([^;]*)", need) for need in needs)
    return {match[1]: match[2].strip() for match in split if match}


def _within(version: str, bounds: str) -> bool:
    """Whether a version keeps lower and upper bounds."""
    mine = _numbers(version)
    for sign, bound in re.findall(r"(>=|<)([\d.]+)", bounds):
        if (mine >= _numbers(bound)) != (sign == ">="):
            return False
    return True


def _numbers(version: str) -> tuple[int, ...]:
    """Of a release, without trailing zeros: "2.10.0" is (2, 10)."""
    match = re.match(r"\d+(\.\d+)*", version)
    numbers = [int(part) for part in match[0].split(".")] if match else []
    while numbers and not numbers[-1]:
        numbers.pop()
    return tuple(numbers)


def _ros() -> Finding:
    """Not a package of Python's index, but of Debian's."""
    what = "ROS 1 (a lab that speaks ROS)"
    try:
        rospy = ros.load()
    except FledgeError as error:
        found, _, valid = str(error).partition(": ")
        return Finding(what, False, found, valid, needed=False)
    return Finding(what, True, f"rospy, in {os.path.dirname(os.path.dirname(rospy.__file__))}")


def _device() -> Finding:
    try:
        import jax

        devices = jax.devices()
    except Exception as error:  # JAX missing, or a platform that is not there
        asked = os.environ.get("JAX_PLATFORMS")
        remedy = f"unset JAX_PLATFORMS, which is {asked!r}" if asked else ""
        return Finding("JAX device", False, str(error).split("\n")[0], remedy)
    return Finding(
        "JAX device", True, f"{len(devices)} {devices[0].device_kind}; {os.cpu_count()} processor cores"
    )


def _folder() -> Finding:
    if not os.access(".", os.W_OK):
        return Finding("this folder", False, "cannot be written to", "give --out", needed=False)
    free = shutil.disk_usage(".").free / 1e9
    remedy = "" if free > FREE_GB else f"make room: {FREE_GB} GB will do"
    return Finding("this folder", not remedy, f"{free:.1f} GB free", remedy, needed=False)
