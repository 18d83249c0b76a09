"""A live flight is the simulator's own; people may act in every tick, and what they demonstrate is data to train on."""

from dataclasses import replace

import jax
import numpy as np
import pytest
from ticks import decision

from fledge.camera import look
from fledge.cockpit.asks import Sticks
from fledge.cockpit.flight import Choice, Live, Person
from fledge.cockpit.scene import PERSON, commander
from fledge.cockpit.seat import HANDS_OFF, Seats, Spoken
from fledge.engines import fly_plain
from fledge.learning.demonstrations import of_flights
from fledge.manoeuvres import Climb, FixedAltitude
from fledge.observation import Action, Axes, StickScale
from fledge.pilots import HumanModel, Servo
from fledge.safety import NoNet, StopTube
from fledge.simulation import TICK, TICKS_PER_ROW, Case, Crew, Rig, flight_key
from fledge.supervision.inputs import Operator
from fledge.supervision.modes import Mode
from fledge.world import Reason

pytestmark = pytest.mark.slow

M = Mode
SILENCE = Seats().silence
FULL = Action(0.5, 0.5, 0.5, 0.5)


class Flown:
    """A flight, somebody at the sticks, and what was shown."""

    def __init__(self, pilot=Servo(), manoeuvre=FixedAltitude(), net=NoNet(), rows=40):
        self.live = Live.draw(Choice(manoeuvre, pilot, net, "some-net", rows, seed=3, number=1))
        self.memory = self.live.init()
        self.shown = []

    def go(self, seconds, vehicle=0, action=HANDS_OFF, silent=0.0, **says):
        """So much later; `silent` is how long nothing has been heard at its end, all the time before at its begin."""
        ticks = round(seconds / TICK)
        for i in range(ticks):
            quiet = silent and (i + 1) * TICK
            lost = quiet > SILENCE
            arm = says.get("arm", 1.0)
            operators = [Operator(arm=arm)] * 4
            if not lost:
                command = StickScale().command(action)
                deflection = max(abs(x) for x in (action.forward, action.left, action.up, action.turn))
                operators[vehicle] = replace(Operator(command, deflection), **({"arm": arm} | says))
            said = Spoken(tuple(operators), HANDS_OFF if lost else action, quiet, lost)
            self.memory, shown = self.live.tick(self.memory, said)
            self.shown.append(shown)
        return self

    @property
    def modes(self):
        return [Mode(int(decision.mode)) for decision in self.shown[-1].decisions]

    @property
    def speed(self):
        v = self.shown[-1].world.uav.velocity
        return float(np.linalg.norm((v.x, v.y, v.z)))

    def episode(self):
        """The pilot's rows, together."""
        rows = [shown.row for shown in self.shown if shown.flown]
        return jax.tree.map(lambda *leaves: np.array(leaves), *rows)


def aloft(*args, **kwargs) -> Flown:
    return Flown(*args, **kwargs).go(1.5, arm=0.0)


@pytest.mark.parametrize("pilot", (Servo(), HumanModel()), ids=lambda pilot: pilot.name)
@pytest.mark.parametrize("net", (NoNet(), StopTube()), ids=lambda net: type(net).__name__)
def test_a_live_flight_is_the_simulators(pilot, net):
    rows, manoeuvre = 40, FixedAltitude()
    flown = aloft(pilot, manoeuvre, net, rows).go(rows / 20.0)
    key = flight_key(3, "demonstration", manoeuvre.name, 1)
    crew = Crew(pilot.for_axes(manoeuvre.axes), Axes.of(manoeuvre.axes), net)
    alone = fly_plain(Case.draw(manoeuvre, key, rows), crew, (*key, 1))
    paths = jax.tree_util.tree_flatten_with_path(flown.episode())[0]
    for (path, live), plain in zip(paths, jax.tree.leaves(alone), strict=True):
        name = jax.tree_util.keystr(path)
        if not name.endswith((".t", ".stamp")):
            np.testing.assert_allclose(live, plain, rtol=1e-9, atol=1e-9, err_msg=name)
    assert flown.memory.way == rows and flown.shown[-1].over


def test_a_tick_is_a_pure_function():
    flown = aloft().go(0.52)
    said = Spoken((Operator(arm=1.0),) * 4, HANDS_OFF, 0.0, False)
    assert flown.live.tick(flown.memory, said) == flown.live.tick(flown.memory, said)


def test_nothing_moves_until_somebody_arms():
    flown = Flown()
    begin = flown.memory.world
    flown.go(2.0, arm=0.0)
    now = flown.shown[-1].world
    assert now.uav == replace(begin.uav, stamp=now.t)
    assert now.ugvs == tuple(replace(ugv, stamp=now.t) for ugv in begin.ugvs)
    assert flown.modes == [M.READY] * 4 and flown.shown[-1].commanders == ("nobody",) * 4
    assert now.t == pytest.approx(2.0)
    flown.go(0.5)
    assert flown.modes == [M.AUTO] * 4


def test_a_switch_that_was_set_from_the_start_arms_nothing():
    assert Flown().go(2.0).modes == [M.INIT] * 4


def test_what_a_person_demonstrates_is_data_of_the_manoeuvres_axes():
    flown = aloft(Person(), Climb()).go(1.0, action=FULL)
    flight = replace(flown.live.about, episode=flown.episode())
    assert (flight.pilot, flight.net, flight.manoeuvre, flight.seed, flight.case) == (
        *("person", "some-net", "climb", 3, 1),
    )
    data = of_flights([flight])
    states, actions = data.episodes[0]
    assert states.shape == (20, 11)
    np.testing.assert_array_equal(actions, np.full((20, 1), 0.5))
    said, proposed = flight.episode.action, flight.episode.proposed.uav
    assert not np.any([said.forward, said.left, said.turn, proposed.forward, proposed.left])
    np.testing.assert_allclose(proposed.up, 0.5 * StickScale().vertical)
    assert not np.any(flight.episode.verdicts[0].intervened)
    assert flown.shown[-1].commanders == ("person", "guidance", "guidance", "guidance")


def test_a_persons_sticks_count_in_the_next_tick_and_a_row_has_their_mean():
    flown = aloft(Person(), FixedAltitude()).go(1.0).go(0.02).go(0.03, action=FULL)
    sent = [shown.decisions[0].verdict.command for shown in flown.shown[-5:]]
    full = FULL.forward * StickScale().horizontal
    assert [command.forward for command in sent] == pytest.approx([0.0, 0.0, full, full, full])
    row = flown.shown[-1].row
    assert row.action.forward == row.action.left == pytest.approx(0.6 * FULL.forward)
    assert row.action.up == row.action.turn == 0.0
    assert row.proposed.uav == StickScale().command(row.action)


def test_a_person_who_falls_silent_hovers_and_goes_on():
    flown = aloft(Person(), FixedAltitude()).go(1.5, action=FULL)
    fast = flown.speed
    flown.go(2.5, action=FULL, silent=True)
    assert fast > 0.3 and flown.speed < 0.15
    assert flown.modes[0] is M.HOLD and flown.shown[-1].commanders[0] == "nobody"
    held = [shown for shown in flown.shown if Mode(int(shown.decisions[0].mode)) is M.HOLD]
    first = held[0].world.t - 3.0
    assert SILENCE <= first <= 0.6
    lost = [shown for shown in flown.shown if shown.row and shown.world.t > 3.0 + SILENCE + 0.06]
    assert lost and not any(shown.flown for shown in lost)
    way = flown.memory.way
    flown.go(4.0, action=FULL)
    assert flown.modes[0] is M.AUTO and flown.shown[-1].flown
    assert flown.memory.way > way


def test_taking_over_and_handing_back():
    flown = aloft(net=StopTube(), rows=400).go(1.0).go(1.0, action=Action(0.0, 0.0, 0.6, 0.0))
    assert flown.modes[0] is M.MANUAL and flown.shown[-1].commanders[0] == "person"
    assert flown.modes[1:] == [M.AUTO] * 3
    assert flown.shown[-1].world.uav.velocity.z > 0.15
    assert not flown.shown[-1].flown and flown.shown[-1].row is not None
    flown.go(0.2, hand_back=1.0)
    assert flown.modes[0] is M.RECOVER
    flown.go(1.2)
    assert flown.modes[0] is M.AUTO and flown.shown[-1].flown


def test_who_flies_by_hand_and_falls_silent_is_stopped():
    flown = aloft(rows=400).go(0.5).go(0.5, action=FULL)
    assert flown.modes[0] is M.MANUAL
    flown.go(0.6, action=FULL, silent=True)
    assert flown.modes[0] is M.STOPPED
    assert Reason(int(flown.shown[-1].decisions[0].verdict.reason)) is Reason.LINK_LOST


HELD = {"reason": Reason.WALL}
BY_HAND = {"reason": Reason.TAKE_OVER}


@pytest.mark.parametrize(
    ("mode", "held", "vehicle", "by_person", "who"),
    [
        (M.AUTO, {}, 0, False, "pilot"),
        (M.AUTO, {}, 0, True, PERSON),
        (M.AUTO, {}, 2, True, "guidance"),
        (M.SHIELDED, {}, 0, False, "pilot"),
        (M.SHIELDED, HELD, 0, True, "net"),
        (M.SHIELDED, HELD, 1, False, "net"),
        (M.RECOVER, {"reason": Reason.RECOVERING}, 0, False, "pilot"),
        (M.MANUAL, BY_HAND, 0, False, PERSON),
        (M.MANUAL, BY_HAND, 3, False, PERSON),
        (M.MANUAL, HELD, 0, True, "net"),
        *((mode, BY_HAND, 0, True, "nobody") for mode in (M.INIT, M.READY, M.HOLD, M.STOPPED, M.LAND)),
    ],
)
def test_who_is_said_to_fly(mode, held, vehicle, by_person, who):
    assert commander(vehicle, decision(mode, **held), by_person) == who


def test_where_it_would_come_to_rest_is_what_its_net_says():
    still = aloft(net=StopTube())
    uav, *ugvs = still.live.halts(still.memory)
    place = still.memory.world.uav.position
    assert (uav.x, uav.y) == pytest.approx((place.x, place.y))
    assert len(ugvs) == 3 and still.live.net == StopTube()
    unguarded = aloft()
    assert unguarded.live.halts(unguarded.memory) == ()


def test_any_vehicle_can_be_stopped():
    flown = aloft(rows=400).go(1.0).go(0.5, vehicle=2, stop=1.0)
    assert flown.modes == [M.AUTO, M.AUTO, M.STOPPED, M.AUTO]


def test_a_landed_uav_rests():
    flown = aloft(rows=400).go(0.5).go(0.1, land=1.0)
    assert flown.modes[0] is M.LAND
    flown.go(15.0)
    assert flown.modes[0] is M.INIT and flown.speed == 0.0
    belly = flown.shown[-1].world.uav.position.z - flown.live.rig.uav.half_height
    assert belly < 0.05


def test_a_row_has_five_ticks():
    flown = aloft().go(0.5)
    rows = [i for i, shown in enumerate(flown.shown) if shown.row is not None]
    assert {b - a for a, b in zip(rows, rows[1:], strict=False)} == {TICKS_PER_ROW}


def test_from_a_page_to_the_vehicle_and_a_closed_tab():
    seats, flown, t = Seats(), Flown(Person(), Climb(), rows=400), 0.0
    seat = seats.ask(seats.join(seats.init(), 7), 7, t)

    def go(seconds, seat, t, talks=True, **says):
        for _ in range(round(seconds / TICK)):
            t += TICK
            if talks and round(t / TICK) % 2 == 0:
                sticks = Sticks(round(t / TICK), 1e3 * t, 0, (0.0, 0.0, 0.8, 0.0), **says)
                seat = seats.hear(seat, 7, sticks, t)
            flown.memory, shown = flown.live.tick(flown.memory, seats.say(seat, t))
            flown.shown.append(shown)
        return seat, t

    seat, t = go(1.0, seat, t, talks=False)
    assert flown.modes == [M.INIT] * 4
    seat, t = go(1.5, seat, t)
    seat, t = go(1.5, seat, t, arm=True)
    assert flown.modes[0] is M.AUTO and flown.shown[-1].flown and flown.speed > 0.2
    seat, t = go(2.0, seats.leave(seat, 7, t), t, talks=False)
    assert flown.modes[0] is M.HOLD and flown.speed < 0.1
    seat, t = go(10.0, seat, t, talks=False)
    assert flown.modes[0] is M.LAND


def test_what_a_person_saw_is_what_there_was_to_be_seen():
    """Whatever delay and noise the scene has for others: recorded is the picture as it was when the row began."""
    rig = Rig()
    for pilot, exact in ((Person(), True), (Servo(), False)):
        episode = aloft(pilot).go(1.0).episode()
        picture = look(rig.lens, episode.world)
        apart = np.abs(episode.observation.ugv_u - picture.u).max()
        assert (apart < 1e-6) == exact
