"""Checkpoints of a training: named arrays and the settings they belong to, in one `.npz`.

NumPy opens the file without fledge: each array is a member `arrays/NAME`, the settings are JSON in the member
`settings`. Nothing in it is ever unpickled. The same checkpoint gives the same bytes.
"""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from fledge.errors import FledgeError
from fledge.storage.atomic import AnyPath, reading, replacing
from fledge.storage.results import plain

FORMAT = 1
"""Version of the layout above; a reader refuses every other."""

_ARRAYS = "arrays/"


def write_checkpoint(path: AnyPath, arrays: Mapping[str, np.ndarray], settings: Mapping[str, Any]) -> None:
    """Store arrays of numbers, truths or text, and settings that JSON can hold.

    Raises:
        BadFile: the file cannot be written.
        FledgeError: an array or a setting that cannot be stored; names it.
    """
    members = {f"{_ARRAYS}{name}": np.asarray(array) for name, array in arrays.items()}
    for name, array in members.items():
        if array.dtype.kind not in "biufcU":
            raise FledgeError(f"{name} is of dtype {array.dtype}: valid are numbers, truths and text")
    text = json.dumps({"format": FORMAT, "settings": plain(settings, "settings")}, sort_keys=True)
    with replacing(path) as file:
        np.savez(file, settings=np.array(text), **members)  # pyright: ignore[reportArgumentType]


def read_checkpoint(path: AnyPath) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """(arrays, settings) as they were stored.

    Raises:
        BadFile: missing, truncated, damaged, foreign, or of another format version.
    """
    with reading(path, "a checkpoint"), open(path, "rb") as file:
        archive = np.load(file, allow_pickle=False)
        if not isinstance(archive, np.lib.npyio.NpzFile) or "settings" not in archive:
            raise FledgeError("a file of NumPy's without settings: valid is a checkpoint stored by fledge")
        record = json.loads(str(archive["settings"]))
        if record["format"] != FORMAT:
            raise FledgeError(f"a checkpoint of format {record['format']}: this fledge reads {FORMAT}")
        names = [name for name in archive.files if name.startswith(_ARRAYS)]
        return {name.removeprefix(_ARRAYS): archive[name] for name in names}, record["settings"]
