"""What the controller knows of people."""

import pytest

from fledge.geometry import Vec3
from fledge.lab.control.hands import Hands
from fledge.lab.control.joy import Gamepad
from fledge.lab.wire import sticks, topics
from fledge.lab.wire.datagrams import STICKS, VICON, Datagram
from fledge.lab.wire.messages import Header, Joy, Twist
from fledge.lab.wire.sticks import Sticks
from fledge.supervision.inputs import Operator

HANDS = Hands(Gamepad(2))
STOP = (Operator(stop=1.0), Operator(arm=1.0))
GO = (Operator(arm=1.0), Operator(arm=1.0))


def says(sequence, operators=GO) -> Datagram:
    return Datagram(STICKS, sticks.encode(Sticks(sequence, 0.0, operators)))


def hear(*datagrams, memory=None, every=0.02):
    """The memory after datagrams that come one by one."""
    memory = memory or HANDS.init()
    for i, datagram in enumerate(datagrams, start=1):
        memory = HANDS.hear(memory, i * every, datagram)
    return memory


def test_nobody_says_nothing_and_was_never_heard():
    memory = HANDS.init()
    assert memory.operators == (Operator(), Operator())
    assert 1e9 - memory.heard > 1e9


def test_the_last_word_counts():
    memory = hear(says(1), says(2, STOP))
    assert (memory.operators, memory.heard) == (STOP, 0.04)


@pytest.mark.parametrize("late", [0, 1, 2])
def test_what_is_late_or_said_twice_is_no_news(late):
    memory = hear(says(1), says(2, STOP))
    assert HANDS.hear(memory, 0.06, says(late)) == memory


def test_a_device_that_has_started_again_is_heard_after_a_silence():
    memory = hear(says(5000, STOP))
    assert HANDS.hear(memory, 0.3, says(1)) == memory
    memory = HANDS.hear(memory, 0.02 + HANDS.anew + 0.01, says(2))
    assert (memory.operators, memory.sequence) == (GO, 2)


@pytest.mark.parametrize(
    "bad", [Datagram(STICKS, b"{}"), says(9, STOP[:1]), says(9, (*STOP, *STOP)), Datagram(topics.JOY, b"?")]
)
def test_what_cannot_be_understood_is_said_and_changes_nothing_else(bad):
    before = hear(says(1))
    after = HANDS.hear(before, 1.0, bad)
    assert "valid is" in after.trouble
    assert after._replace(trouble="") == before
    assert HANDS.hear(after, 1.01, says(2)).trouble == ""


def test_other_wires_say_nothing():
    before = hear(says(1))
    twist = Datagram(topics.FLY, topics.encode(Twist(Vec3(1.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.0))))
    assert hear(Datagram(VICON, says(2, STOP).data), twist, memory=before) == before


def test_a_gamepad_is_an_operator_and_a_lesser_device_is_none():
    rest = (0.0,) * 8

    def pad(axes=rest, pressed=()):
        buttons = tuple(int(i in pressed) for i in range(11))
        return Datagram(topics.JOY, topics.encode(Joy(Header(), axes, buttons)))

    memory = hear(pad(), pad(pressed=(7,)), pad())
    assert [operator.arm for operator in memory.operators] == [1.0, 1.0]
    assert memory.heard == 0.06
    ahead = HANDS.hear(memory, 0.08, pad((0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)))
    assert ahead.operators[0].command.forward == HANDS.gamepad.sticks.horizontal
    small = HANDS.hear(ahead, 0.1, Datagram(topics.JOY, topics.encode(Joy(Header(), (0.0,), (0,)))))
    assert "valid is" in small.trouble
    assert small.operators == ahead.operators and small.heard == ahead.heard
