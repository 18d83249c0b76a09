"""Let two pilots, or two policies from `fledge.read_policy`, fly the same cases, and say what may be claimed."""

import fledge
from fledge.experiments import duel
from fledge.manoeuvres import Combined
from fledge.pilots import Servo

PATIENT = Servo(p=1.0)


def main(cases=20):
    found = duel({"servo": Servo(), "patient servo": PATIENT}, Combined(), cases, seed=0)
    for name, entry in found["entries"].items():
        print(f"{name:14} {entry['distance_rmse_px']:6.2f} px off the centre (rms), in view {entry['in_view']:.1%}")
    for one in found["comparisons"]:
        low, high = one["interval"]
        print(f"{one['metric']}: {one['a']} - {one['b']} = {one['difference']:+.3f}, 95 % {low:+.3f} to {high:+.3f}")
    return found


if __name__ == "__main__":
    main()
