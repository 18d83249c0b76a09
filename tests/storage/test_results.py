"""Results come back as they were; what JSON cannot hold is named."""

import json

import numpy as np
import pytest

from fledge.errors import BadFile, FledgeError
from fledge.storage import read_json, write_json

RESULTS = {
    "z": [1, 2.5, True, None, "ä"],
    "a": {"mean": np.float32(0.1), "curve": np.array([0.1, 1e-300]), "pair": (1, 2), "n": np.int64(3)},
}
PLAIN = {
    "z": [1, 2.5, True, None, "ä"],
    "a": {"mean": float(np.float32(0.1)), "curve": [0.1, 1e-300], "pair": [1, 2], "n": 3},
}


def test_round_trip(tmp_path):
    write_json(tmp_path / "a.json", RESULTS)
    assert read_json(tmp_path / "a.json") == PLAIN


def test_same_results_same_bytes_whatever_the_order(tmp_path):
    write_json(tmp_path / "a.json", RESULTS)
    write_json(tmp_path / "b.json", dict(reversed(RESULTS.items())))
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()
    assert (tmp_path / "a.json").read_text().startswith('{\n "a": {\n  "curve": [\n')
    assert (tmp_path / "a.json").read_text().endswith("\n")


@pytest.mark.parametrize(
    "value", [float("nan"), float("inf"), np.float32("-inf"), np.array([[0.0], [np.nan]])]
)
def test_numbers_that_are_not_finite_are_refused_by_name(tmp_path, value):
    with pytest.raises(
        FledgeError, match=r"results.table\[1\].mean.* is -?(nan|inf): valid is a finite number"
    ):
        write_json(tmp_path / "a.json", {"table": [{}, {"mean": value}]})
    assert list(tmp_path.iterdir()) == []


def test_other_things_are_refused_by_name(tmp_path):
    with pytest.raises(FledgeError, match="results.who is a set: valid are dicts, lists, text and numbers"):
        write_json(tmp_path / "a.json", {"who": {1}})
    with pytest.raises(FledgeError, match="results has the key 3: valid is text"):
        write_json(tmp_path / "a.json", {3: 1})


def test_files_that_are_no_results(tmp_path):
    path = tmp_path / "a.json"
    write_json(path, RESULTS)
    data = path.read_bytes()
    for content in [*(data[:size] for size in range(len(data) - 1)), b"\xff", b"[" * 100_000, b"{'a': 1}"]:
        path.write_bytes(content)
        with pytest.raises(BadFile, match="damaged, or not JSON at all"):
            read_json(path)
    path.write_text(json.dumps({"a": float("nan")}))
    with pytest.raises(BadFile, match="it holds NaN: valid are finite numbers"):
        read_json(path)
    with pytest.raises(BadFile, match="cannot be read: No such file"):
        read_json(tmp_path / "nowhere.json")
