"""Two pilots of one's own. In the folder of this file, they fly by name:

    fledge demonstrate --pilot own_pilot:Gentle
    fledge evaluate own_pilot:Smooth servo

A pilot sees the eleven numbers of the paper's Table 2 and says four, each in [-1, 1], twenty times a second.
"""

import math
from dataclasses import dataclass

import fledge
from fledge.scalars import clip

FOCAL_PX = fledge.Lens().focal_px


class Gentle(fledge.AbstractPilot):
    """Any Python will do: this one leaves the sticks alone while the UGVs are near the middle of the picture."""

    name = "gentle"

    def act(self, memory, seen, noise):
        ahead, aside = seen.centre_v - seen.ugv_v, seen.centre_u - seen.ugv_u
        metres = seen.altitude / FOCAL_PX if math.hypot(ahead, aside) > 15.0 else 0.0
        sticks = 1.2 * ahead * metres, 1.2 * aside * metres, 0.02 * (seen.radius - seen.ideal_radius)
        return memory, fledge.Action(*(min(max(stick, -1.0), 1.0) for stick in sticks), 0.0)


@dataclass(frozen=True)
class Smooth(fledge.AbstractPilot):
    """With the arithmetic of fledge.scalars it is compiled, and flies a thousand flights at once. It has a memory."""

    gain: float = 2.0
    quickness: float = 0.3
    name = "smooth"

    def init(self):
        return 0.0, 0.0, 0.0

    def act(self, memory, seen, noise):
        metres = self.gain * seen.altitude / FOCAL_PX
        errors = seen.centre_v - seen.ugv_v, seen.centre_u - seen.ugv_u, seen.radius - seen.ideal_radius
        wishes = (clip(error * metres, -1.0, 1.0) for error in errors)
        sticks = tuple(old + self.quickness * (new - old) for old, new in zip(memory, wishes, strict=True))
        return sticks, fledge.Action(*sticks, 0.0)


def main(seconds=20):
    from fledge.manoeuvres import Combined
    from fledge.study.evaluation import score

    case = fledge.Case.draw(Combined(), key=(0,), rows=20 * seconds)
    scores = {}
    for pilot in (Gentle(), Smooth()):
        scores[pilot.name] = score(fledge.fly_plain(case, fledge.Crew(pilot), key=(1,)), fledge.Rig())
        print(f"{pilot.name}: all UGVs in view {scores[pilot.name].in_view:.1%} of the time")
    return scores


if __name__ == "__main__":
    main()
