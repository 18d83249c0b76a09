"""The folder that a study leaves behind: results, policies, sample flights. The report is written from it."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fledge import console
from fledge.episode import Flight
from fledge.learning.training import member
from fledge.storage import sweep, write_flight, write_json, write_policy
from fledge.storage.results import plain
from fledge.study.experiments import Results, run
from fledge.study.proving import Bystanders
from fledge.study.setups import Study


def conduct(study: Study, flights: Sequence[Flight], bystanders: Bystanders | None = None) -> Results:
    """Run a study on demonstrations and show how far it is."""
    with console.progress() as bar:
        for event in run(study, flights, bystanders=bystanders):
            if isinstance(event, Results):
                return event
            stage = event.stage if ":" in event.stage else "study"
            bar.update(stage, event.done, event.total)
    raise AssertionError("a study ends with its results")


def store(folder: Path, results: Results, times: dict[str, float]) -> dict[str, Any]:
    """Store every set-up's sample flight, its first seed's policy, and results.json, whose content is returned.

    Raises:
        BadFile: a file cannot be written.
    """
    for part in (folder, folder / "policies", folder / "flights"):
        part.mkdir(parents=True, exist_ok=True)
        sweep(part)
    for name, result in results.setups.items():
        write_flight(folder / "flights" / f"{name}.mcap", result.sample)
        if result.policy is not None:
            write_policy(folder / "policies" / f"{name}.onnx", member(result.policy, 0))
    summary = plain(results.summary | {"times": times})
    write_json(folder / "results.json", summary)
    return summary
