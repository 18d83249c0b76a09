"""A synthetic operator from the manual-control literature. It is not a person, and every report says so.

Per axis (forward, left, up) the chain is that of the precision model (McRuer and Krendel, AGARDograph 188,
1974), here in its first-order form, from pixels to stick:

    error -> indifference threshold -> lead (T_L s + 1) / (T_I s + 1) -> + remnant -> gain
          -> reaction delay e^(-tau s) -> neuromuscular lag 1 / (T_N s + 1) -> stick stops and steps

* **Gain.** A skilled operator closes the loop at a crossover frequency that hardly depends on the plant (crossover
  model: Y_p Y_c ~ w_c e^(-tau_e s) / s). The model does so by knowing the altitude: K = w_c z / (f v_full).
* **Lead** answers the lag of the vehicle's velocity loop, as the crossover model says it must.
* **Remnant** is noise on what is perceived, error and its rate together (the signal y after the lead), with a spectral
  density proportional to its variance (Levison, Baron and Kleinman 1969): V = pi rho E[y^2] / f, coloured by a
  first-order lag as in the structural models. E[y^2] is a running mean.
* **Attention.** f is the share of attention an axis gets. In a sub-task the active axes share it; in Combined three
  do. This is the mechanism by which the composite task is harder for a person. `share_attention=False` turns it
  off (f = 1 everywhere); the study reports both.

Parameters lie inside literature bands that `docs/method.md` fixed before the first study; `crossover.py`
measures the resulting crossover frequency, effective delay and remnant share. None was tuned on a result.
"""

from dataclasses import dataclass, field, replace
from math import pi

from fledge.observation import ROW_RATE, Action, Axes, Observation, StickScale
from fledge.pilots.base import AbstractPilot, Noise
from fledge.scalars import Scalar, clip, exp, maximum, round_, sqrt, where

DT = 1.0 / ROW_RATE
DELAY_ROWS = 10
"""Length of the delay line: reaction delays up to 0.45 s."""

STICK_STEPS = 127.0
"""Joystick resolution: signed 8 bits."""


@dataclass(frozen=True, slots=True)
class AxisMemory:
    """What one axis of the operator remembers."""

    lagged: Scalar
    """State of the lead-lag filter [px]."""
    power: Scalar
    """Running mean square of what is perceived, error and rate together [px^2]."""
    remnant: Scalar
    """Coloured noise on it [px]."""
    delayed: tuple[Scalar, ...]
    """Stick wishes of the last rows, newest first."""
    stick: Scalar
    """Output of the neuromuscular lag."""


@dataclass(frozen=True, slots=True)
class HumanModel(AbstractPilot):
    """One operator; defaults are mid-band."""

    crossover: float = 1.5  # [rad/s] w_c; drone by video 1-2.5 (McRuer-Jex rules with a video delay)
    crossover_up: float = 2.0  # [rad/s] likewise; the vertical loop answers faster, so the operator may, too
    lead: float = 0.3  # [s] T_L; the lag of the vehicle's velocity loops, measured from 0.7 to 1.5 rad/s
    lag: float = 0.1  # [s] T_I
    delay: float = 0.2  # [s] tau, at most 0.45; optimal-control model 0.15-0.25 (Kleinman 1970)
    neuromuscular: float = 0.1  # [s] T_N; same source
    remnant: float = 0.01  # rho, -20 dB; Levison et al. 1969
    remnant_lag: float = 0.23  # [s] T_n; structural-model fits
    power_memory: float = 5.0  # [s]; chosen, how long E[y^2] remembers
    threshold_px: float = (
        2.0  # indifference; chosen below the 3.6 px rms to which Table 4's person held the radius
    )
    share_attention: bool = True
    axes: Axes = Axes()
    focal_px: float = 374.7  # Lens.focal_px; a person learns this scale by flying
    sticks: StickScale = field(default=StickScale(), metadata={"static": True})
    name = "human-model"

    def for_axes(self, axes: tuple[int, ...]) -> "HumanModel":
        """An operator who was told to use only these sticks, and looks only at what they control."""
        return replace(self, axes=Axes.of(axes))

    def init(self) -> tuple[AxisMemory, AxisMemory, AxisMemory]:
        """Rested: hands off, no error seen yet beyond a guess of 10 px."""
        rest = AxisMemory(0.0, 100.0, 0.0, (0.0,) * DELAY_ROWS, 0.0)
        return rest, rest, rest

    def act(
        self,
        memory: tuple[AxisMemory, AxisMemory, AxisMemory],
        observation: Observation,
        noise: Noise,
    ) -> tuple[tuple[AxisMemory, AxisMemory, AxisMemory], Action]:
        """One look at the picture, one movement of the sticks."""
        o, axes = observation, self.axes
        shared = 1.0 / maximum(axes.forward + axes.left + axes.up, 1.0)
        attention = where(self.share_attention, shared, 1.0)
        metres = o.altitude / self.focal_px
        lateral = self.crossover * metres / self.sticks.horizontal
        vertical = self.crossover_up * o.altitude / o.ideal_radius / self.sticks.vertical
        ahead, forward = self._axis(memory[0], o.centre_v - o.ugv_v, lateral, attention, noise[0])
        aside, left = self._axis(memory[1], o.centre_u - o.ugv_u, lateral, attention, noise[1])
        above, up = self._axis(memory[2], o.radius - o.ideal_radius, vertical, attention, noise[2])
        return (ahead, aside, above), Action(forward, left, up, 0.0 * up).only(axes)

    def _axis(
        self, m: AxisMemory, error: Scalar, gain: Scalar, attention: Scalar, noise: Scalar
    ) -> tuple[AxisMemory, Scalar]:
        """One axis, one row: displayed error [px] -> stick in [-1, 1]."""
        seen = error - clip(error, -self.threshold_px, self.threshold_px)
        lagged = m.lagged + (seen - m.lagged) * (1.0 - exp(-DT / self.lag))
        led = lagged + self.lead / self.lag * (seen - lagged)
        power = m.power + (led * led - m.power) * (DT / self.power_memory)
        # White noise of intensity V through a lag T_n has variance V / (2 T_n).
        keep = exp(-DT / self.remnant_lag)
        sigma = sqrt(pi * self.remnant * power / attention / (2.0 * self.remnant_lag))
        remnant = keep * m.remnant + sqrt(1.0 - keep * keep) * sigma * noise
        wishes = (gain * (led + remnant), *m.delayed[:-1])
        stick = m.stick + (self._recall(wishes) - m.stick) * (1.0 - exp(-DT / self.neuromuscular))
        said = round_(clip(stick, -1.0, 1.0) * STICK_STEPS) / STICK_STEPS
        return AxisMemory(lagged, power, remnant, wishes, stick), said

    def _recall(self, wishes: tuple[Scalar, ...]) -> Scalar:
        """The wish of `delay` seconds ago, interpolated between rows."""
        rows = self.delay * ROW_RATE
        return sum(wish * maximum(0.0, 1.0 - abs(rows - i)) for i, wish in enumerate(wishes))
