"""The result of a press of the sheet: force, contact, shape, and how far each can be trusted."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Indenter, flatness
from stretch_bt.simulation.membrane.indenters.placed import Placed
from stretch_bt.simulation.membrane.indenters.several import Several
from stretch_bt.simulation.membrane.sheet import contact_kernel
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.mesh import Mesh
from stretch_bt.simulation.membrane.sheet.problem import ContactPenalty, near, seen
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.membrane.sheet.spline import Array, Axis

if TYPE_CHECKING:  # its kernels are compiled when a press has friction
    from stretch_bt.simulation.membrane.sheet.friction import FrictionMemory

_FLAT = 0.25  # of the offset; inside the rim of a flat face the sheet rests on it without pressure, but for small waves
_STEEP = 0.3  # part of a normal along z below which it belongs to a side
_STEPS = 8  # in which the rest below a top of a slope of 45 degrees falls to a thousandth
_GRID = 141  # places across the sheet that a height map is interpolated from

__all__ = ["Load", "Memory", "Region", "Shape", "SheetPress"]


@dataclass(frozen=True, slots=True)
class Load:
    """The load on the sheet: lengths in m, angles in rad.

    `hang` is how far a sheet with weight hangs below its plane before it is touched: from there on it is pressed.
    """

    indenter: Indenter | Several
    stretch: float
    depth: float
    at: tuple[float, float]
    tilt: tuple[float, float]
    hang: float = 0.0

    @property
    def travel(self) -> float:
        """How far the indenter is past where it first touches, m."""
        return self.depth + self.hang

    def part(self, share: float) -> Load:
        """Return the same load with a share of its travel."""
        return replace(self, depth=share * self.travel - self.hang)

    def moves(self) -> Array:
        """Return the numbers (6,) float that vary along a path of presses."""
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
    """The start of the next press: the control points before this one and the change since, and the offsets.

    Where they act, Mullins softening adds the largest energy seen, and friction the memory of each body.
    """

    offsets: tuple[float, ...]
    previous: Array | None = None
    previous_offsets: tuple[float, ...] | None = None
    change: Array | None = None
    drift: float = 0.0
    peak: Array | None = None
    frictions: tuple[FrictionMemory, ...] = ()


@dataclass(frozen=True, slots=True)
class SheetPress:
    """One equilibrium of the sheet; SI units, membrane frame.

    `force` (3,) acts from the indenter on the sheet, friction included, `reaction` (3,) from the sheet on the clamps;
    `balance` is how far the two are from cancelling, over the force. `force_error` is the standard deviation of force[2], N,
    by the mesh, and `side_error` the one of force[0] and of force[1].
    `residual` is the largest nodal force left over, over the force. `pivot` is the sign of the smallest pivot of the
    tangent without friction, of this shape where it is exact or corrected and else of one a step before: +1 for a stable
    equilibrium. `nodes` counts the quadrature points in contact. `seconds` is the CPU time of the solve.
    """

    sheet: Sheet
    load: Load
    settings: Settings
    force: Array
    force_error: float
    side_error: float
    reaction: Array
    balance: float
    shape: Shape
    contacts: tuple[ContactPenalty, ...]
    nodes: int
    energy: float
    residual: float
    pivot: int
    iterations: int
    factors: int
    seconds: float
    warnings: tuple[str, ...]
    memory: Memory

    @property
    def friction(self) -> Array:
        """The part (3,) of the force that friction carries, N; 0 where there is none."""
        pulls = [g.force(c.body) for g, c in zip(self.memory.frictions, self.contacts, strict=False)]
        return np.asarray(np.sum([np.zeros(3), *pulls], axis=0) * self.sheet.force_unit)

    def points_outside(self, columns: int, rows: int) -> Array:
        """Return (rows, columns, 3) float, m, membrane frame: the shape's points, those below the top of a body raised onto it.

        The sheet is held off a body at its quadrature points; between them it may pass through, under an edge by tenths of a millimetre.
        Points inside a steep side stay where they are.
        """
        points = np.ascontiguousarray(self.shape.points(columns, rows))
        for contact in self.contacts:
            part = points[_slices_near(self.shape, contact, columns, rows)]
            part[..., 2] += _below(contact.body, part.reshape(-1, 3)).reshape(part.shape[:2])
        return points

    def let_go(self) -> SheetPress:
        """Return the press as the sheet remembers it once nothing touches: its softening, not how it slid."""
        return replace(self, memory=replace(self.memory, frictions=())) if self.memory.frictions else self

    def region(self) -> Region:
        """Return where the sheet touches, all bodies together."""
        parts = [_touched(self.shape, contact) for contact in self.contacts]
        return Region(*(np.concatenate(fields) for fields in zip(*parts, strict=True)))

    def touches(self, points: Array) -> npt.NDArray[np.bool_]:
        """Return which of the points (n, 3), m, membrane frame, of the shape as it was solved are in contact."""
        touching = np.zeros(len(points), dtype=np.bool_)
        for contact in self.contacts:
            penetration = contact.offset - contact.body.gap(np.ascontiguousarray(points)).distance / self.shape.unit
            _, _, sunk, area = _near(self.shape, contact)
            touching |= penetration > _least(contact, sunk, area)
        return touching


def _slices_near(shape: Shape, contact: ContactPenalty, columns: int, rows: int) -> tuple[slice, slice]:
    """Return which rows and columns of a shape's points lie over elements that may come into a body."""
    elements = near(shape.mesh, contact.body, shape.control, shape.unit, 0.0)
    ey, ex = np.divmod(elements, shape.mesh.x.elements)
    return _slice_over(shape.mesh.y, ey, rows), _slice_over(shape.mesh.x, ex, columns)


def _slice_over(axis: Axis, elements: npt.NDArray[np.int64], count: int) -> slice:
    """Return which of so many even places along an axis lie between the first and the last of some elements."""
    if not elements.size:
        return slice(0, 0)
    places = np.linspace(axis.breaks[0], axis.breaks[-1], count)
    ends = axis.breaks[elements.min()], axis.breaks[elements.max() + 1]
    return slice(int(np.searchsorted(places, ends[0])), int(np.searchsorted(places, ends[1], side="right")))


def _below(body: Placed, points: Array) -> Array:
    """Return how far below the top of a body points (n, 3) lie, m: 0 outside it and in its steep sides.

    The surface is no nearer above a point than its distance, so that steps of that length never pass it.
    """
    gap, below = body.gap(points), np.zeros(len(points))
    inside = np.flatnonzero((gap.distance < 0.0) & (gap.normal[:, 2] > _STEEP))
    raised = points[inside]
    for _ in range(_STEPS if inside.size else 0):
        raised[:, 2] -= np.minimum(body.gap(raised).distance, 0.0)
    below[inside] = raised[:, 2] - points[inside, 2]
    return below


def _touched(shape: Shape, contact: ContactPenalty) -> tuple[Array, Array, Array]:
    """Return points, deformed areas and areas seen along z of the quadrature points in contact with a body."""
    points, normal, sunk, area = _near(shape, contact)
    touches, body = sunk > _least(contact, sunk, area), contact.body
    return points[touches] @ body.rotation.T + body.origin, area[touches], np.abs(normal[touches, 2])


def _near(shape: Shape, contact: ContactPenalty) -> tuple[Array, Array, Array, Array]:
    """Return points as the body sees them, area vectors, penetration in gauges and areas of the quadrature points near it."""
    (tx, ty), body, unit = shape.mesh.touch, contact.body, shape.unit
    elements = near(shape.mesh, body, shape.control, unit, contact.offset * (1 + _FLAT))
    points = seen(shape.mesh, body, shape.control, unit, elements)
    along_x, along_y = np.empty(points.shape), np.empty(points.shape)
    contact_kernel.tangents(shape.control, elements, tx.value, tx.slope, ty.value, ty.slope, along_x, along_y)
    ey, ex = np.divmod(elements, shape.mesh.x.elements)
    weight = (ty.weight[ey][:, :, None] * tx.weight[ex][:, None, :]).reshape(-1, 1) * unit**2
    normal = np.cross(along_x, along_y) * weight
    sunk = contact.offset - body.indenter.gap(points).distance / unit
    return points, normal, sunk, np.linalg.norm(normal, axis=1)


def _least(contact: ContactPenalty, sunk: Array, area: Array) -> float:
    """Return the penetration, out of those at points that stand for an area, from which on the sheet touches.

    A round body carries tension T times its curvature right up to the edge; on the soft contact this settles as
    1 - exp(-s/sqrt(T/stiffness)), s from where the pressure ends, and the straight piece of sheet outside belongs to a
    rigid contact that ends at s = sqrt(T/stiffness).
    """
    body, pressed = contact.body.indenter, np.maximum(sunk, 0.0) * area
    tip = (1 - np.exp(-1)) * (pressed @ sunk) / max(pressed.sum(), 1e-300)
    return float(tip + flatness(body.flat, body.feature) * (-_FLAT * contact.offset - tip))
