"""The outline of a sheet: the area of its mesh, its clamps, and a first guess of its shape."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from stretch_bt.simulation.membrane.indenters.base import Zone
from stretch_bt.simulation.membrane.indenters.placed import Placed
from stretch_bt.simulation.membrane.sheet import start
from stretch_bt.simulation.membrane.sheet.mesh import Mesh, breakpoints
from stretch_bt.simulation.membrane.sheet.spline import Array, Axis

__all__ = ["CLAMP_POINTS", "Rectangle", "SheetOutline"]

CLAMP_POINTS = 181
_ENDS = np.stack(np.meshgrid(np.linspace(-1, 1, CLAMP_POINTS), [-1, 1]), axis=-1).reshape(-1, 2)


class SheetOutline(Protocol):
    """An outline; lengths in sheet units, hundredths of the gauge, and `span` between opposite clamps."""

    def back(self, length: float) -> tuple[float, float]:
        """Return the factors on places in x and y when the sheet, stretched by `length`, is let go."""
        ...

    def mesh(self, across: float, x: Sequence[Zone], y: Sequence[Zone], growth: float) -> Mesh:
        """Return a mesh with the zones on a sheet `across` wide and 100 long."""
        ...

    def clamps(self, across: float, span: float, near: Array) -> Array:
        """Return places (n, 2) along the clamped edges of a sheet `across` wide, those next to places near (k, 2) included."""
        ...

    def flat(self, mesh: Mesh, span: float) -> Array:
        """Return control points (ny, nx, 3) of the flat stretched sheet, or nearly so."""
        ...

    def clamped(self, mesh: Mesh, control: Array, span: float) -> Array:
        """Return the control points, the clamped ones in their place."""
        ...

    def tent(self, flat: Array, bodies: Sequence[Placed], span: float, unit: float) -> Array:
        """Return the flat control points raised over each body; `unit` is in m."""
        ...


@dataclass(frozen=True, slots=True)
class Rectangle:
    """Clamped at both ends of y, with its width held there; free at the sides."""

    def back(self, length: float) -> tuple[float, float]:
        """Return the factors on places in x and y; stretched, the middle narrows a little more than a strip would."""
        return length**0.55, 1 / length

    def mesh(self, across: float, x: Sequence[Zone], y: Sequence[Zone], growth: float) -> Mesh:
        """Return a mesh with the zones on a sheet `across` wide and 100 long."""
        return Mesh(Axis(breakpoints(across, x, growth)), Axis(breakpoints(100.0, y, growth)))

    def clamps(self, across: float, span: float, near: Array) -> Array:
        """Return places (n, 2) along both ends, those next to places near (k, 2) included."""
        next_to = [
            np.column_stack([np.clip(near[:, 0], -across / 2, across / 2), 0 * near[:, 1] + y]) for y in _sides(span)
        ]
        return np.concatenate([_ENDS * [across / 2, span / 2], *next_to])

    def flat(self, mesh: Mesh, span: float) -> Array:
        """Return control points (ny, nx, 3) of the flat sheet that narrows between its clamps."""
        return start.flat_guess(mesh, span)

    def clamped(self, mesh: Mesh, control: Array, span: float) -> Array:
        """Return the control points with the first and last row held straight."""
        return start.clamped(mesh, control, span)

    def tent(self, flat: Array, bodies: Sequence[Placed], span: float, unit: float) -> Array:
        """Return the flat control points raised to a tent over each body."""
        return start.tent(flat, bodies, span, unit)


def _sides(span: float) -> tuple[float, float]:
    return -span / 2, span / 2
