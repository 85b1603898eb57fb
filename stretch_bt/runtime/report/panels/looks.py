"""The looks at an object that a record holds: where the hand stood, and the reported force and drop."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from stretch_bt.runtime.report.panels.keys import Key, finite

__all__ = ["TREES", "Look", "read_looks"]

SAME = 2e-4  # m, within which two looks are at one press: the hand is held better, and a step is larger
TREES = ("palpate_stiffness", "palpate_active")
SPHERE = Key("main/sphere", TREES, ("radius",))
FELT = Key("main/felt", TREES, ("last", "force", "force_sd", "deflection", "deflection_sd"))
LAST = ("stretch", "height", "depth", "sd")  # fields of `last`


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
        if SPHERE.wrote(event):
            radius = finite(_fields(event["value"]).get("radius"))
        elif FELT.wrote(event) and radius is not None:
            found.append(_look(event, radius))
    return [look for look in found if look is not None]


def _look(event: dict[str, Any], radius: float) -> Look | None:
    felt = _fields(event["value"])
    last = _fields(felt.get("last"))
    given = [last.get(name) for name in LAST] + [felt.get(name) for name in FELT.fields[1:]]
    known = [number for number in map(finite, given) if number is not None]
    if len(known) < len(given):
        return None
    stretch, height, depth, sd, force, force_sd, drop, drop_sd = known
    return Look(float(event["time"]), stretch, height - depth, depth, sd, radius, force, force_sd, drop, drop_sd)


def _fields(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}
