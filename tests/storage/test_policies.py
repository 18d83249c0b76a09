"""A policy comes back as it was and flies the same in onnxruntime; everything else is refused."""

import json
import warnings
from dataclasses import replace

import numpy as np
import onnx
import onnxruntime
import pytest
from onnx import TensorProto, helper

from fledge.camera import Lens
from fledge.errors import BadFile, FledgeError
from fledge.learning.policy import Contract, Policy
from fledge.storage import read_policy, write_policy
from fledge.storage.records import to_json


def make(
    sizes=(9, 30, 30, 4), inputs=(0, 1, 2, 3, 4, 5, 6, 8, 10), states=11, contract=Contract(), seed=0
) -> Policy:
    rng = np.random.default_rng(seed)
    layers = list(zip(sizes[:-1], sizes[1:], strict=True))
    return Policy(
        weights=tuple(rng.normal(0.0, 1.0 / np.sqrt(n), (n, m)).astype(np.float32) for n, m in layers),
        biases=tuple(rng.normal(0.0, 0.1, m).astype(np.float32) for _, m in layers),
        mean=rng.normal(100.0, 50.0, sizes[0]).astype(np.float32),
        scale=rng.uniform(0.5, 50.0, sizes[0]).astype(np.float32),
        inputs=inputs,
        states=states,
        contract=contract,
    )


POLICIES = {
    "paper": make(
        (11, 300, 300, 4), tuple(range(11)), contract=Contract(lens=Lens(700.5, levelled=False), data="ab")
    ),
    "some inputs": make(),
    "no contract": make(contract=None),
    "one layer": make((2, 1), (3, 1), 5, None),
    "odd numbers": replace(make(), scale=np.array([np.nan, np.inf, -0.0, 1e-45, 1, 1, 1, 1, 1], np.float32)),
}


@pytest.fixture(params=POLICIES.values(), ids=POLICIES.keys())
def policy(request) -> Policy:
    return request.param


def arrays(policy: Policy):
    return [*policy.weights, *policy.biases, policy.mean, policy.scale]


def refused(path, content: bytes) -> str:
    path.write_bytes(content)
    with pytest.raises(BadFile) as caught:
        read_policy(path)
    line = str(caught.value)
    assert line.startswith(f"{path}: ") and "\n" not in line
    return line.removeprefix(f"{path}: ")


def test_round_trip(tmp_path, policy):
    write_policy(tmp_path / "a.onnx", policy)
    back = read_policy(tmp_path / "a.onnx")
    assert (back.inputs, back.states, back.contract) == (policy.inputs, policy.states, policy.contract)
    for mine, theirs in zip(arrays(back), arrays(policy), strict=True):
        assert mine.tobytes() == theirs.tobytes() and mine.shape == theirs.shape
        assert mine.dtype == np.float32 and mine.flags.owndata and mine.flags.writeable


def test_same_policy_same_bytes(tmp_path, policy):
    write_policy(tmp_path / "a.onnx", policy)
    write_policy(tmp_path / "b.onnx", read_policy(tmp_path / "a.onnx"))
    assert (tmp_path / "a.onnx").read_bytes() == (tmp_path / "b.onnx").read_bytes()


def test_arrays_of_jax_are_stored_as_numpy_ones(tmp_path):
    import jax.numpy as jnp

    policy = make()
    twin = replace(policy, weights=tuple(map(jnp.asarray, policy.weights)), mean=jnp.asarray(policy.mean))
    write_policy(tmp_path / "a.onnx", policy)
    write_policy(tmp_path / "b.onnx", twin)
    assert (tmp_path / "a.onnx").read_bytes() == (tmp_path / "b.onnx").read_bytes()


def test_whole_numbers_of_any_kind_will_do(tmp_path):
    policy = make()
    loose = replace(
        policy,
        inputs=list(np.array(policy.inputs)),
        states=np.int64(11),
        contract=Contract(rate=20, ideal_radius=np.float32(108.0)),
        mean=policy.mean.astype(float),
    )
    write_policy(tmp_path / "a.onnx", loose)
    back = read_policy(tmp_path / "a.onnx")
    assert (back.inputs, back.states, back.contract) == (policy.inputs, 11, policy.contract)


@pytest.mark.parametrize("name", ["paper", "some inputs", "no contract", "one layer"])
def test_onnxruntime_says_the_same(tmp_path, name):
    policy = POLICIES[name]
    write_policy(tmp_path / "a.onnx", policy)
    onnx.checker.check_model(onnx.load(tmp_path / "a.onnx"), full_check=True)
    session = onnxruntime.InferenceSession(tmp_path / "a.onnx", providers=["CPUExecutionProvider"])
    rng = np.random.default_rng(1)
    for rows in (1, 7, 1000):
        states = rng.normal(0.0, 60.0, (rows, policy.states)).astype(np.float32)
        states[:, policy.inputs] = policy.mean + policy.scale * rng.normal(
            0.0, 1.5, (rows, len(policy.inputs))
        )
        (actions,) = session.run(["action"], {"state": states})
        assert actions.shape == (rows, len(policy.biases[-1]))
        np.testing.assert_allclose(actions, policy(states), rtol=0.0, atol=1e-6)
    assert session.get_modelmeta().custom_metadata_map["fledge.format"] == "1"
    assert ("fledge.contract" in session.get_modelmeta().custom_metadata_map) == (policy.contract is not None)


def test_the_paper_s_network_is_small(tmp_path):
    write_policy(tmp_path / "a.onnx", POLICIES["paper"])
    assert (tmp_path / "a.onnx").stat().st_size < 400_000


def test_policies_that_are_no_network_are_refused(tmp_path):
    policy = make()
    for wrong in [
        replace(policy, mean=policy.mean[:-1]),
        replace(policy, scale=policy.scale[None]),
        replace(policy, weights=policy.weights[:-1]),
        replace(policy, weights=(), biases=()),
        replace(policy, biases=(policy.biases[1], policy.biases[0][:3], policy.biases[2])),
        replace(policy, inputs=(11, *policy.inputs[1:])),
        replace(policy, inputs=policy.inputs[1:]),
        replace(policy, weights=tuple(w[None] for w in policy.weights)),
    ]:
        with pytest.raises(FledgeError, match="these do not make one network"):
            write_policy(tmp_path / "a.onnx", wrong)
    assert list(tmp_path.iterdir()) == []


def test_a_policy_keeps_to_its_contract(tmp_path):
    """As many numbers in and out as the contract has names; without a contract, any."""
    for wrong in [
        replace(make(), contract=Contract(actions=("forward", "left"))),
        replace(make(), contract=Contract(observation=("altitude",))),
        make((9, 30, 3)),
        make(states=12),
    ]:
        with pytest.raises(
            FledgeError, match="a policy from 1[12] numbers to [34] actions: its contract names"
        ):
            write_policy(tmp_path / "a.onnx", wrong)
        write_policy(tmp_path / "b.onnx", replace(wrong, contract=None))
    assert [path.name for path in tmp_path.iterdir()] == ["b.onnx"]


def test_a_policy_cut_anywhere_is_refused(tmp_path):
    write_policy(tmp_path / "a.onnx", make())
    data = (tmp_path / "a.onnx").read_bytes()
    for size in [*range(0, 300), *range(300, len(data), 97), *range(len(data) - 700, len(data))]:
        refused(tmp_path / "a.onnx", data[:size])


def test_rubbish_is_refused(tmp_path):
    rng = np.random.default_rng(2)
    for size in [1, 100, 10_000]:
        refused(tmp_path / "a.onnx", rng.bytes(size))
        refused(tmp_path / "a.onnx", bytes(size))
    for text in [b"#!/bin/sh", b"{}", b"PK\x03\x04"]:
        assert "damaged, or not a policy at all" in refused(tmp_path / "a.onnx", text)
    with pytest.raises(BadFile, match="cannot be read: No such file or directory"):
        read_policy(tmp_path / "nowhere.onnx")
    with pytest.raises(BadFile, match="cannot be read: Is a directory"):
        read_policy(tmp_path)


def altered(path, change) -> str:
    write_policy(path, make())
    model = onnx.load(path)
    change(model)
    return refused(path, model.SerializeToString())


def set_property(model, key, value):
    next(prop for prop in model.metadata_props if prop.key == key).value = value


def test_an_onnx_of_others_is_refused(tmp_path):
    node = helper.make_node("Relu", ["x"], ["y"])
    x, y = (helper.make_tensor_value_info(name, TensorProto.FLOAT, [1]) for name in "xy")
    model = helper.make_model(helper.make_graph([node], "g", [x], [y]), producer_name="pytorch")
    line = refused(tmp_path / "a.onnx", model.SerializeToString())
    assert "without fledge's metadata" in line and "'pytorch'" in line
    helper.set_model_props(model, {"fledge.format": "1"})
    refused(tmp_path / "a.onnx", model.SerializeToString())


def external(model):
    tensor = model.graph.initializer[3]
    tensor.data_location = TensorProto.EXTERNAL
    tensor.external_data.add(key="location", value="/etc/passwd")


def test_a_flipped_bit_gives_the_same_policy_or_none(tmp_path):
    path, policy = tmp_path / "a.onnx", make()
    write_policy(path, policy)
    data = path.read_bytes()
    rng = np.random.default_rng(3)
    for place in rng.integers(0, len(data), 400):
        broken = bytearray(data)
        broken[place] ^= 1 << rng.integers(8)
        path.write_bytes(broken)
        try:
            back = read_policy(path)
        except BadFile:
            continue
        assert back.contract == policy.contract
        assert all(x.tobytes() == y.tobytes() for x, y in zip(arrays(back), arrays(policy), strict=True))


def test_altered_policies_are_refused(tmp_path):
    path = tmp_path / "a.onnx"
    assert altered(path, lambda m: set_property(m, "fledge.format", "2")).startswith("a policy of format '2'")
    assert "opset 17 alone" in altered(path, lambda m: m.opset_import.add(domain="com.example", version=1))
    assert "opset 17 alone" in altered(path, lambda m: setattr(m.opset_import[0], "version", 21))
    assert "contract has rate: valid are" in altered(
        path, lambda m: set_property(m, "fledge.contract", '{"rate":1}')
    )
    assert "damaged" in altered(path, lambda m: set_property(m, "fledge.contract", "{"))
    two = json.dumps(to_json(Contract(actions=("up", "turn"))))
    assert "its contract names 11 and 2" in altered(path, lambda m: set_property(m, "fledge.contract", two))
    unaltered = "its graph or metadata are not as fledge stored them"
    assert unaltered in altered(path, lambda m: set_property(m, "fledge.sha256", "0"))
    assert unaltered in altered(path, lambda m: m.metadata_props.pop(1))
    assert unaltered in altered(path, lambda m: m.metadata_props.add(key="more", value="1"))
    assert unaltered in altered(path, lambda m: setattr(m.graph.node[4], "op_type", "Tanh"))
    assert unaltered in altered(
        path, lambda m: m.graph.node.add(op_type="Neg", input=["action"], output=["b"])
    )
    assert unaltered in altered(path, lambda m: m.graph.initializer.add(name="more", data_type=1, dims=[0]))
    assert unaltered in altered(path, external)
    assert "damaged" in altered(path, lambda m: m.graph.initializer.pop())
    assert "damaged" in altered(path, lambda m: m.graph.initializer[2].dims.append(2))
    assert "do not make one network" in altered(path, lambda m: m.graph.initializer[3].dims.reverse())
    dims = "graph.input[0].type.tensor_type.shape.dim[1]"
    assert "do not make one network" in altered(path, lambda m: setattr(eval(f"m.{dims}"), "dim_value", 3))


def test_reading_is_silent(tmp_path, capfd):
    write_policy(tmp_path / "a.onnx", make())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_policy(tmp_path / "a.onnx")
        refused(tmp_path / "b.onnx", b"junk")
    assert capfd.readouterr() == ("", "")
