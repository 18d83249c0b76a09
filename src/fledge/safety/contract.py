"""What a net relies on: the contract, and how each vehicle stops.

A net proves that nothing is touched as long as the contract holds (`docs/safety-case.md`); beyond it nothing is
promised. The contract bounds the data and the world; a `UavStop` and a `UgvStop` say how far a vehicle still goes
once it is told to stop. Their numbers are measured on the vehicle, here the simulated ones, and a test measures them
again.
"""

from dataclasses import dataclass

from fledge.dynamics import Pioneer
from fledge.scalars import Scalar


@dataclass(frozen=True, slots=True)
class Contract:
    """What must hold for the promise to hold. Bounds are on absolute values."""

    period: float = 0.01
    """Between two calls of the net [s]."""
    age: float = 0.05
    """Of the newest measurement; on older ones nothing new is accepted [s]."""
    latency: float = 0.05
    """From a command's sending to its effect; with `age` the 100 ms of delay [s]."""
    position_error: float = 0.02
    """[m]."""
    velocity_error: float = 0.1
    """[m/s]."""
    angle_error: float = 0.01
    """Of roll, pitch and heading [rad]; motion capture gives half a degree."""
    rate_error: float = 0.1
    """Of body rates [rad/s]."""
    disturbance: float = 0.3
    """Acceleration nobody commanded: wind, and command errors times the velocity loop's gain [m/s^2]."""


@dataclass(frozen=True, slots=True)
class UavStop:
    """Where a UAV comes to rest that is told to hover.

    In its linear range the way to the stop is a linear function of the state, per heading axis:
    `speed` v + `tilt` theta + `rate` theta' + `followed` f, with f the command its filter still follows; to which comes
    what commands on their way to it will add, their speed times their duration. Fitted to restless flights of
    `Quadrotor`, commands jumping between the extremes every 10 to 800 ms. What remains grows with the speed, since the
    range is not quite linear, and while it turns, since its lags turn with it: `miss` bounds it.
    """

    radius: float = 0.26  # [m] of the indoor hull, as `Quadrotor.radius`
    half_height: float = 0.1  # [m]; as `Quadrotor.half_height`
    most: float = 1.0  # [m/s] largest command per axis
    most_up: float = 0.5  # [m/s]
    most_turn: float = 1.0  # [rad/s]
    speed: float = 0.34  # [s]
    tilt: float = 0.312  # [m/rad]
    rate: float = 0.0313  # [m s/rad]
    followed: float = 0.0255  # [s]
    error: float = 0.01  # [m] by which a stop from a crawl misses
    error_speed: float = 0.09  # [s] what a speed adds
    error_turn: float = 0.15  # [s^2/rad] what a speed adds at a rate of turning
    speed_up: float = 0.338  # [s]
    followed_up: float = 0.046  # [s]
    error_up: float = 0.02  # [m]
    lag: float = 0.2  # [s] of the command filter, `dynamics.COMMAND_LAG`
    hold: float = 0.11  # [m] how far the contract's disturbance pushes it off a point it holds
    hold_over: float = 0.05
    """[s] it goes on with the last command when the link is lost: the AR.Drone's watchdog."""
    silence: float = 0.3
    """[s] for which it may be left alone then; chosen, since its own hover drifts."""

    def miss(self, speed: Scalar, turn: Scalar) -> Scalar:
        """By how much at most a stop misses that point [m] after flying at a speed [m/s] and turning [rad/s]."""
        return self.error + speed * (self.error_speed + self.error_turn * turn)


@dataclass(frozen=True, slots=True)
class UgvStop:
    """How a UGV comes to rest that is told to stop: at a bounded deceleration, while its turning dies down, too."""

    radius: float
    height: float
    acceleration: float
    """[m/s^2]."""
    turn_acceleration: float
    """[rad/s^2]."""
    most: float
    """Largest speed [m/s]."""
    most_turn: float
    """[rad/s]."""
    hold_over: float = 0.6
    """[s] it goes on with the last command when the link is lost: the Pioneer's watchdog."""
    silence: float = 1.0
    """[s] for which it is left alone in attacks; longer would do, since then it stands."""

    @classmethod
    def of(cls, model: Pioneer) -> "UgvStop":
        """As the model brakes; its largest speed is that of the guidance, not of the robot."""
        return cls(
            radius=model.radius,
            height=model.height,
            acceleration=model.acceleration,
            turn_acceleration=model.turn_acceleration,
            most=model.max_speed,
            most_turn=model.max_turn_rate,
        )
