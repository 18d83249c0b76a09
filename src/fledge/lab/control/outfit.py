"""What a controller is made of: plain values that a log can keep, and the controller that they make.

Who flies and what stands between it and the vehicle are named here and handed in, since only the command line knows how
to find them by their names.
"""

from dataclasses import dataclass
from math import inf

import numpy as np

from fledge.camera import Lens
from fledge.formation import FormationControl
from fledge.lab import opening
from fledge.lab.control.ardrone_ros import ArDroneRos, Meaning
from fledge.lab.control.ardrone_udp import ArDroneUdp, entries
from fledge.lab.control.checks import Checks
from fledge.lab.control.eyes import TopicEyes, ViconEyes
from fledge.lab.control.guidance import Guidance
from fledge.lab.control.phases import Phases
from fledge.lab.control.team import Team
from fledge.lab.control.tick import Controller
from fledge.lab.control.tilt import Tilt
from fledge.observation import IDEAL_RADIUS_PX, ROW_RATE, Axes, StickScale
from fledge.pilots import AbstractPilot
from fledge.safety import AbstractNet
from fledge.supervision.supervisor import Supervisor
from fledge.world import Arena

SUBJECTS = ("ardrone", "p3at", "p3dx1", "p3dx2")
"""What motion capture calls the vehicles, the UAV first, the UGVs in the order of `dynamics.UGV_FLEET`."""
AXES = (0, 1)
"""Of the pilot's actions those that are in use: the paper's physical experiment flew forward and left alone."""
LONGEST = 900.0
"""[s] of the way of UGVs that are ours to drive; chosen: an AR.Drone's battery lasts twelve minutes."""


@dataclass(frozen=True, slots=True)
class Outfit:
    """One flight's settings."""

    arena: Arena
    pilot: str
    """Its name; "policy" for a file."""
    net: str
    """Its name."""
    topics: bool = False
    """Whether poses come over ROS; else they are Vicon's datagrams."""
    ros: bool = False
    """Whether the vehicles are told over ROS, all of them; else the AR.Drone alone, by its own protocol."""
    meaning: str = Meaning.SHARES.value
    """Over ROS: what the numbers of `/cmd_vel` are, "shares" or "m/s"."""
    subjects: tuple[str, ...] = SUBJECTS
    axes: tuple[int, ...] = AXES
    lens: Lens = Lens()
    sticks: StickScale = StickScale()
    ideal_radius: float = IDEAL_RADIUS_PX
    duration: float = inf
    """[s] for which the pilot flies."""
    seed: int = 0
    """Of the UGVs' way, where they are ours to drive."""
    unattended: bool = False
    """Whether the controller arms by itself, and nobody is asked."""

    def controller(self, pilot: AbstractPilot, net: AbstractNet) -> Controller:
        """The controller of a flight by this pilot behind this net.

        Raises:
            FledgeError: the arena has no room for the formation, where it is ours to drive.
        """
        ugvs = self.subjects[1:]
        tilt = Tilt()
        udp = ArDroneUdp(entries(tilt, self.arena.ceiling))
        return Controller(
            eyes=(TopicEyes if self.topics else ViconEyes)(self.subjects),
            vehicle=ArDroneRos(ugvs, Meaning(self.meaning)) if self.ros else udp,
            guidance=Guidance(
                pilot.for_axes(self.axes), Axes.of(self.axes), self.lens, self.sticks, self.ideal_radius
            ),
            checks=Checks(self.arena, self.subjects, self.unattended),
            supervisor=Supervisor(net),
            tilt=tilt,
            phases=Phases(duration=self.duration),
            team=self._team(pilot.restless) if self.ros else None,
        )

    def _team(self, restless: bool) -> Team:
        rows, formation = round(LONGEST * ROW_RATE), FormationControl()
        rng = np.random.default_rng([self.seed, 0])
        return Team(opening.draw(rng, self.arena, rows, formation), formation, restless)
