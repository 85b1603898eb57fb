"""The common part of responses with a memory."""

from __future__ import annotations

import math

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.objects.response import Response

__all__ = ["check_step", "longest_step"]


def longest_step(inner: Response, own: float) -> float:
    """Return the memory, s, of a response around another: the shorter of the two."""
    return own if inner.memory is None else min(inner.memory, own)


def check_step(dt: float) -> None:
    """Refuse a time step that is below 0 or no number."""
    if not (math.isfinite(dt) and dt >= 0):
        raise InvalidInput(f"a time step must be a finite time of at least 0 s, not {dt!r}")
