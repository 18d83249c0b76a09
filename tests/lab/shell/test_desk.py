"""Who sits at the sticks: what the controller hears of them, and that an order to land gets through."""

from dataclasses import replace

import pytest

from fledge.lab.control.keys import GO, LAND, TAKE_OVER, Keyboard
from fledge.lab.shell.desk import EVERY, Desk, Nobody, Typist
from fledge.lab.wire import sticks
from fledge.lab.wire.datagrams import STICKS, VICON, Datagram
from fledge.lab.wire.sticks import Sticks
from fledge.supervision.inputs import Operator

FRAME = Datagram(VICON, b"frame")


def spoken(datagrams):
    """What people say in these."""
    found = [sticks.decode(datagram.data) for datagram in datagrams if datagram.channel == STICKS]
    return [one for one in found if isinstance(one, Sticks)]


def talk(desk, ticks, came=lambda number: (), start=0):
    """What is heard in so many ticks, of people."""
    return [one for n in range(start, start + ticks) for one in spoken(desk.hear(0.01 * n, came(n)))]


def word(sequence, **flags):
    """What somebody with a wire says of four vehicles."""
    return Datagram(STICKS, sticks.encode(Sticks(sequence, 0.0, (Operator(**flags),) * 4)))


class Hand:
    """A terminal at which keys are pressed."""

    def __init__(self):
        self.gone, self.pressed = False, []

    def keys(self):
        pressed, self.pressed = self.pressed, []
        return pressed


def test_nobody_arms_once_all_is_ready_and_then_sits_still():
    desk = Desk(4, Nobody(4))
    before = talk(desk, 100)
    assert len(before) == 100 / EVERY
    assert {one.operators for one in before} == {(Operator(),) * 4}
    desk.ready = True
    after = talk(desk, 100, start=100)
    assert {one.operators for one in after} == {(Operator(arm=1.0),) * 4}
    numbers = [one.sequence for one in before + after]
    assert numbers == sorted(set(numbers))


def test_keys_are_heard():
    hand = Hand()
    desk = Desk(4, Typist(Keyboard(4), hand))
    desk.ready = True
    hand.pressed = [GO]
    assert talk(desk, 1)[0].operators == (Operator(arm=1.0),) * 4
    hand.pressed = [TAKE_OVER, "w"]
    said = talk(desk, EVERY, start=1)[0].operators[0]
    assert said.switch == 1.0 and said.command.forward > 0.0


def test_an_early_go_is_not_heard():
    """Arming has to be seen unset after all is ready, else the supervisor waits for ever."""
    hand = Hand()
    desk = Desk(4, Typist(Keyboard(4), hand))
    hand.pressed = [GO, TAKE_OVER]
    (said,) = talk(desk, 1)
    assert said.operators[0].arm == 0.0 and said.operators[0].switch == 1.0


def test_who_hangs_up_is_silent():
    hand = Hand()
    desk = Desk(4, Typist(Keyboard(4), hand))
    hand.gone = True
    assert talk(desk, 20) == []


def test_whoever_has_a_wire_is_passed_on_as_they_are():
    desk = Desk(4)
    came = (FRAME, word(7, stop=1.0), Datagram(STICKS, b"nonsense"))
    assert desk.hear(0.0, came) == came
    assert desk.hear(0.01, ()) == ()


def test_the_order_to_land_is_said_for_everybody():
    for device in (None, Nobody(4)):
        desk = Desk(4, device)
        desk.landing = True
        said = talk(desk, 20, lambda n: (FRAME, word(100 + n, arm=1.0, stop=1.0)) if n % 2 else (FRAME,))
        assert len(said) == 20 / EVERY
        assert all(operator.land == 1.0 for one in said for operator in one.operators)


def test_it_needs_nobody_to_be_there():
    desk = Desk(4)
    desk.landing = True
    said = talk(desk, 10)
    assert {one.operators for one in said} == {(Operator(arm=1.0, land=1.0),) * 4}


def test_other_datagrams_pass_as_before():
    desk = Desk(4, Nobody(4))
    desk.landing = True
    for n in range(10):
        assert FRAME in desk.hear(0.01 * n, (FRAME, word(n)))


def test_a_landing_can_still_be_taken_over():
    """As long as the switch is on, and no longer."""
    desk = Desk(4)
    desk.landing = True
    by_hand = replace(Operator(), switch=1.0, arm=1.0)
    said = talk(desk, 50, lambda n: (word(n, switch=1.0, arm=1.0),))
    assert {one.operators[0] for one in said[1:]} == {by_hand}
    said = talk(desk, 50, lambda n: (word(n, arm=1.0),), start=50)
    assert all(one.operators[0].land == 1.0 for one in said)


def test_who_falls_silent_with_the_switch_on_is_landed():
    desk = Desk(4)
    desk.landing = True
    talk(desk, 10, lambda n: (word(n, switch=1.0),))
    later = talk(desk, 100, start=10)
    assert later[0].operators[0].switch == 1.0
    assert all(one.operators[0].land == 1.0 and one.operators[0].switch == 0.0 for one in later[12:])


@pytest.mark.parametrize("before", [0, 5, 10**6])
def test_an_order_is_no_older_than_what_was_said_before_it(before):
    """The controller drops what has no larger number."""
    desk = Desk(4)
    desk.hear(0.0, (word(before),))
    desk.landing = True
    numbers = [one.sequence for one in talk(desk, 50, lambda n: (word(before + 1 + n),), start=1)]
    assert numbers == sorted(set(numbers)) and numbers[0] > before


def test_the_key_for_landing_does_the_same():
    hand = Hand()
    desk = Desk(4, Typist(Keyboard(4), hand))
    hand.pressed = [LAND]
    assert talk(desk, 1)[0].operators[0].land == 1.0
