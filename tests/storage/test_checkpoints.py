"""A checkpoint comes back as it was, or is refused."""

import json

import numpy as np
import pytest

from fledge.errors import BadFile, FledgeError
from fledge.storage import read_checkpoint, write_checkpoint

ARRAYS = {
    "weights/0": np.random.default_rng(0).normal(size=(11, 30)).astype(np.float32),
    "file": np.array([np.nan, np.inf, -0.0]),
    "settings": np.array(7),
    "allow_pickle": np.array([True, False]),
    "empty": np.zeros((0, 3)),
    "key": np.array([1, 2], dtype=np.uint32),
}
SETTINGS = {"epoch": 30, "recipe": {"rate": 1e-3, "init": "paper"}, "inputs": [0, 1]}


def refused(path, content: bytes) -> str:
    path.write_bytes(content)
    with pytest.raises(BadFile) as caught:
        read_checkpoint(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_round_trip(tmp_path):
    write_checkpoint(tmp_path / "a.npz", ARRAYS, SETTINGS)
    arrays, settings = read_checkpoint(tmp_path / "a.npz")
    assert settings == SETTINGS and list(arrays) == list(ARRAYS)
    for name, array in ARRAYS.items():
        assert arrays[name].tobytes() == array.tobytes()
        assert (arrays[name].dtype, arrays[name].shape) == (array.dtype, array.shape)
    assert [path.name for path in tmp_path.iterdir()] == ["a.npz"]


def test_same_checkpoint_same_bytes_and_the_name_is_kept(tmp_path):
    write_checkpoint(tmp_path / "a", ARRAYS, SETTINGS)
    write_checkpoint(tmp_path / "b", ARRAYS, dict(reversed(SETTINGS.items())))
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_what_cannot_be_stored_is_named(tmp_path):
    with pytest.raises(FledgeError, match="arrays/w is of dtype object: valid are numbers"):
        write_checkpoint(tmp_path / "a.npz", {"w": np.array([None])}, {})
    with pytest.raises(FledgeError, match="settings.loss is inf: valid is a finite number"):
        write_checkpoint(tmp_path / "a.npz", {}, {"loss": float("inf")})
    with pytest.raises(BadFile, match="cannot be written: Not a directory"):
        (tmp_path / "file").touch()
        write_checkpoint(tmp_path / "file" / "a.npz", ARRAYS, SETTINGS)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_a_checkpoint_cut_anywhere_is_refused(tmp_path):
    write_checkpoint(tmp_path / "a.npz", ARRAYS, SETTINGS)
    data = (tmp_path / "a.npz").read_bytes()
    for size in [*range(0, 60), *range(60, len(data), 17)]:
        refused(tmp_path / "a.npz", data[:size])


def test_a_flipped_bit_gives_the_same_arrays_or_none(tmp_path):
    write_checkpoint(tmp_path / "a.npz", ARRAYS, SETTINGS)
    data = (tmp_path / "a.npz").read_bytes()
    rng = np.random.default_rng(1)
    for place in rng.integers(0, len(data), 300):
        broken = bytearray(data)
        broken[place] ^= 1 << rng.integers(8)
        (tmp_path / "a.npz").write_bytes(broken)
        try:
            arrays, settings = read_checkpoint(tmp_path / "a.npz")
        except BadFile:
            continue
        assert settings == SETTINGS
        assert all(array.tobytes() == ARRAYS[name].tobytes() for name, array in arrays.items())


def test_foreign_files_are_refused(tmp_path):
    path = tmp_path / "a.npz"
    rng = np.random.default_rng(2)
    for size in [0, 1, 100, 10_000]:
        assert "damaged, or not a checkpoint at all" in refused(path, rng.bytes(size))
    np.savez(path, x=np.zeros(3))
    assert "without settings" in refused(path, path.read_bytes())
    np.save(tmp_path / "b.npy", np.zeros(3))
    assert "without settings" in refused(path, (tmp_path / "b.npy").read_bytes())
    np.savez(path, settings=np.array(json.dumps({"format": 2})))
    assert "a checkpoint of format 2: this fledge reads 1" in refused(path, path.read_bytes())
    np.savez(path, settings=np.array([None], dtype=object))
    assert "damaged" in refused(path, path.read_bytes())
    with pytest.raises(BadFile, match="cannot be read: No such file"):
        read_checkpoint(tmp_path / "nowhere.npz")
