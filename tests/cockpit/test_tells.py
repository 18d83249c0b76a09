"""What the server may say: defaults are valid, and the words are those of the parts that say them."""

from dataclasses import MISSING, fields

import pytest

from fledge.cockpit.asks import RECORDS, WORLDS
from fledge.cockpit.messages import TO_PAGE, decode_told, encode
from fledge.cockpit.tells import FLIGHTS, LESSONS, Lesson, Seating
from fledge.errors import FledgeError
from fledge.lab.wire.fields import plain


@pytest.mark.parametrize("kind", TO_PAGE.values(), ids=TO_PAGE)
def test_defaults_are_valid_themselves(kind):
    for one in fields(kind):
        if one.default is not MISSING:
            assert one.metadata["read"](one.name, plain(one.default)) == one.default


def test_no_word_is_said_twice_in_a_list():
    for words in (RECORDS, WORLDS, FLIGHTS, LESSONS):
        assert len(set(words)) == len(words)


def test_a_word_that_there_is_not_is_not_said():
    with pytest.raises(FledgeError, match="seat is 'stolen'"):
        encode(Seating("stolen", 0))


def test_a_curve_goes_over_as_it_is():
    lesson = Lesson("running", "primitive", epoch=2, epochs=40, points=((1.0, 0.5, 0.25), (2.0, 0.25, 0.125)))
    assert decode_told(encode(lesson)) == lesson
