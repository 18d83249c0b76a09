"""Loopback addresses for tests with real sockets: each test has its own, so any two may run at the same time.

All of 127.0.0.0/8 is this machine, and a port belongs to an address: on one of one's own, the protocols' own ports are
free.
"""

import os
from itertools import count

_NUMBERS = count()


def own_host() -> str:
    """An address that no other test, in this process or in another, is using."""
    pid, number = os.getpid(), next(_NUMBERS)
    return f"127.{1 + pid // 250 % 250}.{1 + pid % 250}.{1 + number % 250}"
