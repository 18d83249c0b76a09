"""What every test needs: JAX on the processor, the same examples on every machine, and real time to itself."""

import os

import pytest
from hypothesis import settings
from xdist.scheduler import LoadScopeScheduling

os.environ.setdefault("JAX_PLATFORMS", "cpu")

settings.register_profile("ci", deadline=None, derandomize=True, database=None)
settings.load_profile("ci")

REAL_TIME = (
    *("browser", "cockpit/test_server.py", "cockpit/test_deck.py", "commands/test_cockpit.py"),
    *("commands/test_fly.py", "lab/shell", "lab/test_", "runs/test_hangar.py"),
)
"""Tests that fly against the clock, by the beginnings of their paths. Two at once would disturb each other."""

GIVES_WAY = 10
"""How nice those are who keep no clock: else they starve those who do."""


def _in_real_time(nodeid):
    return nodeid.removeprefix("tests/").startswith(REAL_TIME)


class ByFile(LoadScopeScheduling):
    """Where several processes share the tests, each file has one to itself, and those in real time share one.

    As groups of `--dist loadgroup` would; but these xdist 3.8 marks in a place where pytest 9.2 no longer looks.
    """

    def _split_scope(self, nodeid):
        return "real time" if _in_real_time(nodeid) else nodeid.partition("::")[0]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Who shares the tests out: files with most tests come first, and first of all those in real time."""
    return ByFile(config, log)


def pytest_runtest_setup(item):
    """A process that shares the tests gives way from its first test on that keeps no clock."""
    mine = os.getpriority(os.PRIO_PROCESS, 0)
    if "PYTEST_XDIST_WORKER" in os.environ and not _in_real_time(item.nodeid) and mine < GIVES_WAY:
        os.setpriority(os.PRIO_PROCESS, 0, GIVES_WAY)
