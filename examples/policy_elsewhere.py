"""Run a trained policy without fledge: all it takes is ONNX Runtime, and an eye on the contract.

    fledge demonstrate && fledge train demos && python policy_elsewhere.py

The normaliser is inside the file: pixels, metres and metres a second go in, sticks come out.
"""

import json
import sys

import numpy as np
import onnxruntime


def main(path="policy.onnx"):
    session = onnxruntime.InferenceSession(path)
    contract = json.loads(session.get_modelmeta().custom_metadata_map["fledge.contract"])
    width, height = contract["lens"]["width_px"], contract["lens"]["height_px"]
    print(f"It wants {contract['rate']:g} decisions a second, on a picture of {width:g} x {height:g} pixels.")
    centred = {"centre_u": 320.0, "centre_v": 180.0, "ugv_u": 320.0, "ugv_v": 180.0}
    seen = centred | {"altitude": 2.8, "ideal_radius": 108.0, "radius": 140.0}
    state = np.array([[seen.get(name, 0.0) for name in contract["observation"]]], dtype=np.float32)
    (sticks,) = session.run(["action"], {"state": state})[0]
    said = dict(zip(contract["actions"], sticks, strict=True))
    print(f"With the UGVs too large in the picture, it says: up {said['up']:+.2f}.")
    return said["up"]


if __name__ == "__main__":
    main(*sys.argv[1:])
