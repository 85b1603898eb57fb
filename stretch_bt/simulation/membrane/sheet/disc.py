"""A round sheet: a square of quadratic splines, mapped onto a disc.

The elliptical map X = u sqrt(1 - v^2/2), Y = v sqrt(1 - u^2/2) (Fong, Analytical Methods for Squaring the Disc,
arXiv:1509.06344) is a product of functions of one variable, so interpolating the root at the Greville points gives the
control points of the whole map; scaled by a little, they cover the area of the disc exactly. The same functions carry the
deformed place, so an even stretch of the disc is exact. The map folds the corners of its square flat: there, and only
there, its area vanishes, which no Gauss point meets.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stretch_bt.simulation.membrane.indenters.base import Zone
from stretch_bt.simulation.membrane.indenters.placed import Placed
from stretch_bt.simulation.membrane.sheet.mesh import Mesh, breakpoints
from stretch_bt.simulation.membrane.sheet.outline import CLAMP_POINTS
from stretch_bt.simulation.membrane.sheet.spline import Array, Axis, BasisTable

__all__ = ["Disc", "DiscMesh"]


@dataclass(frozen=True)
class DiscMesh(Mesh):
    """A mesh whose axes run over [-r, r] each, and which covers the disc of radius r; clamped all around."""

    @property
    def held(self) -> bool:
        """Clamped on all four sides."""
        return True

    @cached_property
    def rest(self) -> Array:
        """Control points (ny, nx, 2) of the unstretched disc."""
        radius, (across, along) = self.x.breaks[-1], (_root(axis) for axis in (self.x, self.y))
        # integrated by parts, the area of the map needs no more than the integrals of the two roots
        area = math.sqrt(2) * radius * (_integral(self.x, across) + _integral(self.y, along)) - 2 * radius**2
        places = [np.outer(along, self.x.greville), np.outer(self.y.greville, across)]
        return np.stack(places, axis=-1) * math.sqrt(math.pi * radius**2 / area)

    @cached_property
    def inverse(self) -> Array:
        """(ey, ex, qy, qx, 5) at the Gauss points of strain: du/dX, dv/dX, du/dY, dv/dY and the area of a unit of u, v."""
        ((xu, yu), (xv, yv)), area = self._slopes(*self.strain)
        return np.ascontiguousarray(np.stack([yv / area, -yu / area, -xv / area, xu / area, area], axis=-1))

    @cached_property
    def spread(self) -> Array:
        """(ey, ex, qy, qx) at the Gauss points of contact: the area of a unit of u, v."""
        return np.ascontiguousarray(self._slopes(*self.touch)[1])

    @cached_property
    def areas(self) -> Array:
        """Unstretched area (ny, nx) that belongs to each control point."""
        tx, ty = self.touch
        weight = np.einsum("yxpq,yp,xq->yxpq", self.spread, ty.weight, tx.weight)
        parts = np.einsum("yxpq,ypj,xqi->jiyx", weight, ty.value, tx.value, optimize=True)
        areas, (ny, nx) = np.zeros(self.shape[:2]), parts.shape[2:]
        for j in range(3):
            for i in range(3):
                areas[j : j + ny, i : i + nx] += parts[j, i]
        return areas

    def _slopes(self, tx: BasisTable, ty: BasisTable) -> tuple[tuple[Array, Array], Array]:
        """Return derivatives (2, ey, ex, qy, qx) of the place by u and by v, and the area of a unit of u, v."""
        local = np.lib.stride_tricks.sliding_window_view(self.rest, (3, 3), axis=(0, 1))  # (ey, ex, c, j, i)
        by_u, by_v = (
            np.einsum("xqi,ypj,yxcji->cyxpq", a, b, local, optimize=True)
            for a, b in ((tx.slope, ty.value), (tx.value, ty.slope))
        )
        return (by_u, by_v), by_u[0] * by_v[1] - by_u[1] * by_v[0]


def _root(axis: Axis) -> Array:
    """Return the control values (n,) of sqrt(1 - (u/r)^2/2), interpolated at the Greville points."""
    places = axis.greville
    element = axis.locate(places)
    basis = np.zeros((len(places), len(places)))
    np.put_along_axis(basis, element[:, None] + np.arange(3), axis.basis(element, places)[0], axis=1)
    return np.linalg.solve(basis, np.sqrt(1 - (places / axis.breaks[-1]) ** 2 / 2))


def _integral(axis: Axis, control: Array) -> float:
    """Return the integral of the function with these control values (n,) over its axis."""
    return float((axis.knots[3:] - axis.knots[:-3]) @ control / 3)


@dataclass(frozen=True, slots=True)
class Disc:
    """A round sheet clamped all around; unstretched its radius is 50 sheet units, clamped it is half the span."""

    def back(self, length: float) -> tuple[float, float]:
        """Return the factors on places in x and y when the sheet, stretched by `length`, is let go."""
        return 1 / length, 1 / length

    def mesh(self, across: float, x: Sequence[Zone], y: Sequence[Zone], growth: float) -> Mesh:
        """Return a mesh with the zones, sheet units, on a sheet `across` wide."""
        return DiscMesh(*(Axis(breakpoints(across, zones, growth)) for zones in (x, y)))

    def clamps(self, across: float, span: float, near: Array) -> Array:
        """Return places (n, 2) around the clamp, those next to places near (k, 2) included."""
        turn = np.linspace(0, 2 * math.pi, 2 * CLAMP_POINTS, endpoint=False)
        turn = np.concatenate([turn, np.arctan2(near[:, 1], near[:, 0])])
        return span / 2 * np.column_stack([np.cos(turn), np.sin(turn)])

    def flat(self, mesh: Mesh, span: float) -> Array:
        """Return the control points (ny, nx, 3) of the flat sheet, evenly stretched: its equilibrium."""
        rest = mesh.rest * (span / 100)
        return np.concatenate([rest, np.zeros((*rest.shape[:2], 1))], axis=-1)

    def clamped(self, mesh: Mesh, control: Array, span: float) -> Array:
        """Return the control points, the boundary's held on the clamp."""
        held = self.flat(mesh, span)
        held[1:-1, 1:-1] = control[1:-1, 1:-1]
        return held

    def tent(self, flat: Array, bodies: Sequence[Placed], span: float, unit: float) -> Array:
        """Return the flat control points raised over each body to a cone that ends at the nearest place of the clamp."""
        raised = flat.copy()
        for body in bodies:
            px, py = (body.origin[:2] / unit).tolist()
            room = max(span / 2 - float(np.hypot(px, py)), 1e-3)
            crest = float(np.hypot(*body.indenter.crest(body.rotation))) / unit
            plateau = min(crest, 0.8 * room)
            along = np.maximum(np.hypot(flat[..., 0] - px, flat[..., 1] - py) - plateau, 0.0) / (room - plateau)
            raised[..., 2] = np.maximum(raised[..., 2], body.top / unit * np.maximum(0.0, 1 - along))
        return raised
