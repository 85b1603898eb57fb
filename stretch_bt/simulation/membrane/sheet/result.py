"""What a press of the sheet gives: force, contact, shape, and how far each can be trusted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.several import Several
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.mesh import Mesh
from stretch_bt.simulation.membrane.sheet.problem import Contact
from stretch_bt.simulation.membrane.sheet.spline import Array

_GRID = 141  # places across the sheet that a height map is interpolated from

__all__ = ["Load", "Memory", "Region", "Shape", "SheetPress"]


@dataclass(frozen=True, slots=True)
class Load:
    """What is done to the sheet: lengths in m, angles in rad."""

    indenter: Indenter | Several
    stretch: float
    depth: float
    at: tuple[float, float]
    tilt: tuple[float, float]

    def moves(self) -> Array:
        """Return (6,) float, what varies along a path of presses."""
        return np.array([self.stretch, self.depth, *self.at, *self.tilt])


@dataclass(frozen=True, slots=True)
class Region:
    """Where sheet and indenter touch: `points` (n, 3), m, membrane frame, and the deformed area of each, m^2."""

    points: Array
    areas: Array
    flat_areas: Array

    @property
    def area(self) -> float:
        """Area of the deformed surface in contact, m^2."""
        return float(self.areas.sum())

    @property
    def radius(self) -> float:
        """Radius of the disc that has the area of the contact seen along z, m."""
        return float(np.sqrt(self.flat_areas.sum() / np.pi))


@dataclass(frozen=True, slots=True)
class Shape:
    """The deformed mid-surface: a smooth spline; lengths in m."""

    mesh: Mesh
    control: Array
    unit: float

    def points(self, columns: int, rows: int) -> Array:
        """Return (rows, columns, 3) float, m, membrane frame: the surface over an even grid of the unstretched sheet."""
        x = np.linspace(self.mesh.x.breaks[0], self.mesh.x.breaks[-1], columns)
        y = np.linspace(self.mesh.y.breaks[0], self.mesh.y.breaks[-1], rows)
        return self.mesh.evaluate(self.control, x, y) * self.unit

    def height(self, x: Array, y: Array) -> Array:
        """Return z, m, of the sheet over places x and y (any equal shape), m; NaN beside the sheet."""
        from scipy.interpolate import LinearNDInterpolator

        x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        if x.shape != y.shape:
            raise InvalidInput(f"x and y must have one shape, not {x.shape} and {y.shape}")
        grid = self.points(_GRID, _GRID).reshape(-1, 3)
        return np.asarray(LinearNDInterpolator(grid[:, :2], grid[:, 2])(x, y))


@dataclass(frozen=True, slots=True)
class Memory:
    """What the next press starts from: the control points before this one and what had changed, and the offsets."""

    offsets: tuple[float, ...]
    previous: Array | None = None
    previous_offsets: tuple[float, ...] | None = None
    change: Array | None = None
    drift: float = 0.0
    peak: Array | None = None


@dataclass(frozen=True, slots=True)
class SheetPress:
    """One equilibrium of the sheet; SI units, membrane frame.

    `force` (3,) is that of the indenter on the sheet, `reaction` (3,) that of the sheet on the clamps; `balance` is how
    far the two are from cancelling, over the force. `force_error` is the estimated discretisation error of force[2], N.
    `residual` is the largest nodal force left over, over the force. `pivot` is the sign of the smallest pivot of the
    last exact tangent: +1 for a stable equilibrium. `nodes` counts the quadrature points in contact. `seconds` is the
    CPU time of the solve.
    """

    sheet: Sheet
    load: Load
    force: Array
    force_error: float
    reaction: Array
    balance: float
    shape: Shape
    contacts: tuple[Contact, ...]
    nodes: int
    energy: float
    residual: float
    pivot: int
    iterations: int
    factors: int
    seconds: float
    warnings: tuple[str, ...]
    memory: Memory

    def region(self) -> Region:
        """Return where the sheet touches, all bodies together."""
        parts = [_touched(self.shape, contact) for contact in self.contacts]
        return Region(*(np.concatenate(fields) for fields in zip(*parts, strict=True)))


def _touched(shape: Shape, contact: Contact) -> tuple[Array, Array, Array]:
    """Return points, deformed areas and areas seen along z of the quadrature points in contact with a body."""
    tx, ty = shape.mesh.touch
    local = np.lib.stride_tricks.sliding_window_view(shape.control, (3, 3), axis=(0, 1))  # (ey, ex, c, j, i)
    places, along_x, along_y = (
        np.einsum("xqi,ypj,yxcji->yxpqc", a, b, local, optimize=True).reshape(-1, 3)
        for a, b in ((tx.value, ty.value), (tx.slope, ty.value), (tx.value, ty.slope))
    )
    weight = np.einsum("xq,yp->yxpq", tx.weight, ty.weight).ravel()
    normal = np.cross(along_x, along_y) * weight[:, None]
    gap = contact.body.gap(np.ascontiguousarray(places * shape.unit)).distance / shape.unit
    sunk, area = contact.offset - gap, np.linalg.norm(normal, axis=1)
    near = sunk > _least(contact, sunk, area)
    square = shape.unit**2
    return (
        places[near] * shape.unit,
        area[near] * square,
        np.abs(normal[near, 2]) * square,
    )


def _least(contact: Contact, sunk: Array, area: Array) -> float:
    """Return the penetration, out of those at points that stand for an area, from which on the sheet touches.

    A flat face carries no pressure inside its rim. A round body carries tension T times its curvature right up to the edge;
    on the soft contact this settles as 1 - exp(-s/sqrt(T/stiffness)), s from where the pressure ends, and the straight
    piece of sheet outside belongs to a rigid contact that ends at s = sqrt(T/stiffness).
    """
    if contact.body.indenter.flat > 0:
        return -1e-3
    pressed = np.maximum(sunk, 0.0) * area
    return float((1 - np.exp(-1)) * (pressed @ sunk) / max(pressed.sum(), 1e-300))
