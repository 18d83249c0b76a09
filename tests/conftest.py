"""What every test needs: JAX on the processor, the same examples on every machine, and real time to itself."""

import os

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


class ByFile(LoadScopeScheduling):
    """Where several processes share the tests, each file has one to itself, and those in real time share one.

    As groups of `--dist loadgroup` would; but these xdist 3.8 marks in a place where pytest 9.2 no longer looks.
    """

    def _split_scope(self, nodeid):
        file = nodeid.partition("::")[0].removeprefix("tests/")
        return "real time" if file.startswith(REAL_TIME) else file


def pytest_xdist_make_scheduler(config, log):
    """Who shares the tests out."""
    return ByFile(config, log)
