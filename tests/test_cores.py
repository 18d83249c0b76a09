"""The machine's cores, for compiled programs."""

import os
import threading
import time

import pytest

from fledge.cores import cores


def test_there_is_a_thread_for_each_and_all_is_done():
    together = threading.Barrier(os.cpu_count() or 1)
    with cores() as pool:
        done = list(pool.map(lambda i: together.wait(10.0) * 0 + i, range(together.parties)))
    assert done == list(range(together.parties))


def test_an_interrupt_waits_for_nobody_and_begins_nothing_more():
    held, begun = threading.Event(), []

    def work(i: int) -> None:
        begun.append(i)
        held.wait(30.0)

    at = time.monotonic()
    with pytest.raises(KeyboardInterrupt), cores() as pool:
        for i in range(100):
            pool.submit(work, i)
        raise KeyboardInterrupt
    assert time.monotonic() - at < 10.0 and not held.is_set()
    held.set()
    assert len(begun) <= 2 * (os.cpu_count() or 1)
