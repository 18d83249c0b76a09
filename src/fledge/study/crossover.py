"""Is the synthetic operator credible? Measured as manual-control experiments measure people.

The formation moves by a sum of sines that never repeat one another's frequencies, so that at each of them the
open loop L = (UAV position) / (position error) can be read off two Fourier coefficients, and everything the stick
does at other frequencies is the operator's own noise. From L follow the numbers of the crossover model
(McRuer and Jex 1967; L ~ w_c e^(-tau_e s) / s near crossover):

* crossover frequency w_c [rad/s], where |L| = 1;
* effective delay tau_e [s], from the phase there: -pi/2 - w_c tau_e;
* remnant share: the part of the stick's power that the forcing does not explain.

`BANDS` are the values people reach, fixed before the first study. The measurement sees the whole loop: the operator's
delay and lag, the video's, and what is left of the vehicle's lag after the operator's lead.
"""

from dataclasses import dataclass, replace

import numpy as np

from fledge.conditions import Conditions
from fledge.engines import fly
from fledge.manoeuvres.base import AbstractManoeuvre, FormationTrack, Plan
from fledge.observation import ROW_RATE, Axes
from fledge.pilots import HumanModel
from fledge.simulation import Case, Crew, Rig, flight_key
from fledge.world import Arena

ROWS = 2400
"""120 s are analysed; as many rows again of warm-up would change nothing, 400 are flown."""
WARM_UP = 400
HARMONICS = {"forward": (3, 5, 11, 19, 31, 43), "left": (4, 7, 13, 23, 37, 47), "up": (2, 6, 10, 17, 29, 41)}
"""Cycles per 120 s: 0.1 to 2.5 rad/s, no two axes alike."""
BANDS = {"crossover": (1.0, 2.5), "delay": (0.35, 0.65), "remnant": (0.10, 0.30)}
"""[rad/s], [s], share of power. McRuer and Jex: tau_e of 0.36 s (K/s) to 0.50 s (K/s^2), with 0.05-0.15 s of video on
top; drones flown by video cross over at 1-2.5 rad/s; remnant of a single task 10-30 %. See docs/method.md."""


@dataclass(frozen=True, slots=True)
class Credibility:
    """One axis of the operator, measured."""

    axis: str
    crossover: float
    """[rad/s]."""
    delay: float
    """[s]."""
    remnant: float
    """Share of stick power."""

    @property
    def inside(self) -> bool:
        """Whether every figure lies in its band."""
        return all(low <= getattr(self, name) <= high for name, (low, high) in BANDS.items())


@dataclass(frozen=True, slots=True)
class SumOfSines(AbstractManoeuvre):
    """The forcing of a sub-task: the centre wanders, or the spread does, by sums of sines."""

    axes: tuple[int, ...] = (0, 1)
    name = "sum-of-sines"

    def plan(self, rng: np.random.Generator, rows: int) -> Plan:
        """Random phases; amplitudes that fall with frequency, as in tracking experiments."""
        lateral, vertical = float(0 in self.axes), float(2 in self.axes)
        x, y = (lateral * _sines(rng, HARMONICS[axis], rows, 0.5) for axis in ("forward", "left"))
        spread = 0.9 + vertical * _sines(rng, HARMONICS["up"], rows, 0.12)
        return Plan(Arena.square(), FormationTrack.through(x, y, spread), 0.0)


def _sines(rng: np.random.Generator, harmonics: tuple[int, ...], rows: int, size: float) -> np.ndarray:
    t = np.arange(rows) / ROWS
    waves = [
        size / (1.0 + (n / 10.0) ** 2) * np.sin(2.0 * np.pi * (n * t + rng.uniform())) for n in harmonics
    ]
    return np.sum(waves, axis=0)


def credibility(
    operator: HumanModel, seed: int, flights: int = 8, rig: Rig = Rig()
) -> tuple[Credibility, ...]:
    """Forward and left in the lateral sub-task, up in the vertical one; `flights` of 120 s each."""
    cases, crews, keys = [], [], []
    for axes in ((0, 1), (2,)):
        manoeuvre = SumOfSines(axes)
        for i in range(flights):
            key = flight_key(seed, "crossover", manoeuvre.name, i)
            case = Case.draw(manoeuvre, key, ROWS + WARM_UP)
            # Nose to the east, so that forward is x; a still day: what is not forcing is the operator's.
            cases.append(replace(case, conditions=Conditions(delay=case.conditions.delay)))
            crews.append(Crew(operator.for_axes(axes), Axes.of(axes)))
            keys.append((*key, 1))
    episodes = fly(cases, crews, keys, rig)
    uav, ugvs, action = episodes.world.uav.position, episodes.world.ugvs, episodes.action
    goal_x, goal_y = (np.mean([getattr(ugv, name) for ugv in ugvs], axis=0) for name in ("x", "y"))
    far = np.max([np.hypot(ugv.x - goal_x, ugv.y - goal_y) for ugv in ugvs], axis=0)
    goal_z = far * rig.lens.focal_px / rig.ideal_radius
    lateral, vertical = slice(0, flights), slice(flights, None)
    return (
        _measure("forward", uav.x[lateral], goal_x[lateral], action.forward[lateral]),
        _measure("left", uav.y[lateral], goal_y[lateral], action.left[lateral]),
        _measure("up", uav.z[vertical], goal_z[vertical], action.up[vertical]),
    )


def _measure(axis: str, position: np.ndarray, goal: np.ndarray, stick: np.ndarray) -> Credibility:
    """From arrays of shape (flights, rows)."""
    n = np.array(HARMONICS[axis])
    out, error, said = (
        np.fft.rfft(signal[:, WARM_UP:], axis=1) for signal in (position, goal - position, stick)
    )
    # Averaging the ratios' numerator and denominator over flights is the cross-spectral estimate.
    forcing = np.fft.rfft(goal[:, WARM_UP:], axis=1)[:, n].conj()
    loop = (out[:, n] * forcing).mean(axis=0) / (error[:, n] * forcing).mean(axis=0)
    omega = 2.0 * np.pi * n * ROW_RATE / ROWS
    gain, phase = np.log(np.abs(loop)), np.unwrap(np.angle(loop))
    crossover = float(np.exp(np.interp(0.0, -gain, np.log(omega))))
    lag = float(np.interp(crossover, omega, phase))
    power = np.abs(said[:, 1:]) ** 2
    forced = np.abs(said[:, n]) ** 2
    remnant = 1.0 - float(forced.sum() / power.sum())
    return Credibility(axis, crossover, (-lag - np.pi / 2.0) / crossover, remnant)
