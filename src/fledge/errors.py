"""The errors fledge raises for its users.

Every message is one line that says what was got, with its unit, and what would be valid. A bug
of ours raises whatever Python raises; a `FledgeError` means that the input was at fault, and the
command line prints it without a traceback.
"""

from collections.abc import Iterable


class FledgeError(Exception):
    """The root: catch this to catch every error that an input can cause."""


class UnknownName(FledgeError):
    """A name that nothing answers to."""

    def __init__(self, kind: str, got: object, valid: Iterable[str]) -> None:
        super().__init__(f"unknown {kind} {got!r}: valid are {', '.join(sorted(valid))}")


class OutOfRange(FledgeError):
    """A number outside the range in which it means something."""

    def __init__(self, what: str, got: object, valid: str) -> None:
        super().__init__(f"{what} is {got}: valid is {valid}")


class BadDemonstrations(FledgeError):
    """Demonstrations that cannot be fused or learned from."""


class BadFile(FledgeError):
    """A file that is missing, truncated, foreign or cannot be written."""

    def __init__(self, path: object, why: str) -> None:
        super().__init__(f"{path}: {why}")


class ContractMismatch(FledgeError):
    """A policy that was trained for another observation, lens, rate or limit than it is to fly with."""
