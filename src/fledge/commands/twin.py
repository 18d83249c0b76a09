"""The command that is a lab: the twin on its wires."""

from contextlib import AbstractContextManager, nullcontext
from math import inf
from typing import TYPE_CHECKING, Literal

from fledge import console, lookup
from fledge.commands.options import Hall, Mocap, NewFile, Seconds, Seed, Speed, Vehicle, Words
from fledge.lab.wire import ardrone, vicon

if TYPE_CHECKING:
    from fledge.lab.shell.link import Link
    from fledge.lab.twin.picture import Pictures

    Wires = tuple[Link, int, AbstractContextManager[Pictures | None]]
    """(all ports, what leads from this machine's clock to that of stamps [ns], the camera while it is on)."""

LOOPBACK = "127.0.0.1"


def twin(
    arena: Hall = None,
    seed: Seed = 0,
    speed: Speed = 1.0,
    drone: Vehicle = (LOOPBACK, ardrone.PORT),
    mocap: Mocap = (LOOPBACK, vicon.PORT),
    spell: Words = (),
    ros: Literal["no", "shares", "velocity"] = "no",
    duration: Seconds = None,
    json: NewFile = None,
) -> None:
    """Be a lab: an AR.Drone, three Pioneers and motion capture, on their own wires.

    Whoever speaks the AR.Drone's protocol can fly it. Ctrl-C ends it.

    The UGVs wait until the UAV is overhead, then drive by themselves.

    A spell is when the cameras do not see as usual
    - 20:22:dropout=0.5: from 20 to 22 s, half of the frames get lost
    - 20:22:hidden=ardrone: likewise, and so on
    - 20:22:swapped=p3at,p3dx1
    - 20:22:latency=0.05, or noise=0.002, or angle_noise=0.01

    Args:
        arena: Where: lab, square, or a TOML file of your own; lab by default.
        seed: Another seed: other weather, errors of the sensors, way of the UGVs.
        speed: How fast its time passes, 0.01 to 50; 1 is real time.
        drone: Where the AR.Drone is, its port for commands; navdata are two below.
        mocap: To whom Vicon's frames go.
        spell: When the cameras see badly; see above.
        ros: Speak ROS 1 in place of UDP; /cmd_vel is then in shares, or a velocity in m/s.
        duration: Seconds of its own time after which it ends by itself.
        json: Write what came of it to this file, too; with -, to standard output and nothing else there.
    """
    from fledge.lab.shell.stage import Stage
    from fledge.lab.twin.bridge import Bridge
    from fledge.lab.twin.cameras import Cameras, Spell
    from fledge.lab.twin.picture import Pictures
    from fledge.lab.twin.twin import Options, Twin

    drivers = None if ros == "no" else Bridge(velocity=ros == "velocity")
    options = Options(cameras=Cameras(spells=tuple(Spell.read(text) for text in spell)), bridge=drivers)
    hall = lookup.arena(arena or "lab")
    made = Twin(hall, seed, options)
    camera = Pictures(hall, options.drone.loops.airframe, tell=console.note)
    link, clock, shown = _by_udp(drone, mocap) if drivers is None else _by_ros(camera)
    with link, shown as pictures:
        stage = Stage(made, link, speed, clock, pictures)
        for contact in stage.run(inf if duration is None else duration):
            touch = f"{contact.who}, {contact.what} ({contact.witness.value})"
            console.note(f"contact at {contact.t:.2f} s: {touch}")
    found = stage.summary()
    console.show(found, json, _ending(found))


def _by_udp(drone: tuple[str, int], mocap: tuple[str, int]) -> "Wires":
    """The wires of the protocols themselves, no clock, no pictures: the AR.Drone's video is not imitated."""
    from fledge.lab.shell.link import Link
    from fledge.lab.shell.udp import navdata_port, opened, twin_wires

    link = Link(opened(twin_wires(mocap, drone)))
    console.note(f"AR.Drone at {drone[0]}, ports {drone[1]} and {navdata_port(drone[1])}")
    console.note(f"Vicon's frames go to {mocap[0]}, port {mocap[1]}; Ctrl-C ends")
    return link, 0, nullcontext()


def _by_ros(camera: "Pictures") -> "Wires":
    """All topics, ROS's clock, and pictures for whoever subscribes."""
    from fledge.lab.shell.link import Link
    from fledge.lab.shell.ros import RosPort
    from fledge.lab.twin.bridge import HEARD, SAID
    from fledge.lab.twin.picture import screening
    from fledge.lab.wire.topics import PICTURES

    port = RosPort(HEARD, (*SAID, PICTURES), name="fledge_twin")
    console.note("topics: /cmd_vel, /ardrone/takeoff, land, reset, navdata, and those of subjects and UGVs")
    console.note(f"{PICTURES} is drawn as long as somebody subscribes")
    return Link((port,)), port.offset, screening(camera, port)


def _ending(found: dict) -> str:
    """What came of it, in a line."""
    late = f", {found['missed']} missed" if found["missed"] else ""
    return (
        f"{found['seconds']:.1f} s in {found['ticks']:,} ticks{late}; a tick took "
        f"{found['tick_us']['p50'] / 1e3:.2f} ms, at most {found['tick_us']['max'] / 1e3:.1f} ms; "
        f"contacts: {len(found['contacts'])}"
    )
