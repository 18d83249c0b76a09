"""Motion capture: noise of the right size, what is lost, hidden, swapped and late."""

from math import pi

import numpy as np
import pytest

from fledge.errors import FledgeError, OutOfRange, UnknownName
from fledge.geometry import Quat, Vec3
from fledge.lab.twin.cameras import NORMALS, SUBJECTS, Cameras, Memory, Sight, Spell
from fledge.lab.wire import vicon

POSES = [(Vec3(0.1 * i, -0.2 * i, 1.0), Quat.from_yaw(0.3 * i)) for i in range(len(SUBJECTS))]
STILL = [0.0] * NORMALS


def frames(cameras, seconds=0.1, poses=POSES, rng=None):
    """What arrives in a while, at the end of which tick, counted from 1."""
    memory, found = Memory(), []
    for tick in range(1, round(seconds / 0.01) + 1):
        normal = STILL if rng is None else rng.standard_normal(NORMALS).tolist()
        uniform = 0.5 if rng is None else rng.random()
        memory = cameras.shoot(memory, 0.01 * tick - 0.006, poses, normal, uniform)
        memory, arrived = cameras.deliver(memory, 0.01 * tick)
        found += [(tick, shot.frame) for shot in arrived]
    return found


def test_every_frame_has_everybody_where_they_are():
    (tick, frame), *_ = frames(Cameras())
    assert (tick, frame.number) == (1, 1)
    assert tuple(one.name for one in frame.objects) == SUBJECTS
    for one, (position, attitude) in zip(frame.objects, POSES, strict=True):
        assert one.position == position
        assert one.attitude.z == pytest.approx(attitude.z)


def test_a_hundred_frames_a_second_numbered_in_turn():
    numbers = [frame.number for _, frame in frames(Cameras(), 1.0)]
    assert numbers == list(range(1, 101))


def test_when_a_frame_was_taken_is_not_lost():
    memory = Cameras().shoot(Memory(), 0.25, POSES, STILL, 0.5)
    assert [shot.taken for shot in Cameras().deliver(memory, 0.26)[1]] == [0.25]


def test_noise_has_its_size():
    cameras = Cameras(Sight(noise=0.002, angle_noise=0.01))
    level = [(Vec3(0.0, 0.0, 0.0), Quat(1.0, 0.0, 0.0, 0.0))] * len(SUBJECTS)
    seen = frames(cameras, 20.0, level, np.random.default_rng(0))
    offsets = [[p.x, p.y, p.z] for _, f in seen for p in [one.position for one in f.objects]]
    angles = [[r.x, r.y, r.z] for _, f in seen for r in [one.rotation for one in f.objects]]
    assert np.std(offsets, axis=0) == pytest.approx([0.002] * 3, rel=0.05)
    assert np.std(angles, axis=0) == pytest.approx([0.01] * 3, rel=0.05)


def test_frames_get_lost_but_are_counted():
    seen = frames(Cameras(Sight(dropout=0.3)), 20.0, rng=np.random.default_rng(1))
    assert len(seen) == pytest.approx(0.7 * 2000, rel=0.05)
    assert seen[-1][1].number > 1990


def test_a_hidden_subject_is_missing():
    _, frame = frames(Cameras(Sight(hidden=("ardrone",))))[0]
    assert tuple(one.name for one in frame.objects) == SUBJECTS[1:]


def test_two_subjects_are_taken_for_each_other():
    _, frame = frames(Cameras(Sight(swapped=("p3at", "p3dx2"))))[0]
    where = {one.name: one.position for one in frame.objects}
    assert where["p3at"] == POSES[3][0] and where["p3dx2"] == POSES[1][0]
    assert where["ardrone"] == POSES[0][0]


@pytest.mark.parametrize(("latency", "ticks"), ((0.005, 0), (0.006, 0), (0.01, 1), (0.05, 5)))
def test_frames_arrive_when_they_have_been_under_way_for_long_enough(latency, ticks):
    assert [tick - frame.number for tick, frame in frames(Cameras(Sight(latency=latency)), 0.2)] == [
        ticks
    ] * (20 - ticks)


def test_a_spell_passes():
    cameras = Cameras(spells=(Spell(0.1, 0.2, Sight(hidden=("ardrone",))),))
    short = [frame.number for _, frame in frames(cameras, 0.3) if len(frame.objects) == 3]
    assert short == list(range(11, 21))  # those taken from 0.104 to 0.194 s


def test_of_two_spells_the_later_counts():
    calm, blind = Sight(noise=0.0), Sight(dropout=1.0)
    cameras = Cameras(spells=(Spell(0.0, 1.0, blind), Spell(0.2, 0.3, calm)))
    assert (cameras.at(0.1), cameras.at(0.25), cameras.at(2.0)) == (blind, calm, Sight())


def test_frames_overtake_each_other_where_the_delay_shrinks():
    cameras = Cameras(spells=(Spell(0.0, 0.05, Sight(latency=0.1)),))
    numbers = [frame.number for _, frame in frames(cameras, 0.3)]
    assert sorted(numbers) == list(range(1, 31)) and numbers != sorted(numbers)


def test_what_is_far_away_is_not_seen():
    poses = [(Vec3(0.0, 0.0, 200.0), POSES[0][1]), *POSES[1:]]
    _, frame = frames(Cameras(), poses=poses)[0]
    assert len(vicon.encode(frame)) in vicon.SIZES
    assert tuple(one.name for one in frame.objects) == SUBJECTS[1:]


def test_every_attitude_can_be_told():
    for yaw in np.linspace(-pi, pi, 9):
        poses = [(Vec3(0.0, 0.0, 1.0), Quat.from_yaw(float(yaw)))] * len(SUBJECTS)
        _, frame = frames(Cameras(), poses=poses)[0]
        assert vicon.decode(vicon.encode(frame)).objects[0].attitude.z == pytest.approx(
            np.sin(yaw / 2), abs=1e-9
        )


def test_what_no_camera_does_is_refused():
    with pytest.raises(OutOfRange, match="dropout of the cameras is 1.5: valid is 0 to 1"):
        Sight(dropout=1.5)
    with pytest.raises(OutOfRange, match="latency"):
        Sight(latency=float("nan"))
    with pytest.raises(UnknownName, match="unknown subject 'ardron'"):
        Sight(hidden=("ardron",))
    with pytest.raises(FledgeError, match="from 2 to 1 s: valid is one that ends after it began"):
        Spell(2, 1, Sight())


@pytest.mark.parametrize(
    ("text", "sight"),
    (
        ("20:22:dropout=0.5", Sight(dropout=0.5)),
        ("20:22:hidden=ardrone", Sight(hidden=("ardrone",))),
        ("20:22:hidden=ardrone,p3at", Sight(hidden=("ardrone", "p3at"))),
        ("20:22:swapped=p3at,p3dx1", Sight(swapped=("p3at", "p3dx1"))),
        ("20:22:latency=5e-2", Sight(latency=0.05)),
    ),
)
def test_a_spell_can_be_written_down(text, sight):
    assert Spell.read(text) == Spell(20.0, 22.0, sight)


@pytest.mark.parametrize(
    "text",
    (
        "",
        "20",
        "20:22",
        "20:22:dropout",
        "20:22:dropout=much",
        "a:b:dropout=0.1",
        "1:2:swapped=p3at",
        "1:2:x=1",
    ),
)
def test_what_is_no_spell_is_refused(text):
    with pytest.raises(
        FledgeError, match="valid is BEGIN:END:WHAT=VALUE, in seconds, with WHAT one of noise"
    ):
        Spell.read(text)
