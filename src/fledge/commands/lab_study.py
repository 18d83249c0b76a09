"""The command of the physical experiment."""

import time
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from fledge import console, lookup
from fledge.commands.options import Contestant, Flights, Folder, Jobs, Lasting, Name, Names, NewFile, Seed
from fledge.errors import FledgeError
from fledge.report import tables

if TYPE_CHECKING:
    from fledge.runs.labwork import Harvest, Plan

NETS = ("stop-tube", "paper", "none")
"""The default, the paper's, and none."""


def lab_study(
    policy: Contestant,
    flights: Flights = 20,
    seconds: Lasting = 30.0,
    nets: Names = NETS,
    days: Literal["both", "ordinary", "reversed"] = "both",
    arena: Name = "lab",
    seed: Seed = 0,
    jobs: Jobs = None,
    out: Folder = Path("report-lab"),
    json: NewFile = None,
) -> None:
    """Fly the paper's physical experiment in the digital twin, as fast as it goes.

    A policy follows the UGVs behind every net; likewise with its sticks reversed.

    The same ways are flown in the simulator, too: what was lost on the way here?

    Leaves index.html, results.json, figures and a flight of each kind.

    Args:
        policy: An ONNX file, or the name of a pilot: servo, human-model, or package.module:Name of your own.
        flights: Behind each net, of each kind.
        seconds: For which it flies, each time.
        nets: Behind which safety nets; by default stop-tube, paper and none.
        days: Ordinary ones, those with both sticks reversed, or both.
        arena: Where: lab, square, or a TOML file of your own.
        seed: Another seed: other days, other ways.
        jobs: How many flights at a time; by default as many as there are cores.
        out: Where everything goes.
        json: Write the results to this file, too; with -, to standard output and nothing else there.
    """
    if not nets:
        raise FledgeError("no net: valid are names of nets, one or more; none is the name of flying without")
    from fledge.report import lab
    from fledge.runs import labwork

    kinds = {"both": labwork.KINDS, "ordinary": labwork.KINDS[:1], "reversed": labwork.KINDS[1:]}[days]
    behind = {name: lookup.lab_net(name) for name in dict.fromkeys(nets)}
    pilot, room = lookup.contestant(policy), lookup.arena(arena)
    plan = labwork.Plan(pilot, policy, behind, room, flights, seconds, seed, kinds)
    start = time.perf_counter()
    harvest = _flown(plan, jobs)
    times = {"flights": round(time.perf_counter() - start, 1)}
    command = f"fledge lab-study {policy} --flights {flights} --seconds {seconds:g} --nets {' '.join(behind)}"
    command += f" --days {days} --arena {arena} --seed {seed}"
    results = labwork.store(out, harvest, labwork.summarise(plan, harvest, command), times)
    page = lab.write_report(out)
    title = f"{Path(policy).stem}: {flights} flights of {seconds:g} s behind each net, in the twin"
    shown = [tables.lab(f"{title}; {kind}", one) for kind, one in results["flights"].items()]
    gap = tables.transfer(results["transfer"]) if results["transfer"] else "simulator and twin: not compared"
    console.show(results, json, *shown, gap, *results["sentences"], f"report: {page}")


def _flown(plan: "Plan", jobs: int | None) -> "Harvest":
    """All flights, with a bar."""
    from fledge.runs import labwork

    with console.progress() as bar:
        for event in labwork.conduct(plan, jobs):
            if isinstance(event, labwork.Harvest):
                return event
            bar.update("flights in the twin", *event)
    raise AssertionError("an experiment ends with what was flown")
