"""Readings of a simulated device that measures a thousand times a second."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import numpy as np

from stretch_bt.frames import Wrench
from stretch_bt.hardware.interfaces import Reading

if TYPE_CHECKING:
    from stretch_bt.hardware.simulated.twin import Twin

__all__ = ["sample", "sample_number", "sample_wrench"]

T = TypeVar("T")
_RATE = 1000


def sample_number(time: float) -> int:
    """Return the number of the latest sample at a time, s."""
    return int(time * _RATE + 1e-6)


def sample(value: T, time: float) -> Reading[T]:
    """Return a reading of a value at a time, s."""
    return Reading(value, time, time, sample_number(time))


def sample_wrench(twin: Twin, device: str, noise: float) -> Reading[Wrench]:
    """Return the contact wrench now, each axis of its force with white noise of this standard deviation, N."""
    now = twin.now()
    added = np.zeros(3)
    if noise > 0:
        added = twin.random(device, sample_number(now)).normal(0.0, noise, 3)
    force = (float(added[0]), float(added[1]), twin.force(now) + float(added[2]))
    return sample(Wrench(force), now)
