"""A record's fields, and how each is read from JSON: strictly, with what was got and what is valid in one line.

    axes: tuple[float, ...] = of(listed(number(-1.0, 1.0), 4, 4))

A reader makes the field's value of a JSON value, or raises a ValueError. No reader takes a number for a flag, a text
for a number, or what is not finite for a number.
"""

from collections.abc import Callable
from dataclasses import MISSING, field, fields
from typing import Any, NoReturn, TypeVar

_T = TypeVar("_T")
Reader = Callable[[str, Any], Any]
"""Makes a field's value of JSON, given its name; a ValueError says what was got."""


def number(low: float, high: float) -> Reader:
    """A number in a range; bounds that are finite keep out what is not."""

    def read(what: str, got: Any) -> float:
        if type(got) not in (int, float) or not low <= got <= high:
            raise ValueError(f"{what} is {got!r:.40}: valid is {low:g} to {high:g}")
        return float(got)

    return read


def whole(low: int, high: int) -> Reader:
    """A whole number in a range, written as one."""

    def read(what: str, got: Any) -> int:
        if type(got) is not int or not low <= got <= high:
            raise ValueError(f"{what} is {got!r:.40}: valid is a whole number from {low:,} to {high:,}")
        return got

    return read


def flag(what: str, got: Any) -> bool:
    """True or false."""
    if type(got) is not bool:
        raise ValueError(f"{what} is {got!r:.40}: valid is true or false")
    return got


def text(longest: int) -> Reader:
    """One line of printable characters."""

    def read(what: str, got: Any) -> str:
        if type(got) is not str or len(got) > longest or not got.isprintable():
            raise ValueError(f"{what} is {got!r:.40}: valid is a line of up to {longest} characters")
        return got

    return read


def one_of(*valid: str) -> Reader:
    """One of these words."""

    def read(what: str, got: Any) -> str:
        if type(got) is not str or got not in valid:
            raise ValueError(f"{what} is {got!r:.40}: valid are {', '.join(valid)}")
        return got

    return read


def listed(item: Reader, least: int, most: int) -> Reader:
    """A list, as a tuple."""

    def read(what: str, got: Any) -> tuple[Any, ...]:
        if type(got) is not list or not least <= len(got) <= most:
            raise ValueError(f"{what} is {got!r:.40}: valid is a list of {least} to {most}")
        return tuple(item(what, one) for one in got)

    return read


def or_null(item: Reader) -> Reader:
    """That, or None."""
    return lambda what, got: None if got is None else item(what, got)


def nested(kind: type) -> Reader:
    """A record within a record."""
    return lambda what, got: made(kind, what, got)


def of(read: Reader, default: Any = MISSING) -> Any:
    """A field that is read so; without a default it must be there."""
    return field(default=default, metadata={"read": read})


def refuse(constant: str) -> NoReturn:
    """For the parser: NaN and the infinities are no JSON."""
    raise ValueError(f"{constant} is no number")


def made(kind: type[_T], what: str, said: Any) -> _T:
    """The record of an object, each field read as it says."""
    if type(said) is not dict:
        raise ValueError(f"{what} is {said!r:.40}: valid is an object")
    known: dict[str, Any] = {one.name: one for one in fields(kind)}  # pyright: ignore[reportArgumentType]
    unknown = [key for key in said if key not in known]
    if unknown:
        raise ValueError(f"{what} has {unknown[0]!r:.40}: valid are {', '.join(known) or 'no keys'}")
    missing = [name for name, one in known.items() if one.default is MISSING and name not in said]
    if missing:
        raise ValueError(f"{what} lacks {missing[0]}")
    return kind(**{name: known[name].metadata["read"](name, value) for name, value in said.items()})


def plain(value: Any) -> Any:
    """A record, or a value of a field, as JSON values."""
    if isinstance(value, tuple):
        return [plain(item) for item in value]
    if hasattr(value, "__dataclass_fields__"):
        return {one.name: plain(getattr(value, one.name)) for one in fields(value)}
    return value
