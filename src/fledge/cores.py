"""The cores of this machine, for compiled programs: they leave Python's lock alone, so threads are enough."""

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager


@contextmanager
def cores(count: int | None = None) -> Iterator[ThreadPoolExecutor]:
    """A thread for each, or so many; an error, Ctrl-C too, does not wait for what they are at."""
    pool = ThreadPoolExecutor(count or os.cpu_count())
    try:
        yield pool
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
