"""What a finite number of looks allows to say about all of them.

The largest of n has been seen; the next may be larger. So a bound is the larger of two numbers: the largest seen, and
what an exponential tail that begins at the median says is passed by one in a thousand,

    median + beta ln(0.5 / 0.001),    beta = excess / n' * 2 n' / chi2(0.05; 2 n')

with `excess` the sum of what the n' looks above the median have beyond it: the upper end, with 95 % confidence, of the
mean of an exponential distribution (peaks over a threshold; S. Coles, An Introduction to Statistical Modeling of
Extreme Values, 2001, chapter 4, with a shape of 0). Ways that stops miss by have tails like that, or lighter, since
tilt and speed have limits; a normal tail was tried first, and 6 of 204 fresh stops of the twin were beyond it.
"""

from math import log

import numpy as np
from scipy.stats import chi2

BEYOND, CONFIDENCE = 0.001, 0.95
"""Share of all that may lie above, and how sure one is of it; chosen."""
MORE = 1.1
"""By how much the largest of many thousands is enlarged, ticks, say, of which none is independent; chosen."""


def bound(seen: np.ndarray) -> float:
    """Below which the next will be as well; of independent looks, ten or more."""
    middle = float(np.median(seen))
    excess = seen[seen > middle] - middle
    if not len(excess):
        return middle
    mean = 2.0 * float(excess.sum()) / float(chi2.ppf(1.0 - CONFIDENCE, 2 * len(excess)))
    return max(float(seen.max()), middle + mean * log(0.5 / BEYOND))


def most(seen: np.ndarray) -> float:
    """The largest of very many, and a little more."""
    return MORE * float(np.abs(seen).max())
