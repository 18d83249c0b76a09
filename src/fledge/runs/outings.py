"""Many flights of the physical experiment at once, in processes of their own.

A flight in lock-step is plain Python on one core, so there are as many at a time as there are cores. The processes are
started anew and not forked, and load neither JAX nor what stands on it; each flight is a pure function of what it was
ordered, so neither their number nor their order changes anything.
"""

import os
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from multiprocessing import get_context

from threadpoolctl import threadpool_limits

from fledge.lab.outing import Found, Outing, fly

Flying = dict[Future[Found], int]
"""Flights under way, and their places in the order."""


@contextmanager
def flying(orders: Sequence[Outing], jobs: int | None = None) -> Iterator[Flying]:
    """Have them flown, while the caller does something else; those that have not begun when it leaves are not flown."""
    jobs = min(jobs or os.cpu_count() or 1, max(len(orders), 1))
    pool = ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=alone)
    try:
        yield {pool.submit(fly, order): i for i, order in enumerate(orders)}
    finally:
        pool.shutdown(cancel_futures=True)


def landed(under_way: Flying) -> Iterator[tuple[int, Found]]:
    """(place in the order, what came of it), as they come down."""
    for future in as_completed(under_way):
        yield under_way[future], future.result()


def alone() -> None:
    """Make this process one of many: Ctrl-C is its parent's business, and NumPy takes one core."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threadpool_limits(1)
