"""The stop-tube nets in flight: what each of them must do, in plain Python."""

from dataclasses import dataclass, field, replace
from math import hypot, inf, isfinite, nan, pi

import jax
import numpy as np
import pytest
from aloft import HALL, HOVER, SPREAD, STILL, always, fly, world

from fledge.geometry import Box, Quat, Vec3
from fledge.pytrees import register
from fledge.safety import Barrier, StopTube, UgvStop, tube
from fledge.safety.tube import Pace, UgvSent, uav_error
from fledge.safety.turns import UavTurn, UgvTurn, in_turn
from fledge.world import Commands, Obstacle, Reason, UavState, UgvState, VelocityCommand, WorldState

pytestmark = pytest.mark.slow

BOTH = pytest.mark.parametrize("net", (StopTube(), Barrier()), ids=lambda net: type(net).__name__)
EAST = VelocityCommand(1.0, 0.0, 0.0, 0.0)
AHEAD = VelocityCommand(1.0, 0.0, 0.0, 0.0)
BACK = VelocityCommand(-0.3, 0.0, 0.0, 0.0)
BOX = replace(HALL, obstacles=(Obstacle(Box(1.0, 2.0, -1.0, 1.0), 4.0),))

WAYS = {
    "east": (VelocityCommand(1.0, 0.0, 0.0, 0.0), (3.0, 0.0, 3.0)),
    "west": (VelocityCommand(-1.0, 0.0, 0.0, 0.0), (-3.0, 0.0, 3.0)),
    "north": (VelocityCommand(0.0, 1.0, 0.0, 0.0), (0.0, 3.0, 3.0)),
    "south": (VelocityCommand(0.0, -1.0, 0.0, 0.0), (0.0, -3.0, 3.0)),
    "up": (VelocityCommand(0.0, 0.0, 0.5, 0.0), (0.0, 0.0, 4.5)),
    "down": (VelocityCommand(0.0, 0.0, -0.5, 0.0), (4.0, 4.0, 1.5)),
    "onto a UGV": (VelocityCommand(0.0, 0.0, -0.5, 0.0), (-2.0, -2.0, 1.5)),
    "corner": (VelocityCommand(1.0, 1.0, 0.0, 0.0), (3.5, 3.0, 3.0)),
}


@BOTH
@pytest.mark.parametrize("way", WAYS)
def test_full_speed_at_anything_ends_before_it_and_not_far_before(net, way):
    told, start = WAYS[way]
    log = fly(net, world(start), always(told), 6.0)
    assert 0.0 < log.least[0] < 0.35
    v = log.last.uav.velocity
    assert hypot(v.x, v.y, v.z) < 0.05, "it stands"


@BOTH
@pytest.mark.parametrize(
    "direction", (Vec3(1.0, 0.0, 0.0), Vec3(0.0, -1.0, 0.0), Vec3(0.0, 0.0, -1.0)), ids=str
)
def test_a_steady_push_does_not_drift_it_through_the_margin(net, direction):
    start = (4.3 * direction.x, 4.3 * direction.y, 3.0 if direction.z == 0.0 else 0.7)
    log = fly(net, world(start), always(), 15.0, push=direction * net.contract.disturbance)
    assert log.least[0] > 0.0


@BOTH
@pytest.mark.parametrize("broken", (nan, inf, -inf, 1e30))
def test_garbage_at_speed_is_braked(net, broken):
    garbage = VelocityCommand(broken, 0.0, 0.0, 0.0)

    def policy(w):
        told = (AHEAD if w.t < 1.0 else garbage, HOVER, HOVER)
        return Commands(EAST if w.t < 1.5 else garbage, told)

    log = fly(net, world((0.0, 0.0, 3.0), ((1.0, -2.0, 0.0), *SPREAD[1:])), policy, 4.0)
    assert min(log.least) > 0.0
    if np.isnan(broken):
        assert log.reasons == {Reason.NOT_FINITE}
        assert abs(log.last.ugvs[0].speed) < 1e-9


@BOTH
def test_a_tall_box_is_stopped_at_and_a_low_one_flown_over(net):
    log = fly(net, world((-1.0, 0.0, 3.0)), always(EAST), 5.0, BOX)
    assert 0.0 < log.least[0] < 0.35
    assert log.reasons == {Reason.OBSTACLE}
    low = replace(BOX, obstacles=(replace(BOX.obstacles[0], height=2.0),))
    log = fly(net, world((-1.0, 0.0, 3.0)), always(EAST), 5.0, low)
    assert log.last.uav.position.x > 3.0, "beyond the box"


def test_what_is_near_at_its_side_hides_nothing_that_is_ahead():
    """Of what is out of reach a net looks at nothing; of what is in reach at everything."""
    told, net = Commands(EAST, (VelocityCommand(0.7, 0.0, 0.0, 0.0), HOVER, HOVER)), StopTube()

    def refused(ahead: float, aside: float) -> list[bool]:
        start = world(
            (5.0 - net.uav.radius - ahead, 0.0, 3.0),
            ((5.0 - net.ugvs[0].radius - ahead, -3.0, 0.0), *SPREAD[1:]),
        )
        beside = (
            Obstacle(Box(3.0, 5.0, net.uav.radius + aside, 2.0), 4.0),
            Obstacle(Box(3.0, 5.0, -4.5, -3.0 - net.ugvs[0].radius - aside), 4.0),
        )
        arena = replace(HALL, obstacles=beside)
        _, verdicts = net.filter(net.init(arena, start), start, told)
        return [bool(verdict.intervened) for verdict in verdicts[:2]]

    for ahead in np.linspace(0.1, 2.1, 81).tolist():
        bare = refused(ahead, 1.0)
        for aside in (0.16, 0.17, 0.18, 0.2, 0.3, 0.4):
            assert not any(free > near for free, near in zip(bare, refused(ahead, aside), strict=True))
    assert refused(0.16, 1.0) == [True, True] and refused(0.6, 1.0) == [False, True]
    assert refused(2.1, 1.0) == [False, False]


def anywhere(rng: np.random.Generator, t: float) -> tuple[WorldState, Commands]:
    """Vehicles anywhere in the hall, at any speed, told whatever."""
    low, high = (-4.7, -4.7, 0.4, -pi, -1.0, -1.0, -0.5), (4.7, 4.7, 3.0, pi, 1.0, 1.0, 0.5)
    x, y, z, yaw, *v = rng.uniform(low, high).tolist()
    uav = UavState(Vec3(x, y, z), Vec3(*v), Quat.from_yaw(yaw), Vec3(0.0, 0.0, 0.0), t)
    low, high = (-4.7, -4.7, -pi, -0.6, -1.0), (4.7, 4.7, pi, 0.6, 1.0)
    ugvs = tuple(
        UgvState(*rng.uniform(low, high).tolist(), stamp=t - rng.uniform(0.0, 0.05)) for _ in range(3)
    )
    told = [VelocityCommand(*rng.uniform(-1.5, 1.5, 4).tolist()) for _ in range(4)]
    return WorldState(t, uav, ugvs), Commands(told[0], tuple(told[1:]))


@BOTH
@pytest.mark.parametrize("seed", range(3))
def test_what_is_too_far_to_be_looked_at_would_have_changed_nothing(net, seed, monkeypatch):
    """In step with a net that looks at everything, as a compiled program does."""
    rng, differ = np.random.default_rng(seed), 0
    memory = net.init(BOX, anywhere(rng, 0.0)[0])
    for tick in range(400):
        seen, commands = anywhere(rng, 0.01 * tick)
        after, verdicts = net.filter(memory, seen, commands)
        with monkeypatch.context() as patch:
            patch.setattr(tube, "surely", lambda condition: False)
            whole, others = net.filter(memory, seen, commands)
        assert after == whole
        for one, other in zip(verdicts, others, strict=True):
            assert replace(one, reason=other.reason) == other
        differ += sum(one.intervened for one in verdicts) < 4.0
        memory = after
    assert differ > 200, "not everything is stopped"


@BOTH
def test_the_reason_names_what_is_near(net):
    for way, reason in (("east", Reason.WALL), ("up", Reason.CEILING), ("down", Reason.FLOOR)):
        told, start = WAYS[way]
        assert fly(net, world(start), always(told), 4.0).reasons == {reason}
    told, start = WAYS["onto a UGV"]
    assert fly(net, world(start), always(told), 4.0).reasons == {Reason.VEHICLE}


@BOTH
def test_from_inside_a_margin_it_finds_its_own_way_out(net):
    log = fly(net, world((4.70, 0.0, 3.0)), always(), 6.0)
    assert log.least[0] > 0.0
    assert log.last.uav.position.x < 4.65
    quiet = fly(net, log.anew, always(), 0.5)
    assert not any(verdicts[0].intervened for verdicts in quiet.verdicts)


@BOTH
def test_what_leads_out_passes_at_once(net):
    start = world((4.70, 0.0, 3.0))
    out = VelocityCommand(-0.4, 0.0, 0.0, 0.0)
    _, verdicts = net.filter(net.init(HALL, start), start, Commands(out, STILL.ugvs))
    assert verdicts[0].command == out and not verdicts[0].intervened


@BOTH
def test_a_ugv_stops_before_walls_boxes_and_its_like(net):
    for start, arena in (
        ((3.0, 0.0, 0.0), HALL),
        ((-1.0, 0.0, 0.0), BOX),
        ((-0.5, -2.0, 0.0), HALL),
        ((3.0, 0.0, 3.14159), replace(HALL, bounds=Box(1.5, 5.0, -5.0, 5.0))),
    ):
        ugvs = (start, (2.0, -2.0, 0.0), (2.5, 3.5, 0.0))
        log = fly(net, world((3.0, 3.0, 3.0), ugvs), always(ugv=AHEAD), 8.0, arena)
        assert 0.0 < log.least[1] < 1.6
        assert abs(log.last.ugvs[0].speed) < 0.02


@BOTH
@pytest.mark.parametrize("speed", (1.2, -1.0))
@pytest.mark.parametrize("then", (0.0, -0.1, 0.1))
@pytest.mark.parametrize("gap", (0.12, 0.17, 0.22))
def test_a_ugv_beside_a_wall_does_not_swing_what_is_left_of_its_speed_into_it(net, speed, then, gap):
    beside = UgvState(-2.0 * speed, 5.0 - net.ugvs[1].radius - gap, 0.0, speed, 0.0, 0.0)
    start = world(ugvs=(SPREAD[0], (0.0, 0.0, 0.0), (2.0, -2.0, 0.0)))
    start = replace(start, ugvs=(start.ugvs[0], beside, start.ugvs[2]))
    along, turning = (VelocityCommand(v, 0.0, 0.0, w) for v, w in ((speed, 0.0), (then * speed, 2.0)))
    turning = replace(turning, turn=2.0 if speed > 0.0 else -2.0)

    def policy(w):
        return Commands(HOVER, (HOVER, along if w.t < 0.2 else turning, HOVER))

    log = fly(net, start, policy, 4.0)
    assert log.least[2] > 0.0


@BOTH
def test_two_ugvs_do_not_meet_and_both_can_part_again(net):
    ugvs = ((-1.5, 0.0, 0.0), (1.5, 0.0, 3.14159), (0.0, 3.5, 0.0))
    both = Commands(HOVER, (AHEAD, AHEAD, HOVER))
    log = fly(net, world((0.0, -3.0, 3.0), ugvs), lambda w: both, 6.0)
    assert 0.0 < log.least[1]
    apart = Commands(HOVER, (BACK, BACK, HOVER))
    after = fly(net, log.anew, lambda w: apart, 4.0)
    assert after.last.ugvs[0].x < log.last.ugvs[0].x - 0.5
    assert after.last.ugvs[1].x > log.last.ugvs[1].x + 0.5


@BOTH
def test_who_was_told_to_stop_is_given_way_until_it_must_have_stopped(net):
    """Its link may be lost; then it goes on, 24 cm farther than if it had heard."""

    def nearest(stops):
        """How near [m] another may come that was standing, after so many ticks in which the first was told to stop."""
        return min(x for x in (1.0 + 0.01 * i for i in range(100)) if _may_approach(net, x, stops))

    heard, unheard = nearest(80), nearest(1)
    assert unheard - heard == pytest.approx(0.4 * net.ugvs[0].hold_over, abs=0.02)


def _may_approach(net, far, stops):
    """Whether a UGV may come towards one that goes at 0.4 m/s and was told to stop so many ticks ago."""
    seen, sent = world(ugvs=((0.0, 3.0, 0.0), (far, 3.0, pi), (-3.0, -3.0, 0.0))), UgvSent.nothing(0.0)
    for told in (*[0.4] * 80, *[0.0] * stops):
        sent = sent.then(net.contract, net.ugvs[0], told, 0.0, net.contract.period)
    seen = replace(seen, ugvs=(replace(seen.ugvs[0], speed=0.4), *seen.ugvs[1:]))
    memory = net.init(HALL, seen)
    memory = memory._replace(ugvs=(sent, *memory.ugvs[1:]))
    comes = VelocityCommand(0.2, 0.0, 0.0, 0.0)
    _, verdicts = net.filter(memory, seen, Commands(HOVER, (HOVER, comes, HOVER)))
    return verdicts[2].command == comes


@BOTH
def test_a_ugv_does_not_drive_under_a_uav_that_may_sink_onto_it(net):
    """However still it hovers: a push may move it as far as the contract says."""
    tall, low = net.ugvs[0].height, net.uav.half_height
    forth = VelocityCommand(0.3, 0.0, 0.0, 0.0)
    for above, passes in ((0.25, True), (0.10, False)):
        seen = world((0.0, 0.0, tall + low + above), ((-0.9, 0.0, 0.0), *SPREAD[1:]))
        _, verdicts = net.filter(net.init(HALL, seen), seen, Commands(HOVER, (forth, HOVER, HOVER)))
        assert (verdicts[1].command == forth) == passes


@BOTH
def test_a_ugv_does_not_drive_under_a_uav_that_comes_down(net):
    ugvs = ((-2.0, 0.0, 0.0), (3.0, -3.0, 0.0), (3.0, 3.0, 0.0))
    down = VelocityCommand(0.0, 0.0, -0.5, 0.0)
    log = fly(net, world((0.0, 0.0, 1.0), ugvs), always(down, AHEAD), 6.0)
    assert min(log.least) > 0.0


@BOTH
def test_a_ugv_does_not_drive_under_a_uav_that_nobody_sees(net):
    """It may be landing; away from below it leads out."""
    ugvs = ((-1.0, 0.0, 0.0), *SPREAD[1:])
    forth = VelocityCommand(0.3, 0.0, 0.0, 0.0)
    for age, passes in ((0.04, True), (0.4, False)):
        seen = world((0.0, 0.0, 3.0), ugvs, t=5.0)
        seen = replace(seen, uav=replace(seen.uav, stamp=5.0 - age))
        _, verdicts = net.filter(net.init(HALL, seen), seen, Commands(HOVER, (forth, HOVER, HOVER)))
        assert (verdicts[1].command == forth) == passes
        _, verdicts = net.filter(net.init(HALL, seen), seen, Commands(HOVER, (BACK, HOVER, HOVER)))
        assert verdicts[1].command == BACK


@BOTH
def test_a_stopped_ugv_may_turn_and_then_drive_away(net):
    start = ((4.3, 0.0, 0.0), (-2.0, -2.0, 0.0), (0.0, 3.5, 0.0))
    turning = VelocityCommand(0.5, 0.0, 0.0, 1.0)
    log = fly(net, world((0.0, 0.0, 3.0), start), always(ugv=turning), 6.0)
    assert log.least[1] > 0.0
    assert log.last.ugvs[0].x < 4.0


@BOTH
def test_old_and_future_data_let_nothing_new_through(net):
    for t in (0.2, -0.2):
        start = replace(world(), t=t)
        _, verdicts = net.filter(net.init(HALL, start), start, Commands(EAST, (AHEAD,) * 3))
        assert [v.command for v in verdicts] == [HOVER] * 4
        assert {v.reason for v in verdicts} == {Reason.STALE}


@BOTH
def test_one_lost_ugv_does_not_stop_those_far_above(net):
    lost = replace(world(), ugvs=(replace(world().ugvs[0], x=nan), *world().ugvs[1:]))
    _, verdicts = net.filter(net.init(HALL, world()), lost, Commands(HOVER, (AHEAD,) * 3))
    assert verdicts[1].command.forward == 0.0
    assert all(np.isfinite(v.command.forward) for v in verdicts)


@BOTH
@pytest.mark.parametrize("value", (nan, inf, -inf))
@pytest.mark.parametrize("of", ("x", "y", "heading", "speed", "turn_rate"))
def test_no_ugv_drives_towards_one_of_which_nobody_knows_what_it_does(net, of, value):
    """However far they are apart."""
    go = replace(AHEAD, forward=0.3)
    start = world(ugvs=((0.0, 0.0, 0.0), (-3.0, 0.0, 0.0), (2.0, 2.0, -2.356)))
    lost = replace(start, ugvs=(replace(start.ugvs[0], **{of: value}), *start.ugvs[1:]))
    for seen, forward in ((start, 0.3), (lost, 0.0)):
        _, verdicts = net.filter(net.init(HALL, start), seen, Commands(HOVER, (go,) * 3))
        assert [verdict.command.forward for verdict in verdicts[2:]] == [forward] * 2


@BOTH
def test_commands_beyond_the_sticks_are_held_to_them(net):
    start = world()
    _, verdicts = net.filter(
        net.init(HALL, start), start, Commands(VelocityCommand(9.0, 0.0, 0.0, 0.0), (HOVER,) * 3)
    )
    assert verdicts[0].command.forward == net.uav.most and verdicts[0].intervened


@BOTH
def test_a_command_that_leads_a_ugv_out_of_where_there_is_no_room_passes_at_once(net):
    radius = net.ugvs[0].radius
    start = world(ugvs=((5.0 - radius - 0.01, 0.0, 0.0), *SPREAD[1:]))
    _, verdicts = net.filter(net.init(HALL, start), start, Commands(HOVER, (BACK, HOVER, HOVER)))
    assert verdicts[1].command == BACK
    _, verdicts = net.filter(net.init(HALL, start), start, Commands(HOVER, (AHEAD, HOVER, HOVER)))
    assert verdicts[1].command.forward == 0.0


@BOTH
def test_a_ugv_that_stands_where_there_is_no_room_may_turn(net):
    start = world(ugvs=((5.0 - net.ugvs[0].radius - 0.01, 0.0, 0.0), *SPREAD[1:]))
    turn = VelocityCommand(0.0, 0.0, 0.0, 1.0)
    _, verdicts = net.filter(net.init(HALL, start), start, Commands(HOVER, (turn, HOVER, HOVER)))
    assert verdicts[1].command.turn == 1.0


@BOTH
def test_a_ugv_stops_in_reverse_as_well(net):
    start = ((-3.0, 0.0, 0.0), *SPREAD[1:])
    log = fly(net, world(ugvs=start), always(ugv=VelocityCommand(-0.8, 0.0, 0.0, 0.0)), 6.0)
    assert 0.0 < log.least[1] < 1.6
    assert abs(log.last.ugvs[0].speed) < 0.02


@BOTH
def test_a_ugv_that_is_stopped_at_speed_is_not_turned(net):
    """A turn would lead its stop elsewhere."""
    start = world(ugvs=((5.0 - net.ugvs[0].radius - 0.1, 0.0, 0.0), *SPREAD[1:]))
    fast = replace(start, ugvs=(replace(start.ugvs[0], speed=0.6), *start.ugvs[1:]))
    told = VelocityCommand(0.6, 0.0, 0.0, nan if isinstance(net, Barrier) else 1.0)
    _, verdicts = net.filter(net.init(HALL, fast), fast, Commands(HOVER, (told, HOVER, HOVER)))
    assert (verdicts[1].command.forward, verdicts[1].command.turn) == (0.0, 0.0)


def refused(distance: float, told: Commands, height: float = 3.0) -> list[bool]:
    """Whether two UGVs, nose to nose so far apart [m], are refused what they are told; the UAV is behind the second."""
    net, x = StopTube(), 0.5 * distance
    ugvs = ((-x, 0.0, 0.0), (x, 0.0, pi), (0.0, 4.0, 0.0))
    start = world((2.0, 0.0, height), ugvs)
    _, verdicts = net.filter(net.init(HALL, start), start, told)
    return [bool(verdict.intervened) for verdict in verdicts[1:3]]


def test_who_decides_later_makes_room_for_what_was_just_allowed():
    """Somewhere there is room for one of them to set off, but not for both: the first has the right of way."""
    slow = VelocityCommand(0.3, 0.0, 0.0, 0.0)
    told = Commands(HOVER, (slow, slow, HOVER))
    found = [refused(1.0 + 0.01 * i, told) for i in range(150)]
    assert found[0] == [True, True] and found[-1] == [False, False]
    assert [False, True] in found and [True, False] not in found


def test_a_ugv_makes_room_for_what_the_uav_was_just_allowed():
    """The UAV goes on with it for as long as its own watchdog lets it."""
    net = StopTube()

    def nearest(uav: VelocityCommand) -> float:
        """At which distance from a low UAV that comes towards it a UGV may set off [m]."""
        for i in range(400):
            ugvs = ((-0.8 - 0.005 * i, 0.0, 0.0), *SPREAD[1:])
            start = world((0.0, 0.0, 0.33), ugvs)
            told = Commands(uav, (VelocityCommand(0.2, 0.0, 0.0, 0.0), HOVER, HOVER))
            _, verdicts = net.filter(net.init(HALL, start), start, told)
            if not verdicts[1].intervened and not verdicts[0].intervened:
                return 0.8 + 0.005 * i
        raise AssertionError

    towards = nearest(VelocityCommand(-1.0, 0.0, 0.0, 0.0)) - nearest(HOVER)
    uav = world().uav
    faster, standing = (uav_error(net.contract, net.uav, uav, Pace(speed, 0.0)) for speed in (1.0, 0.0))
    assert towards == pytest.approx(net.uav.hold_over + faster - standing, abs=0.006)


@BOTH
def test_where_there_is_no_room_a_uav_holds_on_at_speed(net):
    """It does not wait until it is slow: the point it holds moves out at once."""
    start = world((4.72, 0.0, 3.0), velocity=Vec3(0.5, 0.0, 0.0))
    _, verdicts = net.filter(net.init(HALL, start), start, Commands(EAST, STILL.ugvs))
    assert verdicts[0].command.forward < 0.0


@BOTH
def test_a_pace_is_remembered_until_its_lags_are_over(net):
    memory = net.init(HALL, world())
    paces = []
    for tick in range(120):
        fast = 1.0 if tick == 0 else 0.0
        told = VelocityCommand(0.6 * fast, 0.8 * fast, 0.0, fast)
        memory, _ = net.filter(memory, world(t=0.01 * tick), Commands(told, STILL.ugvs))
        paces.append(memory.uav.pace)
    for lately in zip(*paces, strict=True):
        assert lately[0] == pytest.approx(1.0) and list(lately) == sorted(lately, reverse=True)
        assert lately[10] > 0.75 and lately[-1] < 0.4


@BOTH
def test_a_command_that_quickens_has_to_leave_room_for_what_its_stop_may_miss(net):
    """Along a wall straight on it passes, and turning it might not be stopped where it would be now."""
    start = world((4.5, 0.0, 3.0))
    straight, turning = (
        net.filter(net.init(HALL, start), start, Commands(VelocityCommand(0.0, 1.0, 0.0, turn), STILL.ugvs))
        for turn in (0.0, 1.0)
    )
    assert not straight[1][0].intervened and turning[1][0].intervened


@dataclass(frozen=True)
class Watched(StopTube):
    """Notes what room the UAV leaves a UGV."""

    rooms: list[float] = field(default_factory=list)

    def decide_ugv(self, stop: UgvStop, turn: UgvTurn) -> tuple[bool, float]:
        self.rooms.append(turn.faces[-1].room)
        return StopTube.decide_ugv(self, stop, turn)


def test_a_uav_that_was_let_go_faster_is_given_a_wider_berth_at_once():
    """It flies past a UGV, low: its way leads elsewhere, but its stop may miss by more."""
    start, net = world((-0.8, -2.0, 0.3)), Watched()
    for left in (0.0, 1.0):
        go = Commands(VelocityCommand(0.0, left, 0.0, 0.0), STILL.ugvs)
        _, (uav, *_) = net.filter(net.init(HALL, start), start, go)
        assert not uav.intervened
    standing, flying = net.rooms[0], net.rooms[3]
    faster = (uav_error(net.contract, net.uav, start.uav, Pace(speed, 0.0)) for speed in (1.0, 0.0))
    assert standing - flying == pytest.approx(next(faster) - next(faster))
    assert standing - flying > 0.02


@dataclass(frozen=True)
class Reckless(StopTube):
    """A stranger's net: lets pass whatever it may, or says what it was made with."""

    chooses: float | None = None

    def decide_uav(self, turn: UavTurn) -> tuple[bool, Vec3]:
        return turn.known, turn.wanted if self.chooses is None else Vec3(self.chooses, 0.0, 0.0)

    def decide_ugv(self, stop: object, turn: UgvTurn) -> tuple[bool, float]:
        known = True if self.chooses is not None and self.chooses != self.chooses else turn.known
        return known, turn.proposal.forward if self.chooses is None else self.chooses


def broken(record: UavState | UgvState | VelocityCommand) -> list[UavState | UgvState | VelocityCommand]:
    """The record with NaN in one of its numbers, for each of them but the stamp."""
    register(record)
    leaves, shape = jax.tree.flatten(record)
    spoilt = [
        jax.tree.unflatten(shape, [nan if j == i else x for j, x in enumerate(leaves)])
        for i in range(len(leaves))
    ]
    return spoilt[:-1] if hasattr(record, "stamp") else spoilt


def test_nobody_is_asked_about_what_is_no_number():
    net, go = Reckless(), VelocityCommand(0.3, 0.0, 0.0, 0.1)
    start, told = world(), Commands(go, (go,) * 3)

    def sent(seen: WorldState, told: Commands) -> list[VelocityCommand]:
        return [verdict.command for verdict in in_turn(net, net.init(HALL, start), seen, told)[1]]

    assert sent(start, told) == [go] * 4
    for uav in broken(start.uav):
        assert sent(replace(start, uav=uav), told)[0] == HOVER
    for ugv in broken(start.ugvs[0]):
        assert sent(replace(start, ugvs=(ugv, *start.ugvs[1:])), told)[1].forward == 0.0
    for command in broken(go):
        assert sent(start, replace(told, uav=command))[0] == HOVER
    for command in (replace(go, forward=nan), replace(go, turn=nan)):
        assert sent(start, replace(told, ugvs=(command, go, go)))[1].forward == 0.0


@pytest.mark.parametrize("chosen", (9.0, nan))
def test_nobody_is_sent_more_than_it_obeys_whatever_a_net_chooses(chosen):
    net, start = Reckless(chooses=chosen), world()
    turned = replace(start, uav=replace(start.uav, attitude=Quat.from_yaw(0.7)))
    _, verdicts = in_turn(net, net.init(HALL, turned), turned, Commands(EAST, (AHEAD,) * 3))
    uav, ugv = verdicts[0].command, verdicts[1].command
    assert max(abs(uav.forward), abs(uav.left)) == pytest.approx(net.uav.most if isfinite(chosen) else 0.0)
    assert isfinite(ugv.forward)
