"""The clauses that `make mutations` deletes are there to be deleted; of one it is seen here that a test misses it."""

import pytest
from mutate import CLAUSES, ROOT, survives


@pytest.mark.parametrize("module", CLAUSES)
def test_every_clause_stands_in_its_module_once_and_changes(module):
    source = (ROOT / "src" / "fledge" / "safety" / f"{module}.py").read_text()
    for old, new in CLAUSES[module]:
        assert source.count(old) == 1, old
        assert new != old


@pytest.mark.slow
def test_without_a_clause_a_test_fails():
    assert not survives("stop_tube", *CLAUSES["stop_tube"][0])
