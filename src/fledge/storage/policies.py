"""Policies on disk: one ONNX file each, which any ONNX runtime flies and which says what it was made for.

The graph is the network and its normaliser, from the whole state to the action:

    state -> Gather inputs -> Sub mean -> Div scale -> Gemm -> Relu -> ... -> Gemm -> Tanh -> action

with shapes (rows, states) and (rows, actions).

The metadata carry `fledge.format`; where there is one, `fledge.contract`, the Contract as JSON (names, units,
rate, lens, ideal radius, sticks, hash of the data); and `fledge.sha256` of the numbers and the contract,
because ONNX has no checksum and a policy flies real vehicles. The bytes depend on the policy alone. A file is
trusted only if its graph is the one fledge would write for the numbers in it: nobody could say what else an
ONNX made by others computes.
"""

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from fledge.errors import FledgeError
from fledge.learning.policy import Contract, Policy
from fledge.storage.atomic import AnyPath, reading, write
from fledge.storage.records import from_json, to_json

FORMAT = "1"
"""Version of the layout above; a reader refuses every other."""

OPSET = 17
IR_VERSION = 8
"""Of ONNX 1.12 (2022); every operator used is older, so old runtimes on small boards read it too."""

_DTYPES: dict[int, str] = {TensorProto.FLOAT: "<f4", TensorProto.INT64: "<i8"}


def write_policy(path: AnyPath, policy: Policy) -> None:
    """Store a policy.

    Raises:
        BadFile: the file cannot be written.
        FledgeError: its arrays do not fit each other or its contract, or it is a whole team of policies.
    """
    _check_shapes(policy)
    _check_contract(policy)
    model = helper.make_model(
        _graph(policy),
        producer_name="fledge",
        ir_version=IR_VERSION,
        opset_imports=[helper.make_opsetid("", OPSET)],
    )
    contract = None if policy.contract is None else json.dumps(to_json(policy.contract))
    helper.set_model_props(model, _metadata(policy, contract))
    write(path, model.SerializeToString(deterministic=True))


def read_policy(path: AnyPath) -> Policy:
    """The policy as it was stored; NumPy arrays of float32.

    Raises:
        BadFile: missing, truncated, foreign, or of another format version.
    """
    with reading(path, "a policy"):
        model = onnx.load_model_from_string(Path(path).read_bytes())
        metadata = {prop.key: prop.value for prop in model.metadata_props}
        _check_origin(model, metadata)
        contract = metadata.get("fledge.contract")
        known = None if contract is None else from_json(Contract, json.loads(contract), "contract")
        policy = _policy(model.graph, known)
        _check_shapes(policy)
        _check_contract(policy)
        if metadata != _metadata(policy, contract) or _bytes(_graph(policy)) != _bytes(model.graph):
            raise FledgeError("damaged or altered: its graph or metadata are not as fledge stored them")
        return policy


def _metadata(policy: Policy, contract: str | None) -> dict[str, str]:
    inputs = [int(i) for i in policy.inputs]
    sha = hashlib.sha256(json.dumps([FORMAT, contract, inputs, int(policy.states)]).encode())
    for array in (policy.mean, policy.scale, *policy.weights, *policy.biases):
        sha.update(_float32(array).tobytes())
    made_for = {} if contract is None else {"fledge.contract": contract}
    return {"fledge.format": FORMAT, **made_for, "fledge.sha256": sha.hexdigest()}


def _graph(policy: Policy) -> onnx.GraphProto:
    last = len(policy.weights) - 1
    parameters: dict[str, Any] = {"mean": policy.mean, "scale": policy.scale}
    nodes = [
        helper.make_node("Gather", ["state", "inputs"], ["read"], axis=1),
        helper.make_node("Sub", ["read", "mean"], ["centred"]),
        helper.make_node("Div", ["centred", "scale"], ["hidden0"]),
    ]
    for i, (weight, bias) in enumerate(zip(policy.weights, policy.biases, strict=True)):
        parameters |= {f"weight{i}": weight, f"bias{i}": bias}
        nodes.append(helper.make_node("Gemm", [f"hidden{i}", f"weight{i}", f"bias{i}"], [f"sum{i}"]))
        after = ("Tanh", "action") if i == last else ("Relu", f"hidden{i + 1}")
        nodes.append(helper.make_node(after[0], [f"sum{i}"], [after[1]]))
    stored = [numpy_helper.from_array(np.array(policy.inputs, dtype="<i8"), "inputs")]
    stored += [numpy_helper.from_array(_float32(array), name) for name, array in parameters.items()]
    actions = np.shape(policy.biases[-1])[0]
    state = helper.make_tensor_value_info("state", TensorProto.FLOAT, ["rows", int(policy.states)])
    action = helper.make_tensor_value_info("action", TensorProto.FLOAT, ["rows", actions])
    return helper.make_graph(nodes, "policy", [state], [action], stored)


def _policy(graph: onnx.GraphProto, contract: Contract | None) -> Policy:
    """The policy whose numbers a graph holds, whatever else it does with them."""
    arrays = {
        tensor.name: np.frombuffer(tensor.raw_data, _DTYPES[tensor.data_type]).reshape(tensor.dims)
        for tensor in graph.initializer
    }
    layers = sum(name.startswith("weight") for name in arrays)
    return Policy(
        weights=tuple(_float32(arrays[f"weight{i}"]) for i in range(layers)),
        biases=tuple(_float32(arrays[f"bias{i}"]) for i in range(layers)),
        mean=_float32(arrays["mean"]),
        scale=_float32(arrays["scale"]),
        inputs=tuple(arrays["inputs"].tolist()),
        states=graph.input[0].type.tensor_type.shape.dim[1].dim_value,
        contract=contract,
    )


def _float32(array: Any) -> np.ndarray:
    """An own array, as the file has it."""
    return np.array(array, dtype="<f4", order="C")


def _bytes(message: Any) -> bytes:
    return message.SerializeToString(deterministic=True)


def _check_origin(model: onnx.ModelProto, metadata: dict[str, str]) -> None:
    """Refuse what does not even claim to be a policy of this format."""
    if "fledge.format" not in metadata:
        raise FledgeError(
            f"an ONNX file without fledge's metadata, or cut short (producer {model.producer_name!r}): "
            "valid is a policy stored by fledge"
        )
    if metadata["fledge.format"] != FORMAT:
        raise FledgeError(f"a policy of format {metadata['fledge.format']!r}: this fledge reads {FORMAT!r}")
    opsets = {opset.domain: opset.version for opset in model.opset_import}
    if opsets != {"": OPSET} or len(model.functions):
        raise FledgeError(f"operators {opsets}: valid are those of ONNX opset {OPSET} alone")


def _check_shapes(policy: Policy) -> None:
    """Refuse arrays that do not make a network from `states` entries to actions."""
    shapes = [np.shape(weight) for weight in policy.weights]
    biases = [np.shape(bias) for bias in policy.biases]
    width = len(policy.inputs)
    fits = bool(shapes) and all(len(shape) == 2 for shape in shapes) and width > 0
    fits = fits and np.shape(policy.mean) == np.shape(policy.scale) == (width,)
    fits = fits and [shape[0] for shape in shapes] == [width, *(shape[1] for shape in shapes[:-1])]
    fits = fits and biases == [shape[1:] for shape in shapes]
    if not fits or not all(0 <= i < policy.states for i in policy.inputs):
        raise FledgeError(
            f"a policy that reads entries {policy.inputs} of {policy.states}, with weights {shapes}, "
            f"biases {biases}, mean {np.shape(policy.mean)} and scale {np.shape(policy.scale)}: "
            "these do not make one network"
        )


def _check_contract(policy: Policy) -> None:
    """Refuse a policy that has other numbers of entries and actions than its contract has names."""
    if policy.contract is None:
        return
    has = (policy.states, len(policy.biases[-1]))
    names = (len(policy.contract.observation), len(policy.contract.actions))
    if has != names:
        raise FledgeError(
            f"a policy from {has[0]} numbers to {has[1]} actions: its contract names {names[0]} and {names[1]}"
        )
