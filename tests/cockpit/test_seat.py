"""One operator at a time; what is old, late or too much does not count; who falls silent lets go."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fledge.cockpit.asks import Sticks
from fledge.cockpit.seat import HANDS_OFF, Dropped, Seats
from fledge.observation import Action
from fledge.supervision.inputs import HOVER, Operator

SEATS = Seats()


def sticks(sequence, t, vehicle=0, axes=(0.5, 0.0, 0.0, 0.0), **flags) -> Sticks:
    """From a page whose clock began 1,000 s before the server's."""
    return Sticks(sequence, 1e3 * (t + 1000.0), vehicle, axes, **flags)


def seated(*clients, t=0.0):
    """Clients who all want the seat, in this order."""
    memory = SEATS.init()
    for client in clients:
        memory = SEATS.ask(SEATS.join(memory, client), client, t)
    return memory


def hear(memory, *heard, client=1):
    for one, t in heard:
        memory = SEATS.hear(memory, client, one, t)
    return memory


# --- whose it is --------------------------------------------------------------------------------------------------

CLIENT = st.integers(0, 3)
DEED = st.one_of(
    st.tuples(
        st.sampled_from(("join", "leave", "ask", "give_up", "hear", "tick")), CLIENT, st.floats(0.0, 12.0)
    ),
)


def done(memory, deed, client, t, number):
    if deed == "join":
        return SEATS.join(memory, client)
    if deed == "hear":
        return SEATS.hear(memory, client, sticks(number, t), t)
    if deed == "tick":
        return SEATS.tick(memory, t)
    return getattr(SEATS, deed)(memory, client, t)


@pytest.mark.slow
@given(st.lists(DEED, max_size=40))
@settings(max_examples=300)
def test_never_two_have_the_seat_and_what_counts_is_its_holders(deeds):
    memory, t = SEATS.init(), 0.0
    for number, (deed, client, later) in enumerate(deeds):
        t += later
        before, memory = memory, done(memory, deed, client, t, number)
        assert memory.holder is None or memory.holder in memory.clients
        assert memory.holder not in memory.waiting and len(set(memory.waiting)) == len(memory.waiting)
        assert set(memory.waiting) <= set(memory.clients)
        assert memory.holder is not None or not memory.waiting
        if memory.sticks is not None and memory.sticks is not before.sticks:
            assert deed == "hear" and client == memory.holder
        if memory.holder is None or memory.holder != before.holder:
            assert SEATS.say(memory, t).action == HANDS_OFF or memory.sticks is not before.sticks


def test_who_asks_waits_and_gets_it_when_it_is_given_up():
    memory = seated(1, 2, 3)
    assert (memory.holder, memory.waiting) == (1, (2, 3))
    memory = SEATS.give_up(memory, 1, 1.0)
    assert (memory.holder, memory.waiting) == (2, (3,))
    memory = SEATS.leave(memory, 2, 2.0)
    assert (memory.holder, memory.waiting, memory.clients) == (3, (), (1, 3))


def test_who_stops_waiting_gets_nothing():
    memory = SEATS.give_up(seated(1, 2), 2, 0.5)
    assert SEATS.give_up(memory, 1, 1.0).holder is None


def test_a_silent_holder_loses_it_to_who_waits_and_to_nobody_else():
    memory = hear(seated(1, 2), (sticks(0, 1.0), 1.0))
    assert SEATS.tick(memory, 1.0 + SEATS.patience).holder == 1
    assert SEATS.tick(memory, 1.1 + SEATS.patience).holder == 2
    alone = hear(seated(1), (sticks(0, 1.0), 1.0))
    assert SEATS.tick(alone, 1e4).holder == 1


def test_a_stranger_gets_no_seat():
    assert SEATS.ask(SEATS.init(), 5, 0.0).holder is None


def test_a_change_of_hands_lets_go_and_disarms_nothing():
    memory = hear(seated(1, 2), (sticks(0, 1.0, arm=True), 1.0))
    spoken = SEATS.say(SEATS.give_up(memory, 1, 1.1), 1.1)
    assert spoken.operators == (Operator(arm=1.0),) * 4 and spoken.action == HANDS_OFF


# --- what counts --------------------------------------------------------------------------------------------------


def test_sticks_become_one_operator_and_all_are_armed():
    memory = hear(seated(1), (sticks(0, 1.0, axes=(0.5, 0.0, -1.0, 0.2), switch=True, arm=True), 1.0))
    spoken = SEATS.say(memory, 1.2)
    uav, *ugvs = spoken.operators
    command = SEATS.scale.command(Action(0.5, 0.0, -1.0, 0.2))
    assert uav == Operator(command, deflection=1.0, switch=1.0, arm=1.0)
    assert ugvs == [Operator(arm=1.0)] * 3
    assert spoken.action == Action(0.5, 0.0, -1.0, 0.2)
    assert (spoken.silent, spoken.lost) == (pytest.approx(0.2), False)


def test_sticks_of_a_ugv_say_nothing_of_the_uav():
    memory = hear(
        seated(1), (sticks(0, 1.0, switch=True, arm=True), 1.0), (sticks(1, 1.1, vehicle=2, arm=True), 1.1)
    )
    spoken = SEATS.say(memory, 1.1)
    assert [operator.deflection for operator in spoken.operators] == [0.0, 0.0, 0.5, 0.0]
    assert spoken.operators[0] == Operator(arm=1.0) and spoken.action == HANDS_OFF


def test_whoever_falls_silent_lets_go():
    memory = hear(seated(1), (sticks(0, 1.0, dead_man=True, switch=True, arm=True), 1.0))
    assert not SEATS.say(memory, 1.0 + SEATS.silence).lost
    spoken = SEATS.say(memory, 1.01 + SEATS.silence)
    assert spoken.lost and spoken.action == HANDS_OFF
    assert spoken.operators == (Operator(arm=1.0),) * 4
    assert spoken.operators[0].command == HOVER


@pytest.mark.slow
@given(st.lists(st.tuples(st.integers(0, 20), st.floats(0.01, 0.3)), max_size=40))
def test_sequence_numbers_that_count_only_go_up(messages):
    memory, t, counted = seated(1), 0.0, []
    for sequence, later in messages:
        t += later
        before, memory = memory, SEATS.hear(memory, 1, sticks(sequence, t), t)
        if memory.sticks is not before.sticks:
            counted.append(sequence)
    assert counted == sorted(set(counted))
    assert memory.dropped == Dropped(replayed=len(messages) - len(counted))


def test_what_a_frozen_tab_sends_when_it_wakes_up_does_not_count():
    memory = hear(seated(1), (sticks(0, 1.0), 1.0))
    memory = hear(memory, *((sticks(n, 1.0 + 0.02 * n), 3.0) for n in range(1, 20)))
    assert memory.dropped.late == 19 and memory.sticks.sequence == 0
    assert SEATS.say(memory, 3.0).lost
    memory = hear(memory, (sticks(30, 3.0), 3.01))
    assert memory.sticks.sequence == 30


def test_a_page_whose_clock_stood_still_is_late_until_it_takes_the_seat_anew():
    memory = hear(seated(1), (sticks(0, 1.0), 1.0), (sticks(1, 1.1), 20.0))
    assert memory.dropped.late == 1
    memory = hear(SEATS.ask(memory, 1, 20.1), (sticks(2, 1.2), 20.1))
    assert memory.sticks.sequence == 2


@pytest.mark.parametrize("skew", (-1e-4, 1e-4))
def test_clocks_that_differ_a_little_never_make_anybody_late(skew):
    memory = seated(1)
    for n in range(10_000):
        memory = SEATS.hear(memory, 1, sticks(n, n * (1.0 + skew)), float(n))
    assert memory.dropped == Dropped()


def test_a_flood_is_cut_down_to_the_rate():
    memory = seated(1)
    for n in range(10_000):
        memory = SEATS.hear(memory, 1, sticks(n, n * 1e-4), n * 1e-4)
    assert 10_000 - memory.dropped.flooded == pytest.approx(SEATS.rate + SEATS.burst, abs=2)


def test_spectators_and_strange_vehicles_are_counted():
    memory = hear(seated(1, 2), (sticks(0, 1.0), 1.0), client=2)
    memory = hear(memory, (sticks(0, 1.0, vehicle=4), 1.0))
    assert memory.sticks is None and memory.dropped == Dropped(spectators=1, strange=1)
