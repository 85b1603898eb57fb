"""Errors carried over from estimates to what is computed from them."""

from __future__ import annotations

import math
from collections.abc import Callable

from stretch_bt.units import Estimate

__all__ = ["carried"]

_STEP = 1e-6  # of a value, for slopes


def carried(function: Callable[..., float], *given: Estimate) -> Estimate:
    """Return what a function gives of some values, with the standard deviation that follows from theirs at first order."""
    values = [estimate.value for estimate in given]
    value = function(*values)
    parts = []
    for k, estimate in enumerate(given):
        step = _STEP * max(abs(values[k]), 1e-9)
        moved = [v + step * (i == k) for i, v in enumerate(values)]
        parts.append((function(*moved) - value) / step * estimate.sd)
    return Estimate(value, math.hypot(*parts))
