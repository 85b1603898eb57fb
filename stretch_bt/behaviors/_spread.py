"""How far heights scatter."""

import math
import statistics
from collections.abc import Sequence

from stretch_bt.units import Estimate, Length

__all__ = ["spread_of"]


def spread_of(heights: Sequence[Length], sd: Length) -> Estimate | None:
    """Return the standard deviation of heights (n,), m, each with an error `sd`, m; None of fewer than two, which do not show it."""
    if len(heights) < 2:
        return None
    found = statistics.stdev(heights)
    return Estimate(found, math.hypot(found, sd) / math.sqrt(2 * (len(heights) - 1)))
