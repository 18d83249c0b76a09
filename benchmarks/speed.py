"""How fast the simulator flies and a policy answers, as ratios measured side by side in one run.

Simulated seconds of one scene per second of wall time, compiled, at several batch sizes, against plain Python; and one
decision of the policy in NumPy against ONNX Runtime. Machines are noisy: read the ratios.

    python benchmarks/speed.py
"""

import time
from collections.abc import Callable
from statistics import median
from tempfile import TemporaryDirectory

import numpy as np
import onnxruntime

from fledge import Case, Crew, Policy, fly_plain, write_policy
from fledge.manoeuvres import Combined
from fledge.pilots import HumanModel, Servo
from fledge.study.evaluation import evaluate

ROWS = 400
SECONDS = ROWS / 20.0


def policy() -> Policy:
    """The paper's network, untrained."""
    rng, sizes = np.random.default_rng(0), (11, 300, 300, 4)
    pairs = list(zip(sizes[:-1], sizes[1:], strict=True))
    weights = tuple(rng.normal(0.0, (2.0 / a) ** 0.5, (a, b)).astype(np.float32) for a, b in pairs)
    biases = tuple(np.zeros(b, np.float32) for _, b in pairs)
    ones = np.ones(11, np.float32)
    return Policy(weights, biases, 0.0 * ones, 100.0 * ones, tuple(range(11)), 11)


def timed(job: Callable[[], object], repeats: int = 3) -> float:
    """Median seconds of a job, after one run that is not counted."""
    job()
    took = []
    for _ in range(repeats):
        start = time.perf_counter()
        job()
        took.append(time.perf_counter() - start)
    return median(took)


def main() -> None:
    """Print both tables."""
    plain = SECONDS / timed(lambda: fly_plain(Case.draw(Combined(), (0,), ROWS), Crew(Servo()), (1,)), 1)
    print(f"simulated seconds per second; plain Python: {plain:.0f}")
    for pilot in (Servo(), HumanModel(), policy()):
        for flights in (1, 100, 1000):
            cases = [Case.draw(Combined(), (i,), ROWS) for i in range(flights)]
            keys = [(i, 1) for i in range(flights)]
            wall = timed(lambda: evaluate(cases, Crew(pilot), keys))  # noqa: B023
            speed = flights * SECONDS / wall
            print(f"  {pilot.name:12} {flights:5} flights {speed:8.0f}  {speed / plain:7.1f} x plain")
    network, state = policy(), np.zeros(11, np.float32)
    with TemporaryDirectory() as folder:
        write_policy(f"{folder}/policy.onnx", network)
        session = onnxruntime.InferenceSession(f"{folder}/policy.onnx")
    ours = timed(lambda: [network(state) for _ in range(2000)]) / 2000
    theirs = timed(lambda: [session.run(None, {"state": state[None]}) for _ in range(2000)]) / 2000
    print(f"one decision: NumPy {1e6 * ours:.1f} us, {theirs / ours:.2f} x as fast as ONNX Runtime")


if __name__ == "__main__":
    main()
