"""How to optimise, and nothing else: what is learnt was decided in `fuse`.

Two recipes are ready: `Recipe.paper()` is the paper's (full batch, Adam, 10,000 epochs, 67/33 split by row, initial
weights of standard deviation 1e-4) and `Recipe.fast()` reaches the same held-out error in seconds (mini-batches, cosine
schedule, split by episode, stopped where the loss on held-out episodes has risen).
"""

from dataclasses import dataclass
from typing import Literal

from fledge.errors import OutOfRange


@dataclass(frozen=True, slots=True)
class Recipe:
    """How to optimise."""

    epochs: int = 40
    batch: int | None = 256
    """Rows per step; None for all of them."""
    learning_rate: float = 2e-3
    schedule: Literal["constant", "cosine"] = "cosine"
    weight_decay: float = 0.1
    """Decoupled (AdamW), in units of the learning rate."""
    init: Literal["paper", "constant", "he"] = "paper"
    """Normal of sd 1e-4, the constant 1e-4, or He's normal (D5). From weights near 0 an input that a sub-task does not
    vary stays without influence on its actions; from He's it keeps a random one, and flights show it."""
    split: Literal["row", "episode"] = "episode"
    validation: float = 0.2
    """Share of rows or episodes held out."""
    keep: Literal["last", "best"] = "best"
    """The weights of the last epoch, or of the last whose held-out loss is close to the lowest."""
    slack: float = 0.25
    """How close: the share by which it may be above. The lowest itself comes early, from weights that the schedule
    has not yet brought to rest, and they fly worse (docs/method.md)."""
    points: int = 20
    """How often the losses are measured, and a checkpoint is made, over the whole run."""

    @classmethod
    def paper(cls, epochs: int = 10_000) -> "Recipe":
        """Section "Experiments", to the letter where it speaks; Adam's step is Keras's default."""
        return cls(
            epochs=epochs,
            batch=None,
            learning_rate=1e-3,
            schedule="constant",
            weight_decay=0.0,
            init="paper",
            split="row",
            validation=0.33,
            keep="last",
            points=100,
        )

    @classmethod
    def fast(cls, epochs: int = 40) -> "Recipe":
        """The default; chosen on development flights (docs/method.md)."""
        return cls(epochs=epochs)

    def checked(self) -> "Recipe":
        """Itself, if its fields make sense.

        Raises:
            OutOfRange: names the field.
        """
        for name, valid, ok in (
            ("epochs", "1 or more", self.epochs >= 1),
            ("batch", "1 or more, or None", self.batch is None or self.batch >= 1),
            ("learning_rate", "above 0, to 1", 0.0 < self.learning_rate <= 1.0),
            ("weight_decay", "0 or more", self.weight_decay >= 0.0),
            ("validation", "above 0, below 1", 0.0 < self.validation < 1.0),
            ("slack", "0 or more", self.slack >= 0.0),
            ("points", "1 or more", self.points >= 1),
            ("schedule", "constant or cosine", self.schedule in ("constant", "cosine")),
            ("init", "paper, constant or he", self.init in ("paper", "constant", "he")),
            ("split", "row or episode", self.split in ("row", "episode")),
            ("keep", "last or best", self.keep in ("last", "best")),
        ):
            if not ok:
                raise OutOfRange(f"recipe {name}", getattr(self, name), valid)
        return self

    @property
    def stride(self) -> int:
        """Epochs between two measurements."""
        return max(self.epochs // self.points, 1)
