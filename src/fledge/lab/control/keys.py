"""A keyboard as an operator: keys, one after the other, to what a person says about every vehicle.

    w s, up down      forward, back         g   go: arm
    a d, left right   left, right           t   I fly (take-over switch), until h
    r f               up, down              h   hand back: the policy may fly again
    q e               turn left, right      l   land
    space             stop: brake, hold     K   motors off, for good (a capital, so that no slip does it)

The first four lines fly the UAV alone; go, land, stop, hand back and motors off are said to all vehicles at once.

A terminal tells when a key goes down and when it repeats, never when it comes up. So a key counts as held for a while
after the last word of it, and then the stick is in its middle again: hands off, and the vehicle hovers. There is no
dead-man switch: whoever flies by keyboard does so behind the net.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

from fledge.observation import Action, StickScale
from fledge.supervision.inputs import Operator

UP, DOWN, RIGHT, LEFT = "\x1b[A", "\x1b[B", "\x1b[C", "\x1b[D"
"""What a terminal sends for the arrow keys (ECMA-48, cursor control)."""

STICKS = {
    "w": Action(1.0, 0.0, 0.0, 0.0),
    "s": Action(-1.0, 0.0, 0.0, 0.0),
    "a": Action(0.0, 1.0, 0.0, 0.0),
    "d": Action(0.0, -1.0, 0.0, 0.0),
    "r": Action(0.0, 0.0, 1.0, 0.0),
    "f": Action(0.0, 0.0, -1.0, 0.0),
    "q": Action(0.0, 0.0, 0.0, 1.0),
    "e": Action(0.0, 0.0, 0.0, -1.0),
}
STICKS |= {UP: STICKS["w"], DOWN: STICKS["s"], LEFT: STICKS["a"], RIGHT: STICKS["d"]}
GO, TAKE_OVER, HAND_BACK, LAND, STOP, TERMINATE = "gthl K"

HELP = (
    "g go  t take over  h hand back  arrows/wasd fly  r f up/down  q e turn  space stop  l land  K motors off"
)


class Keys(NamedTuple):
    """What is remembered of the keys pressed."""

    armed: bool = False
    taken: bool = False
    """Whether the take-over switch is on."""
    stick: Action = Action(0.0, 0.0, 0.0, 0.0)
    """Where the last stick key put the sticks, as shares of full deflection."""
    moved: float = -1e9
    """When that was [s]."""
    word: str = ""
    """The last key that says something else."""
    said: float = -1e9
    """When that was [s]."""


@dataclass(frozen=True, slots=True)
class Keyboard:
    """How keys are read."""

    vehicles: int
    sticks: StickScale = StickScale()
    share: float = 0.5
    """Of full deflection that a key means; chosen: more than takes over, and gentle."""
    held: float = 0.7
    """[s] after its last word for which a stick key counts as held; chosen: keyboards wait 0.25 to 0.66 s before they
    repeat."""
    lasting: float = 0.3
    """[s] for which any other key is said; chosen: thirty ticks, so that losing some does no harm."""

    def init(self) -> Keys:
        """Nothing pressed, nothing armed."""
        return Keys()

    def press(self, keys: Keys, key: str, t: float) -> Keys:
        """After a key at time `t` [s]; a key that means nothing changes nothing."""
        if key in STICKS:
            return keys._replace(stick=STICKS[key], moved=t)
        if key in (GO, TAKE_OVER, HAND_BACK, LAND, STOP, TERMINATE):
            armed = key == GO or (keys.armed and key not in (LAND, TERMINATE))
            taken = key == TAKE_OVER or (keys.taken and key != HAND_BACK)
            return Keys(armed, taken, Keys().stick, Keys().moved, key, t)
        return keys

    def says(self, keys: Keys, t: float) -> tuple[Operator, ...]:
        """One operator per vehicle at time `t` [s], the UAV first."""
        word = keys.word if t - keys.said <= self.lasting else ""
        everyone = Operator(
            arm=float(keys.armed),
            land=float(word == LAND),
            stop=float(word == STOP),
            hand_back=float(word == HAND_BACK),
            terminate=float(word == TERMINATE),
        )
        uav = replace(everyone, switch=float(keys.taken))
        if t - keys.moved <= self.held:
            stick, share = keys.stick, self.share
            command = self.sticks.command(Action(*(share * x for x in _axes(stick))))
            uav = replace(uav, command=command, deflection=share)
        return (uav, *(everyone,) * (self.vehicles - 1))


def split(text: str) -> tuple[list[str], str]:
    """(whole keys, the rest that may still become one) of what a terminal sent: escape sequences are one key each."""
    keys = []
    while text:
        if text[0] != "\x1b":
            keys.append(text[0])
            text = text[1:]
        elif len(text) < 3 and text[1:] in ("", "[", "O"):
            break  # the rest of an arrow is still to come
        elif text[1] in "[O":
            end = next((i for i, c in enumerate(text[2:], start=2) if "@" <= c <= "~"), None)
            if end is None:
                break
            keys.append("\x1b[" + text[2 : end + 1])  # some terminals say O for [
            text = text[end + 1 :]
        else:
            keys.append("\x1b")
            text = text[1:]
    return keys, text


def _axes(stick: Action) -> tuple[float, ...]:
    return stick.forward, stick.left, stick.up, stick.turn
