"""What is told of flights and operators: each number's name, unit and digits, and which way is better.

The numbers come from `evaluation` and `crossover`; whoever judges or shows them finds here how.
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Metric:
    """How a number is shown and judged."""

    title: str
    unit: str
    """As it is shown; may be empty."""
    meaning: str
    digits: int = 1
    """After the point, of the number itself; differences have two."""
    factor: float = 1.0
    """From the number to what is shown."""
    lower_is_better: bool | None = True
    """None where neither way is."""

    def head(self, difference: bool = False) -> str:
        """Title and unit; a difference of shares is in percentage points."""
        unit = "pp" if difference and self.unit == "%" else self.unit
        return f"{self.title} [{unit}]" if unit else self.title


METRICS = {
    "distance": Metric("distance mean", "px", "distance of the UGVs' centre from the image's, mean"),
    "distance_rmse": Metric("distance RMSE", "px", "distance, root mean square"),
    "radius": Metric("radius mean", "px²", "radius error, mean square"),
    "radius_rmse": Metric("radius RMSE", "px", "radius error, root mean square"),
    "in_view": Metric("in view", "%", "all UGVs in view", 2, 100.0, lower_is_better=False),
    "smoothness": Metric("sticks", "1/s", "sticks: change per second, mean", 2),
    "effort": Metric("effort", "", "sticks: deflection, mean", 3),
}
"""Of a flight, by the fields of `evaluation.Score`."""

ERRORS = ("distance_rmse", "radius_rmse")
"""Those by which claims are judged."""

CREDIBILITY = {
    "crossover": Metric("crossover", "rad/s", "crossover frequency", 2, lower_is_better=None),
    "delay": Metric("delay", "s", "effective delay", 2, lower_is_better=None),
    "remnant": Metric("remnant", "%", "share of stick power", 1, 100.0, lower_is_better=None),
}
"""Of an operator, by the fields of `crossover.Credibility`."""
