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


def sample_wrench(twin: Twin, kind: str, device: str) -> Reading[Wrench]:
    """Return the contact wrench now, with the noise that the scene gives a kind of device, such as `ForceSensor`."""
    now = twin.now()
    wrench = twin.wrench(kind, now)
    added = np.zeros(3)
    for effect in twin.robot:
        with twin.world.stats.timed(effect.name):
            added = added + effect.force_error(kind, twin.random(f"{device} {effect.name}", sample_number(now)))
    x, y, z = (np.asarray(wrench.force) + added).tolist()
    return sample(Wrench((x, y, z)), now)
