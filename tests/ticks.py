"""What a controller of the lab says, made by hand: one UAV over three UGVs on a triangle."""

from math import cos, pi, sin

from fledge.camera import Lens
from fledge.geometry import Quat, Vec3
from fledge.lab.control.phases import Phase
from fledge.lab.control.tick import Said
from fledge.lab.wire.datagrams import AT, VICON, Datagram, Heard
from fledge.observation import IDEAL_RADIUS_PX, Action, observe
from fledge.supervision.modes import Mode
from fledge.supervision.posts import Decision
from fledge.supervision.watchdog import Alarm
from fledge.world import Commands, Reason, UavState, UgvState, VelocityCommand, Verdict, WorldState

HOVER = VelocityCommand.hover()
SPREAD = 0.75
"""[m]."""
HEIGHT = Lens().focal_px * SPREAD / IDEAL_RADIUS_PX
"""[m] at which that has its ideal radius."""


def world(t=0.0, x=0.0, y=0.0, z=HEIGHT, middle=(0.0, 0.0)):
    """The UAV at (x, y, z), the UGVs around `middle`."""
    still = Vec3(0.0, 0.0, 0.0)
    uav = UavState(Vec3(x, y, z), still, Quat(1.0, 0.0, 0.0, 0.0), still, t)
    angles = [2.0 * pi * i / 3.0 for i in range(3)]
    ugvs = tuple(
        UgvState(middle[0] + SPREAD * cos(a), middle[1] + SPREAD * sin(a), a, 0.0, 0.0, t) for a in angles
    )
    return WorldState(t, uav, ugvs)


def decision(mode=Mode.AUTO, reason=Reason.NONE, command=HOVER, intervened=None, clearance=1.0):
    held = float(reason != Reason.NONE) if intervened is None else intervened
    return Decision(float(mode), Verdict(command, held, float(reason), clearance), Alarm(0.0, 0.0))


WAITING = decision(Mode.READY, Reason.NOT_READY)


def said(t=0.0, uav=None, phase=Phase.FLY, action=None, datagrams=(), seen=None):
    """A tick in which the UGVs are not ours to command."""
    seen = seen or world(t)
    proposed = Commands(HOVER, (HOVER,) * 3)
    decisions = (uav or decision(), *(WAITING,) * 3)
    action = action or Action(0.0, 0.0, 0.0, 0.0)
    return Said(tuple(datagrams), phase, seen, observe(seen, Lens()), action, decisions, proposed=proposed)


class Echo:
    """A controller of no wits: answers with what it heard, and how often it was asked; flies from the start."""

    def init(self):
        return 0, Action(0.0, 0.0, 0.0, 0.0)

    def step(self, memory, heard):
        number, action = memory
        if number % 5 == 0:
            action = Action(0.001 * (number % 100), 0.0, 0.0, 0.0)
        heads = b"".join(datagram.data[:8] for datagram in heard.datagrams)
        answer = Datagram(AT, b"%d " % number + heads)
        return (number + 1, action), said(heard.t, action=action, datagrams=[answer], seen=world(heard.t))


def heard(number, data=b"frame"):
    """What comes in a tick: a frame, and every third time something from the drone."""
    others = (Datagram("navdata", b"state"),) if number % 3 == 0 else ()
    return Heard(0.01 * number, (Datagram(VICON, data + b" %d" % number), *others))
