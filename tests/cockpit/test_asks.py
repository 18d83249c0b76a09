"""What a page may say: a record for each kind, with a reader and a word of documentation for each field."""

from dataclasses import MISSING, fields

import pytest

from fledge.cockpit.asks import LARGEST_SEED, Fly, Sticks, Train
from fledge.cockpit.messages import FROM_PAGE, decode
from fledge.commands.options import LARGEST_SEED as TYPED
from fledge.lab import Malformed
from fledge.lab.wire.fields import plain
from fledge.supervision.inputs import Operator


@pytest.mark.parametrize("kind", FROM_PAGE.values(), ids=FROM_PAGE)
def test_defaults_are_valid_themselves(kind):
    for one in fields(kind):
        if one.default is not MISSING:
            assert one.metadata["read"](one.name, plain(one.default)) == one.default


def test_a_person_can_say_on_the_page_all_that_an_operator_can():
    flags = {one.name for one in fields(Operator)} - {"command", "deflection"}
    assert flags <= {one.name for one in fields(Sticks)}


def test_seeds_are_those_of_the_command_line():
    assert LARGEST_SEED == TYPED
    fine = f'{{"kind":"fly","manoeuvre":"climb","pilot":"p","net":"n","seed":{LARGEST_SEED}}}'
    assert decode(fine) == Fly("climb", "p", "n", seed=LARGEST_SEED)
    assert isinstance(decode(fine.replace(str(LARGEST_SEED), str(LARGEST_SEED + 1))), Malformed)


@pytest.mark.parametrize("epochs", (0, -1, 1.5, "ten", 10**9))
def test_epochs_are_a_whole_number_or_the_recipes(epochs):
    assert decode('{"kind":"train","setup":"primitive","epochs":null}') == Train("primitive")
    said = decode(
        f'{{"kind":"train","setup":"primitive","epochs":{epochs if epochs != "ten" else chr(34) * 2}}}'
    )
    assert isinstance(said, Malformed) and "epochs" in said.why
