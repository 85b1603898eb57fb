"""The looks at an object that a record holds: where the hand stood, and the reported force and drop."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

__all__ = ["Look", "read_looks", "written"]

SAME = 2e-4  # m, within which two looks are at one press: the hand is held better, and a step is larger
_MAIN = "main/"


@dataclass(frozen=True, slots=True)
class Look:
    """One look: time, s; stretch, hand (height of its flat membrane), depth of the membrane, radius and drop, m; force, N."""

    time: float
    stretch: float
    hand: float
    depth: float
    depth_sd: float
    radius: float
    force: float
    force_sd: float
    drop: float
    drop_sd: float

    def same_press(self, other: Look) -> bool:
        """Return whether the hand stood alike."""
        return self.stretch == other.stretch and abs(self.hand - other.hand) < SAME


def read_looks(events: Iterable[dict[str, Any]]) -> list[Look]:
    """Return the looks in order: each record `felt` that the main tree was given, with the `sphere` before it.

    A look of which a number is missing or not finite is left out.
    """
    found, radius = [], None
    for event in events:
        if event["type"] == "write" and event["key"] == _MAIN + "sphere":
            radius = _value(event, "radius")
        elif event["type"] == "write" and event["key"] == _MAIN + "felt" and radius is not None:
            found.append(_look(event, radius))
    return [look for look in found if look is not None]


def _look(event: dict[str, Any], radius: float) -> Look | None:
    felt = event["value"] if isinstance(event["value"], dict) else {}
    last = felt.get("last")
    last = last if isinstance(last, dict) else {}
    given = [last.get(name) for name in ("stretch", "height", "depth", "sd")]
    given += [felt.get(name) for name in ("force", "force_sd", "deflection", "deflection_sd")]
    known = [float(value) for value in given if isinstance(value, int | float) and math.isfinite(value)]
    if len(known) < len(given):
        return None
    stretch, height, depth, sd, force, force_sd, drop, drop_sd = known
    return Look(float(event["time"]), stretch, height - depth, depth, sd, radius, force, force_sd, drop, drop_sd)


def written(events: Iterable[dict[str, Any]], key: str) -> float | None:
    """Return the last value of a key of the main tree, SI; None where it is not a finite number."""
    last = None
    for event in events:
        if event["type"] == "write" and event["key"] == _MAIN + key:
            last = event
    return _value(last)


def _value(event: dict[str, Any] | None, field: str = "") -> float | None:
    value = event["value"] if event is not None else None
    if field and isinstance(value, dict):
        value = value.get(field)
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None
