"""The place at which a rising function is 0."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["rising_root"]

_ROUNDS = 60
_CLOSE = 1e-13


def rising_root(off: Callable[[float], float], low: float, high: float) -> float:
    """Return where a rising function is 0 within its bracket, by the secants that keep it (Illinois)."""
    below, above = off(low), off(high)
    if below >= 0 or above <= 0:
        return low if below >= 0 else high
    side = 0
    for _ in range(_ROUNDS):
        at = high - above * (high - low) / (above - below)
        value = off(at)
        if abs(value) < _CLOSE or high - low < _CLOSE * abs(high):
            return at
        if value > 0:
            high, above, below, side = at, value, below / 2 if side == 1 else below, 1
        else:
            low, below, above, side = at, value, above / 2 if side == -1 else above, -1
    return at
