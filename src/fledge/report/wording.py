"""Numbers and settings as they are read in a report: true minus signs, thin spaces, no share rounded up to all."""

import re
from collections.abc import Mapping
from typing import Any

from fledge.study.metrics import Metric


def number(value: float | None, digits: int = 1) -> str:
    """With a true minus and thin spaces between thousands; a dash for none."""
    if value is None:
        return "–"
    text = f"{value:,.{digits}f}".replace(",", "\N{NARROW NO-BREAK SPACE}").replace("-", "\N{MINUS SIGN}")
    return text.removeprefix("\N{MINUS SIGN}") if not re.search("[1-9]", text) else text


def signed(value: float | None, digits: int = 2) -> str:
    """The same with a plus where it is positive."""
    text = number(value, digits)
    return f"+{text}" if value is not None and value > 0.0 and re.search("[1-9]", text) else text


def percent(value: float | None, digits: int = 2) -> str:
    """A share in per cent; one that is not whole never rounds to 100."""
    if value is None:
        return "–"
    text = number(100.0 * value, digits)
    return (
        f">{number(100.0 - 10.0**-digits, digits)}" if value < 1.0 and text == number(100.0, digits) else text
    )


def shown(value: float | None, metric: Metric) -> str:
    """A number as it is shown of its metric."""
    return percent(value, metric.digits) if metric.unit == "%" else number(value, metric.digits)


def p_value(value: float | None) -> str:
    """Three decimals, as far as they go."""
    if value is None:
        return "–"
    return "<0.001" if value < 0.001 else f"{value:.3f}"


def listed(items: Any) -> str:
    """One, two and three."""
    *most, last = [str(item) for item in items] or ["none"]
    return f"{', '.join(most)} and {last}" if most else last


def word(value: Any) -> str:
    """A setting, in a word."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (list, tuple)):
        return ", ".join(word(item) for item in value)
    return str(value)


def flat(settings: Mapping[str, Any], within: str = "") -> list[tuple[str, str]]:
    """Nested settings as pairs of a dotted name and a word."""
    pairs: list[tuple[str, str]] = []
    for name, value in settings.items():
        nested = isinstance(value, Mapping)
        pairs += flat(value, f"{within}{name}.") if nested else [(f"{within}{name}", word(value))]
    return pairs
