"""Results on disk: one JSON file, for people and machines, the same bytes for the same results.

Keys are sorted, numbers are the shortest text that reads back as the same double, and a number that is not
finite is refused by name: JSON has no word for it, and in a result it is a mistake somewhere above.
"""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from fledge.errors import FledgeError
from fledge.storage.atomic import AnyPath, reading, write


def write_json(path: AnyPath, results: Any) -> None:
    """Store results: dicts with text keys, lists, tuples, text, numbers, NumPy's arrays and numbers included.

    Raises:
        BadFile: the file cannot be written.
        FledgeError: something that JSON cannot hold; names where it is.
    """
    text = json.dumps(plain(results), indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False)
    write(path, f"{text}\n".encode())


def read_json(path: AnyPath) -> Any:
    """The results as they were stored; tuples and arrays come back as lists.

    Raises:
        BadFile: missing, truncated or not JSON.
    """
    with reading(path, "JSON"):
        return json.loads(Path(path).read_bytes(), parse_constant=_refuse)


def plain(value: Any, where: str = "results") -> Any:
    """The value in plain dicts, lists and finite numbers; `where` names it in errors.

    Raises:
        FledgeError: something that JSON cannot hold.
    """
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, Mapping):
        wrong = [key for key in value if not isinstance(key, str)]
        if wrong:
            raise FledgeError(f"{where} has the key {wrong[0]!r}: valid is text")
        return {key: plain(item, f"{where}.{key}") for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item, f"{where}[{i}]") for i, item in enumerate(value)]
    if isinstance(value, float) and not math.isfinite(value):
        raise FledgeError(f"{where} is {value}: valid is a finite number")
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    raise FledgeError(f"{where} is a {type(value).__name__}: valid are dicts, lists, text and numbers")


def _refuse(word: str) -> NoReturn:
    raise FledgeError(f"it holds {word}: valid are finite numbers")
