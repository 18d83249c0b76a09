"""The command that finds out what a vehicle can do: its contract, from logs of its flights."""

from pathlib import Path
from typing import Any

from fledge import console
from fledge.commands.options import File, Logs, NewFile
from fledge.errors import FledgeError


def identify(flights: Logs = (), out: File = Path("contract.toml"), json: NewFile = None) -> None:
    """Find out from logged flights what the net may rely on: delay, stops, drift.

    First fly restlessly, two minutes or more in the middle of the room:

    fledge fly --pilot exciter --axes forward left up --log FLIGHT

    Then fledge fly --contract FILE flies by what was found.

    Args:
        flights: Logs of flights of one vehicle.
        out: The contract's file.
        json: Write what was found to this file, too; with -, to standard output and nothing else there.
    """
    from fledge.runs import survey

    if out.is_dir() or not out.parent.is_dir():
        raise FledgeError(f"{out} cannot be written: valid is a file in a folder that exists")
    with console.progress() as bar:
        surveyed = survey.survey(flights, lambda ticks: bar.update("flown again", ticks, ticks + 1))
    found = survey.keep(out, surveyed, out.stem, [path.name for path in flights])
    console.show(found, json, *_lines(found, surveyed.identified.terms), f"contract: {out}")


def _lines(found: dict[str, Any], terms: Any) -> list[str]:
    """For people."""
    c, s = terms.contract, terms.uav
    return [
        f"{found['stops']} stops in the plane, {found['fast_stops']} of them fast, the fastest from "
        f"{found['fastest_m_s']:.2f} m/s; {found['climbs']} in height",
        f"delay {1e3 * found['delay_s']:.0f} ms, poses {1e3 * found['pose_age_s']:.0f} ms old; "
        f"ramp {found['ramp_s']:.2f} s, tracking error {found['tracking_error_m_s']:.2f} m/s",
        f"a stop takes {s.speed:.2f} s of its speed, and misses by up to {s.error:.3f} m; in height "
        f"{s.speed_up:.2f} s, {s.error_up:.3f} m",
        f"drift {found['drift_m_s']:.2f} m/s, at most {found['most_drift_m_s']:.2f} m/s; "
        f"velocities are wrong by up to {c.velocity_error:.2f} m/s, rates by {c.rate_error:.2f} rad/s",
        "UGVs brake at "
        + ", ".join(
            f"{ugv.acceleration:.2f} m/s^2{'' if n else ' (not ours: as simulated)'}"
            for ugv, n in zip(terms.ugvs, found["ugv_stops"], strict=True)
        ),
    ]
