"""Let two pilots fly the same cases, and say what may be claimed. What `fledge.read_policy` reads is a pilot, too."""

from fledge.manoeuvres import Combined
from fledge.pilots import Servo
from fledge.study.experiments import duel

PATIENT = Servo(p=1.0)


def main(cases=20):
    found = duel({"servo": Servo(), "patient servo": PATIENT}, Combined(), cases, seed=0)
    for name, entry in found["entries"].items():
        off, in_view = entry["distance_rmse_px"], entry["in_view"]
        print(f"{name:14} {off:6.2f} px off the centre (rms), all UGVs in view {in_view:.1%} of the time")
    for one in found["comparisons"]:
        low, high = one["interval"]
        print(f"{one['metric']:14} {one['difference']:+.3f}, with 95 % confidence {low:+.3f} to {high:+.3f}")
    return found


if __name__ == "__main__":
    main()
