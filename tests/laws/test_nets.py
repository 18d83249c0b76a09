"""Laws that every safety net obeys; where one does not, the exception stands here with its reason.

Scenes are drawn at random, so no two distances in them are alike: on the very edge of a rule rounding decides.
"""

from dataclasses import dataclass, fields, is_dataclass, replace
from itertools import product
from math import inf, nan, pi

import jax
import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from fledge.geometry import Box, Heading, Quat, Vec3
from fledge.pytrees import pytree, stack
from fledge.safety import (
    NETS,
    AbstractNet,
    Barrier,
    Conformal,
    NoNet,
    Overruns,
    PaperNet,
    RepairedPaperNet,
    StopTube,
)
from fledge.world import (
    Arena,
    Commands,
    Obstacle,
    UavState,
    UgvState,
    VelocityCommand,
    Verdict,
    WorldState,
)

pytestmark = pytest.mark.slow

LETS_NAN_THROUGH = {
    NoNet: "it lets everything through",
    PaperNet: "D8: every comparison with NaN is false, and that counts as safe",
}


def every_net(exceptions=()):
    """One test per net; those that break the law must break it."""
    return pytest.mark.parametrize(
        "net",
        [
            pytest.param(
                net,
                marks=pytest.mark.xfail(reason=exceptions[type(net)], raises=AssertionError)
                if type(net) in exceptions
                else (),
                id=type(net).__name__,
            )
            for net in NETS
        ],
    )


# Far from everything.

WIDE = Arena(Box(-100.0, 100.0, -100.0, 100.0), 60.0, (Obstacle(Box(80.0, 81.0, 80.0, 81.0), 0.5),))
PLACES = ((-30.0, 0.0), (30.0, 0.0), (0.0, 30.0))
"""Everything is tens of metres from everything."""


def far_apart(forward: float, turn: float) -> WorldState:
    """All vehicles under way as they are told, at a steady speed."""
    still = Vec3(0.0, 0.0, 0.0)
    vx, vy = Heading.of(0.5).to_world(forward, 0.0)
    uav = UavState(Vec3(0.0, 0.0, 30.0), Vec3(vx, vy, 0.0), Quat.from_yaw(0.5), still, 0.0)
    return WorldState(0.0, uav, tuple(UgvState(x, y, 0.5, forward, turn, 0.0) for x, y in PLACES))


def judged(net, world, commands, arena=WIDE, begin=None) -> tuple[Verdict, ...]:
    """The verdicts at the start of a flight, which may have begun in another world than the net sees now."""
    return net.filter(net.init(arena, begin or world), world, commands)[1]


SLOW = tuple(
    VelocityCommand(forward, 0.0, 0.0, turn) for forward, turn in product((0.0, 0.1, -0.3, 0.4), (0.0, 0.2))
)


@every_net()
@pytest.mark.parametrize("command", SLOW, ids=str)
def test_far_from_everything_a_net_is_transparent(net, command):
    world = far_apart(command.forward, command.turn)
    for verdict in judged(net, world, Commands(command, (command,) * len(PLACES))):
        assert verdict.command == command
        assert not verdict.intervened
        assert verdict.reason == 0
        assert verdict.clearance > 10.0


@every_net()
def test_there_is_one_verdict_per_vehicle_in_their_order(net):
    told = tuple(VelocityCommand(0.1 * (i + 1), 0.0, 0.0, 0.0) for i in range(len(PLACES)))
    commands = Commands(VelocityCommand(0.0, 0.0, 0.2, 0.0), told)
    verdicts = judged(net, far_apart(0.1, 0.0), commands)
    assert [verdict.command for verdict in verdicts] == [commands.uav, *told]


@every_net()
def test_far_from_everything_a_net_stays_transparent_for_as_long_as_it_is_asked(net):
    world, commands = far_apart(0.0, 0.0), Commands(SLOW[0], (SLOW[0],) * len(PLACES))
    memory = net.init(WIDE, world)
    for _ in range(200):
        memory, verdicts = net.filter(memory, world, commands)
        assert not any(verdict.intervened for verdict in verdicts)


# Near to everything.


@dataclass(frozen=True)
class Scene:
    """A moment in a crowded arena, and what the vehicles are told from then on, tick by tick."""

    arena: Arena
    world: WorldState
    told: tuple[Commands, ...]


def in_scenes(*more, ticks: int = 3):
    """A test for many scenes, and more if wanted; a seed cannot be made simpler, so none is tried."""

    def wrapped(test):
        drawn = given(st.builds(scene, st.integers(0, 2**32 - 1), st.just(ticks)), *more)
        return settings(phases=(Phase.generate,), report_multiple_bugs=False)(drawn(test))

    return wrapped


def scene(seed: int, ticks: int = 3) -> Scene:
    rng = np.random.default_rng(seed)

    def number(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    def vector(x: float, y: float, z: float) -> Vec3:
        return Vec3(number(-x, x), number(-y, y), number(-z, z))

    def obstacle() -> Obstacle:
        x, y = number(-half, half), number(-half, half)
        return Obstacle(Box(x, x + number(0.1, 1.0), y, y + number(0.1, 1.0)), number(0.3, 2.5))

    half, t, pace = number(2.0, 5.0), number(0.0, 60.0), number(0.0, 1.0)
    arena = Arena(Box(-half - number(0.0, 0.5), half, -half, half + number(0.0, 0.5)), 4.0)
    arena = replace(arena, obstacles=tuple(obstacle() for _ in range(3)))
    roll, pitch, yaw = number(-0.2, 0.2), number(-0.2, 0.2), number(-pi, pi)
    tilted = Quat(1.0, 0.5 * roll, 0.5 * pitch, 0.0).integrate(Vec3(0.0, 0.0, 0.0), 0.0)  # of length one
    uav = UavState(
        Vec3(number(-half, half), number(-half, half), number(0.0, 4.0)),
        vector(pace, pace, 0.5 * pace),
        turned(tilted, yaw),
        vector(0.5, 0.5, 1.0),
        t - number(0.0, 0.05),
    )
    ugvs = tuple(
        UgvState(
            number(-half, half),
            number(-half, half),
            number(-pi, pi),
            number(-pace, pace),
            number(-pace, pace),
            t - number(0.0, 0.05),
        )
        for _ in PLACES
    )
    told = tuple(
        Commands(
            VelocityCommand(number(-1.0, 1.0), number(-1.0, 1.0), number(-0.5, 0.5), number(-1.0, 1.0)),
            tuple(VelocityCommand(number(-0.8, 0.8), 0.0, 0.0, number(-1.0, 1.0)) for _ in ugvs),
        )
        for _ in range(ticks)
    )
    return Scene(arena, WorldState(t, uav, ugvs), told)


def turned(q: Quat, yaw: float) -> Quat:
    """A rotation by `yaw` about the vertical, after `q`."""
    z = Quat.from_yaw(yaw)
    return Quat(z.w * q.w - z.z * q.z, z.w * q.x - z.z * q.y, z.w * q.y + z.z * q.x, z.w * q.z + z.z * q.w)


def sent(verdicts: tuple[Verdict, ...]) -> Commands:
    uav, *ugvs = (verdict.command for verdict in verdicts)
    return Commands(uav, tuple(ugvs))


def watched(net: AbstractNet, scene: Scene):
    """(memory before, commands, verdicts) of every tick."""
    memory = net.init(scene.arena, scene.world)
    for commands in scene.told:
        before = memory
        memory, verdicts = net.filter(memory, scene.world, commands)
        yield before, commands, verdicts


def numbers(record) -> list[float]:
    """Every number in a record or tuple."""
    if is_dataclass(record):
        record = [getattr(record, field.name) for field in fields(record)]
    return [x for part in record for x in numbers(part)] if isinstance(record, list | tuple) else [record]


def assert_alike(a, b) -> None:
    np.testing.assert_allclose(numbers(a), numbers(b), rtol=1e-7, atol=1e-9)


@every_net()
@in_scenes()
def test_a_net_depends_on_its_inputs_only(net, scene):
    np.testing.assert_equal(list(watched(net, scene)), list(watched(net, scene)))


@every_net()
@in_scenes()
def test_a_verdict_says_what_was_done(net, scene):
    for _, commands, verdicts in watched(net, scene):
        for proposed, verdict in zip((commands.uav, *commands.ugvs), verdicts, strict=True):
            assert verdict.intervened == (verdict.command != proposed)
            assert (verdict.reason != 0) == verdict.intervened


@every_net()
@in_scenes(st.permutations(range(3)))
def test_the_order_of_obstacles_does_not_matter(net, scene, order):
    shuffled = replace(scene.arena, obstacles=tuple(scene.arena.obstacles[i] for i in order))
    for (_, _, a), (_, _, b) in zip(
        watched(net, scene), watched(net, replace(scene, arena=shuffled)), strict=True
    ):
        assert_alike(a, b)


@dataclass(frozen=True)
class Motion:
    """Of the whole scene: reflected in the x axis or not, turned by quarters, shifted."""

    mirror: float = 1.0
    quarters: int = 0
    shift: tuple[float, float] = (0.0, 0.0)

    def vector(self, x: float, y: float) -> tuple[float, float]:
        y = self.mirror * y
        for _ in range(self.quarters):
            x, y = -y, x
        return x, y

    def point(self, x: float, y: float) -> tuple[float, float]:
        x, y = self.vector(x, y)
        return x + self.shift[0], y + self.shift[1]

    def box(self, box: Box) -> Box:
        (x, y), (u, v) = self.point(box.x_min, box.y_min), self.point(box.x_max, box.y_max)
        return Box(min(x, u), max(x, u), min(y, v), max(y, v))

    def uav(self, uav: UavState) -> UavState:
        p, v, q, w = uav.position, uav.velocity, uav.attitude, uav.rates
        # A mirror turns rotations about the axes that lie in it round.
        mirrored = Quat(q.w, self.mirror * q.x, q.y, self.mirror * q.z)
        return UavState(
            Vec3(*self.point(p.x, p.y), p.z),
            Vec3(*self.vector(v.x, v.y), v.z),
            turned(mirrored, self.quarters * pi / 2),
            Vec3(self.mirror * w.x, w.y, self.mirror * w.z),
            uav.stamp,
        )

    def ugv(self, ugv: UgvState) -> UgvState:
        heading = self.mirror * ugv.heading + self.quarters * pi / 2
        x, y = self.point(ugv.x, ugv.y)
        return UgvState(x, y, heading, ugv.speed, self.mirror * ugv.turn_rate, ugv.stamp)

    def command(self, c: VelocityCommand) -> VelocityCommand:
        return VelocityCommand(c.forward, self.mirror * c.left, c.up, self.mirror * c.turn)

    def scene(self, scene: Scene) -> Scene:
        arena, world = scene.arena, scene.world
        obstacles = tuple(Obstacle(self.box(one.footprint), one.height) for one in arena.obstacles)
        return Scene(
            Arena(self.box(arena.bounds), arena.ceiling, obstacles),
            WorldState(world.t, self.uav(world.uav), tuple(map(self.ugv, world.ugvs))),
            tuple(
                Commands(self.command(told.uav), tuple(map(self.command, told.ugvs))) for told in scene.told
            ),
        )


METRES = st.floats(-20.0, 20.0)
MOTIONS = st.builds(Motion, st.sampled_from((1.0, -1.0)), st.integers(0, 3), st.tuples(METRES, METRES))


@every_net()
@in_scenes(MOTIONS)
def test_a_net_has_no_favourite_place_or_direction(net, scene, motion):
    moved = watched(net, motion.scene(scene))
    for (_, _, here), (_, _, there) in zip(watched(net, scene), moved, strict=True):
        assert_alike(
            [replace(verdict, command=motion.command(verdict.command)) for verdict in here], list(there)
        )


@every_net()
@in_scenes()
def test_what_a_net_has_sent_passes(net, scene):
    """With the same memory: of a command of its own, to hold a point say, a net remembers that it is its own."""
    for memory, _, verdicts in watched(net, scene):
        _, again = net.filter(memory, scene.world, sent(verdicts))
        assert_alike(sent(again), sent(verdicts))


def wider(net: AbstractNet, by: float) -> list[AbstractNet]:
    """The same net with each of its margins in turn larger by a share."""
    more = 1.0 + by
    match net:
        case NoNet():
            return []
        case PaperNet() | RepairedPaperNet():
            return [replace(net, margin=net.margin * more)]
        case Conformal():
            learnt = Overruns(net.overruns.delta * more, net.overruns.alpha, net.overruns.episodes)
            return [
                replace(net, overruns=learnt),
                *(replace(net, proven=proven) for proven in wider(net.proven, by)),
            ]
        case StopTube() | Barrier():
            names = ("position_error", "velocity_error", "angle_error", "rate_error", "disturbance")
            enlarged = [{name: getattr(net.contract, name) * more} for name in names]
            return [replace(net, contract=replace(net.contract, **bound)) for bound in enlarged]
    raise NotImplementedError(f"say what the margins of {type(net).__name__} are")


@every_net()
@in_scenes(st.floats(0.01, 1.0), ticks=1)
def test_a_wider_margin_allows_nothing_more(net, scene, by):
    """Of the vehicles in their order, up to the first that is told something else: the rest face another world.

    But for a UAV to which it leaves no room, neither beside something nor above: that one may go out as it likes.
    """
    world, told = scene.world, scene.told[0]
    hover = replace(told, uav=VelocityCommand.hover())
    narrow = judged(net, world, told, scene.arena)
    for other in wider(net, by):
        led_out = bool(judged(other, world, hover, scene.arena)[0].intervened)
        for i, (a, b) in enumerate(zip(narrow, judged(other, world, told, scene.arena), strict=True)):
            assert a.intervened <= b.intervened or (i == 0 and led_out)
            if a.command != b.command:
                break


@in_scenes(ticks=1)
def test_a_learnt_margin_allows_nothing_that_the_proven_one_forbids(scene):
    proven, learnt = (
        judged(net, scene.world, scene.told[0], scene.arena) for net in (StopTube(), Conformal())
    )
    for a, b in zip(proven, learnt, strict=True):
        assert a.intervened <= b.intervened
        if a.command != b.command:
            break


# What is no number.

BROKEN = st.sampled_from((nan, inf, -inf))


def broken(record, at: int, value: float):
    """The same with its number at that place spoilt; places are counted on round and round."""
    left = at % len(numbers(record))

    def rebuilt(part):
        nonlocal left
        if is_dataclass(part):
            return type(part)(*(rebuilt(getattr(part, field.name)) for field in fields(part)))
        if isinstance(part, tuple):
            return tuple(map(rebuilt, part))
        left -= 1
        return value if left == -1 else part

    return rebuilt(record)


NOTHING = VelocityCommand(nan, nan, nan, nan)


def of_vehicle(world: WorldState, commands: Commands, vehicle: int, change) -> tuple[WorldState, Commands]:
    """The same with what is known of one vehicle, and what it is told, changed."""
    if vehicle == 0:
        t, uav, told = change((world.t, world.uav, commands.uav))
        return WorldState(t, uav, world.ugvs), replace(commands, uav=told)
    states, told = list(world.ugvs), list(commands.ugvs)
    states[vehicle - 1], told[vehicle - 1] = change((states[vehicle - 1], told[vehicle - 1]))
    return replace(world, ugvs=tuple(states)), replace(commands, ugvs=tuple(told))


@every_net(LETS_NAN_THROUGH)
@in_scenes(st.integers(0), BROKEN, ticks=1)
def test_what_is_sent_is_always_a_number(net, scene, at, value):
    world, commands = broken((scene.world, scene.told[0]), at, value)
    assert np.isfinite(numbers(sent(judged(net, world, commands, scene.arena, scene.world)))).all()


def answer(net, scene, vehicle, change=lambda its: its, silent=False) -> VelocityCommand:
    """What a vehicle is sent once something of it has changed, and nothing is proposed if so wished."""
    world, commands = of_vehicle(scene.world, scene.told[0], vehicle, change)
    if silent:
        world, commands = of_vehicle(world, commands, vehicle, lambda its: (*its[:-1], NOTHING))
    sent = judged(net, world, commands, scene.arena, scene.world)[vehicle].command
    # A UGV may be turned on the spot.
    return sent if vehicle == 0 else replace(sent, turn=0.0)


@every_net(LETS_NAN_THROUGH)
@in_scenes(st.integers(0, 3), st.integers(0), BROKEN, ticks=1)
def test_who_is_not_known_is_told_to_stop(net, scene, vehicle, at, value):
    """As if nothing had been proposed; unless the net does not even look at the number that is none."""

    def change(its):
        return (*broken(its[:-1], at, value), its[-1])

    got, stopped = (answer(net, scene, vehicle, change, silent) for silent in (False, True))
    assert got in (stopped, answer(net, scene, vehicle))
    assert np.hypot(stopped.forward, stopped.left) < 0.5
    assert vehicle == 0 or stopped.forward == 0.0


@every_net(LETS_NAN_THROUGH)
@in_scenes(st.integers(0, 3), st.integers(0), BROKEN, ticks=1)
def test_a_command_that_is_no_number_is_none(net, scene, vehicle, at, value):
    """Unless nothing obeys it; and what is infinite may count as the largest."""

    def told(value: float) -> VelocityCommand:
        return answer(net, scene, vehicle, lambda its: (*its[:-1], broken(its[-1], at, value)))

    largest = told(1e30 if value > 0.0 else -1e30)
    others = (answer(net, scene, vehicle, silent=True), answer(net, scene, vehicle))
    assert told(value) in ((*others, largest) if abs(value) == inf else others)


# On both backends.


@every_net()
def test_plain_floats_and_jax_give_the_same_verdicts(net):
    """In every third scene something is no number, or absurd."""
    told = []
    for seed in range(300):
        one = scene(seed, ticks=1)
        seen = one.world, one.told[0]
        if seed % 3 == 0:
            seen = broken(seen, 7 * seed, (nan, inf, 1e30)[seed // 3 % 3])
        told.append((*seen, one.arena, one.world))
    plain = [judged(net, *inputs) for inputs in told]
    pytree(Verdict)
    with jax.enable_x64(True):
        judge = jax.jit(jax.vmap(lambda inputs: judged(net, *inputs)))
        jaxed = jax.tree.map(np.asarray, judge(stack(told)))
    plain = jax.tree.map(lambda *leaves: np.array(leaves, dtype=float), *plain)
    for (path, a), b in zip(jax.tree_util.tree_leaves_with_path(plain), jax.tree.leaves(jaxed), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9, err_msg=jax.tree_util.keystr(path))
