"""What a controller is made of: settings that a file can hold, and that it really is made of them."""

import json
from math import inf

import pytest

from fledge.camera import REAL_BOTTOM_CAMERA
from fledge.errors import FledgeError
from fledge.geometry import Box
from fledge.lab import opening
from fledge.lab.control.ardrone_ros import ArDroneRos, Meaning
from fledge.lab.control.ardrone_udp import ArDroneUdp
from fledge.lab.control.eyes import TopicEyes, ViconEyes
from fledge.lab.control.outfit import SUBJECTS, Outfit
from fledge.observation import Axes, StickScale
from fledge.pilots import HumanModel, Servo
from fledge.safety import PaperNet, StopTube
from fledge.storage.records import from_json, to_json
from fledge.world import Arena, Obstacle

HALL = Arena(Box(-4.0, 4.0, -3.0, 3.0), 3.5, (Obstacle(Box(2.0, 2.5, 2.0, 2.5), 0.5),))
ODD = Outfit(
    HALL, "servo", "paper", True, True, "m/s", ("a", "b", "c", "d"), (0,), REAL_BOTTOM_CAMERA, StickScale(0.5),
    90.0, 60.0, 7, True,
)  # fmt: skip


@pytest.mark.parametrize("outfit", [Outfit(Arena.lab(), "policy", "stop-tube"), ODD])
def test_it_comes_back_from_json(outfit):
    assert from_json(Outfit, json.loads(json.dumps(to_json(outfit), allow_nan=False))) == outfit


def test_the_usual_lab():
    made = Outfit(Arena.lab(), "servo", "stop-tube").controller(Servo(), StopTube())
    assert isinstance(made.eyes, ViconEyes) and isinstance(made.vehicle, ArDroneUdp) and made.team is None
    assert made.guidance.axes == Axes(up=0.0) and made.guidance.pilot == Servo()
    assert made.checks.subjects == made.eyes.subjects == SUBJECTS and not made.checks.unattended
    assert made.phases.duration == inf
    altitude = next(one.value for one in made.vehicle.configuration if one.key == "control:altitude_max")
    assert float(altitude) == 1e3 * Arena.lab().ceiling


def test_every_setting_gets_where_it_belongs():
    made = ODD.controller(HumanModel(), PaperNet())
    assert isinstance(made.eyes, TopicEyes) and made.eyes.subjects == ("a", "b", "c", "d")
    assert made.vehicle == ArDroneRos(("b", "c", "d"), Meaning.VELOCITY)
    assert made.guidance.pilot == HumanModel().for_axes((0,)) and made.guidance.axes == Axes.of((0,))
    assert (made.guidance.lens, made.guidance.sticks) == (REAL_BOTTOM_CAMERA, StickScale(0.5))
    assert (made.guidance.ideal_radius, made.phases.duration) == (90.0, 60.0)
    assert made.supervisor.net == PaperNet() and made.checks.arena == HALL and made.checks.unattended
    assert made.team is not None and made.team.plan.arena == HALL


def test_the_ugvs_way_is_drawn_from_the_seed():
    plans = [
        Outfit(Arena.lab(), "", "", ros=True, seed=seed).controller(Servo(), StopTube()) for seed in (1, 1, 2)
    ]
    tracks = [made.team.plan.track.x for made in plans if made.team]
    assert tracks[0] == tracks[1] != tracks[2]


def test_a_room_that_is_too_small_for_the_formation_is_refused(monkeypatch):
    monkeypatch.setattr(opening, "TRIES", 5)
    closet = Arena(Box(-1.0, 1.0, -1.0, 1.0), 3.0)
    with pytest.raises(FledgeError, match="found no place to begin"):
        Outfit(closet, "", "", ros=True).controller(Servo(), StopTube())
