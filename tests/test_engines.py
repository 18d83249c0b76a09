"""Plain and compiled, alone and in batches, it is the same flight."""

import jax
import numpy as np
import pytest

from fledge.engines import BATCH, fly, fly_plain, take, traceable
from fledge.formation import FormationControl
from fledge.manoeuvres import Climb, Combined, FixedAltitude
from fledge.observation import OBSERVATION_NAMES, Action, Axes
from fledge.pilots import HumanModel, Servo
from fledge.pilots.base import AbstractPilot
from fledge.simulation import Case, Crew

pytestmark = pytest.mark.slow

ROWS = 60
CREW = Crew(Servo())
# Some among boxes and some without any.
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


class HandsOff(AbstractPilot):
    """A stranger's pilot: no dataclass, no fledge.scalars."""

    name = "hands-off"

    def act(self, memory, observation, noise):
        return memory, Action(0.0, 0.0, 0.0, 0.0)


class Decided(AbstractPilot):
    """Plain Python that JAX cannot trace: it branches on what it sees."""

    name = "decided"

    def act(self, memory, observation, noise):
        return memory, Action(0.0, 0.0, 0.5 if observation.radius > observation.ideal_radius else 0.0, 0.0)


class Diarist(AbstractPilot):
    """Plain Python that JAX cannot compile: its memory grows."""

    name = "diarist"

    def init(self):
        return ("take-off",)

    def act(self, memory, observation, noise):
        return (*memory, "wait"), Action(0.0, 0.0, 0.01 * len(memory), 0.0)


def test_a_pilot_that_jax_cannot_trace_flies_in_plain_python():
    episode = fly_plain(CASES[2], Crew(Decided()), KEYS[2])
    assert len(episode.world.t) == ROWS
    assert set(np.unique(episode.action.up)) <= {0.0, 0.5}
    climbing = episode.observation.radius > episode.observation.ideal_radius
    np.testing.assert_array_equal(episode.action.up == 0.5, climbing)


def test_a_pilot_may_remember_whatever_it_likes_in_plain_python():
    episode = fly_plain(CASES[2].lasting(5), Crew(Diarist()), KEYS[2])
    np.testing.assert_allclose(episode.action.up, [0.01, 0.02, 0.03, 0.04, 0.05])


@pytest.mark.parametrize("pilot", (Servo(), HumanModel(), HandsOff()), ids=lambda pilot: pilot.name)
def test_it_is_known_beforehand_which_pilots_can_be_compiled(pilot):
    assert traceable(pilot)


@pytest.mark.parametrize("pilot", (Decided(), Diarist()), ids=lambda pilot: pilot.name)
def test_and_which_cannot(pilot):
    assert not traceable(pilot)


@pytest.fixture(scope="module")
def batch():
    return fly(CASES, CREW, KEYS)


def test_a_batch_has_a_leading_axis_of_flights(batch):
    assert {leaf.shape for _, leaf in leaves(batch)} == {(len(CASES), ROWS)}
    assert {leaf.dtype for _, leaf in leaves(batch)} == {np.dtype(np.float32)}
    assert {leaf.shape for _, leaf in leaves(take(batch, 2, 10))} == {(10,)}


def test_the_same_keys_give_the_same_flights_and_other_keys_others(batch):
    assert_same(fly(CASES, CREW, KEYS), batch)
    others = fly(CASES, CREW, [(9, i) for i in range(4)])
    for i in range(4):
        assert not np.allclose(others.observation.ugv_u[i], batch.observation.ugv_u[i])


def test_a_flight_does_not_depend_on_who_flies_beside_it(batch):
    strangers = [Case.draw(Combined(), (77, i), ROWS) for i in range(3)]
    company = fly([CASES[0], *strangers], CREW, [KEYS[0], (8, 1), (8, 2), (8, 3)])
    assert_same(take(company, 0, ROWS), take(batch, 0, ROWS))


def test_a_flight_does_not_depend_on_its_place_in_the_batch(batch):
    backwards = fly(CASES[::-1], CREW, KEYS[::-1])
    for i in range(4):
        assert_same(take(backwards, 3 - i, ROWS), take(batch, i, ROWS))


@pytest.mark.parametrize("i", range(4), ids=("boxes", "no boxes", "climb", "more boxes"))
def test_compiled_and_plain_flights_are_the_same_flight(batch, i):
    """Same chance, to single precision; arenas with fewer boxes were padded and did not notice."""
    plain = fly_plain(CASES[i], CREW, KEYS[i])
    compiled = take(batch, i, ROWS)
    for axis in ("x", "y", "z"):
        wanted = getattr(plain.world.uav.position, axis)
        np.testing.assert_allclose(getattr(compiled.world.uav.position, axis), wanted, atol=1e-4)
    for name in OBSERVATION_NAMES:
        np.testing.assert_allclose(
            getattr(compiled.observation, name), getattr(plain.observation, name), atol=0.05, err_msg=name
        )
    for got, wanted in zip(compiled.world.ugvs, plain.world.ugvs, strict=True):
        np.testing.assert_allclose(got.x, wanted.x, atol=1e-4)


def test_ugvs_follow_their_formation_in_the_simulator_as_well(batch):
    corners = [FormationControl().corners(case.plan.track, case.plan.orientation) for case in CASES[:3]]
    for i, places in enumerate(corners[1:], start=1):  # those without boxes
        for ugv, (x, y, _, _) in zip(batch.world.ugvs, places, strict=True):
            assert np.hypot(ugv.x[i] - x, ugv.y[i] - y).max() < 0.15


def test_a_pilot_that_jax_cannot_trace_raises_jaxs_own_error():
    with pytest.raises(jax.errors.JAXTypeError):
        fly(CASES, Crew(Decided()), KEYS)


def mean_offset(episodes):
    """One number per flight."""
    return abs(episodes.observation.ugv_u - episodes.observation.centre_u).mean(axis=-1)


def test_reducing_inside_the_program_is_reducing_afterwards(batch):
    inside = fly(CASES, CREW, KEYS, reduce=mean_offset)
    assert inside.shape == (4,)
    np.testing.assert_allclose(inside, mean_offset(batch), rtol=1e-4)


def test_every_flight_may_have_its_own_crew(batch):
    crews = [CREW, CREW, Crew(Servo(), Axes.of((2,))), Crew(Servo(p=0.1))]
    mixed = fly(CASES, crews, KEYS)
    for i in (0, 1):
        assert_same(take(mixed, i, ROWS), take(batch, i, ROWS), rtol=1e-3, atol=5e-3)
    assert not mixed.action.forward[2].any() and mixed.action.up[2].any()
    assert np.abs(mixed.action.forward[3]).mean() < np.abs(batch.action.forward[3]).mean()


def test_more_flights_than_a_batch_holds_are_the_same_flights(batch):
    many = fly([*CASES[:1] * BATCH, CASES[2]], CREW, [*KEYS[:1] * BATCH, KEYS[2]])
    assert {leaf.shape for _, leaf in leaves(many)} == {(BATCH + 1, ROWS)}
    for i, known in ((0, 0), (BATCH - 1, 0), (BATCH, 2)):
        assert_same(take(many, i, ROWS), take(batch, known, ROWS))


def test_who_has_crews_of_their_own_and_who_shares_one_fly_in_one_program(batch, monkeypatch):
    monkeypatch.setattr("fledge.engines.compiled", None)
    assert_same(fly(CASES, [CREW] * 4, KEYS), batch)
