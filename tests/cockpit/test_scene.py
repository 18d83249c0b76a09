"""Who flies a vehicle, as people are told: read off mode, verdict and reason alone."""

import pytest

from fledge.cockpit.scene import FLOWN, NET_REASONS, commander
from fledge.supervision.modes import Mode
from fledge.supervision.posts import Decision
from fledge.supervision.watchdog import Alarm
from fledge.world import Reason, VelocityCommand, Verdict

HOVER = VelocityCommand.hover()


def decided(mode, intervened=0.0, reason=Reason.NONE):
    return Decision(float(mode), Verdict(HOVER, intervened, float(reason), 1.0), Alarm(0.0, 0.0))


@pytest.mark.parametrize("mode", Mode)
def test_in_a_mode_in_which_nobody_flies_nobody_does(mode):
    who = {commander(i, decided(mode), person) for i in (0, 1) for person in (True, False)}
    assert ("nobody" in who) == (mode not in FLOWN) and (mode in FLOWN or who == {"nobody"})


def test_a_policy_flies_the_uav_guidance_the_ugvs_and_a_person_what_is_theirs():
    auto = decided(Mode.AUTO)
    assert [commander(i, auto, False) for i in (0, 1)] == ["pilot", "guidance"]
    assert [commander(i, auto, True) for i in (0, 1)] == ["person", "guidance"]
    assert commander(1, decided(Mode.MANUAL, 1.0, Reason.TAKE_OVER), False) == "person"


@pytest.mark.parametrize("reason", NET_REASONS)
def test_the_net_commands_where_it_changed_something(reason):
    for mode in (Mode.AUTO, Mode.SHIELDED, Mode.MANUAL):
        assert commander(0, decided(mode, 1.0, reason), True) == "net"
    # A person's command always differs from what the policy proposed; that is not the net's doing.
    assert commander(0, decided(Mode.MANUAL, 1.0, Reason.TAKE_OVER), False) == "person"
    assert commander(0, decided(Mode.RECOVER, 1.0, Reason.RECOVERING), False) == "pilot"
