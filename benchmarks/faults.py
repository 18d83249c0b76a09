"""The fault matrix: every fault in every phase of flight, by the hundred, behind the default net.

Writes the matrix into the safety case and, with every count, as JSON beside this file. Same seed, same matrix.

    python benchmarks/faults.py [--seeds 100] [--seed 0]
"""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np

from fledge.faults.catalogue import FAULTS, Fault, Promise
from fledge.faults.drills import PHASES, Drill, Report, draw_drill, judge
from fledge.faults.injection import fly_drills
from fledge.supervision.modes import Mode

HERE = Path(__file__).parent
CASE = HERE.parent / "docs" / "safety-case.md"
DATA = HERE / "faults.json"
BATCH = 600
"""Flights in one call; they all fit into a gigabyte."""
HEAD = f"""| fault | touched: {", ".join(PHASES)} | unsafe | named | median [s] | most [s] | those struck end in |
|---|---|---|---|---|---|---|"""
BEGIN, END = "<!-- fault matrix -->", "<!-- end of fault matrix -->"


class Flown(NamedTuple):
    """The drills of one fault in one phase."""

    fault: Fault
    phase: str
    drills: list[Drill]
    report: Report


def fly(seeds: int, seed: int) -> Iterator[Flown]:
    """Every fault in every phase, with as many seeds."""
    jobs = [
        (fault, phase, (seed, n, i))
        for fault in FAULTS
        for n, phase in enumerate(PHASES)
        for i in range(seeds)
    ]
    drills = [draw_drill(*job) for job in jobs]
    keys = [key for _, _, key in jobs]
    # The last batch is filled up, so that all run in one program.
    wanting = -len(jobs) % min(BATCH, len(jobs))
    drills, keys = drills + drills[:wanting], keys + keys[:wanting]
    parts = []
    for first in range(0, len(drills), BATCH):
        parts.append(fly_drills(drills[first : first + BATCH], keys[first : first + BATCH]))
        print(f"{min(first + BATCH, len(jobs))} of {len(jobs)} flights", flush=True)
    report = jax.tree.map(lambda *leaves: np.concatenate(leaves), *parts)
    for first in range(0, len(jobs), seeds):
        fault, phase, _ = jobs[first]
        some = slice(first, first + seeds)
        yield Flown(fault, phase, drills[some], jax.tree.map(lambda leaf: leaf[some], report))  # noqa: B023


def count(flown: Flown) -> dict[str, Any]:
    """What came of the drills of one fault in one phase, in numbers."""
    result = judge(flown.fault, flown.report, flown.drills)
    struck = np.array([drill.struck for drill in flown.drills]).T > 0.5
    ends = np.array(flown.report.modes)[struck]
    return {
        "fault": flown.fault.name,
        "promise": str(flown.fault.promise),
        "phase": flown.phase,
        "flights": len(flown.drills),
        "touched": int(result.touched.sum()),
        "smallest gap [m]": round(float(np.min(flown.report.gaps)), 3),
        "not safe": int((~result.safe).sum()),
        "overdue": int(result.overdue.sum()),
        "named after [s]": [round(float(s), 2) for s in result.named[np.isfinite(result.named)]],
        "ends": {mode.name: int((ends == mode).sum()) for mode in Mode if (ends == mode).any()},
    }


def row(fault: Fault, counts: list[dict[str, Any]]) -> str:
    """A fault's line of the matrix."""
    named = [s for c in counts for s in c["named after [s]"]]
    ends: dict[str, int] = {}
    for c in counts:
        for mode, n in c["ends"].items():
            ends[mode] = ends.get(mode, 0) + n
    shares = ", ".join(
        f"{mode} {100 * n / sum(ends.values()):.0f} %"
        for mode, n in sorted(ends.items(), key=lambda e: -e[1])
    )
    cells = (
        fault.name,
        " / ".join(str(c["touched"]) for c in counts),
        sum(c["not safe"] for c in counts),
        f"{len(named)} of {len(named) + sum(c['overdue'] for c in counts)}" if fault.reasons else "",
        f"{np.median(named):.2f}" if named and fault.reasons else "",
        f"{max(named):.2f}" if named and fault.reasons else "",
        shares,
    )
    return "| " + " | ".join(map(str, cells)) + " |"


def _percent(share: float) -> str:
    return "<1 %" if share < 0.005 else f"{100 * share:.0f} %"


def summary(counts: list[dict[str, Any]]) -> str:
    """What came of all faults of which something is promised, in a sentence."""
    promised = [c for c in counts if c["promise"] != Promise.NONE]
    flights, touched = (sum(c[name] for c in promised) for name in ("flights", "touched"))
    faults = len({c["fault"] for c in promised})
    most = f"with 95 % confidence fewer than {300 / flights:.2g} % do" if not touched else "a broken promise"
    return f"{flights} flights with {faults} faults of which something is promised: {touched} touched anything; {most}."


def matrix(counts: list[dict[str, Any]]) -> str:
    """All of it in Markdown, a table for each promise."""
    tables = []
    for promise in Promise:
        rows = [row(f, [c for c in counts if c["fault"] == f.name]) for f in FAULTS if f.promise == promise]
        tables.append("\n".join([f"**{str(promise).capitalize()}**", "", HEAD, *rows]))
    return "\n\n".join([summary(counts), *tables])


def main() -> None:
    """Fly, write, and say what broke its promise."""
    parser = argparse.ArgumentParser(description="Fly the fault matrix into the safety case.")
    parser.add_argument("--seeds", type=int, default=100, help="of every fault in every phase")
    parser.add_argument("--seed", type=int, default=0, help="of them all")
    asked = parser.parse_args()
    counts = [count(flown) for flown in fly(asked.seeds, asked.seed)]
    lines = ",\n".join(map(json.dumps, counts))
    DATA.write_text(f'{{"seeds": {asked.seeds}, "seed": {asked.seed}, "counts": [\n{lines}\n]}}\n')
    before, _, rest = CASE.read_text().partition(BEGIN)
    _, _, after = rest.partition(END)
    CASE.write_text(f"{before}{BEGIN}\n{matrix(counts)}\n{END}{after}")
    for c in counts:
        if c["promise"] != Promise.NONE and (c["touched"] or c["not safe"] or c["overdue"]):
            print(f"broken: {c['fault']}, {c['phase']}: {c['touched']}, {c['not safe']}, {c['overdue']}")


if __name__ == "__main__":
    main()
