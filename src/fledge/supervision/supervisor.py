"""Layer two of the safety net: who flies each vehicle, decided anew every tick.

The watchdog says what may be believed, the table of modes who flies, layer one (the net) what of it is let through:

    inputs -> `Watchdog.check` -> `modes.advance` -> one command per vehicle -> `AbstractNet.filter` -> verdicts

| mode | command | through the net |
|---|---|---|
| AUTO, SHIELDED | the policy's; none while an alarm says "brake" | yes |
| RECOVER | from the last command sent to the policy's, faded over `settle` | yes |
| HOLD, STOPPED | none | yes |
| MANUAL | the person's | yes, unless the dead-man switch is held |
| LAND | down at `descent`, or up and aside where that was held back | yes, but for the floor |
| INIT, READY, TERMINATED | none | no |

No command is for the net to answer, which brakes and holds a point; where there is no net it is zero velocity. Only a
blind landing does not pass the net: what a net does not see cannot hold it back. Whatever the net did not say itself
it is told (`AbstractNet.overruled`), since the room that it keeps is for stopping from what was really sent.

Nothing here reads a clock: timers are differences of the times that come in. What a mode means for motors (off in INIT,
READY and TERMINATED) is for the link to the vehicle.
"""

from dataclasses import dataclass, field
from math import nan

from fledge.geometry import Vec3
from fledge.safety.base import AbstractNet
from fledge.safety.stop_tube import StopTube
from fledge.scalars import Scalar, clip, maximum, negate, sqrt, where
from fledge.supervision.inputs import HOVER, Inputs, finite, said, sane
from fledge.supervision.modes import TABLE, Mode, Row, Trigger, advance
from fledge.supervision.posts import Decision, Memory, Passed, Post, Situation, is_in
from fledge.supervision.tracking import LEAD
from fledge.supervision.watchdog import Alarm, Severity, Watchdog
from fledge.world import Arena, Commands, Reason, UavState, VelocityCommand, Verdict, WorldState

IDLE = (Mode.INIT, Mode.READY, Mode.TERMINATED)

LONG_AGO = 1e3
"""[s] before the flight: when everything that has not happened yet happened last."""

NOTHING = VelocityCommand(nan, nan, nan, nan)
"""No command: a net that steers brakes, and holds."""


@dataclass(frozen=True, slots=True)
class Supervisor:
    """Limits, and the parts."""

    net: AbstractNet = StopTube()
    watchdog: Watchdog = Watchdog()
    settle: float = 1.0  # [s] a fault must be gone, and a fade lasts; chosen: braking from 1 m/s takes 0.8 s
    deaf: float = 5.0  # [s] that a hold does not listen to sticks; PX4's COM_FAIL_ACT_T
    shown: float = 0.5  # [s] that SHIELDED outlasts its cause; chosen, so that a log can be read
    taking: float = 0.3  # share of full deflection that takes over; PX4's COM_RC_STICK_OV
    holding: float = 0.1  # [s] it must last, so that a spike takes nothing over; chosen
    neutral: float = 0.1  # share of full deflection that counts as hands off; chosen
    silence: float = 0.5  # [s] without the link that end MANUAL; PX4's COM_RC_LOSS_T
    descent: float = 0.3  # [m/s]; chosen
    inset: float = 1.0  # [m] from both walls of a corner: where a landing that is held back goes; chosen
    table: tuple[Row, ...] = field(default=TABLE, metadata={"static": True})

    def init(self, arena: Arena, world: WorldState) -> Memory:
        """Every vehicle in INIT, nothing having happened yet."""
        t = world.t
        past = t - LONG_AGO
        post = Post(float(Mode.INIT), float(Reason.NOT_READY), t, past, past, t, 0.0, HOVER)
        vehicles = 1 + len(world.ugvs)
        pad = Vec3(arena.bounds.x_min + self.inset, arena.bounds.y_min + self.inset, 0.0)
        return Memory(self.watchdog.init(world), self.net.init(arena, world), (post,) * vehicles, pad)

    def step(self, memory: Memory, inputs: Inputs) -> tuple[Memory, tuple[Decision, ...]]:
        """(memory, one decision per vehicle, the UAV first)."""
        watch, world, alarms = self.watchdog.check(memory.watch, inputs)
        situations = self._situations(world, alarms, inputs, memory.pad)
        posts = [self._post(*pair) for pair in zip(memory.posts, situations, strict=True)]
        wanted = [self._wanted(*pair) for pair in zip(posts, situations, strict=True)]
        net, verdicts = self.net.filter(memory.net, world, _commands(wanted))
        vehicles = list(zip(posts, situations, wanted, verdicts, strict=True))
        passed = [self._passed(*vehicle) for vehicle in vehicles]
        net = self.net.overruled(net, world, _commands([one.instead for one in passed]))
        done = [
            self._decide(post, s, verdict, one)
            for (post, s, _, verdict), one in zip(vehicles, passed, strict=True)
        ]
        kept, decisions = tuple(post for post, _ in done), tuple(decision for _, decision in done)
        return Memory(watch, net, kept, memory.pad), decisions

    def _situations(
        self, world: WorldState, alarms: tuple[Alarm, ...], inputs: Inputs, pad: Vec3
    ) -> tuple[Situation, ...]:
        grounded = inputs.airborne <= 0.5
        always = grounded | True
        landing = VelocityCommand(0.0, 0.0, -self.descent, 0.0)
        aside = _aside(pad, world.uav, self.descent)
        too_old = self.watchdog.poses[0][0]
        states, commands = (world.uav, *world.ugvs), (inputs.proposed.uav, *inputs.proposed.ugvs)
        return tuple(
            Situation(
                world.t,
                alarms[i],
                commands[i],
                inputs.operators[i],
                alarms[i].severity >= float(Severity.BRAKE),
                world.t - inputs.heard,
                always if i else grounded,
                negate(world.t - state.stamp <= too_old),
                HOVER if i else landing,
                HOVER if i else aside,
            )
            for i, state in enumerate(states)
        )

    def _post(self, post: Post, s: Situation) -> Post:
        """The mode after this tick, and what it remembers."""
        before = (post.mode, post.reason)
        mode, reason = advance(self.table, before, self._triggers(post, s), s.alarm.reason)
        return Post(
            mode,
            reason,
            where(mode == post.mode, post.since, s.now),
            where(s.braking, s.now, post.alarmed),
            post.held_back,
            where(s.operator.deflection > self.taking, post.at_rest, s.now),
            post.free,
            post.origin,
        )

    def _triggers(self, post: Post, s: Situation) -> dict[Trigger, Scalar]:
        """What is so; every condition says what is good of what could be NaN."""
        o, severity, lasted = s.operator, s.alarm.severity, s.now - post.since
        linked = (s.silent >= -LEAD) & (s.silent <= self.silence)
        calm = negate(s.braking) & (s.now - post.alarmed >= self.settle)
        moved = (o.deflection > self.taking) & (s.now - post.at_rest >= self.holding)
        hands_off = (o.switch <= 0.5) & (o.dead_man <= 0.5) & (o.deflection <= self.neutral)
        held_back = s.now - post.held_back <= self.shown
        return {
            Trigger.TERMINATE: said(o.terminate),
            Trigger.LAND: said(o.land),
            Trigger.STOP: said(o.stop),
            Trigger.ARM: said(o.arm),
            Trigger.DISARM: o.arm <= 0.5,
            Trigger.SWITCH: said(o.switch) & linked,
            Trigger.STICKS: moved & linked,
            Trigger.HAND_BACK: said(o.hand_back) & linked & hands_off & calm & said(post.free),
            Trigger.LINK_LOST: negate(linked),
            Trigger.ON_GROUND: s.on_ground,
            Trigger.ALARM_BRAKE: s.braking,
            Trigger.ALARM_HOLD: severity >= float(Severity.HOLD),
            Trigger.ALARM_STOP: severity >= float(Severity.STOP),
            Trigger.ALARM_LAND: severity >= float(Severity.LAND),
            Trigger.CALM: calm,
            Trigger.HELD_BACK: held_back,
            Trigger.QUIET: negate(held_back),
            Trigger.LASTED: lasted >= self.settle,
            Trigger.HEARD_OUT: lasted >= self.deaf,
        }

    def _wanted(self, post: Post, s: Situation) -> VelocityCommand:
        """What the vehicle is to do, before the net has a look."""
        share = clip((s.now - post.since) / self.settle, 0.0, 1.0)
        faded = post.origin.scaled(1.0 - share) + s.proposed.scaled(share)
        held_back = (post.held_back >= post.since) & (s.now - post.held_back <= self.shown)
        down = where(held_back & negate(s.blind), s.aside, s.descent)
        wanted = where(is_in(post, Mode.LAND), down, NOTHING)
        wanted = where(is_in(post, Mode.MANUAL) & sane(s.operator), s.operator.command, wanted)
        wanted = where(is_in(post, Mode.RECOVER), faded, wanted)
        return where(is_in(post, Mode.AUTO, Mode.SHIELDED) & negate(s.braking), s.proposed, wanted)

    def _passed(self, post: Post, s: Situation, wanted: VelocityCommand, net: Verdict) -> Passed:
        """What comes of that where the net has its say, and where it has none."""
        manual, landing = is_in(post, Mode.MANUAL), is_in(post, Mode.LAND)
        alone = is_in(post, *IDLE) | (landing & s.blind) | (manual & said(s.operator.dead_man))
        # Held back by the floor alone, it comes down, and keeps to the place that the net holds.
        floor = landing & negate(alone) & (net.reason == float(Reason.FLOOR))
        known, answered = finite(wanted), finite(net.command)
        onto = VelocityCommand(net.command.forward, net.command.left, wanted.up, 0.0)
        sent = where(
            alone, where(known, wanted, HOVER), where(answered, where(floor, onto, net.command), HOVER)
        )
        own = where(floor & answered, VelocityCommand(nan, nan, sent.up, nan), NOTHING)
        return Passed(
            sent,
            where(alone | negate(answered), sent, own),
            negate(alone | floor) & negate(net.intervened <= 0.5),
            (manual & negate(known)) | (negate(alone) & known & negate(answered)),
        )

    def _decide(self, post: Post, s: Situation, net: Verdict, passed: Passed) -> tuple[Post, Decision]:
        """(what is remembered, what is sent and why)."""
        manual, policy = is_in(post, Mode.MANUAL), is_in(post, Mode.AUTO, Mode.SHIELDED)
        braking = policy & s.braking
        reason = where((policy | manual) & passed.filtered, net.reason, post.reason)
        reason = where(passed.broken, float(Reason.NOT_FINITE), where(braking, s.alarm.reason, reason))
        held_back = passed.filtered | braking | passed.broken
        kept = Post(
            post.mode,
            post.reason,
            post.since,
            post.alarmed,
            where(held_back & (policy | is_in(post, Mode.LAND)), s.now, post.held_back),
            post.at_rest,
            where(manual & negate(net.intervened <= 0.5), 0.0, 1.0),
            where(is_in(post, Mode.RECOVER), post.origin, passed.sent),
        )
        intervened = where(policy & negate(held_back), 0.0, 1.0)
        verdict = Verdict(passed.sent, intervened, reason, net.clearance)
        return kept, Decision(post.mode, verdict, s.alarm)


@dataclass(frozen=True, slots=True)
class Supervised(AbstractNet):
    """A supervisor in a net's place: of a flight that lacks nothing, and that nobody attends to."""

    supervisor: Supervisor = Supervisor()

    def init(self, arena: Arena, world: WorldState) -> Memory:
        """The supervisor's."""
        return self.supervisor.init(arena, world)

    def filter(
        self, memory: Memory, world: WorldState, commands: Commands
    ) -> tuple[Memory, tuple[Verdict, ...]]:
        """What it decides, without saying in which mode."""
        memory, decisions = self.supervisor.step(memory, Inputs.unattended(world, commands))
        return memory, tuple(decision.verdict for decision in decisions)


def _aside(place: Vec3, uav: UavState, speed: float) -> VelocityCommand:
    """Towards a place, and up: over what is in the way."""
    dx, dy = place.x - uav.position.x, place.y - uav.position.y
    share = speed / maximum(sqrt(dx * dx + dy * dy), speed)
    forward, left = uav.attitude.heading().from_world(dx * share, dy * share)
    return VelocityCommand(forward, left, speed, 0.0)


def _commands(each: list[VelocityCommand]) -> Commands:
    uav, *ugvs = each
    return Commands(uav, tuple(ugvs))
