"""The evidence about a net: a campaign with a bar to watch, and what it found, as flights to replay.

Every violation that is kept stands whole in its folder as one MCAP file, named by net, family, seed and flight.
"""

import re
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from fledge import console
from fledge.falsification.campaign import Campaign, falsify, reenact
from fledge.falsification.toll import Toll, Violation
from fledge.learning.policy import Policy
from fledge.storage import sweep, write_flight
from fledge.study.experiments import Progress
from fledge.study.novices import novices


def train(seed: int) -> dict[str, Policy]:
    """Two policies, trained on the spot, with a bar."""
    with console.progress() as bar:
        for event in novices(seed):
            if not isinstance(event, Progress):
                return event
            bar.update(event.stage, event.done, event.total)
    raise AssertionError("a training ends with its policies")


def gather(campaign: Campaign) -> Toll:
    """The toll of a whole campaign, with a bar.

    Raises:
        FledgeError: the arena that was given has no room for the vehicles.
    """
    toll = Toll()
    with console.progress() as bar:
        bar.update("attacks", 0, campaign.flights)
        for toll in falsify(campaign):
            bar.update("attacks", toll.total.flights, campaign.flights)
    return toll


def store(folder: Path, campaign: Campaign, toll: Toll) -> list[dict[str, Any]]:
    """Fly every violation again and store it; what each was, with its file.

    Its file is None where a violation did not happen again: what hangs by a hair goes by how a program rounds.

    Raises:
        BadFile: a file cannot be written.
    """
    files = {}
    if toll.violations:
        folder.mkdir(parents=True, exist_ok=True)
        sweep(folder)
        for violation, flight in reenact(campaign, toll.violations):
            name = f"{campaign.name}-{violation.family}-{campaign.seed}-{violation.flight}.mcap"
            files[violation.flight] = folder / re.sub(r"[^\w.-]", "-", name)
            write_flight(files[violation.flight], flight)
    return [_shown(one, files) for one in toll.violations]


def sentences(found: Mapping[str, Any]) -> list[str]:
    """What may be said of the net, in a line, and in another where to see it."""
    files = [one["file"] for one in found["violations"] if one["file"]]
    if found["contacts"] or found["deadlocks"]:
        said = (
            f"{found['net']} is beaten: in {found['contacts']:,} of {found['flights']:,} flights something was "
            f"touched; in {found['deadlocks']:,} of {found['retreats']:,} with a way out it was not let out"
        )
        return [said, *([f"{len(files)} of them to replay: fledge replay {files[0]}"] if files else [])]
    most = 100.0 * found["upper_bound_95"]
    return [
        f"{found['net']} holds: nothing was touched, nobody locked in; the probability of a contact in such a "
        f"flight is below {most:.2g} % (95 % confidence)"
    ]


def _shown(violation: Violation, files: dict[int, Path]) -> dict[str, Any]:
    names = [field.name for field in fields(violation) if field.name != "draw"]
    file = files.get(violation.flight)
    return {name: getattr(violation, name) for name in names} | {"file": file and str(file)}
