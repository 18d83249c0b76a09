"""The twin as a whole: flights over its wires, from the floor and in the air, and the same bytes for the same seed."""

from dataclasses import replace
from math import hypot

import numpy as np
import pytest
from workbench import Client, aloft, steady

from fledge.geometry import Box, Vec3
from fledge.lab.twin.bridge import Bridge
from fledge.lab.twin.cameras import SUBJECTS, Cameras, Sight, Spell
from fledge.lab.twin.contacts import AREA, FLOOR, Witness
from fledge.lab.twin.draught import Draught
from fledge.lab.twin.drone import Drone
from fledge.lab.twin.firmware import Phase
from fledge.lab.twin.senses import Senses
from fledge.lab.twin.twin import TICK, Options, Twin
from fledge.lab.wire import ardrone, topics
from fledge.lab.wire.ardrone import Config, Ctrl, Flag, Mode, Pcmd, Ref
from fledge.lab.wire.datagrams import AT, NAVDATA, VICON, Datagram, Heard
from fledge.lab.wire.messages import Empty, Twist
from fledge.lab.wire.navdata import ControlState, State
from fledge.world import Arena, Obstacle

pytestmark = pytest.mark.slow

LAB = Arena.lab()
FAST = Options(duration=60.0)
EXACT = Senses(level=0.0, trimmed=0.0, turn=0.0, velocity=0.0, up=0.0, altitude=0.0)
CALM = Draught(gust=0.0, mean=Draught().mean * 0.0)


def client(seed=0, options=FAST, arena=LAB):
    return Client(Twin(arena, seed, options))


def below_uav(twin):
    """How far the UAV is from above the UGVs' middle [m]."""
    now = twin.world()
    middle = [sum(getattr(u, name) for u in now.ugvs) / 3.0 for name in "xy"]
    return hypot(now.uav.position.x - middle[0], now.uav.position.y - middle[1])


def test_take_off_hover_and_landing_by_the_drone_itself():
    one = client()
    one.run(1.0, steady(fly=False))
    assert one.twin.phase == Phase.LANDED
    one.run(6.0, steady())
    assert one.twin.phase == Phase.FLYING
    assert one.twin.world().uav.position.z == pytest.approx(1.065, abs=0.15)
    one.run(6.0, steady(fly=False))
    assert one.twin.phase == Phase.LANDED
    assert one.twin.world().uav.position.z == pytest.approx(0.065, abs=0.01)
    assert one.twin.contacts == []
    states = [data.demo.control for data in one.navdata if data.demo]
    order = list(dict.fromkeys(states))
    assert order == [
        ControlState.LANDED,
        ControlState.TAKING_OFF,
        ControlState.HOVERING,
        ControlState.LANDING,
    ]


def test_navdata_begin_with_a_bootstrap_and_acknowledge_the_configuration():
    def script(t):
        if t < 0.5:
            return (Ref(fly=False),)
        return (Ref(fly=False), Config("general:navdata_demo", "TRUE") if t < 1.0 else Ctrl(Mode(5)))

    one = client().run(2.0, script)
    kinds = [(State.BOOTSTRAP in n.state, State.COMMAND_ACK in n.state, n.demo is None) for n in one.navdata]
    assert list(dict.fromkeys(kinds)) == [(True, False, True), (False, True, False), (False, False, False)]


def test_its_poses_are_those_of_its_world():
    one = aloft()
    one.run(1.0, steady())
    now, (uav, *ugvs) = one.twin.world(), one.twin.poses()
    assert uav == (now.uav.position, now.uav.attitude)
    for (place, attitude), ugv in zip(ugvs, now.ugvs, strict=True):
        nose = attitude.heading()
        assert (place.x, place.y) == (ugv.x, ugv.y)
        assert (nose.cos, nose.sin) == pytest.approx((np.cos(ugv.heading), np.sin(ugv.heading)), abs=1e-4)


@pytest.mark.parametrize(("value", "rate"), (("TRUE", 15), ("FALSE", 200)))
def test_navdata_come_at_the_protocol_s_rates(value, rate):
    one = client().run(0.2, lambda t: (Ref(fly=False), Config("general:navdata_demo", value)))
    before = len(one.navdata)
    one.run(2.0, lambda t: (Ref(fly=False),))
    assert len(one.navdata) - before == pytest.approx(2.0 * rate, abs=1)


def test_frames_come_at_100_hz_and_show_the_truth():
    one = aloft()
    one.run(1.0, steady())
    assert [frame.number for frame in one.frames] == list(range(1, 101))
    last, now = one.frames[-1], one.twin.world()
    assert tuple(item.name for item in last.objects) == SUBJECTS
    p, seen = now.uav.position, last.objects[0].position
    assert (seen.x, seen.y, seen.z) == pytest.approx((p.x, p.y, p.z), abs=5e-3)


def test_a_start_aloft_is_above_the_formation_at_its_ideal_height():
    for seed in range(5):
        twin = aloft(seed=seed).twin
        now = twin.world()
        assert below_uav(twin) < 1e-9
        radius = max(hypot(u.x - now.uav.position.x, u.y - now.uav.position.y) for u in now.ugvs)
        assert 374.7 * radius / now.uav.position.z == pytest.approx(108.0)


def test_a_start_aloft_goes_on_hovering():
    one = aloft()
    begin = one.twin.world().uav.position
    one.run(5.0, steady())
    end = one.twin.world().uav.position
    assert max(one.heights) - min(one.heights) < 0.1
    assert hypot(end.x - begin.x, end.y - begin.y) < 0.4
    assert one.twin.phase == Phase.FLYING


@pytest.mark.parametrize(
    ("command", "axis", "sign"),
    (
        (Pcmd(0.0, -0.5, 0.0, 0.0), "forward", 1.0),
        (Pcmd(0.5, 0.0, 0.0, 0.0), "left", -1.0),
        (Pcmd(0.0, 0.0, -0.5, 0.0), "up", -1.0),
    ),
)
def test_it_flies_where_it_is_told(command, axis, sign):
    one = aloft(draught=CALM, drone=Drone(senses=EXACT))
    one.run(1.2, steady(command))
    now = one.twin.world().uav
    forward, left = now.attitude.heading().from_world(now.velocity.x, now.velocity.y)
    moves = {"forward": forward, "left": left, "up": now.velocity.z}
    assert sign * moves[axis] > 0.2
    assert all(abs(value) < 0.1 for name, value in moves.items() if name != axis)


def test_full_tilt_is_a_push_and_not_a_speed():
    one = aloft(draught=CALM, drone=Drone(senses=EXACT))
    speeds = []
    for _ in range(3):
        one.run(0.5, steady(Pcmd(0.0, -0.2, 0.0, 0.0)))
        v = one.twin.world().uav.velocity
        speeds.append(hypot(v.x, v.y))
    assert speeds[2] > 1.3 * speeds[1] > 1.3 * speeds[0]


def test_left_alone_it_hovers_and_after_two_seconds_it_lands():
    one = aloft()
    # Backwards: on the way ahead it would come down on a robot.
    one.run(1.0, steady(Pcmd(0.0, 0.5, 0.0, 0.0)))
    one.run(1.5, lambda t: ())
    v = one.twin.world().uav.velocity
    assert one.twin.phase == Phase.FLYING and hypot(v.x, v.y) < 0.3
    assert State.COM_WATCHDOG in one.navdata[-1].state
    one.run(1.0, lambda t: ())
    assert one.twin.phase == Phase.LANDING
    assert State.COM_LOST in one.navdata[-1].state
    one.run(12.0, lambda t: ())
    assert one.twin.phase == Phase.LANDED


def test_an_emergency_drops_it():
    one = aloft()
    one.run(0.5, steady())
    one.run(1.5, lambda t: (Ref(fly=False, emergency=True),))
    assert one.twin.phase == Phase.EMERGENCY
    assert one.heights[-1] < 0.5


def test_a_hover_drifts_but_not_far():
    gone = []
    for seed in range(3):
        one = aloft(seed=seed)
        begin = one.twin.world().uav.position
        one.run(20.0, steady())
        end = one.twin.world().uav.position
        gone.append(hypot(end.x - begin.x, end.y - begin.y))
    assert all(0.01 < far < 1.5 for far in gone)


def test_the_ugvs_wait_and_then_follow():
    one = client()
    one.run(3.0, steady(fly=False))
    assert max(abs(ugv.speed) for ugv in one.twin.world().ugvs) < 0.01
    other = aloft()
    before = other.twin.world().ugvs
    other.run(15.0, steady())
    after = other.twin.world().ugvs
    assert max(hypot(a.x - b.x, a.y - b.y) for a, b in zip(before, after, strict=True)) > 0.3
    assert other.twin.contacts == []


def test_same_seed_same_bytes():
    def heard_and_said(seed):
        one, said = client(seed), []
        for _ in range(400):
            said += one.tick(steady())
        return said

    first = heard_and_said(3)
    assert first == heard_and_said(3)
    assert first != heard_and_said(4)


def test_commands_take_their_time():
    options = replace(FAST, aloft=True, draught=CALM, drone=Drone(senses=EXACT))
    quick, slow = (client(0, replace(options, link_delay=delay)) for delay in (0.0, 0.1))
    for one in (quick, slow):
        one.run(0.6, steady(Pcmd(0.0, -1.0, 0.0, 0.0)))
    fast, late = (hypot(v.x, v.y) for v in (one.twin.world().uav.velocity for one in (quick, slow)))
    assert fast - late == pytest.approx(0.1 * 2.0, rel=0.3)


def test_the_cameras_change_when_they_are_told_to():
    spell = Spell(0.5, 1.0, Sight(hidden=("p3at",)))
    one = client(options=replace(FAST, cameras=Cameras(spells=(spell,))))
    one.run(1.5, steady(fly=False))
    short = [frame.number for frame in one.frames if len(frame.objects) == 3]
    assert short == list(range(51, 101))


def test_crossing_the_edge_of_the_safe_area_is_a_contact_by_the_referee_alone():
    one = aloft()
    one.run(6.0, steady(Pcmd(0.0, -1.0, 0.0, 0.0)))
    assert one.twin.contacts[0].who == "ardrone"
    assert (one.twin.contacts[0].what, one.twin.contacts[0].witness) == (AREA, Witness.REFEREE)
    assert 0.5 < one.twin.contacts[0].t < 5.0
    assert sum(contact.what == AREA for contact in one.twin.contacts) == 1  # told of once


def test_flying_into_the_floor_is_one_by_both():
    one = aloft()
    one.run(10.0, steady(Pcmd(0.0, 0.0, -1.0, 0.0)))
    witnesses = {contact.witness for contact in one.twin.contacts if contact.what == FLOOR}
    assert witnesses == {Witness.PHYSICS, Witness.REFEREE}


def test_flying_into_an_obstacle_is_one_by_both():
    walls = tuple(
        Obstacle(box, 3.9)
        for box in (
            Box(-3.0, 3.0, 1.9, 2.1),
            Box(-3.0, 3.0, -2.1, -1.9),
            Box(2.5, 2.7, -1.8, 1.8),
            Box(-2.7, -2.5, -1.8, 1.8),
        )
    )
    one = Client(Twin(Arena(LAB.bounds, 4.0, walls), 0, replace(FAST, aloft=True)))
    one.run(6.0, steady(Pcmd(0.0, -1.0, 0.0, 0.0)))
    first = {c.what for c in one.twin.contacts if c.who == "ardrone" and c.what.startswith("obstacle")}
    assert first
    witnesses = {c.witness for c in one.twin.contacts if c.what in first}
    assert witnesses == {Witness.PHYSICS, Witness.REFEREE}


@pytest.mark.parametrize("data", (b"", b"\0" * 100, b"AT*PCMD=1,1,0,0\r", bytes(range(256))))
def test_rubbish_on_any_channel_changes_nothing(data):
    def said(junk):
        one = client()
        found = []
        for k in range(50):
            sent = [Datagram(NAVDATA, b"\1"), Datagram(AT, ardrone.encode(1 + k, Ref(fly=False)))]
            extra = [Datagram(c, data) for c in (AT, VICON, "sticks", "/p3at/cmd_vel", "?")] if junk else []
            found += one.twin.tick(Heard(k * TICK, (*sent, *extra)))
        return found

    assert said(True) == said(False)


def test_a_flight_of_ten_seconds_stays_in_the_room():
    """Hands that know where the UAV is can hold it over the UGVs by tilt alone."""
    one = aloft(seed=2)

    def hold(t):
        now = one.twin.world()
        p, v = now.uav.position, now.uav.velocity
        x, y = (sum(getattr(u, name) for u in now.ugvs) / 3.0 for name in "xy")
        ahead, aside = now.uav.attitude.heading().from_world(
            2.0 * (x - p.x) - 1.5 * v.x, 2.0 * (y - p.y) - 1.5 * v.y
        )
        shares = [float(np.clip(a / 2.06, -1.0, 1.0)) for a in (aside, ahead)]
        return Ref(fly=True), Pcmd(-shares[0], -shares[1], 0.0, 0.0, Flag.PROGRESSIVE)

    one.run(10.0, hold)
    assert below_uav(one.twin) < 0.5
    assert one.twin.contacts == []


class RosClient(Client):
    """Somebody who speaks to the twin over topics alone."""

    def fly(self, seconds, said):
        """Tick by tick; returns the messages by topic."""
        found = {}
        for _ in range(round(seconds / TICK)):
            sent = tuple(Datagram(topic, topics.encode(message)) for topic, message in said(self.twin.t))
            for one in self.twin.tick(Heard(self.twin.t, sent)):
                if one.channel.startswith("/"):
                    found.setdefault(one.channel, []).append(topics.decode(one.channel, one.data))
        return found


def by_topics(velocity=False, **options):
    twin = Twin(LAB, 0, replace(FAST, bridge=Bridge(velocity=velocity), draught=CALM, **options))
    return RosClient(twin)


def forward(x, turn=0.0):
    return Twist(Vec3(x, 0.0, 0.0), Vec3(0.0, 0.0, turn))


def test_over_topics_it_takes_off_flies_and_lands():
    one = by_topics(drone=Drone(senses=EXACT))
    one.fly(0.5, lambda t: ())
    found = one.fly(7.0, lambda t: [(topics.TAKE_OFF, Empty())] if t < 0.6 else [])
    assert one.twin.phase == Phase.FLYING and one.twin.world().uav.position.z == pytest.approx(
        1.065, abs=0.15
    )
    assert len(found["/vicon/ardrone/ardrone"]) == 700
    assert len(found[topics.NAVDATA]) == pytest.approx(350, abs=5)
    assert len(found["/p3at/odom"]) == 70
    one.fly(0.6, lambda t: [(topics.FLY, forward(0.4))])
    v = one.twin.world().uav.velocity
    assert hypot(v.x, v.y) > 0.2
    one.fly(10.0, lambda t: [(topics.LAND, Empty())])
    assert one.twin.phase == Phase.LANDED
    assert one.twin.contacts == []


@pytest.mark.parametrize("speed", (0.3, -0.5))
def test_over_tum_simulators_topics_a_twist_is_a_speed(speed):
    one = by_topics(velocity=True, aloft=True, drone=Drone(senses=EXACT))
    one.fly(0.2, lambda t: [(topics.TAKE_OFF, Empty())])
    one.fly(2.5, lambda t: [(topics.FLY, forward(speed))])
    now = one.twin.world().uav
    ahead, aside = now.attitude.heading().from_world(now.velocity.x, now.velocity.y)
    assert ahead == pytest.approx(speed, abs=0.15 * abs(speed) + 0.05)
    assert abs(aside) < 0.05


def test_over_topics_robots_obey_them_alone_and_stop_when_nobody_speaks():
    one = by_topics()
    before = one.twin.world().ugvs
    one.fly(1.0, lambda t: [("/p3dx1/cmd_vel", forward(0.3))])
    moved = one.twin.world().ugvs
    assert moved[1].speed == pytest.approx(0.3, rel=0.05)
    assert moved[0].speed == pytest.approx(0.0, abs=0.01)
    one.fly(1.2, lambda t: ())
    after = one.twin.world().ugvs
    assert abs(after[1].speed) < 0.01
    gone = hypot(after[1].x - before[1].x, after[1].y - before[1].y)
    assert gone == pytest.approx(0.3 * 1.6, rel=0.2)


def test_messages_are_stamped_by_the_clock_of_whoever_has_one():
    twin = by_topics().twin
    twin.epoch = 1e9
    stamps = []
    for k in range(20):
        for one in twin.tick(Heard(5.0 + k * TICK)):
            if one.channel == "/vicon/p3at/p3at":
                stamps.append(topics.decode(one.channel, one.data).header.stamp - 1e9 - 5.0 - k * TICK)
    assert stamps == pytest.approx([-0.006] * 20, abs=1e-5)
