"""The default net's own rule."""

import pytest
from aloft import HALL, HOVER, always, fly, world

from fledge.geometry import Vec3
from fledge.safety import StopTube
from fledge.world import Commands, VelocityCommand


def passed(net: StopTube, at: float, speed: float, told: float) -> bool:
    """Whether a command east passes, at x = `at` and that speed."""
    start = world((at, 0.0, 3.0), velocity=Vec3(speed, 0.0, 0.0))
    _, verdicts = net.filter(
        net.init(HALL, start), start, Commands(VelocityCommand(told, 0.0, 0.0, 0.0), (HOVER,) * 3)
    )
    return not verdicts[0].intervened


def nearest_passing(net: StopTube, speed: float) -> float:
    """Largest x [m] at which going on with a speed passes."""
    return max(x for x in (4.9 - 0.005 * i for i in range(600)) if passed(net, x, speed, speed))


def test_all_or_nothing():
    net = StopTube()
    log = fly(net, world((3.0, 0.0, 3.0)), always(VelocityCommand(0.7, 0.1, 0.0, 0.3)), 3.0)
    whole = VelocityCommand(0.7, 0.1, 0.0, 0.3)
    assert log.verdicts[0][0].command == whole
    assert any(verdicts[0].command == HOVER for verdicts in log.verdicts), "it brakes by hovering"


def test_the_margin_is_the_stop_by_the_contract():
    net = StopTube()
    c, stop = net.contract, net.uav
    unknown = stop.speed * c.velocity_error + stop.tilt * c.angle_error + stop.rate * c.rate_error
    for speed in (0.0, 0.5, 1.0):
        margin = 5.0 - nearest_passing(net, speed) - stop.radius
        side = unknown + stop.miss(speed, 0.0)
        expected = c.position_error + max(side, stop.hold) + speed * (stop.speed + stop.hold_over)
        assert margin == pytest.approx(expected, abs=0.006)


def test_the_margin_grows_with_speed_and_with_its_scale():
    margins = [[5.0 - nearest_passing(StopTube(scale=k), v) for v in (0.0, 0.5, 1.0)] for k in (0.5, 1.0)]
    for row in margins:
        assert row == sorted(row) and row[0] < row[-1]
    assert all(half < whole for half, whole in zip(*margins, strict=True))


def test_a_way_out_must_lead_out_faster_than_the_push_drifts():
    net = StopTube()
    assert not passed(net, 4.72, 0.0, -0.1)
    assert passed(net, 4.72, 0.0, -0.16)
    assert net.outwards > net.contract.disturbance / 2.5
