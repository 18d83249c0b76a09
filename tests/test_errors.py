"""What the user reads when an input is at fault."""

import pytest

from fledge import errors
from fledge.errors import BadFile, ContractMismatch, FledgeError, OutOfRange, UnknownName

EVERY_KIND = [
    kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, Exception)
]


@pytest.mark.parametrize("kind", EVERY_KIND)
def test_every_error_is_a_fledge_error_and_explains_itself(kind):
    assert issubclass(kind, FledgeError)
    assert kind.__doc__


def test_the_root_is_no_bug_of_ours():
    assert FledgeError.__bases__ == (Exception,)


def test_an_unknown_name_is_quoted_beside_the_valid_ones_in_order():
    assert str(UnknownName("net", "nonet", ["tube", "none"])) == "unknown net 'nonet': valid are none, tube"


def test_a_number_out_of_range_comes_with_the_range():
    assert str(OutOfRange("height [m]", -1.0, "a positive number")) == (
        "height [m] is -1.0: valid is a positive number"
    )


def test_a_bad_file_is_named():
    assert str(BadFile("a/b.mcap", "truncated")) == "a/b.mcap: truncated"


@pytest.mark.parametrize(
    "error",
    (
        UnknownName("pilot", "x", ["a"]),
        OutOfRange("speed", 3, "0 to 1 m/s"),
        BadFile("f", "no such file"),
        ContractMismatch("trained at 20 Hz, to fly at 10 Hz"),
    ),
)
def test_a_message_is_one_line_and_caught_by_the_root(error):
    with pytest.raises(FledgeError) as caught:
        raise error
    assert len(str(caught.value).splitlines()) == 1
