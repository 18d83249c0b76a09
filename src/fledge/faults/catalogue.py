"""What can go wrong behind a supervisor's back, as data, and what is said of it before anything is flown.

A fault spoils what comes in (`spoils`), or what the vehicles obey, or the air. Its promise is one of three:

* inside the contract: the net holds it; whether it is noticed does not matter;
* detectable: the data show it, so it must be called by its name within a stated time;
* not promised: the data do not show it, or nobody can do anything about it. It is measured all the same.

Of the first two nothing may be touched, and everybody must end in a mode named here.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from math import inf, nan

from fledge.faults.spoils import (
    Moment,
    Spoil,
    backwards,
    battery,
    broken_stick,
    clearly_moving,
    clock,
    deaf,
    dropped,
    exchanged,
    mirrored,
    one_field,
    placed,
    poses,
    proposing,
    silent,
    stopped_clock,
    undecided,
)
from fledge.scalars import Scalar, where
from fledge.supervision.inputs import Inputs
from fledge.supervision.modes import Mode
from fledge.supervision.tracking import Motion
from fledge.world import Commands, Reason


class Promise(StrEnum):
    """What is said of a fault beforehand."""

    CONTRACT = "inside the contract"
    DETECTABLE = "detectable"
    NONE = "not promised"


UAV = ((0,),)
ANYONE = ((0,), (1,), (2,), (3,))
ALL = ((0, 1, 2, 3),)
TWO_UGVS = ((1, 2), (1, 3), (2, 3))
UAV_AND_UGV = ((0, 1), (0, 2), (0, 3))

SHORT = (0.05, 1.5)
LONG = (1.0, 5.0)
FOR_GOOD = (inf, inf)

FLYING_ON = (Mode.AUTO, Mode.SHIELDED)
STOPPED = (*FLYING_ON, Mode.STOPPED)
DOWN = (Mode.LAND, Mode.INIT)


@dataclass(frozen=True, slots=True)
class Fault:
    """Something that goes wrong, and what is said of it beforehand."""

    name: str
    promise: Promise
    lasts: tuple[float, float]
    """Shortest and longest duration [s]."""
    strikes: tuple[tuple[int, ...], ...]
    """The groups of vehicles of which one is struck; 0 is the UAV."""
    spoil: Spoil = lambda inputs, moment: inputs
    reasons: tuple[Reason, ...] = ()
    """One of them must be given for every vehicle struck; none if it need not be noticed."""
    within: float = inf
    """[s] for which it has shown."""
    ends: tuple[Mode, ...] = FLYING_ON
    """Modes in which the vehicles struck may be in the end; the others may also fly on."""
    shows: Callable[[Inputs, Moment], Scalar] = lambda inputs, moment: True
    """Whether the data show it now."""
    obey: Callable[[Commands, Moment], Commands] = lambda told, moment: told
    """What the vehicles do instead of what they are told."""
    delay: float = 0.0
    """How old `Moment.past` is [s]."""
    push: float = 0.0
    """On the UAV, beside the contract's disturbance [m/s^2]."""
    tilt: float = 1.0
    """Share of the UAV's tilt limit that is left."""
    by_hand: bool = False
    """Whether a person flies the UAV."""
    from_start: bool = False
    """Whether it is there before the flight begins."""


C, D, N = Promise
R, M = Reason, Mode

# fmt: off
FAULTS = (
    # Poses that do not come, or come late.
    Fault("poses freeze for 0.1 s", C, (0.1, 0.1), ALL, dropped(1.0), (R.STALE,), 0.2),
    Fault("poses freeze for 0.5 s", D, (0.5, 0.5), ALL, dropped(1.0), (R.STALE,), 0.2),
    Fault("poses freeze for 2 s", D, (2.0, 2.0), ALL, dropped(1.0), (R.STALE,), 0.2, (*FLYING_ON, *DOWN)),
    Fault("10 % of the poses are lost", C, LONG, ALL, dropped(0.1)),
    Fault("50 % of the poses are lost", C, LONG, ALL, dropped(0.5)),
    Fault("poses late by 0.1 s", D, LONG, ALL, poses(lambda s: s.past), (R.STALE,), 0.2, delay=0.1),
    Fault("poses late by 0.3 s", D, LONG, ALL, poses(lambda s: s.past), (R.STALE,), 0.2, delay=0.3),
    Fault("poses late by 0.5 s", D, LONG, ALL, poses(lambda s: s.past), (R.STALE,), 0.2, delay=0.5),
    Fault("half of the poses are old ones again", D, LONG, ALL,
          poses(lambda s: where(s.moment.odds < 0.5, s.past, s.now)), (R.BACKWARD,), 0.2, delay=0.3),
    # Poses that are wrong.
    Fault("NaN somewhere in a pose", D, SHORT, ANYONE, one_field(nan), (R.BAD_POSE,), 0.05),
    Fault("infinity somewhere in a pose", D, SHORT, ANYONE, one_field(inf), (R.BAD_POSE,), 0.05),
    Fault("positions in millimetres", D, SHORT, ANYONE,
          poses(lambda s: placed(s.now, Motion.of(s.now).position * 1e3)), (R.BAD_POSE, R.JUMP), 0.05),
    Fault("a pose jumps by 0.5 m", D, LONG, ANYONE,
          poses(lambda s: s.moved(s.aside(0.5))), (R.JUMP,), 0.05, STOPPED),
    Fault("two UGVs taken for each other", D, LONG, TWO_UGVS, exchanged, (R.SWAP,), 0.05, STOPPED),
    # Stamps and clocks.
    Fault("one stamp on every pose", D, SHORT, ALL,
          poses(lambda s: replace(s.now, stamp=s.last.stamp)), (R.DUPLICATE, R.STALE), 0.2),
    Fault("stamps ahead by 10 s", D, SHORT, ALL,
          poses(lambda s: replace(s.now, stamp=s.now.stamp + 10.0)), (R.FUTURE,), 0.05),
    Fault("the clock goes back by 1 s", D, LONG, ALL, clock(-1.0), (R.CLOCK,), 0.05),
    Fault("the clock goes ahead by 10 s", D, LONG, ALL, clock(10.0), (R.CLOCK,), 0.05),
    Fault("the clock stands still", D, LONG, ALL, stopped_clock, (R.CLOCK,), 0.05),
    # Policy, people, vehicles.
    Fault("the policy decides nothing", D, LONG, ALL, undecided, (R.POLICY_LATE,), 0.6),
    Fault("the policy proposes NaN", D, SHORT, ANYONE, proposing(nan), (R.NOT_FINITE,), 0.05),
    Fault("the policy proposes infinity", D, SHORT, ANYONE, proposing(inf), (R.NOT_FINITE,), 0.05),
    Fault("the policy proposes 1e30", C, LONG, ANYONE, proposing(1e30)),
    Fault("NaN from the sticks, the policy flies", D, SHORT, UAV, broken_stick, (R.NOT_FINITE,), 0.05),
    Fault("NaN from the sticks, a person flies", D, SHORT, UAV,
          broken_stick, (R.NOT_FINITE,), 0.05, (M.MANUAL,), by_hand=True),
    Fault("the operator's link is lost", D, FOR_GOOD, ALL, silent, (R.LINK_LOST,), 10.1, DOWN),
    Fault("the same, a person flies", D, FOR_GOOD, UAV, silent, (R.LINK_LOST,), 0.6, DOWN, by_hand=True),
    Fault("a battery runs low", D, FOR_GOOD, ANYONE, battery(0.1), (R.BATTERY_LOW,), 0.05, DOWN),
    Fault("what a battery says is NaN", D, LONG, ANYONE, battery(nan), (R.BATTERY_LOW,), 0.05),
    Fault("a vehicle hears nothing for 0.3 s", C, (0.3, 0.3), ANYONE, obey=deaf),
    # Beyond what anybody can promise.
    Fault("the UAV hears nothing for seconds", N, LONG, UAV, obey=deaf),
    Fault("poses are lost for good", N, FOR_GOOD, ALL, dropped(1.0), (R.STALE,), 0.2, DOWN),
    Fault("poses late by 0.3 s, stamped as fresh", N, LONG, ALL,
          poses(lambda s: replace(s.past, stamp=s.now.stamp)), delay=0.3),
    Fault("velocities of the wrong sign", N, LONG, ANYONE,
          poses(backwards), (R.INCONSISTENT,), 1.0, STOPPED, clearly_moving),
    Fault("UAV and UGV taken for each other", N, LONG, UAV_AND_UGV, exchanged, (R.SWAP,), 0.05, STOPPED),
    Fault("a pose drifts by 5 cm/s", N, (10.0, 10.0), ANYONE,
          poses(lambda s: s.moved(s.aside(0.05 * s.moment.since)))),
    Fault("the y axis is flipped", N, FOR_GOOD, ALL, poses(mirrored), from_start=True),
    Fault("a gust of three times the contract", N, (1.0, 3.0), UAV, push=0.6),
    Fault("half the UAV's tilt", N, FOR_GOOD, UAV, tilt=0.5),
)
# fmt: on
