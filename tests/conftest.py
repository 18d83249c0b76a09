"""What every test needs: JAX on the processor, the same examples on every machine, and real time to itself."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

os.environ.setdefault("JAX_PLATFORMS", "cpu")

settings.register_profile("ci", deadline=None, derandomize=True, database=None)
settings.load_profile("ci")

HERE = Path(__file__).parent
REAL_TIME = (
    *("browser", "cockpit/test_server.py", "cockpit/test_deck.py", "commands/test_cockpit.py"),
    *("commands/test_fly.py", "lab/shell", "lab/test_", "runs/test_hangar.py"),
)
"""Tests that fly against the clock, by the beginnings of their paths. Two at once would disturb each other."""


@pytest.hookimpl(tryfirst=True)  # before xdist reads the groups
def pytest_collection_modifyitems(items):
    """Where several processes share the tests, each file has one to itself, and those in real time share one."""
    for item in items:
        file = item.path.relative_to(HERE).as_posix()
        item.add_marker(pytest.mark.xdist_group("real time" if file.startswith(REAL_TIME) else file))
