"""How far two answers for one press are apart."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stretch_bt.simulation.membrane.press import PressResult
from stretch_bt.simulation.membrane.sheet.result import SheetPress
from stretch_bt.simulation.membrane.sheet.spline import Array

__all__ = ["Reference", "Round"]

_GRID, _EDGE = 121, 12  # places along each side of the sheet, and how many at either end are left out

Round = Callable[[Array], Array]  # height, m, over distance from the axis, m


@dataclass(frozen=True, slots=True)
class Reference:
    """The reference: force, N, contact radius, m, and the surface over the inner 80 % of the sheet.

    `places` (n, n, 3), m, are material points; `slopes` (n, n, 3) turn their displacement into the change of height over
    a fixed place, as a material point also slides along the surface.
    """

    force: float
    radius: float | None
    places: Array
    slopes: Array

    @classmethod
    def of(cls, solved: PressResult) -> Reference:
        """Take a press of the sheet for right."""
        points = _points(solved)
        normal = np.cross(np.gradient(points, axis=1), np.gradient(points, axis=0))
        slopes = normal / normal[..., 2:]
        return cls(solved.force, solved.contact.radius, _inner(points), _inner(slopes))

    def errors(self, solved: PressResult, height: Round | None = None) -> dict[str, float]:
        """Return the error of each kind that an answer has; `height` is the surface of a round membrane."""
        found = {"force": abs(solved.force / self.force - 1)}
        if isinstance(solved.detail, SheetPress):
            moved = _inner(_points(solved)) - self.places
            found["surface"] = float(np.abs((moved * self.slopes).sum(axis=-1)).max())
        elif height is not None:
            x, y, z = np.moveaxis(self.places, -1, 0)
            found["surface"] = float(np.abs(height(np.hypot(x, y)) - z).max())
        if self.radius is not None and solved.contact.radius is not None:
            found["contact_radius"] = abs(solved.contact.radius / self.radius - 1)
        return found


def _points(solved: PressResult) -> Array:
    assert isinstance(solved.detail, SheetPress)
    return solved.detail.shape.points(_GRID, _GRID)


def _inner(field: Array) -> Array:
    return field[_EDGE:-_EDGE, _EDGE:-_EDGE]
