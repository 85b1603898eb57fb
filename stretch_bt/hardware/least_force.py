"""The least limit of force that an arm can hold whose force has noise."""

from __future__ import annotations

import math
from typing import Final

__all__ = ["DEVIATIONS", "LONGEST", "least_limit"]

#: standard deviations from zero force to the limit: noise alone passes it once in 800 000 independent means of three axes
DEVIATIONS: Final = 5.5
#: the longest time over which the arm's force is averaged, s: a hand at 10 mm/s goes 3.5 mm in it
LONGEST: Final = 0.35


def least_limit(noise: float, over: float = LONGEST) -> float:
    """Return the least limit, N, of a force that has a noise of so many N s^0.5 an axis and is averaged over a time, s."""
    return DEVIATIONS * noise / math.sqrt(over)
