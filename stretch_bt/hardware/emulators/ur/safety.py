"""The states of a controller's safety system."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["SAFETY", "Safety"]


class Safety(NamedTuple):
    """A state of the safety system: its names on the dashboard, number and bits."""

    name: str
    mode: int
    bits: int


_NORMAL, _STOPS = 1 << 0, 1 << 10
#: the gravest last: it is told where some exist side by side
SAFETY: dict[str, Safety] = {
    "normal": Safety("NORMAL", 1, _NORMAL),
    "protective_stop": Safety("PROTECTIVE_STOP", 3, 1 << 2 | _STOPS),
    "safeguard_stop": Safety("SAFEGUARD_STOP", 5, 1 << 4 | _STOPS),
    "emergency_stop": Safety("ROBOT_EMERGENCY_STOP", 7, 1 << 6 | 1 << 7 | _STOPS),
    "violation": Safety("VIOLATION", 8, 1 << 8 | _STOPS),
    "fault": Safety("FAULT", 9, 1 << 9 | _STOPS),
}
