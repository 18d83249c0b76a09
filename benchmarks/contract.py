"""The contract of the twin's vehicles, found out as one would for real ones: restless flights, then `fledge identify`.

    python benchmarks/contract.py [--seeds N ...] [--seconds N] [--out FILE.toml]

Writes what stands in src/fledge/contracts/ar-drone-2.toml, from the same seeds the same bytes.
"""

import argparse
from pathlib import Path

from fledge.lab.control.outfit import SUBJECTS, Outfit
from fledge.lab.control.tilt import Tilt
from fledge.lab.lockstep import fly_lockstep
from fledge.lab.survey.identify import identify
from fledge.lab.survey.traces import Trace, trace
from fledge.lab.twin.twin import Twin
from fledge.pilots import Exciter
from fledge.runs import survey
from fledge.safety import StopTube
from fledge.world import Arena

AXES = (0, 1, 2)
NAME = "the twin's AR.Drone 2.0 and Pioneers, over UDP"
LONGER = 20.0
"""[s] that a flight takes beside its pilot's time."""


def flight(seed: int, seconds: float) -> Trace:
    """One flight of the exciter's."""
    arena = Arena.lab()
    outfit = Outfit(arena, "exciter", "stop-tube", axes=AXES, duration=seconds, unattended=True, seed=seed)
    ticks = fly_lockstep(outfit.controller(Exciter(), StopTube()), Twin(arena, seed), seconds + LONGER)
    return trace(((tick.heard.t, tick.said) for tick in ticks), ours=False)


def main() -> None:
    """Fly, find out, write."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, nargs="+", default=[101, 102, 103])
    parser.add_argument("--seconds", type=float, default=120.0)
    parser.add_argument("--out", type=Path, default=Path("contract.toml"))
    given = parser.parse_args()

    found = identify([flight(seed, given.seconds) for seed in given.seeds], Tilt().lag)
    logs = [f"the twin, seed {seed}, {given.seconds:.0f} s of the exciter" for seed in given.seeds]
    seeds = " ".join(map(str, given.seeds))
    how = f"python benchmarks/contract.py --seeds {seeds} --seconds {given.seconds:.0f}"
    survey.keep(given.out, survey.Surveyed(found, SUBJECTS), NAME, logs, how)


if __name__ == "__main__":
    main()
