"""How long a net takes in the lab: plain Python, one UAV and three UGVs, ten obstacles.

Every call gets another state and other commands, drawn beforehand; garbage collection as it comes. The tick it must fit
into has 10 ms.

    python benchmarks/net.py [--calls N] [stop-tube | barrier]
"""

import argparse
import time

import numpy as np

from fledge.geometry import Box, Quat, Vec3
from fledge.safety import Barrier, StopTube
from fledge.world import Arena, Commands, Obstacle, UavState, UgvState, VelocityCommand, WorldState

STATES = 1000
NETS = {"stop-tube": StopTube(), "barrier": Barrier()}


def arena() -> Arena:
    """10 x 10 m with ten boxes."""
    boxes = (Box(x, x + 0.5, y, y + 0.5) for x in (-4.0, -2.0, 0.0, 2.0, 4.0) for y in (-4.0, 3.5))
    return Arena(Box(-5.0, 5.0, -5.0, 5.0), 6.0, tuple(Obstacle(box, 1.0) for box in boxes))


def drawn(rng: np.random.Generator) -> tuple[WorldState, Commands]:
    """Somewhere, moving, told something."""
    u = lambda low, high: float(rng.uniform(low, high))  # noqa: E731
    uav = UavState(
        Vec3(u(-4, 4), u(-3, 3), u(0.5, 5)),
        Vec3(u(-1, 1), u(-1, 1), u(-0.5, 0.5)),
        Quat.from_yaw(u(-3, 3)),
        Vec3(u(-1, 1), u(-1, 1), 0.0),
        0.0,
    )
    ugvs = tuple(UgvState(u(-4, 4), u(-3, 3), u(-3, 3), u(-0.5, 0.5), u(-1, 1), 0.0) for _ in range(3))
    told = tuple(VelocityCommand(u(-0.5, 0.5), 0.0, 0.0, u(-1, 1)) for _ in range(3))
    return WorldState(0.0, uav, ugvs), Commands(VelocityCommand(u(-1, 1), u(-1, 1), u(-0.5, 0.5), 0.0), told)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="How long a net takes in the lab.")
    parser.add_argument("--calls", type=int, default=1_000_000)
    parser.add_argument("net", nargs="?", choices=NETS, default="stop-tube")
    given = parser.parse_args()
    calls = given.calls
    rng = np.random.default_rng(0)
    inputs = [drawn(rng) for _ in range(STATES)]
    net = NETS[given.net]
    memory = net.init(arena(), inputs[0][0])
    took = np.empty(calls)
    for i in range(calls):
        world, commands = inputs[i % STATES]
        begin = time.perf_counter()
        memory, _ = net.filter(memory, world, commands)
        took[i] = time.perf_counter() - begin
    p50, p999, most = 1e3 * np.quantile(took, (0.5, 0.999, 1.0))
    print(f"{given.net}: {calls:,} calls, median {p50:.3f} ms, p99.9 {p999:.3f} ms, most {most:.2f} ms")


if __name__ == "__main__":
    main()
