"""The commands of a lab flight: to fly it, and to fly it once more from its log; a function each, as in `study`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from fledge import console, lookup
from fledge.commands.options import (
    Axes,
    Axis,
    Drone,
    Flag,
    Hall,
    Hands,
    Maybe,
    Name,
    NewFile,
    PolicyFile,
    Poses,
    Seconds,
    Seed,
)
from fledge.errors import BadFile
from fledge.lab.wire import ardrone, vicon

if TYPE_CHECKING:
    from fledge.episode import Flight

LOOPBACK = "127.0.0.1"


def fly(
    policy: PolicyFile = None,
    pilot: Maybe = None,
    arena: Hall = None,
    mocap: Poses = (LOOPBACK, vicon.PORT),
    vehicle: Drone = (LOOPBACK, ardrone.PORT),
    velocity: Flag = False,
    net: Name = "stop-tube",
    contract: Name = lookup.LAB_CONTRACT,
    axes: Axes = ("forward", "left"),
    operator: Hands = ("keyboard", None),
    no_operator: Flag = False,
    duration: Seconds = None,
    dry_run: Flag = False,
    seed: Seed = 0,
    log: NewFile = None,
    json: NewFile = None,
) -> None:
    """Let a policy fly an AR.Drone, real or the twin's, over three UGVs.

    Up from the pad and over the UGVs; then the policy flies, behind the net.

    Ctrl-C lands; a second one leaves the drone to its own watchdog.

    Without options it flies the twin that `fledge twin` is on this machine.

    Args:
        policy: The policy's file. Or, in its place, --pilot.
        pilot: Who flies in place of a policy: servo, human-model, or package.module:Name.
        arena: The room: a TOML file, lab or square. Needed but for a twin on this machine.
        mocap: Where poses come from: the host that sends Vicon's frames to our port, or ros.
        vehicle: The AR.Drone's host, and its port for commands; or ros, which moves the UGVs, too.
        velocity: Over ROS, the numbers of /cmd_vel are m/s, as for tum_simulator; by default shares of a tilt.
        net: Behind which safety net: stop-tube, paper, ..., or package.module:Name.
        contract: What the net relies on: ar-drone-2, as the twin is, or the file that identify made of your vehicle.
        axes: Which of the pilot's actions are in use: forward and left by default. Along the others it holds.
        operator: Who may take over: keyboard (of this terminal), joy (over ROS), udp, or ws (a cockpit that attaches).
        no_operator: Fly with nobody to take over.
        duration: Seconds for which the policy flies; until told to land by default.
        dry_run: Take off not at all: say whether all is ready; with --duration, watch for so long.
        seed: Over ROS: another seed, another way of the UGVs.
        log: Where everything heard and said goes; flight-DATE-TIME.mcap by default.
        json: Write what came of it to this file, too; with -, to standard output and nothing else there.
    """
    from fledge.runs import hangar

    hands, sticks = operator
    order = hangar.Order(
        policy, pilot, arena, mocap, vehicle, velocity, net, contract,
        tuple(get_args(Axis).index(axis) for axis in axes), hands, None if no_operator else sticks,
        no_operator, duration, dry_run, seed, log,
    )  # fmt: skip
    found = hangar.fly(order)
    console.show(found, json, *_landing(found))
    if found["log_problem"]:
        raise BadFile(
            found["log"], f"{found['ticks_not_logged']:,} ticks are not in it: {found['log_problem']}"
        )


def rerun(log: Path) -> tuple["Flight | None", dict[str, Any]]:
    """Fly a log once more and say whether it was the same: (the flight, if there was one; that in plain JSON values).

    Raises:
        FledgeError: it is no log, is damaged, or is not the same.
    """
    from fledge.lab.shell.rerun import length
    from fledge.runs import hangar

    ticks = length(log)
    with console.progress() as bar:
        flight, found = hangar.rerun(log, lambda done: bar.update("flown again", done, max(ticks, done)))
    if found.difference:
        raise BadFile(log, f"not the same when it was flown once more: {found.difference}")
    more = f"; {found.missing}" if found.missing else ""
    console.note(f"flown once more: {found.ticks:,} ticks, all of them the same, byte for byte{more}")
    return flight, {"ticks": found.ticks, "identical": True, "missing": found.missing}


def _landing(found: dict[str, Any]) -> list[str]:
    """What came of a flight, in lines."""
    took = found["tick_us"]
    view = "" if found["in_view"] is None else f", all in view {100.0 * found['in_view']:.2f} %"
    held = ", ".join(f"{layer} {sum(times.values())}" for layer, times in found["interventions"].items())
    return [
        f"{found['phase']}: the pilot flew for {found['flown_s']:.1f} s{view}; contacts: {found['contacts']}",
        f"interventions: {held}; take-overs: {found['takeovers']}",
        f"{found['ticks']:,} ticks, {found['deadline_misses']} deadlines missed; a tick took "
        f"{took['p50'] / 1e3:.2f} ms, 99.9 % at most {took['p999'] / 1e3:.2f} ms",
        f"log: {found['log'] or 'none'}",
    ]
