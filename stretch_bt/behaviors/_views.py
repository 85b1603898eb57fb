"""Places from which an object is pressed: as an operator writes them, and whether the latest showed anything new."""

from __future__ import annotations

import math
from dataclasses import replace

from stretch_bt.behaviors.records import TriedViews
from stretch_bt.errors import InvalidInput
from stretch_bt.units import KINDS, parse_quantity

__all__ = ["Place", "counted", "place_of", "request_of"]

#: x, y, m, and turn about the vertical, rad
Place = tuple[float, float, float]

FRUITLESS = 0.02  # least change of the map by a press that counts, as a share of the known area


def place_of(text: str) -> Place:
    """Return x, y, m, and turn, from -pi to pi rad, of a pose as text; raises InvalidInput when it is none."""
    parts = [part.strip() for part in text.replace(";", ",").split(",")]
    if len(parts) not in (2, 3):
        raise InvalidInput(f"poses: {text!r} is not 'x; y' or 'x; y; turn', such as '10 mm; 0 mm; 90 deg'")
    found = [parse_quantity(part) for part in parts]
    for part, (_, dimension), kind in zip(parts, found, ("Length", "Length", "Angle"), strict=False):
        if dimension != KINDS[kind].dimension:
            raise InvalidInput(
                f"poses: {part!r} in {text!r} has another unit than it takes, as in '10 mm; 0 mm; 90 deg'"
            )
    x, y, *turn = (value for value, _ in found)
    return x, y, math.remainder(turn[0], 2 * math.pi) if turn else 0.0


def request_of(place: Place) -> str:
    """Return the request that an operator is asked to confirm."""
    x, y, yaw = place
    where = f"x {x * 1e3:.4g} mm, y {y * 1e3:.4g} mm, turned by {math.degrees(yaw):.4g} deg"
    return f"The hand is about to press at {where}."


def counted(before: TriedViews, presses: int, known: float, unseen: float) -> TriedViews:
    """Return the tried views, updated by the presses since the latest plan; `known` and `unseen` are areas of the upper surface, m^2."""
    fruitless = before.fruitless
    if before.presses is not None and presses > before.presses:
        change = abs(known - before.known) + abs(unseen - before.unseen)
        fruitless = fruitless + 1 if change < FRUITLESS * known else 0
    return replace(before, presses=presses, known=known, unseen=unseen, fruitless=fruitless)
