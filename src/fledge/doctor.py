"""What is installed, what is missing for what, and what to type."""

import importlib.metadata
import platform
import shutil
import sys
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing looked at."""

    what: str
    ok: bool
    found: str
    remedy: str = ""
    optional: bool = False
    """Whether fledge does its main job without it."""


NEEDED = {
    "numpy": "everything",
    "scipy": "paths and statistics",
    "jax": "the simulator and training",
    "optax": "training",
    "mcap": "flights on disk",
    "onnx": "policies on disk",
    "onnxruntime": "policies elsewhere",
    "tyro": "the command line",
    "rich": "the command line",
    "matplotlib": "figures",
    "jinja2": "the report",
}


def examine() -> list[Finding]:
    """Look at Python, the packages, the accelerator and the disk."""
    return [_python(), *(_package(name, use) for name, use in NEEDED.items()), _device(), _disk()]


def _python() -> Finding:
    ok = sys.version_info >= (3, 11)
    return Finding("Python", ok, platform.python_version(), "" if ok else "install Python 3.11 or later")


def _package(name: str, use: str) -> Finding:
    try:
        return Finding(f"{name} ({use})", True, importlib.metadata.version(name))
    except importlib.metadata.PackageNotFoundError:
        return Finding(f"{name} ({use})", False, "not installed", f"pip install {name}")


def _device() -> Finding:
    try:
        import jax

        devices = ", ".join(str(device) for device in jax.devices())
    except (ImportError, RuntimeError) as error:
        return Finding("JAX device", False, str(error).splitlines()[0], "pip install jax")
    return Finding("JAX device", True, devices)


def _disk() -> Finding:
    free = shutil.disk_usage(".").free / 1e9
    ok = free > 1.0
    return Finding("free disk here", ok, f"{free:.1f} GB", "" if ok else "a full study needs about 1 GB")
