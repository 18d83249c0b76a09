"""Demonstrations: what is refused, how many rows there are, and that a flight is a function of its seed."""

import math
from dataclasses import replace

import jax
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.errors import BadDemonstrations
from fledge.learning.demonstrations import PAPER_ORDERS, Demonstrations, Order, collect, of_flights
from fledge.manoeuvres import Climb, Combined, FixedAltitude
from fledge.observation import ACTION_NAMES, OBSERVATION_NAMES, Action
from fledge.pilots import AbstractPilot, HumanModel

pytestmark = pytest.mark.slow

ORDERS = tuple(Order(order.manoeuvre, 2, 121) for order in PAPER_ORDERS)
"""Two short flights of each manoeuvre: 61 and 60 rows."""


def pair(rows=4, states=3, actions=2):
    """One episode whose numbers are all different."""
    numbers = np.arange(float(rows * (states + actions)))
    return numbers[: rows * states].reshape(rows, states), numbers[rows * states :].reshape(rows, actions)


@pytest.fixture(scope="module")
def flights():
    return list(collect(ORDERS, HumanModel(), seed=0))


def said(flight):
    """Actions, shape (rows, 4)."""
    return np.stack([getattr(flight.episode.action, name) for name in ACTION_NAMES], axis=1)


def assert_equal(one, other):
    """The same flights to the last bit."""
    jax.tree.map(np.testing.assert_array_equal, [f.episode for f in one], [f.episode for f in other])


# What is data


@pytest.mark.parametrize("kind", [tuple, list])
def test_pairs_in_any_container_are_episodes(kind):
    states, actions = pair()
    for count in (1, 2, 3):
        demos = Demonstrations.of(kind((states + i, actions) for i in range(count)), "x")
        assert len(demos.episodes) == count
        assert (demos.rows, demos.state_dim, demos.action_dim) == (4 * count, 3, 2)
        for i, (s, a) in enumerate(demos.episodes):
            np.testing.assert_array_equal(s, states + i)
            np.testing.assert_array_equal(a, actions)


@pytest.mark.parametrize("rows", [1, 2, 3])
@pytest.mark.parametrize("plain", [np.asarray, np.ndarray.tolist, np.float32])
def test_a_bare_pair_is_one_episode(rows, plain):
    states, actions = pair(rows=rows)
    ((s, a),) = Demonstrations.of((plain(states), plain(actions)), "x").episodes
    np.testing.assert_array_equal(s, states)
    np.testing.assert_array_equal(a, actions)
    assert s.dtype == a.dtype == np.float64


def test_a_generator_is_read_once_and_demonstrations_pass_through():
    demos = Demonstrations.of((pair() for _ in range(3)), "x")
    assert demos.rows == 12
    assert Demonstrations.of(demos, "x") is demos


S, A = pair()


@pytest.mark.parametrize(
    ("data", "says"),
    [
        ([], ["no episode"]),
        ([(S, A), (S[:0], A[:0])], ["episode 1", "(0, 3)", "at least one"]),
        ((S[:0], A[:0]), ["episode 0", "(0, 3)"]),
        ([(S, A), (S, A[:3])], ["episode 1", "(4, 3)", "(3, 2)", "same number of rows"]),
        ([(S[0], A[0])], ["episode 0", "(3,)"]),
        ((S[0], A[0]), ["episode 0"]),
        ([(S[None], A[None])], ["episode 0", "(1, 4, 3)"]),
        ([(S, A), (S[:, :2], A)], ["episodes differ", "3", "2"]),
        ([(S, A), (S, A[:, :1])], ["episodes differ"]),
        ([(S, A, A)], ["episode 0", "not a pair"]),
        ([(S,)], ["episode 0", "not a pair"]),
        (S, ["episode 0", "not a pair"]),
        ([([["a"]], [[1.0]])], ["episode 0", "not a pair"]),
        ([([[1.0, 2.0], [3.0]], [[1.0], [2.0]])], ["episode 0", "not a pair"]),
    ],
)
def test_what_is_no_demonstration_is_refused_in_one_line(data, says):
    with pytest.raises(BadDemonstrations) as caught:
        Demonstrations.of(data, "hop")
    message = str(caught.value)
    assert "\n" not in message
    for word in ("hop", *says):
        assert word in message


@given(
    st.integers(0, 2),
    st.integers(0, 3),
    st.integers(0, 1),
    st.sampled_from(["states", "actions"]),
    st.sampled_from([math.nan, math.inf, -math.inf]),
)
def test_a_number_that_is_not_finite_is_named_by_its_place(episode, row, entry, part, value):
    data = [pair() for _ in range(3)]
    data[episode][("states", "actions").index(part)][row, entry] = value
    with pytest.raises(BadDemonstrations) as caught:
        Demonstrations.of(data, "hop")
    assert f"hop, episode {episode}: {part} row {row}, entry {entry} is {value}" in str(caught.value)


# How many rows


@given(st.integers(1, 40), st.integers(0, 20_000))
def test_lengths_add_up_exactly_and_are_even(episodes, rows):
    lengths = Order(Climb(), episodes, rows).lengths()
    assert len(lengths) == episodes
    assert sum(lengths) == rows
    assert max(lengths) - min(lengths) <= 1
    assert lengths == sorted(lengths, reverse=True)


def test_the_paper_s_counts():
    counts = {order.manoeuvre.name: (order.episodes, sum(order.lengths())) for order in PAPER_ORDERS}
    assert counts == {
        "fixed-altitude": (5, 5296),
        "climb": (10, 4691),
        "descend": (10, 4904),
        "combined": (10, 5464),
    }


# Flights


def test_every_order_is_flown_to_its_length(flights):
    wanted = [(order.manoeuvre.name, i, rows) for order in ORDERS for i, rows in enumerate(order.lengths())]
    assert [(f.manoeuvre, f.case, f.rows) for f in flights] == wanted
    for flight in flights:
        shapes = {np.shape(leaf) for leaf in jax.tree.leaves(flight.episode)}
        assert shapes == {(flight.rows,)}
        assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(flight.episode.world))
        assert (flight.pilot, flight.net, flight.seed) == ("human-model", "none", 0)


def test_a_flight_is_a_function_of_its_seed(flights):
    assert_equal(collect(ORDERS, HumanModel(), seed=0), flights)
    for one, other in zip(collect(ORDERS, HumanModel(), seed=1), flights, strict=True):
        assert not np.array_equal(one.episode.world.uav.position.x, other.episode.world.uav.position.x)
        assert not np.array_equal(one.episode.observation.ugv_u, other.episode.observation.ugv_u)
        assert not np.array_equal(said(one), said(other))


def test_what_is_done_is_left_out_and_changes_nothing(flights):
    """To the last bit: somebody who was interrupted ends with the same flights as somebody who was not."""
    done = [("climb", 0), ("combined", 1), ("combined", 0)]
    left = [flight for flight in flights if (flight.manoeuvre, flight.case) not in done]
    assert_equal(collect(ORDERS, HumanModel(), seed=0, done=done), left)


def test_no_two_flights_are_alike(flights):
    starts = {
        (float(f.episode.world.uav.position.x[0]), float(f.episode.observation.ugv_u[0])) for f in flights
    }
    assert len(starts) == len(flights)


def test_axes_out_of_use_stay_at_exactly_zero(flights):
    for flight, order in zip(flights, (order for order in ORDERS for _ in range(2)), strict=True):
        assert flight.axes == order.manoeuvre.axes
        actions = said(flight)
        unused = [i for i in range(4) if i not in flight.axes]
        assert not actions[:, unused].any()
        assert actions[:, list(flight.axes)].any(axis=0).all()
        assert np.abs(actions).max() <= 1.0


def test_a_flight_does_not_depend_on_what_else_is_collected(flights):
    """Climb alone is another program: fewer flights, and no boxes to stack. Equal but for rounding."""
    alone = list(
        collect([order for order in ORDERS if order.manoeuvre.name == "climb"], HumanModel(), seed=0)
    )
    among = [flight for flight in flights if flight.manoeuvre == "climb"]
    assert [(f.case, f.rows) for f in alone] == [(f.case, f.rows) for f in among]
    for one, other in zip(alone, among, strict=True):
        jax.tree.map(
            lambda a, b: np.testing.assert_allclose(a, b, rtol=1e-3, atol=1e-3),
            (one.episode.world, one.episode.action, one.episode.observation),
            (other.episode.world, other.episode.action, other.episode.observation),
        )


class Plain(AbstractPilot):
    """Any Python: `math`, `if`, and a count that grows; JAX can trace none of it."""

    name = "plain"

    def init(self):
        return 0

    def act(self, memory, observation, noise):
        forward = math.tanh(0.01 * (observation.centre_v - observation.ugv_v))
        left = 0.5 if observation.ugv_u < observation.centre_u and memory > 3 else -0.5
        return memory + 1, Action(forward, left, math.copysign(0.25, observation.up), 0.0)


class Counting(AbstractPilot):
    """Asks nothing of what it sees, but `if` of what it remembers."""

    name = "counting"

    def init(self):
        return 0

    def act(self, memory, observation, noise):
        return memory + 1, Action(0.5 if memory < 5 else -0.5, 0.0 * observation.up, 0.0, 0.0)


def test_a_pilot_in_plain_python_demonstrates_too():
    orders = [Order(FixedAltitude(), 1, 12), Order(Climb(), 1, 12)]
    flown = list(collect(orders, Plain(), seed=0))
    assert [f.rows for f in flown] == [12, 12]
    for flight in flown:
        seen, actions = flight.episode.observation, said(flight)
        wanted = np.stack([
            np.tanh(0.01 * (seen.centre_v - seen.ugv_v)),
            np.where((seen.ugv_u < seen.centre_u) & (np.arange(flight.rows) > 3), 0.5, -0.5),
            np.copysign(0.25, seen.up),
            np.zeros(flight.rows),
        ], axis=1)  # fmt: skip
        np.testing.assert_allclose(actions, wanted * np.isin(range(4), flight.axes), atol=1e-12)
    assert_equal(collect(orders, Plain(), seed=0), flown)


def test_a_pilot_that_asks_its_memory_demonstrates_too():
    (flight,) = collect([Order(FixedAltitude(), 1, 12)], Counting(), seed=0)
    assert flight.episode.action.forward.tolist() == [0.5] * 5 + [-0.5] * 7


# Flights as data


def test_of_flights_is_what_was_seen_and_said(flights):
    for order in ORDERS:
        own = [flight for flight in flights if flight.manoeuvre == order.manoeuvre.name]
        demos = of_flights(own)
        assert (demos.rows, len(demos.episodes)) == (order.rows, order.episodes)
        assert (demos.state_dim, demos.action_dim) == (11, len(order.manoeuvre.axes))
        for flight, (states, actions) in zip(own, demos.episodes, strict=True):
            for i, name in enumerate(OBSERVATION_NAMES):
                np.testing.assert_array_equal(states[:, i], getattr(flight.episode.observation, name))
            np.testing.assert_array_equal(actions, said(flight)[:, list(flight.axes)])


def test_of_flights_refuses_none_and_names_the_manoeuvre(flights):
    with pytest.raises(BadDemonstrations, match="no flight"):
        of_flights([])
    flight = flights[-1]
    assert flight.manoeuvre == Combined.name
    seen = replace(flight.episode.observation, ugv_u=np.full(flight.rows, np.nan))
    with pytest.raises(BadDemonstrations, match="combined, episode 0: states row 0, entry 2 is nan"):
        of_flights([replace(flight, episode=replace(flight.episode, observation=seen))])
