"""Velocities from poses: the bound, and what becomes of poses that are wrong."""

from dataclasses import replace
from math import cos, inf, nan, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fledge.geometry import Quat, Vec3
from fledge.lab.control.estimator import Estimator, Pose
from fledge.supervision.inputs import Inputs
from fledge.supervision.watchdog import Severity, Watchdog
from fledge.world import Commands, Reason, UavState, UgvState, VelocityCommand

E = Estimator()
TICK = 0.01
LEVEL = Quat(1.0, 0.0, 0.0, 0.0)
NOISE, ACCELERATION = 0.0005, 2.4


def pose(stamp, x=0.0, y=0.0, z=2.0, attitude=LEVEL) -> Pose:
    return Pose(stamp, Vec3(x, y, z), attitude)


def driving(stamp, x, heading=0.0, y=0.0) -> Pose:
    return Pose(stamp, Vec3(x, y, 0.0), Quat.from_yaw(heading))


def states(poses, vehicle=0):
    """What was shown after each pose of one vehicle, others standing by."""
    memory, shown = E.init(2), []
    for one in poses:
        memory = E.see(E.begin(memory), vehicle, one)
        shown.append(memory[vehicle].doubt or memory[vehicle].state)
    return shown


def known(shown):
    """Those that are new and were shown with a velocity of their own."""
    return [s for before, s in zip([None, *shown], shown, strict=False) if s is not None and s is not before]


# The bound.


def test_a_steady_motion_is_known_exactly():
    for s in known(states([pose(i * TICK, x=0.7 * i * TICK, z=2.0 - 0.2 * i * TICK) for i in range(50)])):
        assert (s.velocity.x, s.velocity.z) == pytest.approx((0.7, -0.2))
        assert s.rates == Vec3(0.0, 0.0, 0.0)


def test_nothing_is_known_before_everybody_was_seen_for_long_enough():
    memory = E.init(2)
    for i in range(20):
        memory = E.see(memory, 0, pose(i * TICK))
        assert E.world(memory, i * TICK) is None
    for i in range(20):
        memory = E.see(memory, 1, driving(i * TICK, 1.0))
        world = E.world(memory, 0.3)
        assert (world is None) == (i * TICK < E.shortest)
    assert world is not None
    assert (world.t, world.uav.stamp, world.ugvs[0].stamp) == pytest.approx((0.3, 0.19, 0.19))


@pytest.mark.slow
@given(
    st.lists(
        st.tuples(st.sampled_from((-1.0, 1.0)), st.sampled_from((-1.0, 1.0)), st.booleans()), min_size=60
    ),
    st.sampled_from((0.005, 0.01, 0.02)),
)
def test_no_noise_no_bang_bang_and_no_loss_breaks_the_bound(ticks, period):
    x, v, bound = 0.0, 0.3, E.velocity_error(NOISE, ACCELERATION)
    memory = E.init(1)
    for i, (push, error, lost) in enumerate(ticks):
        a = push * ACCELERATION
        x, v = x + v * period + 0.5 * a * period * period, v + a * period
        if lost:
            continue
        before = memory[0].state
        memory = E.see(memory, 0, pose(i * period, x=x + error * NOISE))
        shown = memory[0].state
        if shown is not before:
            assert isinstance(shown, UavState)
            assert abs(shown.velocity.x - v) <= bound + 1e-12


def test_the_bound_is_no_larger_than_it_has_to_be():
    """Each of its terms is reached by somebody: noise over the shortest time, acceleration over the longest."""
    near = [pose(t, x=error * NOISE) for t, error in ((0.0, -1.0), (E.shortest, 1.0))]
    assert states(near)[-1].velocity.x == pytest.approx(E.velocity_error(NOISE, 0.0))
    far = [pose(t, x=0.5 * ACCELERATION * t * t) for t in (0.0, 0.02, E.longest)]
    lag = ACCELERATION * E.longest - states(far)[-1].velocity.x
    assert lag == pytest.approx(E.velocity_error(0.0, ACCELERATION))


def test_what_the_contract_says_of_velocities_holds_within_the_lab_s_tilt():
    assert E.velocity_error(NOISE, ACCELERATION) < 0.1


@pytest.mark.slow
def test_a_flight_with_noise_and_losses_stays_within_the_bound_and_raises_no_alarm():
    rng, watch = np.random.default_rng(0), Watch()
    bound, worst = E.velocity_error(NOISE, ACCELERATION), 0.0
    for i in range(3000):
        t = i * TICK
        x, v = 1.5 * sin(1.2 * t), 1.8 * cos(1.2 * t)  # accelerates by up to 2.16 m/s^2
        noise = rng.uniform(-NOISE, NOISE, 3) / np.sqrt(3.0)
        if rng.random() < 0.1 and i > 5:
            watch.tick()
            continue
        truth = pose(t, x=x + noise[0], y=noise[1], z=2.0 + noise[2])
        alarm = watch.tick(truth)
        if watch.world and watch.world.uav.stamp == t:
            worst = max(worst, abs(watch.world.uav.velocity.x - v))
            assert alarm.severity == Severity.OK
    assert 0.3 * bound < worst <= bound


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 0.6, 0.8), (0.48, -0.6, 0.64)])
def test_rates_are_known_within_their_bound(axis):
    """Spinning up about a fixed axis, seen with errors about any axis."""
    rng, spin_up, off = np.random.default_rng(1), 20.0, 0.001
    bound = E.rate_error(off, spin_up)
    for sign in (1.0, -1.0):  # of the quaternion: the same rotation
        poses, truth = [], {}
        for i in range(40):
            t = i * TICK
            q = turned(Quat(0.6, 0.0, 0.8, 0.0), axis, 0.5 * spin_up * t * t)
            q = turned(q, unit(rng), rng.uniform(-off, off))
            flip = sign if i % 2 else 1.0
            poses.append(pose(t, attitude=Quat(*(flip * x for x in (q.w, q.x, q.y, q.z)))))
            truth[t] = tuple(spin_up * t * x for x in axis)
        for s in known(states(poses)):
            error = np.array([s.rates.x, s.rates.y, s.rates.z]) - truth[s.stamp]
            assert np.linalg.norm(error) <= 1.01 * bound


def turned(q: Quat, axis, angle: float) -> Quat:
    """`q` followed by a rotation about an axis of the body."""
    w, s = cos(0.5 * angle), sin(0.5 * angle)
    x, y, z = (s * a for a in axis)
    return Quat(
        q.w * w - q.x * x - q.y * y - q.z * z,
        q.w * x + q.x * w + q.y * z - q.z * y,
        q.w * y - q.x * z + q.y * w + q.z * x,
        q.w * z + q.x * y - q.y * x + q.z * w,
    )


def unit(rng):
    v = rng.standard_normal(3)
    return tuple(v / np.linalg.norm(v))


def test_a_ugv_drives_along_its_nose_forwards_and_back_and_its_heading_counts_turns():
    poses, x, y = [], 0.0, 0.0
    for i in range(1000):
        heading = 1.0 + 1.2 * i * TICK
        speed = 0.4 if i < 500 else -0.4
        x, y = x + speed * cos(heading - 0.006) * TICK, y + speed * sin(heading - 0.006) * TICK
        poses.append(driving(i * TICK, x, heading, y))
    shown = states(poses, vehicle=1)
    assert isinstance(shown[-1], UgvState)
    assert shown[-1].heading == pytest.approx(1.0 + 1.2 * 9.99)
    for i in (300, 800):
        assert (shown[i].speed, shown[i].turn_rate) == pytest.approx(
            (0.4 if i < 500 else -0.4, 1.2), abs=0.01
        )


def test_a_ugv_that_shows_up_with_its_nose_the_other_way_does_not_spin():
    """As after a swap: on either side of half a turn from the last heading, by the noise on it."""
    before = [driving(i * TICK, 0.0) for i in range(20)]
    after = [driving((20 + i) * TICK, 3.0, pi + 0.001 * (-1) ** i) for i in range(20)]
    shown = states(before + after, vehicle=1)
    assert shown[-1].x == 3.0
    assert max(abs(s.turn_rate) for s in shown if s is not None) <= E.rate_error(0.001, 0.0)


# What is wrong.


class Watch:
    """The estimator and the watchdog, one behind the other, as in the lab's tick."""

    def __init__(self):
        self.t, self.poses, self.dog, self.memory = 0.0, E.init(3), Watchdog(), None
        self.world = None
        self.named, self.worst = set(), Severity.OK
        self.trusted = None

    def tick(self, *uav: Pose, ugvs=(1.0, -1.0)):
        """10 ms with these poses of the UAV, the UGVs standing at these places; the UAV's alarm."""
        self.poses = E.begin(self.poses)
        for one in uav:
            self.poses = E.see(self.poses, 0, one)
        for i, x in enumerate(ugvs, start=1):
            if x is not None:
                self.poses = E.see(self.poses, i, driving(self.t, x))
        self.world = E.world(self.poses, self.t)
        alarms = None
        if self.world is not None:
            if self.memory is None:
                self.memory = self.dog.init(self.world)
            hover = VelocityCommand.hover()
            inputs = Inputs.unattended(self.world, Commands(hover, (hover, hover)))
            self.memory, self.trusted, alarms = self.dog.check(self.memory, inputs)
            for alarm in alarms:
                self.named.add(Reason(int(alarm.reason)))
                self.worst = max(self.worst, Severity(int(alarm.severity)))
        self.t = round(self.t + TICK, 9)
        return alarms[0] if alarms else None

    def fly(self, seconds, **how):
        """On and on at 0.5 m/s."""
        for _ in range(round(seconds / TICK)):
            self.tick(self.here(), **how)

    def here(self, **but) -> Pose:
        return pose(self.t, **({"x": 0.5 * self.t} | but))

    def forget(self):
        self.named, self.worst = set(), Severity.OK


def flying() -> Watch:
    watch = Watch()
    watch.fly(1.0)
    assert watch.worst == Severity.OK
    return watch


BAD = {
    "no number": lambda w: pose(w.t, x=nan),
    "infinite": lambda w: pose(w.t, z=-inf),
    "an attitude that is none": lambda w: w.here(attitude=Quat(nan, 0.0, 0.0, 0.0)),
    "elsewhere": lambda w: w.here(y=0.5),
    "millimetres": lambda w: w.here(x=500.0 * w.t, z=2000.0),
    "the same stamp": lambda w: pose(w.t - TICK, x=0.5 * w.t + 0.05),
    "an older stamp": lambda w: pose(w.t - 5 * TICK, x=0.5 * w.t),
}
NAMES = {
    "no number": Reason.BAD_POSE,
    "infinite": Reason.BAD_POSE,
    "an attitude that is none": Reason.BAD_POSE,
    "elsewhere": Reason.JUMP,
    "millimetres": Reason.BAD_POSE,
    "the same stamp": Reason.DUPLICATE,
    "an older stamp": Reason.BACKWARD,
}


@pytest.mark.parametrize("kind", BAD)
def test_one_bad_pose_is_named_at_once_and_leaves_no_trace(kind):
    watch, clean = flying(), flying()
    alarm = watch.tick(BAD[kind](watch))
    clean.tick()
    assert (alarm.severity, alarm.reason) == (Severity.WARN, NAMES[kind])
    for _ in range(30):
        watch.tick(watch.here())
        clean.tick(clean.here())
        assert watch.world == clean.world
        assert watch.trusted == clean.trusted
    assert watch.worst == Severity.WARN


LASTING = [kind for kind in BAD if "stamp" not in kind]


@pytest.mark.parametrize("kind", LASTING)
def test_bad_poses_for_good_are_flown_by_for_a_tenth_of_a_second_at_most(kind):
    watch = flying()
    for _ in range(30):
        alarm = watch.tick(BAD[kind](watch))
    assert NAMES[kind] in watch.named
    assert alarm.severity >= Severity.BRAKE


def test_who_stays_elsewhere_is_believed_again_and_somebody_is_called():
    watch = flying()
    for _ in range(150):
        watch.tick(watch.here(y=0.5))
    assert watch.named == {Reason.NONE, Reason.JUMP}
    assert watch.worst == Severity.STOP
    watch.forget()
    for _ in range(30):
        watch.tick(watch.here(y=0.5))
    assert watch.worst == Severity.OK
    assert watch.trusted.uav.position.y == 0.5
    assert watch.trusted.uav.velocity.x == pytest.approx(0.5)


def test_two_that_change_places_are_named_both():
    watch = flying()
    watch.fly(0.02, ugvs=(-1.0, 1.0))
    assert watch.named == {Reason.NONE, Reason.SWAP}
    watch.fly(1.5, ugvs=(-1.0, 1.0))
    assert watch.named == {Reason.NONE, Reason.SWAP}
    assert watch.worst == Severity.STOP


@pytest.mark.parametrize(
    ("seconds", "worst"),
    [(0.05, Severity.OK), (0.3, Severity.BRAKE), (0.7, Severity.HOLD), (2.5, Severity.LAND)],
)
def test_a_pause_is_an_age_and_then_velocities_are_right_from_the_first(seconds, worst):
    watch = flying()
    for _ in range(round(seconds / TICK)):
        watch.tick()
    braking = 0.8 * (watch.t - 1.0)  # it has not stood still meanwhile
    x = 0.5 * 1.0 + braking
    start = watch.t
    for _ in range(30):
        watch.tick(pose(watch.t, x=x - 0.3 * (watch.t - start)))
        fresh = watch.trusted.uav.stamp >= start
        if fresh:
            assert watch.trusted.uav.velocity.x == pytest.approx(-0.3)
    assert fresh
    assert watch.worst == worst
    assert watch.named <= {Reason.NONE, Reason.STALE}


def test_poses_that_overtake_each_other_do_no_harm():
    watch, rng = flying(), np.random.default_rng(3)
    waiting = []
    for _ in range(300):
        waiting.append(watch.here())
        if rng.random() < 0.7:
            rng.shuffle(waiting)
            watch.tick(*waiting)
            waiting = []
        else:
            watch.tick()
    assert watch.worst <= Severity.WARN
    assert watch.trusted.uav.velocity.x == pytest.approx(0.5)


@pytest.mark.parametrize("together", [True, False])
def test_of_two_bodies_under_one_name_one_is_followed(together):
    watch = flying()
    for i in range(300):
        both = watch.here(), watch.here(y=1.0)
        watch.tick(*(both if together else both[i % 2 : i % 2 + 1]))
        assert watch.trusted.uav.position.y == 0.0
        assert watch.trusted.uav.velocity.y == 0.0
    assert together or Reason.JUMP in watch.named


def test_a_body_that_flickers_between_two_places_shows_no_velocity_between_them():
    memory = E.init(1)
    for i in range(100):
        memory = E.see(E.begin(memory), 0, pose(i * TICK, y=0.5 if i % 3 == 0 else 0.0))
        for state in (memory[0].state, memory[0].doubt):
            assert state is None or state.velocity == Vec3(0.0, 0.0, 0.0)


def test_the_watchdog_s_idea_of_a_jump_is_the_estimator_s():
    assert E.tracker == Watchdog().tracker
    assert E.longest <= Watchdog().tracker.gap
    assert replace(E, longest=0.05).velocity_error(0.0, 1.0) == pytest.approx(0.025)
    assert E.rate_error(0.001, pi) == E.velocity_error(0.001, pi)
