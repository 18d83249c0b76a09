"""Flights in processes of their own: in any order, by any number of them, the same."""

import subprocess
import sys

import pytest

from fledge.lab.outing import Outing, fly
from fledge.pilots import Servo
from fledge.runs.outings import flying, landed
from fledge.safety import NoNet


def test_nobody_waits_for_flights_that_were_not_ordered():
    with flying([]) as under_way:
        assert list(landed(under_way)) == []


@pytest.mark.slow
def test_the_processes_load_no_jax():
    code = "import fledge.runs.outings, sys; sys.exit('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


@pytest.mark.slow
def test_a_flight_elsewhere_is_the_same_flight():
    orders = [Outing(Servo(), NoNet(), seed, seconds=0.5) for seed in (1, 2)]
    with flying(orders, jobs=2) as under_way:
        found = dict(landed(under_way))
    assert sorted(found) == [0, 1] and [found[i].numbers["seed"] for i in (0, 1)] == [1, 2]
    assert found[0].numbers == fly(orders[0]).numbers
