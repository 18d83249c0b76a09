"""Learn to look after two things at once from a teacher who only ever showed one at a time. Nothing here flies.

A tank has a level and a temperature, both drift, and each has its own valve. In half the episodes the teacher works on
the level and leaves the other valve alone; in the other half it is the temperature's turn.
"""

import numpy as np

import fledge

LEVEL = fledge.SubTask("level", actions=(0,))
TEMPERATURE = fledge.SubTask("temperature", actions=(1,))


def teacher(errors):
    return np.clip(-3.0 * errors, -1.0, 1.0)


def run(control, rng, rows=300):
    """(states, actions) of an episode: two errors, and two valves in [-1, 1]; shapes (rows, 2)."""
    errors, states, actions = rng.uniform(-1.0, 1.0, 2), [], []
    for _ in range(rows):
        states.append(errors)
        actions.append(control(errors))
        errors = 0.98 * errors + 0.2 * actions[-1] + 0.08 * rng.standard_normal(2)
    return np.array(states), np.array(actions)


def shown(valve, rng):
    """An episode in which the teacher touches one valve only."""
    states, actions = run(lambda errors: teacher(errors) * (np.arange(2) == valve), rng)
    return states, actions[:, [valve]]


def main(episodes=10):
    rng = np.random.default_rng(0)
    sub_tasks = {
        LEVEL: [shown(0, rng) for _ in range(episodes)],
        TEMPERATURE: [shown(1, rng) for _ in range(episodes)],
    }
    pupils = {"nobody": np.zeros_like, "the teacher": teacher}
    for fill in ("zero", "mask"):
        composite = fledge.fuse(sub_tasks, action_dim=2, fill=fill)
        pupils[f"taught, fill={fill!r}"], _ = fledge.fit(composite, fledge.Recipe.fast(), key=0)
    errors = {name: run(pupil, np.random.default_rng(1))[0] for name, pupil in pupils.items()}
    for name, error in errors.items():
        print(f"{name:20} errors of {np.sqrt(np.mean(error**2)):.3f} (rms) with both drifting")
    return errors


if __name__ == "__main__":
    main()
