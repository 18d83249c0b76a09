"""The berth a net gives is what it says of itself, or keeps; and who gets out of a margin again."""

import numpy as np
import pytest

from fledge.dynamics import UGV_FLEET, Quadrotor
from fledge.errors import FledgeError
from fledge.geometry import Box
from fledge.room import free_share
from fledge.safety import NoNet, PaperNet, StopTube
from fledge.study.berth import PUSH, SPEEDS, announced, margin, reach, stand_off
from fledge.world import Arena

pytestmark = pytest.mark.slow

PAPER, DEFAULT = PaperNet(), StopTube()


@pytest.mark.parametrize("vehicle", (0, 1, 3))
def test_the_papers_margin_is_the_papers_margin(vehicle):
    """And one period's way, which is all its foresight."""
    for speed in (0.25, 1.0):
        assert margin(PAPER, vehicle, speed) == pytest.approx(0.5 + 0.01 * speed, abs=2e-3)


def test_without_a_net_only_the_hull_is_kept():
    found = reach({"none": NoNet()}, Arena.lab())["none"]
    assert margin(NoNet(), 0, 1.0) < 2e-3
    assert {row["margin_m"] for row in found["uav"]} == {Quadrotor().radius}
    assert {row["margin_m"] for row in found["ugv"]} == {UGV_FLEET[0].radius}


@pytest.mark.parametrize("vehicle", (0, 1))
def test_the_default_keeps_more_the_faster_a_vehicle_comes(vehicle):
    kept = [margin(DEFAULT, vehicle, max(speed, 1e-3)) for speed in SPEEDS[:3]]
    assert (np.diff(kept) > 0.05).all()
    # At rest: the hull, and what measurements and a held point may be off.
    hull = (Quadrotor().radius, UGV_FLEET[0].radius)[vehicle]
    assert hull < kept[0] < hull + 0.25


def test_a_wider_margin_leaves_less():
    found = reach({"stop-tube": DEFAULT}, Arena.lab())["stop-tube"]
    assert [row["speed"] for row in found["uav"]] == list(SPEEDS)
    for rows in found.values():
        assert (np.diff([row["share"] for row in rows]) < 0.0).all()
        assert rows[1]["share"] == free_share(Arena.lab(), rows[1]["margin_m"])


def test_called_back_from_a_wall_one_stays_and_the_other_comes():
    """The paper's rule overshoots its margin of 0.5 m, hull included, and lets no command pass in there."""
    found = stand_off({"paper": PAPER, "stop-tube": DEFAULT})
    late = np.array(found["t_s"]) > PUSH
    stuck, free = (np.array(found["gap_m"][name]) for name in ("paper", "stop-tube"))
    assert stuck[late].max() < 0.5 - Quadrotor().radius
    assert free.min() > 0.0 and free[-1] > 1.5


def test_a_net_is_announced_by_where_it_steps_in():
    said = announced("stop-tube", DEFAULT, Arena.lab())
    assert said.startswith("stop-tube steps in so far before a wall, hull to wall: UAV 0.")
    gap = margin(DEFAULT, 0, 0.5) - Quadrotor().radius
    assert f"{gap:.2f} m at 0.5 m/s" in said and "; UGV 0." in said
    assert announced("none", NoNet(), Arena.lab()).endswith("UAV never; UGV never")


@pytest.mark.parametrize("net", (DEFAULT, PAPER), ids=("stop-tube", "paper"))
def test_a_margin_larger_than_the_arena_is_refused(net):
    closet = Arena(Box(0.0, 0.9, 0.0, 3.0), 2.0)
    with pytest.raises(FledgeError, match="leaves no room in an arena of 0.9 x 3 m.* at most 0.4"):
        announced("it", net, closet)
