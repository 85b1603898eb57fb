"""Arithmetic on wrench readings."""

from __future__ import annotations

from dataclasses import replace

from stretch_bt.frames import Wrench
from stretch_bt.hardware.interfaces import Reading

__all__ = ["minus"]


def minus(reading: Reading[Wrench], zero: Wrench) -> Reading[Wrench]:
    """Return the reading with a wrench taken off."""
    (fx, fy, fz), (tx, ty, tz) = reading.value.force, reading.value.torque
    (ax, ay, az), (bx, by, bz) = zero.force, zero.torque
    return replace(reading, value=Wrench((fx - ax, fy - ay, fz - az), (tx - bx, ty - by, tz - bz)))
