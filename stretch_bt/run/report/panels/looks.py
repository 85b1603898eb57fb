"""The looks at an object that a record holds: where the hand stood, and what was told of force and drop."""

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
    """One look: time, s; stretch, hand (its depth past first contact), depth of the membrane, radius and drop, m; force, N."""

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
    """Return the looks in order: each time that a node has written both `force` and `drop`.

    The keys of the main tree are `stretch`, `depth` (of the hand past first contact), `h0` (height of that), `seen` (height of the
    top, as seen), `sphere`, `look_force` (`force` in older records) and `drop`. A look of which one is missing or not a finite number is left out.
    """
    known: dict[str, dict[str, Any]] = {}
    told: dict[str, set[str]] = {}
    found = []
    for event in events:
        if event["type"] != "write" or not str(event["key"]).startswith(_MAIN):
            continue
        name = str(event["key"]).removeprefix(_MAIN).replace("look_force", "force")
        known[name] = event
        if name in ("force", "drop"):
            both = told.setdefault(event["path"], set())
            both.add(name)
            if len(both) == 2:
                both.clear()
                found.append(_look(known))
    return [look for look in found if look is not None]


def _look(known: dict[str, dict[str, Any]]) -> Look | None:
    names = ("stretch", "depth", "h0", "seen", "force", "drop")
    stretch, hand, top, seen, force, drop = (_value(known.get(name)) for name in names)
    radius = _value(known.get("sphere"), "radius")
    if (
        stretch is None
        or hand is None
        or top is None
        or seen is None
        or force is None
        or drop is None
        or radius is None
    ):
        return None
    seen_sd, force_sd, drop_sd = (_sd(known[name]) for name in ("seen", "force", "drop"))
    depth = hand - (top - seen)
    return Look(float(known["drop"]["time"]), stretch, hand, depth, seen_sd, radius, force, force_sd, drop, drop_sd)


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


def _sd(event: dict[str, Any]) -> float:
    sd = event.get("sd")
    return float(sd) if isinstance(sd, int | float) and math.isfinite(sd) else 0.0
