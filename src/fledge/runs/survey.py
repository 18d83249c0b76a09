"""From the logs of flights to a contract's file: what `fledge identify` does.

A log has the bytes that were heard; what the controller knew and said in every tick is had by flying it once more
(`hangar.restored`). A log that does not replay to the bytes it has is refused: then somebody else flew it.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from fledge.errors import BadFile, FledgeError
from fledge.lab.control.outfit import Outfit
from fledge.lab.control.tick import Said
from fledge.lab.shell.rerun import read_opening, read_ticks
from fledge.lab.survey.identify import Findings, Identified, identify
from fledge.lab.survey.traces import Trace, trace
from fledge.runs import hangar
from fledge.storage import write_contract

ABOUT = """What a safety net relies on, found out by `fledge identify`; docs/safety-case.md says what the numbers mean.
Bounds hold for the vehicle, the room and the weather of these flights, and for speeds flown there.
"""


class Surveyed(NamedTuple):
    """What came of it."""

    identified: Identified
    subjects: tuple[str, ...]


def survey(logs: Sequence[Path], seen: Callable[[int], None] = lambda ticks: None) -> Surveyed:
    """From these logs; `seen` is told how many ticks were read so far.

    Raises:
        FledgeError: a log is damaged or cannot be flown once more, or all of them show too little.
    """
    if not logs:
        raise FledgeError("no flight: valid are logs of lab flights, one or more; `fledge fly` writes them")
    count, traces, subjects, lags = 0, [], set(), set()
    for path in logs:
        with TemporaryDirectory() as folder:
            outfit, controller = hangar.restored(read_opening(path), Path(folder))
        subjects.add(outfit.subjects)
        lags.add(controller.tilt.lag)
        flight = _trace(path, controller, outfit, lambda ticks, before=count: seen(before + ticks))
        count += len(flight.t)
        traces.append(flight)
    if len(subjects) > 1 or len(lags) > 1:
        raise FledgeError("flights of several fleets or loops: valid are those of one")
    return Surveyed(identify(traces, *lags), *subjects)


def keep(
    path: Path, surveyed: Surveyed, name: str, logs: Sequence[str], how: str = "fledge identify"
) -> dict[str, Any]:
    """Write the contract's file; what was found beside it, in plain values.

    Raises:
        BadFile: it cannot be written.
    """
    terms, findings = surveyed.identified
    found = told(findings)
    about = "\n".join((ABOUT, f"Made by: {how}", "From:", *(f"- {log}" for log in logs)))
    write_contract(path, terms, name, found, about)
    return found


def told(findings: Findings) -> dict[str, Any]:
    """In plain values, by names with their units."""
    plain: Mapping[str, Any] = asdict(findings)
    a = findings.answer
    return {
        **{name: plain[name] for name in ("flights", "stops", "fast_stops", "climbs")},
        "seconds_s": findings.seconds,
        "fastest_m_s": findings.fastest,
        "delay_s": findings.delay,
        "pose_age_s": findings.pose_age,
        "oldest_pose_s": findings.oldest_pose,
        "ramp_s": a.lag,
        "tracking_error_m_s": a.error,
        "most_tracking_error_m_s": a.largest,
        "drift_m_s": findings.drift,
        "most_drift_m_s": findings.most_drift,
        "push_m_s2": findings.push,
        "missed_m": findings.missed,
        "most_missed_m": findings.most_missed,
        "ugv_stops": list(findings.ugv_stops),
    }


def _trace(path: Path, controller: Any, outfit: Outfit, seen: Callable[[int], None]) -> Trace:
    """One flight, flown once more."""

    def ticks() -> Iterator[tuple[float, Said]]:
        memory = controller.init()
        for number, logged in enumerate(read_ticks(path)):
            if logged.number != number:
                raise BadFile(path, f"ticks {number:,} to {logged.number - 1:,} were not logged")
            memory, said = controller.step(memory, logged.heard)
            if said.datagrams != logged.said:
                raise BadFile(path, f"tick {number:,} is not the same when it is flown once more")
            seen(number)
            yield logged.heard.t, said

    return trace(ticks(), outfit.ros, outfit.meaning != "m/s")
