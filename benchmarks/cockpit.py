"""The cockpit in real time, for long: how fast sticks are answered, how many pictures come, how much memory it takes.

A visitor flies by hand, sixty sticks a second, one flight of a minute after another, in the simulator: taken over, so
that every stick is a command 10 ms later at most. Memory is the server's, read every ten seconds.

    python benchmarks/cockpit.py [--minutes N] [--json FILE]
"""

import argparse
import json
import math
import time
from pathlib import Path
from tempfile import TemporaryDirectory

from visitor import Server, visiting

from fledge.cockpit.asks import Fly

SETTLED = 300.0
"""[s] after which memory should not grow any more."""
FLIGHT = 60.0
"""[s]."""


def main() -> None:
    """Fly for so long; print what was found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    memory: list[tuple[float, float]] = []
    with TemporaryDirectory() as folder:
        server = Server(Path(folder))
        began = time.monotonic()
        with visiting(server) as visitor:
            end, frames, flown = began + 60.0 * asked.minutes, 0, 0.0
            while time.monotonic() < end:
                visitor.begin(Fly("combined", "servo", "stop-tube"))
                first, start, due = visitor.frames, time.monotonic(), time.monotonic()
                while time.monotonic() < min(start + FLIGHT, end):
                    t = time.monotonic() - start
                    visitor.sticks((0.2 * math.sin(t), 0.2 * math.cos(t), 0.0, 0.0), arm=True, switch=True)
                    if not memory or time.monotonic() - began - memory[-1][0] > 10.0:
                        memory.append((time.monotonic() - began, server.memory))
                    due += 1.0 / 60.0
                    time.sleep(max(due - time.monotonic(), 0.0))
                frames, flown = frames + visitor.frames - first, flown + time.monotonic() - start
        found = server.stop()
    settled = [megabytes for t, megabytes in memory if t >= SETTLED] or [memory[-1][1]]
    found |= {
        "minutes": asked.minutes,
        "pictures_per_s": round(frames / flown, 1),
        "memory_mb": {
            "settled": settled[0],
            "end": settled[-1],
            "growth": round(max(settled) - settled[0], 1),
        },
    }
    print(json.dumps(found, indent=1))
    if asked.json:
        asked.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
