"""The number from which everything random in a simulation follows."""

from __future__ import annotations

from numbers import Integral
from typing import Any

from stretch_bt.errors import InvalidInput, shown

__all__ = ["checked_seed"]


def checked_seed(seed: Any) -> int:
    """Return a seed as Python's own number; raises InvalidInput unless it is a whole number from 0 on."""
    if isinstance(seed, bool) or not isinstance(seed, Integral) or seed < 0:
        raise InvalidInput(f"a seed is a whole number from 0 on, not {shown(seed)}")
    return int(seed)
