"""Numbers of numpy and of Python alike: what is one, and as Python's own."""

from __future__ import annotations

import math
from numbers import Integral, Real
from typing import Any, TypeGuard

__all__ = ["is_number", "plain_list", "plain_number"]


def is_number(value: object) -> TypeGuard[float]:
    """Return whether a value is a finite number, of Python or numpy; a truth is none."""
    try:
        return not isinstance(value, bool) and isinstance(value, Real) and math.isfinite(value)
    except OverflowError:  # a whole number beyond every float
        return False


def plain_number(value: Any) -> Any:
    """Return a number of numpy as Python's own, and anything else as it is."""
    if isinstance(value, int | float):
        return value
    if isinstance(value, Integral):
        return int(value)
    return float(value) if isinstance(value, Real) else value


def plain_list(value: Any) -> Any:
    """Return an array of numpy as a list of Python's own numbers, and anything else as it is."""
    return value.tolist() if type(value).__module__ == "numpy" and getattr(value, "ndim", 0) > 0 else value
