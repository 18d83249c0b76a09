"""A stranger's pilot or manoeuvre is taken as it is, or refused in one line that helps."""

import sys

import pytest

from fledge import guests
from fledge.errors import FledgeError
from fledge.manoeuvres import Climb
from fledge.pilots import Servo
from fledge.safety import StopTube

GUESTS = """
import fledge
from fledge.manoeuvres import Climb
from fledge.pilots import Servo
from fledge.world import Verdict

STILL = fledge.Action(0.0, 0.0, 0.0, 0.0)
PATIENT = Servo(p=0.5)

class Calm(fledge.AbstractPilot):
    name = "calm"
    def act(self, memory, seen, noise):
        return memory, STILL

class Nameless(fledge.AbstractPilot):
    def act(self, memory, seen, noise):
        return memory, STILL

class Needy(Calm):
    def __init__(self, gain):
        self.gain = gain

class Idle(fledge.AbstractPilot):
    name = "idle"

class Silent(Calm):
    def act(self, memory, seen, noise):
        pass

class Forgetful(Calm):
    def act(self, memory, seen, noise):
        return STILL

class Picky(Calm):
    def act(self, memory, seen, noise):
        return memory, seen.altitude.wants_an_array()

class Hop(fledge.AbstractManoeuvre):
    name, axes = "hop", (2,)
    def plan(self, rng, rows):
        return Climb().plan(rng, rows)

class Brief(Hop):
    def plan(self, rng, rows):
        return Climb().plan(rng, 100)

class Vague(Hop):
    def plan(self, rng, rows):
        return "up"

class Handless(Hop):
    axes = ()

class ManyHanded(Hop):
    axes = (2, 4)

class Clumsy(Hop):
    def plan(self, rng, rows):
        return 1 / 0

NOT_A_PILOT = 3

class Free(fledge.AbstractNet):
    def init(self, arena, world):
        return ()
    def filter(self, memory, world, commands):
        told = (commands.uav, *commands.ugvs)
        return memory, tuple(Verdict(command, 0.0, 0.0, 9.0) for command in told)

class Blind(Free):
    def filter(self, memory, world, commands):
        return super().filter(memory, world, commands)[1]

class Partial(Free):
    def filter(self, memory, world, commands):
        memory, verdicts = super().filter(memory, world, commands)
        return memory, verdicts[:2]

class Breaks(Free):
    def filter(self, memory, world, commands):
        return memory, world.nothing
"""


@pytest.fixture
def house(tmp_path, monkeypatch):
    """The current folder, with guests in it; afterwards they are forgotten."""
    (tmp_path / "house").mkdir()
    (tmp_path / "house" / "visitors.py").write_text(GUESTS)
    (tmp_path / "house" / "broken.py").write_text("def (:\n")
    (tmp_path / "house" / "wanting.py").write_text("import nothing_of_that_name\n")
    (tmp_path / "house" / "failing.py").write_text("\n1 / 0\n")
    monkeypatch.chdir(tmp_path)
    yield "house.visitors:"
    for name in [name for name in sys.modules if name.split(".")[0] == "house"]:
        del sys.modules[name]


def test_a_class_or_an_instance_will_do(house):
    assert guests.pilot(house + "Calm").name == "calm"
    assert guests.pilot(house + "PATIENT") == Servo(p=0.5)
    assert guests.pilot(house + "Picky").name == "calm", "it may want arrays, which it gets in flight"
    assert guests.manoeuvre(house + "Hop").axes == (2,)


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("Nobody", r"Nobody: no such pilot: house.visitors has Calm, Nameless, .*Forgetful, Picky"),
        ("NOT_A_PILOT", r"a int: valid is a subclass of fledge.AbstractPilot"),
        ("Hop", r"a Hop: valid is a subclass of fledge.AbstractPilot"),
        ("Nameless", r"it has no name"),
        ("Needy", r"cannot be made without arguments: .*'gain'"),
        ("Idle", r"cannot be made without arguments: .*abstract method '?act"),
        ("Silent", r"act returned None: valid is a pair \(memory, Action\)"),
        ("Forgetful", r"act returned Action\(.*: valid is a pair"),
    ],
)
def test_a_pilot_is_refused_in_one_line(house, name, line):
    with pytest.raises(FledgeError, match=line) as refused:
        guests.pilot(house + name)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("Calm", r"a Calm: valid is a subclass of fledge.AbstractManoeuvre"),
        ("Brief", r"asked for 200 rows, it planned \{\(100,\)\}: valid is one number a row"),
        ("Vague", r"plan returned 'up': valid is a Plan"),
        ("Handless", r"axes are \(\): valid is a tuple of some of 0, 1, 2 and 3"),
        ("ManyHanded", r"axes are \(2, 4\)"),
    ],
)
def test_a_manoeuvre_is_refused_in_one_line(house, name, line):
    with pytest.raises(FledgeError, match=line):
        guests.manoeuvre(house + name)


def test_a_net_needs_no_name(house):
    assert type(guests.net(house + "Free")).__name__ == "Free"
    assert guests.net("fledge.safety:StopTube") == StopTube()


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("Calm", r"a Calm: valid is a subclass of fledge.AbstractNet"),
        ("Blind", r"filter returned \(Verdict\(.*: valid is a pair \(memory, verdicts\)"),
        ("Partial", r"filter returned \(\(\), \(Verdict\(.*the UAV's Verdict first, then one per UGV"),
    ],
)
def test_a_net_is_refused_in_one_line(house, name, line):
    with pytest.raises(FledgeError, match=line):
        guests.net(house + name)


def test_a_nets_own_error_is_located_in_its_file(house):
    with pytest.raises(AttributeError) as raised:
        guests.net(house + "Breaks")
    assert (
        guests.culprit(raised.value)
        == f"visitors.py, line {GUESTS.split(chr(10)).index('        return memory, world.nothing') + 1}"
    )


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("nowhere:Calm", r"pilot 'nowhere': cannot be imported: No module named 'nowhere'"),
        ("house.wanting:Calm", r"cannot be imported: No module named 'nothing_of_that_name'"),
        ("house.broken:Calm", r"broken.py, line 1: invalid syntax"),
        (":Calm", r"valid is the name of a module, as in package.module:Name"),
        ("..house:Calm", r"valid is the name of a module"),
        ("a b:Calm", r"valid is the name of a module"),
    ],
)
def test_a_module_that_cannot_be_imported_says_why(house, name, line):
    with pytest.raises(FledgeError, match=line):
        guests.pilot(name)


def test_a_guests_own_error_is_located_in_its_file(house):
    with pytest.raises(ZeroDivisionError) as raised:
        guests.manoeuvre(house + "Clumsy")
    line = GUESTS.split("\n").index("        return 1 / 0") + 1
    assert guests.culprit(raised.value) == f"visitors.py, line {line}"
    with pytest.raises(ZeroDivisionError) as raised:
        guests.pilot("house.failing:Calm")
    assert guests.culprit(raised.value) == "failing.py, line 2"


def test_our_own_error_is_nobody_elses():
    try:
        Climb().plan(None, 10)
    except AttributeError as error:
        own = error.with_traceback(error.__traceback__.tb_next)  # without this test's own line
    assert guests.culprit(own) is None
