"""The geometry of stops."""

from dataclasses import replace
from math import cos, inf, nan, pi, sin

import pytest
from aloft import HALL, SPREAD, world
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fledge.dynamics import P3_DX
from fledge.geometry import Box, Heading, Vec3
from fledge.safety import Contract, UavStop, UgvStop
from fledge.safety.tube import (
    Face,
    Held,
    Pace,
    Phases,
    Sent,
    Turn,
    UavCommitment,
    UavTube,
    UgvCommitment,
    UgvMotion,
    UgvSent,
    UgvSweep,
    UgvTube,
    around_uav,
    around_ugv,
    pending,
    side_of_box,
    uav_tube,
    within,
)
from fledge.world import Obstacle, Reason, UavState, UgvState, VelocityCommand

C, UAV, UGV = Contract(), UavStop(), UgvStop.of(P3_DX)
NOTHING = Sent.nothing(C, 0.0)
STANDING = Pace(0.0, 0.0)
NO_ORDERS = UgvSent.nothing(0.0)
LASTS = UGV.hold_over + C.age + C.latency
SHARE = 0.0488


def sent(*commands: float) -> Sent:
    """A history, oldest first."""
    line = NOTHING
    for command in commands:
        line = line.then(command, SHARE)
    return line


def ordered(*speeds: float, turn: float = 0.0) -> UgvSent:
    """What a UGV was sent, oldest first."""
    line = NO_ORDERS
    for speed in speeds:
        line = line.then(C, UGV, speed, turn, C.period)
    return line


def upwards(line: Sent, periods: float) -> tuple[float, float]:
    """Of a UAV that was sent this upwards."""
    nothing, other, found = pending((NOTHING, NOTHING, line), within(periods, len(line.newest)), SHARE)
    assert nothing == other == (0.0, 0.0)
    return found


def test_commands_on_their_way_count_for_as_long_as_they_will_last():
    line = sent(0.3, 0.2, 1.0)
    assert upwards(line, 0.0)[0] == 0.0
    assert upwards(line, 1.0)[0] == pytest.approx(1.0)
    assert upwards(line, 2.5)[0] == pytest.approx(1.0 + 0.2 + 0.15)
    assert upwards(line, 99.0)[0] == pytest.approx(1.5)


def test_a_filter_follows_what_has_acted_already():
    steady = sent(*[0.8] * 200)
    assert upwards(steady, 10.0)[1] == pytest.approx(0.8, abs=0.01)
    assert upwards(sent(*[0.0] * 50, *[1.0] * 3), 3.0)[1] == 0.0


def test_a_filter_remembers_beyond_its_line():
    line = sent(1.0, *[0.0] * 12)
    assert 0.0 < upwards(line, 0.0)[1] < SHARE


@given(st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=200))
@example([1.0] + [0.9] * 60)  # the largest lasts shortest
@example([1.0] + [0.5] * 60 + [0.4] * 20)  # it is over, and those that came after it go on
def test_what_is_held_bounds_whatever_may_still_be_gone_on_with(commands):
    held = Held.nothing(0.0)
    for command in commands:
        held = held.then(command, C.period, LASTS)
    delay = C.age + C.latency
    for age, command in enumerate(reversed(commands)):
        left = LASTS - age * C.period
        if left > 1e-9:
            assert held.most >= command
            assert held.way(delay, UGV.hold_over) >= command * (left - delay) - 1e-9
    assert held.most <= max(0.0, *commands)


def test_a_stop_is_over_once_nothing_older_can_be_gone_on_with():
    ticks = round(LASTS / C.period)
    going, standing = ordered(*[0.4] * 50, *[0.0] * (ticks - 2)), ordered(*[0.4] * 50, *[0.0] * (ticks + 2))
    assert going.ahead.most == 0.4 and standing.ahead.most == 0.0


def test_what_was_sent_instead_counts_as_sent():
    assert ordered(0.1).then(C, UGV, -0.3, 0.2, 0.0) == ordered(0.1)._replace(
        astern=Held(0.3, LASTS, 0.0), left=Held(0.2, LASTS, 0.0)
    )


def test_who_was_told_to_stop_may_not_have_heard_it():
    """Nothing but the clock ends what a UGV goes on with."""
    ugv = UgvState(0.0, 0.0, 0.0, 0.4, 0.0, 0.0)
    told = [ordered(*[0.4] * 80, *[0.0] * n) for n in (0, 1, 30)]
    go, *stops = (UgvMotion.of(C, UGV, ugv, one, C.age).committed().tube for one in told)
    assert go.ahead == pytest.approx(UgvMotion.of(C, UGV, ugv, told[0], C.age).told(0.4, 0.0).ahead)
    assert [go.ahead - stop.ahead for stop in stops] == pytest.approx([0.4 * 0.01, 0.4 * 0.3])


@pytest.mark.parametrize("way", (1.0, -1.0))
def test_so_it_is_with_a_turn(way):
    rate = 0.5
    ugv = UgvState(0.0, 0.0, 0.0, 0.0, way * rate, 0.0)
    turned = ordered(*[0.0] * 80, turn=way * rate).then(C, UGV, 0.0, 0.0, C.period)
    still = ordered(*[0.0] * 80)
    (to, fro), (to_still, fro_still) = (
        UgvMotion.of(C, UGV, ugv, one, 0.0).committed().tube.turn[:: int(way)] for one in (turned, still)
    )
    reacting = UGV.turn_acceleration * (C.latency + C.period)
    chasing = min(rate, rate + C.rate_error + reacting) - (rate + C.rate_error)
    assert chasing < 0.0, "it turns as fast as it was told already"
    assert to - to_still == pytest.approx(rate * (UGV.hold_over - C.period))
    assert fro == fro_still


@pytest.mark.parametrize("missed", (0, 1, 3, 5))
def test_a_uav_may_not_have_heard_its_newest_commands(missed):
    """It goes on with the last that it heard for 50 ms in all."""
    one, other = sent(*[0.8] * 300, *[-0.6] * missed), sent(*[-0.3] * 300, *[0.0] * missed)
    # What it really does, over what it would do if it heard all and hovered from now on.
    on, back = 0.8 * UAV.hold_over + 0.6 * C.period * missed, 0.3 * UAV.hold_over

    def unheard(x, y, z):
        rests = (Vec3(0.0, 0.0, 0.0),)
        return UavCommitment.of(UavTube(rests, 0.1, 0.1), (x, y, z), C.period, UAV.hold_over)

    tube, turned = unheard(one, other, one), unheard(other, one, other)
    assert [tube.advance(1.0, 0.0), turned.advance(0.0, 1.0)] == pytest.approx([on] * 2)
    assert [tube.advance(0.0, -1.0), turned.advance(-1.0, 0.0), turned.sink()] == pytest.approx([back] * 3)
    assert turned.sinking(0.7).sink() == pytest.approx(back + 0.7)
    if not missed:  # heard in time, it stays
        assert tube.advance(-1.0, 0.0) == tube.sink() == 0.0


def test_a_resting_uav_rests():
    tube = uav_tube(C, UAV, world().uav, (NOTHING,) * 3, STANDING, 0.0)
    assert set(tube.rests) == {Vec3(0.0, 0.0, 0.0)}
    assert tube.error > C.position_error and tube.error_up > C.position_error


def test_a_uav_under_way_goes_on_by_its_speed_and_by_what_is_pending():
    uav = world(velocity=Vec3(0.6, 0.0, -0.2)).uav
    x = sent(*[0.6] * 300)
    tube = uav_tube(C, UAV, uav, (x, NOTHING, NOTHING), STANDING, C.age)
    still = UAV.speed * 0.6 + UAV.followed * 0.6
    assert tube.rests[0].x == pytest.approx(still + 0.6 * C.age, abs=1e-3)
    assert tube.late.x == pytest.approx(still + 0.6 * (C.age + C.latency), abs=1e-3)
    assert tube.sink() == pytest.approx(0.2 * UAV.speed_up)
    assert tube.rise() == 0.0
    assert tube.advance(-1.0, 0.0) == 0.0


def test_a_ugv_that_stands_is_told_apart_from_one_that_goes_on():
    ugv = UgvState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    stop, go = (UgvMotion.of(C, UGV, ugv, NO_ORDERS, 0.0).told(v, 0.0) for v in (0.0, 0.4))
    braking = UGV.acceleration - C.disturbance
    assert go.ahead - stop.ahead == pytest.approx(
        0.4 * UGV.hold_over + (0.4**2 - 0.1**2) / (2 * braking), abs=1e-6
    )
    assert go.astern == stop.astern


def test_a_uav_misses_by_more_the_faster_it_flies_and_turns():
    def error(pace, velocity=Vec3(0.0, 0.0, 0.0)):
        return uav_tube(C, UAV, world(velocity=velocity).uav, (NOTHING,) * 3, pace, 0.0).error

    unknown = UAV.speed * C.velocity_error + UAV.tilt * C.angle_error + UAV.rate * C.rate_error
    rest = C.position_error + unknown + UAV.error
    assert error(Pace(1.2, 0.0)) == pytest.approx(rest + 1.2 * UAV.error_speed)
    assert error(Pace(1.2, 1.0)) == pytest.approx(rest + 1.2 * (UAV.error_speed + UAV.error_turn))
    # However it came to be that fast.
    assert error(Pace(0.3, 0.5), Vec3(0.0, -1.2, 0.0)) == pytest.approx(error(Pace(1.2, 0.5)))
    assert error(Pace(0.0, 1.0)) == C.position_error + UAV.hold, "on the spot it may turn as it likes"


def test_a_pace_fades_and_is_raised_at_once():
    pace = Pace(1.0, 0.4).then(0.3, -0.4, -0.8, 0.1)
    assert pace == pytest.approx((0.9, 0.8))
    assert pace.then(0.0, -1.2, 0.0) == (1.2, 0.8)


@pytest.mark.parametrize("way", (1.0, -1.0))
def test_the_way_of_a_ugv_is_reaction_and_braking_by_the_contract(way):
    """Seen 40 ms ago at 0.5 m/s, forwards or in reverse, and told to stop."""
    ugv, age = UgvState(0.0, 0.0, 0.0, way * 0.5, 0.0, 0.0), 0.04
    tube = UgvMotion.of(C, UGV, ugv, ordered(*[way * 0.5] * 20), age).told(0.0, 0.0)
    v = 0.5 + C.velocity_error
    reaction = v * (age + C.latency + C.period)
    ahead, astern = (tube.ahead, tube.astern)[:: int(way)]
    assert ahead == pytest.approx(reaction + v * v / (2.0 * (UGV.acceleration - C.disturbance)))
    assert astern == 0.0


@pytest.mark.parametrize("told", (0.0, 0.1, 0.6))
@pytest.mark.parametrize("seen", (-2.0, -0.5, 0.0, 0.5, 2.0))
def test_within_its_reach_a_ugv_stops_and_does_what_it_is_told_besides(seen, told):
    motion = UgvMotion.of(C, UGV, UgvState(0.0, 0.0, 0.0, seen, 0.0, 0.0), ordered(0.3), 0.04)
    stop, *tubes = (motion.told(forward, 0.0) for forward in (0.0, told, -told))
    farthest = [max(tube.ahead, tube.astern) for tube in (stop, *tubes)]
    braking = told * told / (2.0 * (UGV.acceleration - C.disturbance))
    assert motion.reach(told) == pytest.approx(farthest[0] + told * UGV.hold_over + braking)
    assert max(farthest) <= motion.reach(told)


@settings(max_examples=60)
@given(
    st.tuples(*[st.floats(-1.5, 1.5)] * 2),
    st.lists(st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)), max_size=8),
    st.floats(0.0, 0.2),
)
def test_whatever_it_was_told_a_ugv_stays_within_its_reach(seen, told, age):
    """Faster than it may be told, too: by a person who holds the dead-man switch."""
    orders = NO_ORDERS
    for command in told:
        orders = orders.then(C, UGV, *command, C.period)
    one = UgvCommitment(UgvMotion.of(C, UGV, UgvState(0.0, 0.0, 0.0, *seen, 0.0), orders, age))
    ways = [one.sweep.advance(cos(pi * k / 12), sin(pi * k / 12)) for k in range(24)]
    assert max(ways) <= one.reach + 1e-9


@pytest.mark.parametrize("way", (1.0, -1.0))
def test_a_ugv_may_still_chase_what_it_was_told_before(way):
    ugv = UgvState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    chasing = UgvMotion.of(C, UGV, ugv, ordered(way * 0.6, 0.0), 0.0).told(0.0, 0.0)
    resting = UgvMotion.of(C, UGV, ugv, NO_ORDERS, 0.0).told(0.0, 0.0)
    gained = C.velocity_error + UGV.acceleration * (C.latency + C.period)
    further = [(one.ahead, one.astern)[way < 0.0] for one in (chasing, resting)]
    braking = 2.0 * (UGV.acceleration - C.disturbance)
    expected = [v * (C.latency + C.period) + v * v / braking for v in (gained, C.velocity_error)]
    assert further == pytest.approx(expected)


@pytest.mark.parametrize("way", (1.0, -1.0))
def test_a_nose_swings_as_long_as_its_turning_takes_to_die_down(way):
    """Seen turning at 0.5 rad/s, told to turn on at 0.4."""
    ugv, reaction = UgvState(0.0, 0.0, 0.0, 0.0, way * 0.5, 0.0), C.latency + C.period
    to, fro = UgvMotion.of(C, UGV, ugv, NO_ORDERS, 0.0).told(0.0, way * 0.4).turn[:: int(way)]
    turning = 0.5 + C.rate_error
    swing = turning * (reaction + turning / (2.0 * UGV.turn_acceleration)) + 0.4 * UGV.hold_over
    assert to == pytest.approx(C.angle_error + swing)
    assert fro == C.angle_error


def test_a_nose_may_still_chase_a_turn_it_was_told_before():
    ugv, reaction = UgvState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), C.latency + C.period
    told = NO_ORDERS.then(C, UGV, 0.0, 1.5, C.period).then(C, UGV, 0.0, 0.0, C.period)
    turning = C.rate_error + UGV.turn_acceleration * reaction
    swing = turning * (reaction + turning / (2.0 * UGV.turn_acceleration))
    assert UgvMotion.of(C, UGV, ugv, told, 0.0).told(0.0, 0.0).turn.left == pytest.approx(
        C.angle_error + swing
    )


def hovering(uav: UavState) -> tuple[UavStop, UavState, UavCommitment]:
    """A UAV as UGVs see it that was told nothing yet."""
    tube = uav_tube(C, UAV, uav, (NOTHING,) * 3, STANDING, 0.0)
    return UAV, uav, UavCommitment.of(tube, (NOTHING,) * 3, C.period, UAV.hold_over)


def face_of_another(x: float, reach: float) -> tuple[Face, UgvCommitment]:
    """What a UGV at the origin sees of one that drives towards it from x [m], and what that is committed to."""
    me, other = (
        UgvMotion.of(C, UGV, state, ordered(0.3), 0.0)
        for state in (UgvState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), UgvState(x, 0.0, pi, 0.3, 0.0, 0.0))
    )
    commitment = UgvCommitment(other)
    (face,) = around_ugv(C, me, reach, HALL, (commitment,), hovering(world().uav)).faces
    assert face.gap == pytest.approx(x - 2.0 * UGV.radius)
    return face, commitment


def test_another_ugv_is_as_near_as_its_own_stop_may_bring_it():
    face, other = face_of_another(1.5, reach=0.45)
    assert face.room == pytest.approx(face.gap - 2.0 * C.position_error - other.sweep.tube.ahead)


def test_one_that_it_cannot_meet_counts_with_all_its_reach():
    face, other = face_of_another(1.5, reach=0.0)
    assert face.room == pytest.approx(face.gap - 2.0 * C.position_error - other.reach)
    assert face.room > 0.0 and "sweep" not in vars(other)


@pytest.mark.parametrize("angle", (0.0, 0.5, 2.0))
def test_a_ugv_goes_along_its_nose_as_far_as_it_may_turn(angle):
    tube = UgvTube(Heading.of(angle), 1.0, 0.2, Turn(left=0.6, right=0.15))

    def advance(a: float) -> float:
        x, y = cos(angle + a), sin(angle + a)
        return tube.along(tube.shares(x, y))

    assert [advance(0.0), advance(pi)] == pytest.approx([1.0, 0.2])
    assert [advance(pi / 2), advance(-pi / 2)] == pytest.approx([0.6, 0.15]), (
        "a nose leads farther than a tail"
    )
    assert advance(1.9) == pytest.approx(cos(1.9) + 0.6 * sin(1.9))
    tube = tube._replace(ahead=0.0)
    assert [advance(pi / 2), advance(-pi / 2)] == pytest.approx([0.2 * 0.15, 0.2 * 0.6]), "a tail goes right"


@pytest.mark.parametrize("angle", (0.0, 0.5, 2.0))
def test_what_a_ugv_is_committed_to_it_turns_from_by_and_by(angle):
    tube = UgvTube(Heading.of(angle), 1.0, 0.2, Turn(left=0.6, right=0.15))
    going = UgvSweep(tube, Turn(0.3, 0.1), Turn(0.4, 0.12))

    def advance(a: float) -> float:
        return going.advance(cos(angle + a), sin(angle + a))

    assert [advance(0.0), advance(pi)] == pytest.approx([1.0, 0.2])
    assert [advance(pi / 2), advance(-pi / 2)] == pytest.approx([0.3, 0.1])
    a = pi / 2 + 0.35
    assert advance(a) == pytest.approx(cos(a) + 0.6 * sin(a)), "what leads away takes off what its end does"
    a = pi / 2 + 0.01
    assert advance(a) == pytest.approx(0.3 * sin(a)), "but not what it does on average"
    going = going._replace(tube=tube._replace(ahead=0.0))
    assert [advance(pi / 2), advance(-pi / 2)] == pytest.approx([0.2 * 0.12, 0.2 * 0.4]), "a tail goes right"


def test_a_nose_turns_by_and_by():
    """Half of what comes first while it reacts, some while a command is gone on with, all while it brakes."""
    turn = Phases(0.0, 0.1, 0.4, 0.05)
    assert Phases(0.0, 1.0, 2.0, 3.0).turned(turn, 0.2) == pytest.approx(
        (0.05 + 2.0 * 0.3 + 3.0 * 0.55) / 6.0
    )


EXACT = replace(C, velocity_error=0.0, angle_error=0.0, rate_error=0.0, disturbance=0.0)
"""Nothing hides what a stop leaves out."""
SLUGGISH = replace(UGV, turn_acceleration=1.0)


def full(most):
    return st.floats(-most, most)


@pytest.mark.parametrize(
    ("contract", "stop"),
    ((C, UGV), (EXACT, UGV), (EXACT, SLUGGISH)),
    ids=("with errors", "without", "turning dies slowly"),
)
@given(
    seen=st.tuples(full(0.8), full(1.5)),
    before=st.tuples(full(0.8), full(1.5)),
    told=st.tuples(full(0.8), full(1.5)),
    late=st.floats(0.0, C.latency),
    heard=st.floats(0.0, UGV.hold_over),
)
@example((0.8, 1.5), (0.8, 1.5), (0.8, 1.5), C.latency, UGV.hold_over)  # all there is
@example((0.8, 0.0), (0.8, 0.0), (0.8, 1.5), C.latency, UGV.hold_over)  # it begins to turn
@example((0.0, 0.0), (0.0, 0.0), (0.8, 1.5), 0.0, UGV.hold_over)  # slow before it has turned
@example((-0.8, 1.5), (-0.8, 1.5), (-0.8, 1.5), C.latency, UGV.hold_over)
@example((0.8, 1.5), (0.8, 1.5), (0.0, 1.5), C.latency, UGV.hold_over)  # told to stop, and to turn on
@example((0.8, -1.5), (0.8, -1.5), (0.0, 0.0), C.latency, 0.0)
@example((0.5, 1.5), (0.0, 0.0), (0.5, 0.0), 0.0, 0.5)  # its turning dies down while it goes on
def test_however_it_is_driven_a_ugv_goes_no_farther_than_its_tube(
    contract, stop, seen, before, told, late, heard
):
    """It chases what it was told before, hears late what it is told now, goes on with that for a while, and stops."""
    state, step = UgvState(0.0, 0.0, 0.3, *seen, 0.0), 0.01
    model = replace(
        P3_DX,
        acceleration=stop.acceleration - contract.disturbance,
        turn_acceleration=stop.turn_acceleration,
    )
    orders = NO_ORDERS
    for _ in range(20):
        orders = orders.then(contract, stop, *before, contract.period)
    motion = UgvMotion.of(contract, stop, state, orders, 0.0)
    then = orders.then(contract, stop, *told, contract.period)
    commitment = UgvMotion.of(contract, stop, state, then, 0.0).committed()
    ways = [(cos(pi * k / 12), sin(pi * k / 12)) for k in range(24)]
    tube, sweep = motion.told(*told), motion.sweep(*told)
    assert sweep.tube == tube
    farthest = [min(sweep.advance(x, y), commitment.advance(x, y)) for x, y in ways]
    for i in range(300):
        t = step * i
        v, w = before if t < late else told if t < late + heard else (0.0, 0.0)
        state = model.step(state, VelocityCommand(v, 0.0, 0.0, w), step)
        for (x, y), most in zip(ways, farthest, strict=True):
            assert state.x * x + state.y * y <= most + 1e-9


def test_sides_of_a_box_and_its_corners():
    box = Box(0.0, 2.0, 0.0, 1.0)
    assert side_of_box(box, 3.0, 0.5) == pytest.approx((1.0, 0.0, 1.0))
    nx, ny, far = side_of_box(box, 2.3, 1.4)
    assert (nx, ny, far) == pytest.approx((0.6, 0.8, 0.5))


def test_beside_or_above_is_enough():
    tall, low = Obstacle(Box(0.5, 1.0, -1.0, 1.0), 5.0), Obstacle(Box(0.5, 1.0, -1.0, 1.0), 1.0)
    for obstacle, z in ((tall, 0.0), (low, 1.0)):
        arena = replace(HALL, obstacles=(obstacle,))
        tube = uav_tube(C, UAV, world().uav, (NOTHING,) * 3, STANDING, 0.0)
        (face,) = [
            f
            for f in around_uav(C, UAV, inf, arena, world().uav, tube, ()).faces
            if f.reason == Reason.OBSTACLE
        ]
        assert face.z == z
    # A little above, and far beside.
    arena = replace(HALL, obstacles=(Obstacle(Box(2.5, 3.0, -1.0, 1.0), 1.6),))
    faces = around_uav(C, UAV, inf, arena, world().uav, tube, ()).faces
    (face,) = [f for f in faces if f.reason == Reason.OBSTACLE]
    assert face.z == 0.0 and face.room > 1.0


def test_high_above_a_ugv_nothing_it_does_matters():
    lost = UgvState(0.0, 0.0, 0.0, nan, 0.0, 0.0)
    for height, minds in ((3.0, False), (0.3, True)):
        w = world((0.9, 0.0, height))
        tube = uav_tube(C, UAV, w.uav, (NOTHING,) * 3, STANDING, 0.0)
        ugv = UgvCommitment(UgvMotion.of(C, UGV, lost, NO_ORDERS, 0.0))
        *_, face = around_uav(C, UAV, inf, HALL, w.uav, tube, (ugv,)).faces
        assert (face.room >= 0.0) != minds and face.z == 1.0 - minds


def test_a_ugv_minds_a_uav_only_when_it_is_low():
    for height, minds in ((3.0, False), (0.3, True)):
        w = world((-1.4, -2.0, height))
        motion = UgvMotion.of(C, UGV, w.ugvs[0], NO_ORDERS, 0.0)
        *_, face = around_ugv(C, motion, inf, HALL, (), hovering(w.uav)).faces
        assert (face.room < 1.0) == minds


def test_every_wall_is_a_face():
    w = world((4.0, -3.0, 2.0), SPREAD)
    tube = uav_tube(C, UAV, w.uav, (NOTHING,) * 3, STANDING, 0.0)
    around = around_uav(C, UAV, inf, HALL, w.uav, tube, ())
    assert sorted(round(f.gap, 2) for f in around.faces) == sorted([0.74, 8.74, 1.74, 7.74, 1.9, 3.9])
    assert around.gap == pytest.approx(0.74)


@pytest.mark.parametrize("more", (0.01, -0.01))
def test_what_is_far_is_left_out_but_for_its_gap(more):
    """A box, and a UGV that drives towards the UAV, a little beyond what may come near, and a little nearer."""
    high, reach = replace(HALL, ceiling=40.0), 1.0
    uav = world((0.0, 0.0, 6.0), velocity=Vec3(0.5, 0.0, 0.0)).uav
    tube = uav_tube(C, UAV, uav, (NOTHING,) * 3, STANDING, 0.0)
    assert tube.reach == pytest.approx(tube.error + tube.advance(1.0, 0.0))
    gap = reach + tube.reach + more
    box = Obstacle(Box(UAV.radius + gap, UAV.radius + gap + 0.1, -1.0, 1.0), 9.0)
    beside_box = around_uav(C, UAV, reach, replace(high, obstacles=(box,)), uav, tube, ())
    assert (Reason.OBSTACLE in {face.reason for face in beside_box.faces}) == (more < 0.0)
    assert beside_box.gap == pytest.approx(gap)

    low = replace(uav, position=Vec3(0.0, 0.0, 0.2))
    towards = UgvMotion.of(C, UGV, UgvState(0.0, 0.0, pi, 0.3, 0.0, 0.0), ordered(0.3), 0.0)
    gap = reach + tube.reach + 20.0 * more + C.position_error + UgvCommitment(towards).reach
    x = UAV.radius + UGV.radius + gap
    driving = UgvCommitment(towards._replace(ugv=replace(towards.ugv, x=x)))
    beside_ugv = around_uav(C, UAV, reach, high, low, tube, (driving,))
    assert (Reason.VEHICLE in {face.reason for face in beside_ugv.faces}) == (more < 0.0)


def test_for_a_uav_that_is_infinitely_far_nothing_is_left_out():
    """Infinitely far is no place: nobody knows what is near there."""
    tube = uav_tube(C, UAV, world().uav, (NOTHING,) * 3, STANDING, 0.0)
    nowhere = replace(world().uav, position=Vec3(inf, 0.0, 3.0))
    arena = replace(HALL, obstacles=(Obstacle(Box(2.5, 3.0, -1.0, 1.0), 1.6),))
    seen = around_uav(C, UAV, 1.0, arena, nowhere, tube, ()).faces
    assert {Reason.WALL, Reason.OBSTACLE} <= {face.reason for face in seen}
