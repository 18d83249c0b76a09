"""A manoeuvre of one's own. In the folder of this file, it is flown by name:

    fledge demonstrate --manoeuvre own_manoeuvre:Orbit --pilot servo

It is held to nothing but its class: a name, the axes a demonstrator may use, and a plan.
"""

import numpy as np

import fledge
from fledge.manoeuvres import FormationTrack, Plan
from fledge.observation import ROW_RATE
from fledge.world import Arena


class Orbit(fledge.AbstractManoeuvre):
    """The UGVs circle the middle of the arena, once in 50 s; the UAV needs forward and left to follow."""

    name = "orbit"
    axes = (0, 1)

    def plan(self, rng, rows):
        angle = rng.uniform(0.0, 2.0 * np.pi) + 2.0 * np.pi / 50.0 * np.arange(rows) / ROW_RATE
        track = FormationTrack.through(2.0 * np.cos(angle), 2.0 * np.sin(angle), np.full(rows, 0.8))
        return Plan(Arena.square(), track, orientation=rng.uniform(0.0, 2.0 * np.pi))


def main(seconds=20):
    from fledge.pilots import Servo

    case = fledge.Case.draw(Orbit(), key=(0,), rows=20 * seconds)
    flown = fledge.fly_plain(case, fledge.Crew(Servo()), key=(1,))
    uav = flown.world.uav.position
    off = np.hypot(uav.x - case.plan.track.x, uav.y - case.plan.track.y)
    print(f"The UAV was {off.mean():.2f} m off the centre of the orbit on average.")
    return off


if __name__ == "__main__":
    main()
