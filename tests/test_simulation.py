"""The simulator: what a flight is a function of, what its rows say, and what nets and axes make of it."""

from dataclasses import astuple, fields, replace

import jax
import numpy as np
import pytest

from fledge.camera import Lens
from fledge.conditions import SIGHT_ROWS, Conditions
from fledge.engines import fly, fly_plain, take
from fledge.geometry import Vec3
from fledge.manoeuvres import Climb, Combined, FixedAltitude
from fledge.observation import OBSERVATION_NAMES, ROW_RATE, Action, Axes, observe
from fledge.pilots import HumanModel, Servo
from fledge.pilots.base import AbstractPilot
from fledge.safety import AbstractNet
from fledge.scalars import where
from fledge.simulation import STEP, STEPS_PER_TICK, TICK, TICKS_PER_ROW, Case, Crew, Rig, flight_key, start
from fledge.world import VelocityCommand, Verdict

pytestmark = pytest.mark.slow

ROWS = 60
CALM = Conditions()
CREW = Crew(Servo())
# One shape for all compiled flights of this file: four of them, some among boxes and some without any.
CASES = [Case.draw(m, (1, i), ROWS) for i, m in enumerate((Combined(), FixedAltitude(), Climb(), Combined()))]
KEYS = [(2, i) for i in range(4)]


def leaves(episode):
    return [
        (jax.tree_util.keystr(path), leaf) for path, leaf in jax.tree_util.tree_flatten_with_path(episode)[0]
    ]


def assert_same(a, b, rtol=0.0, atol=0.0):
    for (name, x), (other, y) in zip(leaves(a), leaves(b), strict=True):
        assert name == other
        np.testing.assert_allclose(x, y, rtol=rtol, atol=atol, err_msg=name)


def calm(case: Case, **changes) -> Case:
    return replace(case, conditions=replace(CALM, **changes))


class HandsOff(AbstractPilot):
    """A stranger's pilot: no dataclass, no fledge.scalars."""

    name = "hands-off"

    def act(self, memory, observation, noise):
        return memory, Action(0.0, 0.0, 0.0, 0.0)


class Blink(AbstractNet):
    """Stops the UAV on the second and fourth tick of every row, for a new reason each time."""

    def init(self, arena, world):
        return 0.0 * world.t

    def filter(self, memory, world, commands):
        memory = memory + 1.0
        stops = (memory % TICKS_PER_ROW == 2.0) | (memory % TICKS_PER_ROW == 4.0)
        sent = where(stops, VelocityCommand.hover(), commands.uav)
        verdict = Verdict(sent, where(stops, 1.0, 0.0), where(stops, memory, 0.0), -memory)
        return memory, (verdict, *(Verdict(told, 0.0, 0.0, memory) for told in commands.ugvs))


class Guard(AbstractNet):
    """Stops the UAV, lets the UGVs go, counts how often it is asked."""

    def init(self, arena, world):
        return 0.0

    def filter(self, memory, world, commands):
        memory = memory + 1.0
        stop = Verdict(VelocityCommand.hover(), 1.0, 7.0, memory)
        return memory, (stop, *(Verdict(told, 0.0, 0.0, memory) for told in commands.ugvs))


# --- cases and keys ---------------------------------------------------------------------------------------------


def test_the_rates_are_20_100_and_500_hertz():
    assert (ROW_RATE, 1.0 / TICK, 1.0 / STEP) == pytest.approx((20.0, 100.0, 500.0))
    assert TICKS_PER_ROW * STEPS_PER_TICK * STEP == pytest.approx(1.0 / ROW_RATE)


def test_a_case_is_a_pure_function_of_manoeuvre_key_and_rows():
    once, again, other = (Case.draw(Combined(), key, 50) for key in ((3, 1), (3, 1), (3, 2)))
    assert once.conditions == again.conditions != other.conditions
    assert once.plan.arena == again.plan.arena
    np.testing.assert_array_equal(once.plan.track.x, again.plan.track.x)
    assert not np.array_equal(once.plan.track.x, other.plan.track.x)


def test_flights_for_different_purposes_never_share_a_key():
    keys = {
        flight_key(seed, purpose, manoeuvre, number)
        for seed in (0, 1)
        for purpose in ("demonstration", "test")
        for manoeuvre in ("climb", "descend")
        for number in (0, 1)
    }
    assert len(keys) == 16
    assert flight_key(0, "test", "climb", 1) == flight_key(0, "test", "climb", 1)


def test_a_flight_starts_above_its_formation_at_the_altitude_that_makes_it_look_right():
    case, rig = calm(CASES[0]), Rig()
    state = start(case, CREW, rig)
    seen = observe(state.world, rig.lens)
    assert (seen.ugv_u, seen.ugv_v) == pytest.approx(rig.lens.centre)
    assert seen.radius == pytest.approx(rig.ideal_radius)
    assert len(state.views) == SIGHT_ROWS and set(state.views) == {seen}
    first = astuple(state.world.uav.velocity) + astuple(state.world.uav.rates)
    assert set(first) == {0.0} and {ugv.speed for ugv in state.world.ugvs} == {0.0}
    moved = start(calm(CASES[0], offset=Vec3(0.1, -0.2, 0.3)), CREW, rig).world.uav.position
    was = state.world.uav.position
    assert (moved.x - was.x, moved.y - was.y, moved.z - was.z) == pytest.approx((0.1, -0.2, 0.3))


# --- one flight, in plain Python --------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def perfect():
    return fly_plain(calm(CASES[0]), CREW, KEYS[0])


def test_there_is_a_row_for_every_twentieth_of_a_second(perfect):
    assert {np.shape(leaf) for _, leaf in leaves(perfect)} == {(ROWS,)}
    np.testing.assert_allclose(perfect.world.t, np.arange(ROWS) / ROW_RATE, atol=1e-12)
    for vehicle in (perfect.world.uav, *perfect.world.ugvs):
        np.testing.assert_array_equal(vehicle.stamp, perfect.world.t)


def test_on_a_perfect_day_the_pilot_sees_the_world_of_its_row(perfect):
    exact = observe(perfect.world, Lens())
    for name in OBSERVATION_NAMES:
        np.testing.assert_allclose(
            getattr(perfect.observation, name), getattr(exact, name), atol=1e-9, err_msg=name
        )


def test_with_delay_it_sees_the_world_of_some_rows_ago():
    late = fly_plain(calm(CASES[0], delay=3.0 / ROW_RATE), CREW, KEYS[0])
    exact = observe(late.world, Lens())
    for name in ("ugv_u", "ugv_v", "radius", "altitude", "forward", "left", "up", "turn"):
        seen, was = getattr(late.observation, name), getattr(exact, name)
        np.testing.assert_allclose(seen[3:], was[:-3], atol=1e-9, err_msg=name)
        np.testing.assert_allclose(seen[:3], was[0], atol=1e-9, err_msg=name)


def test_what_is_proposed_is_what_the_action_means(perfect):
    for i in (0, 20, ROWS - 1):
        action = Action(*(getattr(perfect.action, f.name)[i] for f in fields(Action)))
        wanted = Rig().sticks.command(action)
        got = VelocityCommand(*(getattr(perfect.proposed.uav, f.name)[i] for f in fields(VelocityCommand)))
        assert astuple(got) == pytest.approx(astuple(wanted))
    np.testing.assert_array_equal(perfect.ideal_spread, CASES[0].plan.track.spread)


def test_without_a_net_everything_proposed_is_sent(perfect):
    assert len(perfect.verdicts) == 1 + len(perfect.world.ugvs)
    for verdict, told in zip(perfect.verdicts, (perfect.proposed.uav, *perfect.proposed.ugvs), strict=True):
        assert_same(verdict.command, told)
        assert not verdict.intervened.any() and not verdict.reason.any()


def test_a_flight_is_a_pure_function_of_case_and_key():
    case = CASES[0].lasting(15)
    once = fly_plain(case, CREW, (5,))
    assert_same(fly_plain(case, CREW, (5,)), once)
    other = fly_plain(case, CREW, (6,))
    assert not np.allclose(other.observation.ugv_u[1:], once.observation.ugv_u[1:])
    # The chance of the first row's sight and the weather differ; the start does not.
    assert other.world.uav.position.x[0] == once.world.uav.position.x[0]


@pytest.mark.parametrize("pilot", (Servo(), HumanModel()), ids=lambda pilot: pilot.name)
def test_a_longer_flight_begins_like_a_shorter_one(pilot):
    short = fly_plain(CASES[3].lasting(12), Crew(pilot), (7,))
    long = fly_plain(CASES[3].lasting(25), Crew(pilot), (7,))
    assert_same(jax.tree.map(lambda leaf: leaf[:12], long), short)


def test_lasting_cuts_a_case_or_repeats_its_last_row():
    track = CASES[0].plan.track
    cut, stretched = CASES[0].lasting(10).plan.track, CASES[0].lasting(ROWS + 5).plan.track
    for field in fields(track):
        values = getattr(track, field.name)
        np.testing.assert_array_equal(getattr(cut, field.name), values[:10])
        np.testing.assert_array_equal(getattr(stretched, field.name)[:ROWS], values)
        np.testing.assert_array_equal(getattr(stretched, field.name)[ROWS:], values[-1])


def test_with_nobody_at_the_sticks_on_a_perfect_day_it_hovers_where_it_is():
    episode = fly_plain(calm(CASES[1]), Crew(HandsOff()), KEYS[1])
    for axis in ("x", "y", "z"):
        place = getattr(episode.world.uav.position, axis)
        np.testing.assert_allclose(place, place[0], atol=1e-9)


def test_wind_carries_it_along_and_noise_on_commands_shakes_it():
    still, windy, shaky = (
        fly_plain(calm(CASES[1], **weather), Crew(HandsOff()), KEYS[1]).world.uav.position
        for weather in ({}, {"wind": Vec3(1.0, 0.0, 0.0)}, {"command_noise": 0.05})
    )
    assert windy.x[-1] - still.x[-1] > 0.005
    assert abs(windy.y[-1] - still.y[-1]) < 1e-6
    assert np.hypot(shaky.x - still.x, shaky.y - still.y)[-1] > 1e-3


def test_a_nets_verdicts_are_columns_and_are_obeyed():
    episode = fly_plain(calm(CASES[1]), Crew(Servo(), net=Guard()), KEYS[1])
    uav, *ugvs = episode.verdicts
    assert (uav.intervened == 1.0).all() and (uav.reason == 7.0).all()
    for verdict, told in zip(ugvs, episode.proposed.ugvs, strict=True):
        assert not verdict.intervened.any()
        assert_same(verdict.command, told)
    # The pilot asked for more and more, the net said no, and the UAV stood still.
    assert np.abs(episode.proposed.uav.forward).max() + np.abs(episode.proposed.uav.left).max() > 0.05
    assert np.ptp(episode.world.uav.position.x) < 1e-9
    # It is asked a hundred times a second; the row keeps the smallest of its five clearances.
    np.testing.assert_array_equal(uav.clearance, 1 + TICKS_PER_ROW * np.arange(ROWS))


@pytest.mark.parametrize(
    "engine", (fly_plain, lambda case, *rest: take(fly([case], rest[0], [rest[1]]), 0, 5))
)
def test_no_intervention_is_lost_between_two_rows(engine):
    episode = engine(CASES[1].lasting(5), Crew(Servo(), net=Blink()), KEYS[1])
    uav, *ugvs = episode.verdicts
    assert uav.intervened.all() and not any(ugv.intervened.any() for ugv in ugvs)
    np.testing.assert_array_equal(uav.reason, [2, 7, 12, 17, 22])
    np.testing.assert_array_equal(uav.clearance, [-5, -10, -15, -20, -25])
    # On the fifth tick the proposed command passed, and that is the one sent last.
    assert_same(uav.command, episode.proposed.uav)


def test_axes_not_in_use_are_not_flown():
    episode = fly_plain(CASES[0].lasting(15), Crew(Servo(), Axes.of((2,))), KEYS[0])
    for name in ("forward", "left", "turn"):
        assert not getattr(episode.action, name).any()
    assert episode.action.up.any()
