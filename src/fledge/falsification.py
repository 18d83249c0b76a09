"""Attack a net in the simulator, thousands of flights at once, and count what it let happen.

A `Scenario` is everything drawn before a flight: arena, start, how badly the contract's bounds are used, the attack.
Every vehicle is attacked at once; at the end one of them, in turn, is led away by a retreat pilot while the others
stand, which shows whether the net keeps it prisoner. Beside the flight runs a second one, cloned from it whenever the
net steps in and flown on without it: if nothing is touched there within `HORIZON`, the alarm was false.

The attackers know the truth; the net sees it late and with errors, its commands act late, and a steady or malicious
push works on the vehicles, each up to the contract's bound times the scenario's share. Touching is judged by
`clearance`, which the nets do not use.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from fledge.attacks import FAMILIES, SEGMENTS, Attacker, Chance, Nature, drive
from fledge.clearance import Nearest, clearances
from fledge.dynamics import Pioneer
from fledge.geometry import Box, Quat, Vec3
from fledge.safety import AbstractNet, Contract
from fledge.scalars import Scalar, maximum, minimum, where
from fledge.simulation import COMPILED, TICK, Rig, apart, compiled, fly_tick, pytree, register, stack
from fledge.world import Arena, Commands, Obstacle, UavState, UgvState, VelocityCommand, WorldState

ATTACK_TICKS = 1000
RETREAT_TICKS = 1000
"""10 s each."""
HORIZON = 200
"""Ticks for which a flight without the net is followed [10 ms]."""
BREACH = 0.5
"""[m] the paper's margin about a vehicle's centre; coming nearer is a breach."""
LEFT = 0.5
"""[m] a vehicle that moved so far in its retreat was no prisoner."""
ROOMY = (0.3, 0.2)
"""[m] free hull to hull that a way out must have for the UAV, and for a UGV: what a stop at a crawl needs."""
MOST_OBSTACLES = 10
PASSAGE = 1.6
"""[m] least width of a gap between things that is not closed altogether: every vehicle gets through."""


class Trouble(NamedTuple):
    """How badly a flight uses the contract's bounds."""

    age: Scalar
    """Of what the net sees [ticks]."""
    latency: Scalar
    """Of what it sends [ticks]."""
    share: Scalar
    """Of errors and disturbance."""
    malice: Scalar
    """1: errors and push always point the worst way; 0: a fixed random way."""
    way: Vec3
    """That way, a unit vector."""


@pytree
@dataclass(frozen=True, slots=True)
class Scenario:
    """Everything drawn before a flight."""

    arena: Arena
    world: WorldState
    trouble: Trouble
    nature: Nature
    focus: Scalar
    """Which vehicle is led away at the end; 0 is the UAV."""


class Tally(NamedTuple):
    """What happened in a flight."""

    least: tuple[Scalar, ...]
    """Smallest gap of every vehicle [m]."""
    first: Scalar
    """Tick of the first contact; -1 if there was none."""
    breached: Scalar
    """1 if a centre came nearer than `BREACH`."""
    interventions: Scalar
    """Vehicle ticks in which the net changed a command."""
    windows: Scalar
    """Alarms that were followed without the net."""
    false_alarms: Scalar
    """Those in which nothing was touched."""


class Outcome(NamedTuple):
    """Of a whole flight."""

    tally: Tally
    deadlock: Scalar
    """1 if the vehicle in focus could not be led away although there was a way."""
    track: Any
    """(worlds, what was proposed, verdicts), leaves of shape (ticks,), if it was recorded."""


# Drawing scenarios; on the host, in NumPy.


def draw_arena(rng: np.random.Generator) -> tuple[Arena, int]:
    """(a random arena with 0 to 10 obstacles, how many were rejected before it)."""
    rejected = 0
    while True:
        arena = _try_arena(rng, int(rng.integers(MOST_OBSTACLES + 1)))
        if arena is not None:
            return arena, rejected
        rejected += 1


def _try_arena(rng: np.random.Generator, count: int) -> Arena | None:
    half = (5.0, 5.0) if rng.random() < 0.7 else (3.3, 2.5)
    bounds = Box(-half[0], half[0], -half[1], half[1])
    placed: list[Obstacle] = []
    for _ in range(count):
        x, y = rng.uniform(-half[0], half[0]), rng.uniform(-half[1], half[1])
        w, h = rng.uniform(0.1, 0.6, 2)
        box = Box(float(x - w), float(x + w), float(y - h), float(y + h))
        if any(0.0 < gap < PASSAGE for gap in _gaps(box, bounds, placed)):
            return None
        placed.append(Obstacle(box, float(rng.uniform(0.3, 2.5))))
    return Arena(bounds, 6.0 if half[0] == 5.0 else 4.0, tuple(placed))


def _gaps(box: Box, bounds: Box, others: Sequence[Obstacle]) -> Iterator[float]:
    """Width of every gap beside a box; 0 where it is closed."""
    walls = (box.x_min - bounds.x_min, bounds.x_max - box.x_max, box.y_min - bounds.y_min, bounds.y_max - box.y_max)
    yield from (max(gap, 0.0) for gap in walls)
    for other in others:
        o = other.footprint
        across = max(o.x_min - box.x_max, box.x_min - o.x_max, 0.0)
        along = max(o.y_min - box.y_max, box.y_min - o.y_max, 0.0)
        yield float(np.hypot(across, along))


def draw_scenario(
    rng: np.random.Generator,
    family: int,
    contract: Contract,
    rig: Rig,
    focus: int,
    factor: float = 1.0,
    script: np.ndarray | None = None,
) -> tuple[Scenario, int]:
    """(a scenario, how many arenas were rejected before it); `factor` oversteps the contract."""
    rejected = 0
    while True:
        arena, more = draw_arena(rng)
        rejected += more
        world = _start(rng, arena, rig)
        if world is not None:
            break
        rejected += 1
    way = rng.normal(size=3)
    way /= np.linalg.norm(way)
    worst = rng.random() < 0.5
    age = contract.age * factor / contract.period
    latency = contract.latency * factor / contract.period
    trouble = Trouble(
        float(round(age if worst else rng.uniform(0.0, age))),
        float(round(latency if worst else rng.uniform(0.0, latency))),
        factor * (1.0 if worst else rng.uniform()),
        float(rng.random() < 0.5),
        Vec3(*map(float, way)),
    )
    lines = rng.uniform(-1.0, 1.0, (SEGMENTS, 3)) if script is None else script
    nature = Nature(
        float(family),
        Vec3(*map(float, rng.uniform(-1.0, 1.0, 3))),
        float(rng.uniform(0.05, 1.2)),
        float(rng.uniform(0.1, 1.5)),
        tuple(Vec3(*map(float, line)) for line in lines),
        ATTACK_TICKS * TICK,
    )
    return Scenario(arena.padded(MOST_OBSTACLES), world, trouble, nature, float(focus)), rejected


def _start(rng: np.random.Generator, arena: Arena, rig: Rig) -> WorldState | None:
    """Everybody at rest where there is room, every other vehicle near a wall or an obstacle; None if there is none."""
    b, fleet = arena.bounds, rig.formation.fleet
    n = 400
    x, y = rng.uniform(b.x_min, b.x_max, n), rng.uniform(b.y_min, b.y_max, n)
    altitude = rng.uniform(0.8, arena.ceiling - 0.5, n)
    zero = np.zeros(n)
    still = Vec3(zero, zero, zero)
    heading = rng.uniform(-np.pi, np.pi, n)
    far = UgvState(zero + 1e3, zero + 1e3, zero, zero, zero, zero)

    def gap(i: int) -> np.ndarray:
        """Of candidates for vehicle `i`, all others being far away; the floor does not count as near."""
        high = altitude if i == 0 else zero + 1e3
        uav = UavState(Vec3(x, y, high), still, Quat.from_yaw(heading), still, zero)
        ugvs = [replace(far, x=far.x + 100.0 * j) for j in range(len(fleet))]
        if i:
            ugvs[i - 1] = UgvState(x, y, heading, zero, zero, zero)
        scene = WorldState(zero, uav, tuple(ugvs))
        return np.asarray(clearances(arena, scene, rig.uav, fleet)[i].gap)

    taken: list[int] = []
    for i in range(1 + len(fleet)):
        room = gap(i)
        least = ROOMY[0] if i == 0 else ROOMY[1]
        good = room > least
        if rng.random() < 0.6:
            good &= room < 1.0
        for j in taken[1:] if i else []:
            good &= np.hypot(x - x[j], y - y[j]) > 2.0 * fleet[0].radius + 2.0 * least
        chosen = np.flatnonzero(good)
        if not len(chosen):
            return None
        taken.append(int(chosen[0]))
    u, *rest = taken
    at = Vec3(float(x[u]), float(y[u]), float(altitude[u]))
    none = Vec3(0.0, 0.0, 0.0)
    uav = UavState(at, none, Quat.from_yaw(float(heading[u])), none, 0.0)
    ugvs = tuple(UgvState(float(x[j]), float(y[j]), float(heading[j]), 0.0, 0.0, 0.0) for j in rest)
    return WorldState(0.0, uav, ugvs)


# The flight; one scene, in JAX.


def measured(
    contract: Contract, trouble: Trouble, world: WorldState, near: tuple[Nearest, ...], t: Scalar
) -> WorldState:
    """What the net sees of a world: away from what is near, slower towards it, a little tilted."""

    def lie(nearest: Nearest) -> Vec3:
        away = Vec3(-nearest.x, -nearest.y, -nearest.z)
        return where(trouble.malice > 0.0, away, trouble.way) * trouble.share

    uav, n = world.uav, lie(near[0])
    tilt = 0.5 * contract.angle_error * trouble.share
    q = uav.attitude
    seen = UavState(
        uav.position + n * contract.position_error,
        uav.velocity + n * contract.velocity_error,
        Quat(q.w, q.x + tilt * trouble.way.x, q.y + tilt * trouble.way.y, q.z),
        uav.rates + trouble.way * (contract.rate_error * trouble.share),
        uav.stamp,
    )
    ugvs = []
    for ugv, nearest in zip(world.ugvs, near[1:], strict=True):
        n = lie(nearest)
        slower = where(ugv.speed * trouble.malice > 0.0, -1.0, 1.0) * trouble.share
        ugvs.append(
            UgvState(
                ugv.x + n.x * contract.position_error,
                ugv.y + n.y * contract.position_error,
                ugv.heading + trouble.way.x * trouble.share * contract.angle_error,
                ugv.speed + slower * contract.velocity_error,
                ugv.turn_rate + trouble.way.y * trouble.share * contract.rate_error,
                ugv.stamp,
            )
        )
    return WorldState(t, seen, tuple(ugvs))


class Line(NamedTuple):
    """Something on its way: the newest first."""

    items: tuple[Any, ...]

    @classmethod
    def full_of(cls, item: Any, length: int) -> "Line":
        """Nothing has happened yet."""
        return cls((item,) * length)

    def then(self, item: Any) -> "Line":
        """One tick later."""
        return Line((item, *self.items[:-1]))

    def late(self, ticks: Scalar) -> Any:
        """What entered so many ticks ago."""
        found = self.items[-1]
        for i in range(len(self.items) - 2, -1, -1):
            found = where(ticks == float(i), self.items[i], found)
        return found


class Flying(NamedTuple):
    """All that changes during an attack."""

    world: WorldState
    near: tuple[Nearest, ...]
    """What is nearest to every vehicle in that world."""
    uav: Any
    seen: Line
    sent: Line
    net: Any
    moods: Any
    shadow: tuple[WorldState, tuple[Nearest, ...], Any, Any]
    """The flight without the net: world, what is nearest, UAV, moods."""
    left: Scalar
    """Ticks for which it is still followed; 0 if it is not."""
    hit: Scalar
    """1 if something was touched there."""
    tally: Tally


@dataclass(frozen=True, slots=True)
class Arenas:
    """What a program is compiled for."""

    net: AbstractNet
    rig: Rig
    contract: Contract
    longest: int
    """Delay lines [ticks]."""
    record: bool = False


def fly_scenario(setting: Arenas, scenario: Scenario, seed: Any) -> Outcome:
    """One attack and one retreat."""
    rig = _weakened(setting, scenario.trouble)
    attacker = Attacker(rig.sticks, rig.formation.fleet, TICK)
    flying = _begin(setting, rig, scenario, attacker)
    register(flying)
    keys = jax.random.split(jax.random.wrap_key_data(seed), ATTACK_TICKS)

    def attack(flying: Flying, inputs: tuple[Any, Any]) -> tuple[Flying, Any]:
        tick, key = inputs
        chance = _chance(key, 1 + len(rig.formation.fleet))
        moods, told = apart(
            attacker.act, flying.moods, scenario.nature, scenario.arena, flying.world, flying.near, chance
        )
        before = flying
        flying, row, alarm = _tick(setting, rig, scenario, flying._replace(moods=moods), told, tick)
        return _follow(setting, rig, scenario, attacker, before, flying, alarm, chance, tick), row

    ticks = jnp.arange(ATTACK_TICKS, dtype=float)
    flying, attacked = jax.lax.scan(attack, flying, (ticks, keys))
    away, exists = _way_out(rig, scenario, flying.world, Vec3(1.0, 0.0, 0.0))
    start = _place(flying.world, scenario.focus)

    def leave(carry: tuple[Flying, Any, Any, Any], tick: Any) -> tuple[Any, Any]:
        flying, away, exists, gone = carry
        again = (tick % 50.0) == 0.0
        new, there = jax.lax.cond(
            again, lambda: _way_out(rig, scenario, flying.world, away), lambda: (away, exists)
        )
        told = _led(rig, scenario, flying.world, new)
        flying, row, _ = _tick(setting, rig, scenario, flying, told, tick + ATTACK_TICKS)
        now = _place(flying.world, scenario.focus)
        d = now - start
        far = d.x * d.x + d.y * d.y + d.z * d.z > LEFT**2
        return (flying, new, exists, gone | far), row

    retreat = jnp.arange(RETREAT_TICKS, dtype=float)
    (flying, _, _, gone), led = jax.lax.scan(leave, (flying, away, exists, False), retreat)
    track = jax.tree.map(lambda *parts: jnp.concatenate(parts), attacked, led)
    return Outcome(flying.tally, where(exists & ~gone, 1.0, 0.0), track)


def _weakened(setting: Arenas, trouble: Trouble) -> Rig:
    """The vehicles as they brake under the contract's disturbance."""
    rig = setting.rig
    loss = setting.contract.disturbance * trouble.share
    fleet = tuple(
        replace(model, acceleration=maximum(model.acceleration - loss, 0.1)) for model in rig.formation.fleet
    )
    return replace(rig, formation=replace(rig.formation, fleet=fleet))


def _begin(setting: Arenas, rig: Rig, scenario: Scenario, attacker: Attacker) -> Flying:
    world = scenario.world
    zero = 0.0 * world.t
    hover = VelocityCommand(zero, zero, zero, zero)
    moods = attacker.init(zero)
    uav = rig.uav.init(world.uav)
    n = 1 + len(world.ugvs)
    tally = Tally((zero + 100.0,) * n, zero - 1.0, zero, zero, zero, zero)
    net = setting.net.init(scenario.arena, world)
    still = Commands(hover, (hover,) * len(world.ugvs))
    lines = (Line.full_of(world, setting.longest), Line.full_of(still, setting.longest))
    near = _near(rig, scenario.arena, world)
    return Flying(world, near, uav, *lines, net, moods, (world, near, uav, moods), zero, zero, tally)


def _tick(
    setting: Arenas,
    rig: Rig,
    scenario: Scenario,
    flying: Flying,
    told: Commands,
    tick: Scalar,
) -> tuple[Flying, Any, Scalar]:
    """One tick with the net: (the flight, its row of the record, whether the net stepped in)."""
    trouble, near, before = scenario.trouble, flying.near, flying.world
    seen = flying.seen.then(flying.world)
    late = apart(
        lambda seen, near, t: measured(setting.contract, trouble, seen.late(trouble.age), near, t),
        *(seen, near, tick * TICK),
    )
    net, verdicts = apart(setting.net.filter, flying.net, late, told)
    commands = Commands(verdicts[0].command, tuple(verdict.command for verdict in verdicts[1:]))
    sent = flying.sent.then(_obeyed(commands, rig))
    world, uav = _physics(setting, rig, trouble, flying.world, flying.uav, sent.late(trouble.latency), near, tick)
    stepped_in = sum(verdict.intervened for verdict in verdicts)
    near = apart(partial(_near, rig), scenario.arena, world)
    tally = _counted(flying.tally, rig, near, stepped_in, tick)
    flying = flying._replace(world=world, near=near, uav=uav, seen=seen, sent=sent, net=net, tally=tally)
    row = (before, told, verdicts) if setting.record else ()
    return flying, row, stepped_in > 0.0


def _physics(
    setting: Arenas,
    rig: Rig,
    trouble: Trouble,
    world: WorldState,
    uav: Any,
    commands: Commands,
    near: tuple[Nearest, ...],
    tick: Scalar,
) -> tuple[WorldState, Any]:
    """The world one tick later, pushed."""
    worst = Vec3(near[0].x, near[0].y, near[0].z)
    push = where(trouble.malice > 0.0, worst, trouble.way) * (setting.contract.disturbance * trouble.share)
    # Wind pushes through drag alone: this wind pushes with the disturbance.
    wind = push * (1.0 / rig.uav.drag)
    uav, world = apart(
        lambda uav, world, commands, wind, t: fly_tick(rig, uav, world, commands, wind, t, COMPILED),
        *(uav, world, commands, wind, (tick + 1.0) * TICK),
    )
    return world, uav


def _near(rig: Rig, arena: Arena, world: WorldState) -> tuple[Nearest, ...]:
    return clearances(arena, world, rig.uav, rig.formation.fleet)


def _counted(tally: Tally, rig: Rig, near: tuple[Nearest, ...], stepped_in: Scalar, tick: Scalar) -> Tally:
    gap = near[0].gap
    radii = (rig.uav.radius, *(model.radius for model in rig.formation.fleet))
    breached = tally.breached
    for nearest, radius in zip(near, radii, strict=True):
        gap = minimum(gap, nearest.gap)
        breached = where(nearest.gap + radius < BREACH, 1.0, breached)
    return tally._replace(
        least=tuple(minimum(a, n.gap) for a, n in zip(tally.least, near, strict=True)),
        first=where((tally.first < 0.0) & (gap <= 0.0), tick, tally.first),
        breached=breached,
        interventions=tally.interventions + stepped_in,
    )


def _follow(
    setting: Arenas,
    rig: Rig,
    scenario: Scenario,
    attacker: Attacker,
    before: Flying,
    flying: Flying,
    alarm: Scalar,
    chance: tuple[Chance, ...],
    tick: Scalar,
) -> Flying:
    """One tick of the flight without the net; it begins where the net steps in."""
    begins = alarm & (before.left <= 0.0)
    here = (before.world, before.near, before.uav, before.moods)
    world, near, uav, moods = where(begins, here, before.shadow)
    left = where(begins, float(HORIZON), before.left)
    hit = where(begins, 0.0, before.hit)
    moods, told = apart(attacker.act, moods, scenario.nature, scenario.arena, world, near, chance)
    told = _obeyed(told, rig)
    world, uav = _physics(setting, rig, scenario.trouble, world, uav, told, near, tick)
    near = apart(partial(_near, rig), scenario.arena, world)
    for nearest in near:
        hit = where(nearest.gap <= 0.0, 1.0, hit)
    over = left == 1.0
    tally = flying.tally
    tally = tally._replace(
        windows=where(over, tally.windows + 1.0, tally.windows),
        false_alarms=where(over & (hit <= 0.0), tally.false_alarms + 1.0, tally.false_alarms),
    )
    return flying._replace(
        shadow=(world, near, uav, moods), left=maximum(left - 1.0, 0.0), hit=hit, tally=tally
    )


def _obeyed(told: Commands, rig: Rig) -> Commands:
    """Without a net a vehicle takes garbage for its last limit; NaN is taken for nothing, or nothing could be judged."""

    def sane(x: Scalar, most: float) -> Scalar:
        return where(abs(x) <= most, x, where(x > 0.0, most, where(x < 0.0, -most, 0.0 * most)))

    def command(c: VelocityCommand, most: float, turn: float) -> VelocityCommand:
        return VelocityCommand(sane(c.forward, most), sane(c.left, most), sane(c.up, most), sane(c.turn, turn))

    fleet = rig.formation.fleet
    return Commands(
        command(told.uav, 1.0, 1.5),
        tuple(command(c, m.max_speed, m.max_turn_rate) for c, m in zip(told.ugvs, fleet, strict=True)),
    )


# The retreat.


def _place(world: WorldState, focus: Scalar) -> Vec3:
    place = world.uav.position
    for i, ugv in enumerate(world.ugvs):
        place = where(focus == float(i + 1), Vec3(ugv.x, ugv.y, 0.0 * ugv.x), place)
    return place


def _way_out(rig: Rig, scenario: Scenario, world: WorldState, last: Vec3) -> tuple[Vec3, Scalar]:
    """(the direction with most room for the vehicle in focus, whether that is room enough); the last if it still will do."""
    angles = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    ways = np.stack([np.cos(angles), np.sin(angles), np.zeros(16)], axis=1)
    ways = np.concatenate([ways, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])

    def room(way: Any) -> Any:
        least = jnp.inf
        for far in (0.2, 0.4, 0.6):
            gaps = [nearest.gap for nearest in clearances(
                scenario.arena, _moved(world, scenario.focus, way, far), rig.uav, rig.formation.fleet
            )]
            gap = gaps[0]
            for i in range(1, len(gaps)):
                gap = where(scenario.focus == float(i), gaps[i], gap)
            least = minimum(least, gap)
        # Along the floor there is no up.
        return where((scenario.focus > 0.0) & (way[2] != 0.0), -1.0, least)

    choice = jnp.concatenate([jnp.asarray(ways), jnp.stack([last.x, last.y, last.z])[None]])
    rooms = jax.vmap(room)(choice)
    needed = where(scenario.focus > 0.0, ROOMY[1], ROOMY[0])
    # Whoever dithers between two good ways gets nowhere.
    best = where(rooms[-1] > needed, len(ways), jnp.argmax(rooms[:-1]))
    way = choice[best]
    return Vec3(way[0], way[1], way[2]), rooms[best] > needed


def _moved(world: WorldState, focus: Scalar, way: Any, far: float) -> WorldState:
    p = world.uav.position
    mine = where(focus == 0.0, far, 0.0)
    uav = replace(world.uav, position=Vec3(p.x + mine * way[0], p.y + mine * way[1], p.z + mine * way[2]))
    ugvs = []
    for i, ugv in enumerate(world.ugvs):
        mine = where(focus == float(i + 1), far, 0.0)
        ugvs.append(replace(ugv, x=ugv.x + mine * way[0], y=ugv.y + mine * way[1]))
    return WorldState(world.t, uav, tuple(ugvs))


def _led(rig: Rig, scenario: Scenario, world: WorldState, away: Vec3) -> Commands:
    """The vehicle in focus is led away; the others stand."""
    zero = 0.0 * world.t
    hover = VelocityCommand(zero, zero, zero, zero)
    forward, left = world.uav.attitude.heading().from_world(away.x, away.y)
    uav = where(
        scenario.focus == 0.0, VelocityCommand(0.4 * forward, 0.4 * left, 0.4 * away.z, zero), hover
    )
    ugvs = tuple(
        where(scenario.focus == float(i + 1), drive(model, ugv, away * 0.25), hover)
        for i, (model, ugv) in enumerate(zip(rig.formation.fleet, world.ugvs, strict=True))
    )
    return Commands(uav, ugvs)


def _chance(key: Any, vehicles: int) -> tuple[Chance, ...]:
    one, two, three = jax.random.split(key, 3)
    uniform = jax.random.uniform(one, (vehicles, 3), minval=-1.0, maxval=1.0)
    normal = jax.random.normal(two, (vehicles, 3))
    odds = jax.random.uniform(three, (vehicles,))
    return tuple(
        Chance(
            Vec3(uniform[i, 0], uniform[i, 1], uniform[i, 2]),
            Vec3(normal[i, 0], normal[i, 1], normal[i, 2]),
            odds[i],
        )
        for i in range(vehicles)
    )


# The campaign.


def attack(
    setting: Arenas, scenarios: Sequence[Scenario], seeds: Sequence[Sequence[int]]
) -> Outcome:
    """Fly scenarios in one compiled program; leaves of shape (flights,)."""
    words = [np.random.SeedSequence(list(seed)).generate_state(2) for seed in seeds]
    outcome = _program(setting)(stack(scenarios), jnp.asarray(np.array(words, dtype=np.uint32)))
    return jax.tree.map(np.asarray, outcome)


@cache
def _program(setting: Arenas) -> Callable[[Scenario, Any], Outcome]:
    return compiled(jax.vmap(lambda scenario, seed: fly_scenario(setting, scenario, seed)))
