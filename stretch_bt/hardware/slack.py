"""How far a measured value may be past a limit that no command passed: a device neither controls nor measures exactly."""

from __future__ import annotations

__all__ = ["SLACK", "most_measured"]

#: slack of a place or an opening, m: three counts of a gripper
SLACK = 0.002
#: slack of a speed, as a part of it and in m/s: a servo that catches up, and noise of the measured speed
_SPEED_PART, _SPEED = 1.2, 0.02


def most_measured(speed: float) -> float:
    """Return the largest speed, m/s, that may be measured where a speed is the limit."""
    return _SPEED_PART * speed + _SPEED
