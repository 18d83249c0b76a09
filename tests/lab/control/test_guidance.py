"""Where the UAV is led."""

from dataclasses import dataclass
from math import cos, pi, sin

import pytest

from fledge.camera import Lens
from fledge.geometry import Quat, Vec3
from fledge.lab.control.guidance import Guidance
from fledge.lab.control.phases import Course, Phase
from fledge.observation import Action, Axes, observe
from fledge.pilots import AbstractPilot, Servo
from fledge.world import UavState, UgvState, VelocityCommand, WorldState

SPREAD = 0.75
HEIGHT = 374.7 * SPREAD / 108.0
STILL = Vec3(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Counting(AbstractPilot):
    """Says how often it was asked."""

    name = "counting"

    def init(self):
        return 0

    def act(self, memory, observation, noise):
        assert noise == (0.0, 0.0, 0.0, 0.0)
        return memory + 1, Action(0.1 * (memory + 1), -0.2, 0.3, 0.4)


def world(x=0.0, y=0.0, z=HEIGHT, yaw=0.0, middle=(0.0, 0.0), spread=SPREAD) -> WorldState:
    uav = UavState(Vec3(x, y, z), STILL, Quat.from_yaw(yaw), STILL, 0.0)
    angles = [2.0 * pi * i / 3.0 for i in range(3)]
    ugvs = [
        UgvState(middle[0] + spread * cos(a), middle[1] + spread * sin(a), a, 0.0, 0.0, 0.0) for a in angles
    ]
    return WorldState(0.0, uav, tuple(ugvs))


def course(phase, yaw=0.0, place=STILL) -> Course:
    return Course(phase, 0.0, place, Quat.from_yaw(yaw).heading())


def led(guidance, phase, at, **how):
    """The command of a first decision there."""
    memory = guidance.decide(guidance.init(), phase, at)
    return guidance.propose(memory, course(phase, **how), at.uav, HEIGHT)


@pytest.mark.parametrize("phase", [Phase.WAIT, Phase.TAKE_OFF, Phase.LAND, Phase.OVER])
def test_where_others_lead_it_is_told_nothing(phase):
    assert led(Guidance(Counting()), phase, world(x=1.0, z=1.0, yaw=1.0)) == VelocityCommand.hover()


@pytest.mark.parametrize("yaw", [0.0, 2.0])
def test_it_climbs_over_its_place_and_turns_back_to_its_heading(yaw):
    at = world(x=0.2, y=-0.1, z=1.0, yaw=yaw)
    command = led(Guidance(Counting()), Phase.CLIMB, at, yaw=yaw - 0.1, place=Vec3(0.0, 0.0, 0.0))
    vx, vy = at.uav.attitude.heading().to_world(command.forward, command.left)
    assert (vx, vy) == pytest.approx((-0.16, 0.08))
    assert command.up == 0.3
    assert command.turn == pytest.approx(-0.1)


def test_a_heading_is_reached_the_short_way():
    command = led(Guidance(Counting()), Phase.CLIMB, world(yaw=3.1), yaw=-3.1)
    assert command.turn == pytest.approx(2.0 * pi - 6.2)


@pytest.mark.parametrize(("x", "y"), [(-1.5, 0.0), (0.3, 0.4), (0.0, 2.0)])
@pytest.mark.parametrize("yaw", [0.0, -1.0])
def test_it_is_led_over_the_formation_by_a_servo(x, y, yaw):
    at = world(x=x, y=y, yaw=yaw)
    command = led(Guidance(Counting()), Phase.JOIN, at, yaw=yaw)
    vx, vy = at.uav.attitude.heading().to_world(command.forward, command.left)
    assert vx * x + vy * y < 0.0
    assert (command.up, command.turn) == pytest.approx((0.0, 0.0))


def test_the_pilot_flies_its_axes_and_the_rest_is_held():
    guidance = Guidance(Counting())
    command = led(guidance, Phase.FLY, world(z=HEIGHT - 0.1, yaw=0.05))
    assert (command.forward, command.left) == pytest.approx((0.1, -0.2))
    assert command.up == pytest.approx(0.1)
    assert command.turn == pytest.approx(-0.05)
    everything = led(Guidance(Counting(), Axes(turn=1.0)), Phase.FLY, world(z=1.0, yaw=0.5))
    assert (everything.up, everything.turn) == pytest.approx((0.15, 0.4))


def test_a_pilot_begins_anew_whenever_it_is_its_turn():
    guidance, at = Guidance(Counting()), world()
    memory = guidance.init()
    said = []
    for phase in [Phase.FLY] * 3 + [Phase.JOIN] + [Phase.FLY] * 2 + [Phase.CLIMB] + [Phase.FLY]:
        memory = guidance.decide(memory, phase, at)
        said.append(round(memory.action.forward, 3))
    assert said == [0.1, 0.2, 0.3, said[3], 0.1, 0.2, 0.0, 0.1]


def test_what_is_seen_is_the_study_s_observation_through_the_lens_given():
    lens, at = Lens(focal_px=500.0), world(x=0.3, z=2.0)
    memory = (guidance := Guidance(Servo(), lens=lens, ideal_radius=90.0)).decide(
        guidance.init(), Phase.FLY, at
    )
    assert memory.observation == observe(at, lens, 90.0)
    assert guidance.distance(memory.observation) == pytest.approx(500.0 * 0.3 / 2.0)


@pytest.mark.parametrize("spread", [0.7, 0.8])
def test_at_its_height_the_formation_has_its_ideal_radius(spread):
    guidance = Guidance(Servo())
    at = world(x=0.4, middle=(1.0, -0.5), spread=spread)
    height = guidance.height(at)
    assert observe(world(z=height, middle=(1.0, -0.5), spread=spread), guidance.lens).radius == pytest.approx(
        108.0
    )
    assert height == pytest.approx(374.7 * spread / 108.0)
