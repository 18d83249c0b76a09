"""The definitions: their sums are those that every ROS 1 node in the world compares."""

import json

import debian
import pytest

from fledge.lab.wire import definitions
from fledge.lab.wire.rosmsg import Kind

SUMS = {
    "std_msgs/Empty": "d41d8cd98f00b204e9800998ecf8427e",
    "std_msgs/Header": "2176decaecbce78abc3b96ef049fabed",
    "geometry_msgs/TransformStamped": "b5764a33bfeb3588febc2682852579b0",
    "geometry_msgs/Twist": "9f195f881246fdfa2798d1d3eebca84a",
    "nav_msgs/Odometry": "cd5e73d190d741a2f92e81eda573aca7",
    "sensor_msgs/Image": "060021388200f6f0f447d0fcd9c64743",
    "sensor_msgs/Joy": "5a9ea5f83505693b71e785041e67a8bb",
    "ardrone_autonomy/Navdata": "e1169f766234363125ac62c9a3f87eeb",
}
"""As catkin generates them; the last is in roslisp's, rosjs' and rosserial's files, too."""

THEIRS = """
import json, sys
from importlib import import_module
sums = {}
for name in sys.argv[1:]:
    package, kind = name.split("/")
    sums[name] = getattr(import_module(package + ".msg"), kind)._md5sum
print(json.dumps(sums))
"""


def kinds() -> dict[str, Kind]:
    return {kind.name: kind for kind in vars(definitions).values() if isinstance(kind, Kind)}


@pytest.mark.parametrize("name", SUMS)
def test_sums_are_the_known_ones(name):
    assert kinds()[name].md5 == SUMS[name]


@debian.needs_ros
def test_sums_are_those_of_debians_packages():
    ours = {name: kind.md5 for name, kind in kinds().items() if not name.startswith("ardrone")}
    assert json.loads(debian.run(THEIRS, *ours)) == ours
