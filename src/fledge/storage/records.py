"""Records as trees of JSON values, and back: written once for all records, by their fields.

A dataclass becomes an object with its fields in their order, a tuple a list. JSON has no NaN and no infinity;
they are written as the strings "NaN", "Infinity" and "-Infinity", as protobuf's JSON mapping does, so a file
stays strict JSON and no number is lost.
"""

from collections.abc import Callable, Collection
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any, get_args, get_origin, get_type_hints

from fledge.errors import FledgeError

NON_FINITE = {"nan": "NaN", "inf": "Infinity", "-inf": "-Infinity"}
"""What Python's `repr` says of them, and what a file says."""


def to_tree(record: Any, leaf: Callable[[str, Any], Any], path: str = "") -> Any:
    """The record as nested dicts and lists; `leaf(path, value)` says what stands for a leaf."""
    if is_dataclass(record) and not isinstance(record, type):
        return {f.name: to_tree(getattr(record, f.name), leaf, f"{path}{f.name}.") for f in fields(record)}
    if isinstance(record, tuple):
        return [to_tree(item, leaf, f"{path}{i}.") for i, item in enumerate(record)]
    return leaf(path[:-1], record)


def from_tree(kind: Any, tree: Any, leaf: Callable[[str, Any, Any], Any], path: str = "") -> Any:
    """A record of type `kind` from its tree; `leaf(path, type, value)` makes a leaf.

    Raises:
        FledgeError: the tree is not that of such a record; names where.
    """
    if isinstance(kind, type) and is_dataclass(kind):
        hints = _hints(kind)
        if not isinstance(tree, dict) or tree.keys() != hints.keys():
            has = ", ".join(map(str, tree)) if isinstance(tree, dict) else shown(tree)
            raise FledgeError(f"{path[:-1] or 'the record'} has {has}: valid are {', '.join(hints)}")
        return kind(**{name: from_tree(hints[name], tree[name], leaf, f"{path}{name}.") for name in hints})
    if get_origin(kind) is tuple:
        if not isinstance(tree, list):
            raise FledgeError(f"{path[:-1]} is {shown(tree)}: valid is a list")
        item = get_args(kind)[0]
        return tuple(from_tree(item, part, leaf, f"{path}{i}.") for i, part in enumerate(tree))
    return leaf(path[:-1], kind, tree)


def to_json(record: Any) -> Any:
    """The record, or a plain value, as JSON values."""
    return to_tree(record, lambda _, value: _plain(value))


def from_json(kind: Any, tree: Any, path: str = "") -> Any:
    """A record of type `kind`, or a plain value, from JSON values.

    Raises:
        FledgeError: the values are not those of such a record; names where.
    """
    return from_tree(kind, tree, _parsed, f"{path}." if path else "")


@cache
def _hints(kind: type) -> dict[str, Any]:
    hints = get_type_hints(kind)
    return {field.name: hints[field.name] for field in fields(kind)}


def _plain(value: Any) -> Any:
    value = value.item() if hasattr(value, "item") else value
    return NON_FINITE.get(repr(value), value) if isinstance(value, float) else value


def _parsed(path: str, kind: Any, value: Any) -> Any:
    number = kind in (float, Any)
    if number and isinstance(value, str) and value in NON_FINITE.values():
        return float(value)
    valid = (int, float) if number else kind
    if not isinstance(value, valid) or (isinstance(value, bool) and kind in (int, float)):
        raise FledgeError(f"{path} is {shown(value)}: valid is {'a number' if number else kind.__name__}")
    return float(value) if kind is float else value


def shown(value: Any) -> str:
    """A value in an error: its beginning will do."""
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def check_keys(name: str, table: Any, needed: Collection[str], optional: Collection[str] = ()) -> None:
    """See that something read from a file is a table with these keys and no others.

    Raises:
        FledgeError: it is not; names what it has, and what is valid.
    """
    if not isinstance(table, dict):
        raise FledgeError(f"{name} is {shown(table)}: valid is a table with {', '.join(needed)}")
    for key in table:
        if key not in (*needed, *optional):
            raise FledgeError(f"{name} has {key!r}: valid are {', '.join((*needed, *optional))}")
    for key in needed:
        if key not in table:
            raise FledgeError(f"{name} has no {key}: valid is one with {', '.join(needed)}")
