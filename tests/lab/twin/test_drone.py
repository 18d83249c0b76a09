"""The AR.Drone put together: its parts in their order, the battery, the trim."""

import pytest
from workbench import room

from fledge.lab.twin.drone import SAG, Drone
from fledge.lab.twin.firmware import Phase
from fledge.lab.twin.loops import STILL
from fledge.lab.twin.scene import TIMESTEP
from fledge.lab.twin.senses import BIRTH_NORMALS, NORMALS
from fledge.lab.wire import ardrone, navdata
from fledge.lab.wire.ardrone import Config, Ftrim, Pcmd, Ref

DRONE = Drone()
QUIET = [0.0] * NORMALS
BORN = [1.0] * BIRTH_NORMALS
MOTION = room().uav()


def hear(memory, *commands, t=0.0, asked=False, first=1):
    data = [ardrone.encode(first, *commands)] if commands else []
    return DRONE.hear(memory, t, data, asked, MOTION, QUIET, 0.01)


def test_on_the_floor_the_rotors_stand_still():
    memory = hear(DRONE.init(0.0, BORN))
    assert DRONE.fly(memory, MOTION, TIMESTEP)[1] == STILL


def test_a_command_reaches_the_rotors():
    memory = hear(
        DRONE.init(0.0, [0.0] * BIRTH_NORMALS, aloft=True), Ref(fly=True), Pcmd(0.0, -1.0, 0.0, 0.0)
    )
    _, (front_left, rear_left, rear_right, front_right) = DRONE.fly(memory, MOTION, TIMESTEP)
    assert rear_left > front_left and rear_right > front_right  # nose down


def test_an_emptier_battery_lifts_less():
    def lifted(battery):
        memory = hear(DRONE.init(0.0, [0.0] * BIRTH_NORMALS, aloft=True, battery=battery), Ref(fly=True))
        return sum(DRONE.fly(memory, MOTION, TIMESTEP)[1])

    assert lifted(0.5) == pytest.approx((1.0 - 0.5 * SAG) * lifted(1.0))


def test_what_the_rotors_draw_empties_the_battery():
    memory = hear(DRONE.init(0.0, [0.0] * BIRTH_NORMALS, aloft=True), Ref(fly=True))
    for _ in range(5):
        memory, _ = DRONE.fly(memory, MOTION, TIMESTEP)
    flown = DRONE.rest(memory, 0.01).knows.battery
    spent = 0.01 / DRONE.firmware.endurance
    assert 1.0 - flown == pytest.approx(1.02 * spent, rel=0.05)  # it hovers
    idle = DRONE.rest(hear(DRONE.init(0.0, BORN)), 0.01).knows.battery
    assert flown < idle < 1.0


def test_told_that_it_stands_level_it_mends_its_attitude():
    before = DRONE.init(0.0, BORN)
    after = hear(before, Ftrim())
    assert abs(after.errors.roll) < abs(before.errors.roll)


def test_navdata_begin_when_somebody_asks():
    memory = hear(DRONE.init(0.0, BORN), Config("general:navdata_demo", "TRUE"))
    assert DRONE.say(memory, 0.0, MOTION)[1] is None
    memory, data = DRONE.say(hear(memory, asked=True), 0.0, MOTION)
    assert navdata.decode(data).demo.battery == 1.0
    assert DRONE.say(memory, 0.01, MOTION)[1] is None  # 15 a second


def test_in_the_air_it_begins_in_flight():
    assert DRONE.init(0.0, BORN, aloft=True).knows.phase == Phase.FLYING
    assert DRONE.init(0.0, BORN).knows.phase == Phase.LANDED
