"""The trained network: one map, however it is called, and only for the rig it was made for."""

from dataclasses import astuple, fields, replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from fledge.camera import REAL_BOTTOM_CAMERA, Lens
from fledge.engines import fly_plain
from fledge.errors import ContractMismatch, FledgeError
from fledge.learning.policy import HIDDEN, Contract, Policy
from fledge.manoeuvres import Climb
from fledge.observation import ACTION_NAMES, OBSERVATION_NAMES, Action, Observation, StickScale
from fledge.pilots import AbstractPilot
from fledge.pytrees import pytree
from fledge.simulation import Case, Crew

pytestmark = pytest.mark.slow

NOISE = (0.0, 0.0, 0.0, 0.0)


def network(seed=0, inputs=tuple(range(11)), states=11, outputs=4, hidden=(16, 16), gain=1.0):
    """Random weights, and a normaliser that fits numbers like those of a flight."""
    rng = np.random.default_rng(seed)
    sizes = (len(inputs), *hidden, outputs)
    layers = list(zip(sizes[:-1], sizes[1:], strict=True))
    return Policy(
        weights=tuple((gain * rng.normal(size=s) / np.sqrt(s[0])).astype(np.float32) for s in layers),
        biases=tuple(rng.normal(size=n).astype(np.float32) for _, n in layers),
        mean=rng.uniform(-100.0, 100.0, len(inputs)).astype(np.float32),
        scale=rng.uniform(1.0, 50.0, len(inputs)).astype(np.float32),
        inputs=tuple(inputs),
        states=states,
    )


def in_words(policy, state):
    """Normalise, ReLU, ReLU, tanh: written out, in double precision."""
    x = (np.asarray(state, float)[..., list(policy.inputs)] - policy.mean) / policy.scale
    for weight, bias in zip(policy.weights[:-1], policy.biases[:-1], strict=True):
        x = np.maximum(x @ weight.astype(float) + bias, 0.0)
    return np.tanh(x @ policy.weights[-1].astype(float) + policy.biases[-1])


STATES = arrays(float, (5, 11), elements=st.floats(-500.0, 500.0, width=32))


@given(STATES, st.integers(0, 3))
def test_one_map_however_it_is_called(states, seed):
    """Rows at once, one by one, and as a pilot on floats: the same to single precision."""
    policy = network(seed)
    many = policy(states)
    np.testing.assert_allclose(many, in_words(policy, states), atol=1e-4)
    for state, row in zip(states, many, strict=True):
        np.testing.assert_allclose(policy(state), row, atol=1e-5)
        memory, action = policy.act(policy.init(), Observation(*state.tolist()), NOISE)
        assert memory == ()
        assert all(type(value) is float for value in astuple(action))
        np.testing.assert_allclose(astuple(action), row, atol=1e-5)


def test_compiled_it_is_the_same_map():
    """Under jit and vmap, its arrays being leaves or constants."""
    for kind in (Policy, Observation, Action):
        pytree(kind)
    policy = network()
    states = np.random.default_rng(1).uniform(-300.0, 300.0, (20, 11)).astype(np.float32)
    seen = Observation(*jnp.asarray(states.T))

    def act(pilot, observation):
        return pilot.act(pilot.init(), observation, NOISE)[1]

    for actions in (
        jax.jit(jax.vmap(act, in_axes=(None, 0)))(policy, seen),
        jax.jit(lambda o: act(policy, o))(seen),
        act(policy, Observation(*states.T)),
    ):
        columns = np.stack([getattr(actions, name) for name in ACTION_NAMES], axis=1)
        np.testing.assert_allclose(columns, policy(states), atol=1e-5)


@pytest.mark.parametrize("outputs", [1, 2, 4])
def test_shapes_of_one_row_and_of_many(outputs):
    policy = network(inputs=(0, 2), states=3, outputs=outputs)
    assert policy(np.zeros(3)).shape == (outputs,)
    assert policy([0, 0, 0]).shape == (outputs,)
    assert policy(np.zeros((1, 3))).shape == (1, outputs)
    assert policy(np.zeros((7, 3))).shape == (7, outputs)
    assert policy(np.zeros((0, 3))).shape == (0, outputs)
    assert type(policy(np.zeros(3))) is np.ndarray


@pytest.mark.parametrize("shape", [(), (2,), (4,), (3, 2), (5, 4), (3, 0)])
def test_a_state_of_another_shape_is_refused(shape):
    with pytest.raises(FledgeError) as caught:
        network(inputs=(0, 2), states=3)(np.zeros(shape))
    message = str(caught.value)
    assert "\n" not in message
    for word in (str(shape), "(3,)", "(rows, 3)"):
        assert word in message


@given(arrays(float, (3, 11), elements=st.floats(-1e6, 1e6)), st.sampled_from([0.1, 1.0, 100.0]))
def test_actions_stay_within_the_sticks(states, gain):
    actions = network(gain=gain)(states)
    assert (np.abs(actions) <= 1.0).all()


@settings(max_examples=30)
@given(st.sets(st.integers(0, 10), min_size=1, max_size=10), STATES, st.data())
def test_what_it_does_not_read_does_not_matter(inputs, states, data):
    """To the last bit; and every entry it reads does."""
    policy = network(inputs=tuple(sorted(inputs)))
    unread = sorted(set(range(11)) - inputs)
    other = states.copy()
    other[:, unread] = data.draw(
        arrays(float, (5, len(unread)), elements=st.floats(allow_nan=True, width=32))
    )
    np.testing.assert_array_equal(policy(states), policy(other))
    one, two = (policy.act((), Observation(*s.tolist()), NOISE)[1] for s in (states[0], other[0]))
    assert one == two


def test_every_entry_it_reads_matters_and_in_its_own_place():
    policy = network(inputs=(6, 2, 3), gain=3.0)
    state = np.zeros(11)
    state[[6, 2, 3]] = policy.mean
    for entry in (6, 2, 3):
        moved = state.copy()
        moved[entry] += 20.0
        assert np.abs(policy(moved) - policy(state)).max() > 1e-3
        np.testing.assert_allclose(policy(moved), in_words(policy, moved), atol=1e-4)
        action = policy.act((), Observation(*moved.tolist()), NOISE)[1]
        np.testing.assert_allclose(astuple(action), policy(moved), atol=1e-5)


def test_with_four_outputs_it_is_a_pilot():
    policy = network(inputs=(2, 3, 6), hidden=HIDDEN)
    assert isinstance(policy, AbstractPilot)
    assert policy.for_axes((0, 1)) is policy
    case = Case.draw(Climb(), (0, 1, 2, 3), 5)
    episode = fly_plain(case, Crew(policy), (0, 1, 2, 3, 1))
    seen = np.stack([getattr(episode.observation, name) for name in OBSERVATION_NAMES], axis=1)
    said = np.stack([getattr(episode.action, name) for name in ACTION_NAMES], axis=1)
    np.testing.assert_allclose(said, policy(seen) * [1, 1, 1, 0], atol=1e-5)


# The contract

OTHER = {
    "observation": OBSERVATION_NAMES[::-1],
    "units": ("m",) * 11,
    "actions": ACTION_NAMES[:3],
    "rate": 10.0,
    "lens": REAL_BOTTOM_CAMERA,
    "ideal_radius": 100.0,
    "sticks": StickScale(horizontal=2.0),
}


def test_a_blank_network_lets_go_of_the_sticks():
    blank = Policy.blank((0, 3, 5))
    assert [w.shape for w in blank.weights] == [(3, 300), (300, 300), (300, 4)]
    assert not blank(100.0 * np.ones((5, 11), np.float32)).any()
    assert network(inputs=(0, 3, 5), hidden=HIDDEN)(np.ones((5, 11), np.float32)).all()


def test_the_list_of_what_differs_is_complete():
    assert {*OTHER, "data"} == {field.name for field in fields(Contract)}


@pytest.mark.parametrize("name", OTHER)
def test_a_contract_names_exactly_what_differs(name):
    trained, rig = replace(Contract(), **{name: OTHER[name]}), Contract()
    for mine, theirs in ((trained, rig), (rig, trained)):
        with pytest.raises(ContractMismatch) as caught:
            mine.check(theirs)
        message = str(caught.value)
        assert "\n" not in message
        assert f"with {name} = " in message
        assert not [other for other in OTHER if other != name and f"{other} = " in message]
    trained.check(trained)


def test_a_contract_says_both_values():
    with pytest.raises(ContractMismatch, match=r"ideal_radius = 90\.0, but is to fly with 108\.0"):
        Contract(ideal_radius=90.0).check(Contract(ideal_radius=108.0))
    with pytest.raises(ContractMismatch, match="'levelled': False.*'levelled': True"):
        Contract(lens=Lens(levelled=False)).check(Contract())


def test_the_data_it_was_trained_on_is_no_matter_of_contract():
    Contract(data="one").check(Contract(data="another"))
    Contract().check(Contract())
