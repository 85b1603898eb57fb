"""The equations of one press: energy, gradient and Hessian of a sheet against placed bodies."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.membrane.indenters.base import Gap
from stretch_bt.simulation.membrane.indenters.placed import Placed
from stretch_bt.simulation.membrane.sheet import contact_kernel, elastic_kernel
from stretch_bt.simulation.membrane.sheet.bending import BendingMatrices
from stretch_bt.simulation.membrane.sheet.elastic_kernel import EXACT, GRADIENT, PROJECTED
from stretch_bt.simulation.membrane.sheet.mesh import Mesh
from stretch_bt.simulation.membrane.sheet.spline import Array

if TYPE_CHECKING:  # its kernels are compiled when a press has friction
    from stretch_bt.simulation.membrane.sheet.friction import LaggedFriction

__all__ = ["EXACT", "GRADIENT", "PROJECTED", "ContactPenalty", "Evaluation", "Problem", "around", "near", "seen"]

_LARGEST_STEP = 8.0
_NO_BAND = np.empty((0, 0))
_NO_PEAK = np.empty((0, 0, 0, 0))
_FREE = np.zeros(3)


@dataclass(slots=True)
class ContactPenalty:
    """A body with the stiffness of its contact and the offset that makes up for the mean penetration; sheet units.

    `friction` is None where it has none.
    """

    body: Placed
    stiffness: float
    offset: float = 0.0
    friction: LaggedFriction | None = None


@dataclass(slots=True)
class Evaluation:
    """Energy and gradient at some control points; per body: force (3,), pressure integral, area,
    points, the pressure integral on flanks that face away, and the energy of the penalty.

    `sides` (3,) is the force on the first and last column of control points where these are clamped.
    """

    energy: float
    gradient: Array
    totals: Array
    sides: Array

    @property
    def force(self) -> Array:
        """Force (3,) of all bodies on the sheet."""
        return np.asarray(self.totals[:, :3].sum(axis=0))

    @property
    def reaction(self) -> Array:
        """Force (3,) of the sheet on its clamps."""
        return np.asarray(self.gradient[0].sum(axis=0) + self.gradient[-1].sum(axis=0) + self.sides)


@dataclass(slots=True)
class Problem:
    """A mesh, a material law and the bodies; all in the sheet's unit of length, which is `unit` metres."""

    mesh: Mesh
    law: Array
    contacts: list[ContactPenalty]
    unit: float
    peak: Array = field(default_factory=lambda: _NO_PEAK)
    flat: bool = False
    weight: float = 0.0
    bending: BendingMatrices | None = None

    @property
    def unknowns(self) -> int:
        """How many unknowns there are: three for each control point that is not clamped."""
        ny, nx, _ = self.mesh.shape
        return 3 * nx * (ny - 2)

    @property
    def largest_step(self) -> float:
        """How far a control point may move at once: not through a thin body."""
        return min([_LARGEST_STEP, *(c.body.indenter.bulk / self.unit / 4 for c in self.contacts)])

    def bands(self) -> list[Array]:
        """Return two bands (n, half-bandwidth + 1) for Hessians, so that a factor outlives the next one."""
        width = 3 * (2 * self.mesh.shape[1] + 2) + 3
        return [np.empty((self.unknowns, width)) for _ in range(2)]

    def evaluate(self, control: Array, mode: int, band: Array | None = None) -> Evaluation:
        """Return energy and gradient at control points (ny, nx, 3); a Hessian is added to band (n, width)."""
        band = _NO_BAND if band is None else band
        x, y = self.mesh.strain
        gradient = np.zeros(self.mesh.shape)
        energy = elastic_kernel.elastic(
            control, x.value, x.slope, x.weight, y.value, y.slope, y.weight, self.mesh.inverse, self.law, self.peak,
            mode, gradient, band,
        )  # fmt: skip
        totals = np.zeros((len(self.contacts), 8))
        if np.isfinite(energy):
            for contact, row in zip(self.contacts, totals, strict=True):
                energy += self._touch(contact, control, mode, gradient, band, row)
                if contact.friction is not None:
                    energy += contact.friction.add(control, self.mesh, mode, gradient, band, row)
            energy += self._other(control, mode, gradient, band)
        if self.flat:
            self._hold_flat(gradient, band, mode)
        sides = self._hold_sides(gradient, band, mode) if self.mesh.held else _FREE
        return Evaluation(energy, gradient, totals, sides)

    def _touch(
        self, contact: ContactPenalty, control: Array, mode: int, gradient: Array, band: Array, row: Array
    ) -> float:
        elements, gap = self._gaps(contact, control)
        x, y = self.mesh.touch
        return float(
            contact_kernel.contact(
                elements, *gap, self.unit, contact.offset, contact.stiffness,
                x.value, x.weight, y.value, y.weight, self.mesh.spread, mode, gradient, band, row,
            )
        )  # fmt: skip

    def leftover(self, control: Array) -> tuple[Array, Array]:
        """Return the nodal forces (ny, nx, 3) of stiffness times the penetration that is left over, and the change of the
        contacts' nodal forces (3, ny, nx, 3) as the bodies move along x, y and z.
        """
        excess, lift = np.zeros(self.mesh.shape), np.zeros((3, *self.mesh.shape))
        x, y = self.mesh.touch
        for contact in self.contacts:
            elements, gap = self._gaps(contact, control)
            contact_kernel.leftover(
                elements, *gap, self.unit, contact.offset, contact.stiffness,
                x.value, x.weight, y.value, y.weight, self.mesh.spread, excess, lift,
            )  # fmt: skip
        return excess, lift

    def pressures(self, contact: ContactPenalty, control: Array) -> tuple[Array, Array]:
        """Return the Gauss points (n, 3), m, near a body as it sees them, and the pressure (n,) at each times its area."""
        elements, gap = self._gaps(contact, control)
        x, y = self.mesh.touch
        row, column = np.divmod(elements, self.mesh.x.elements)
        area = (y.weight[row][:, :, None] * x.weight[column][:, None, :]).reshape(-1)
        sunk = np.maximum(contact.offset - gap.distance / self.unit, 0.0)
        return seen(self.mesh, contact.body, control, self.unit, elements), contact.stiffness * sunk * area

    def _gaps(self, contact: ContactPenalty, control: Array) -> tuple[npt.NDArray[np.int64], Gap]:
        """Return the elements that may touch at a Gauss point, and the gaps at their points, or lower bounds of the gaps.

        The distance changes by no more than a point moves: the distance at an element's middle control point rules most of its points out.
        """
        body = contact.body
        elements, centres, distances = _reachable(self.mesh, body, control, self.unit, contact.offset)
        x, y = self.mesh.touch
        each = x.value.shape[1] * y.value.shape[1]
        most = elements.size * each
        points, places, least = np.empty((most, 3)), np.empty(most, dtype=np.int64), np.empty(most)
        close, reached = contact_kernel.within_reach(
            control, elements, centres, distances, x.value, y.value, self.unit, contact.offset * self.unit,
            body.origin, body.rotation, points, places, least,
        )  # fmt: skip
        count = close * each
        gap = Gap(least[:count], np.zeros((count, 3)), np.zeros((count, 6)))
        for whole, known in zip(gap, body.gap_seen(points[:reached]), strict=True):
            whole[places[:reached]] = known
        return elements[:close], gap

    def _other(self, control: Array, mode: int, gradient: Array, band: Array) -> float:
        """Add weight and bending, where they act; return their energy."""
        energy = 0.0
        if self.weight:
            pull = self.weight * self.mesh.areas
            gradient[..., 2] += pull
            energy += float(np.vdot(pull, control[..., 2]))
        if self.bending is not None:
            forces = self.bending.gradient(control)
            gradient += forces
            energy += float(np.vdot(forces, control)) / 2
            if mode != GRADIENT:
                self.bending.add(band)
        return energy

    def raised_peak(self, control: Array) -> Array:
        """Return the largest energy seen at each Gauss point, this shape included."""
        x, y = self.mesh.strain
        peak = self.peak.copy()
        elastic_kernel.peaks(control, x.value, x.slope, y.value, y.slope, self.mesh.inverse, self.law, peak)
        return peak

    def _hold_flat(self, gradient: Array, band: Array, mode: int) -> None:
        """Take z out of the equations: in the plane it is coupled to nothing, so a push-free z stays where it is."""
        gradient[..., 2] = 0.0
        if mode != GRADIENT:
            band[2::3, 0] += 10.0

    def _hold_sides(self, gradient: Array, band: Array, mode: int) -> Array:
        """Take the first and last column of control points out of the equations; return the force on them."""
        sides = gradient[1:-1, [0, -1]].sum(axis=(0, 1))
        gradient[1:-1, [0, -1]] = 0.0
        if mode != GRADIENT:
            ny, nx, _ = self.mesh.shape
            width, flat = band.shape[1], band.reshape(-1)
            for k in np.arange(self.unknowns).reshape(ny - 2, nx, 3)[:, [0, -1]].ravel().tolist():
                # row k of the lower band lies along a falling diagonal of its storage
                flat[k * width - min(width - 1, k) * (width - 1) : k * width + 1 : width - 1] = 0.0
                band[k] = 0.0
                band[k, 0] = 1.0
        return np.asarray(sides)


def around(mesh: Mesh, body: Placed, control: Array, unit: float) -> tuple[Array, Array]:
    """Return a ball around each element as a body sees it: centres (n, 3) and radii (n,), m."""
    count = mesh.x.elements * mesh.y.elements
    centres, radii = np.empty((count, 3)), np.empty(count)
    contact_kernel.bounds(control, unit, body.origin, body.rotation, centres, radii)
    return centres, radii


def near(mesh: Mesh, body: Placed, control: Array, unit: float, reach: float) -> npt.NDArray[np.int64]:
    """Return the elements that may come within `reach` of a body: the distance changes by no more than a point moves."""
    return _reachable(mesh, body, control, unit, reach)[0]


def _reachable(
    mesh: Mesh, body: Placed, control: Array, unit: float, reach: float
) -> tuple[npt.NDArray[np.int64], Array, Array]:
    """Return the same, with the middles (n, 3) of all elements as the body sees them, and how far these are from it (n,), m."""
    centres, radii = around(mesh, body, control, unit)
    distances = body.indenter.gap(centres).distance
    return np.nonzero(distances < radii + reach * unit)[0], centres, distances


def seen(mesh: Mesh, body: Placed, control: Array, unit: float, elements: npt.NDArray[np.int64]) -> Array:
    """Return the Gauss points (n, 3), m, of some elements as a body sees them."""
    x, y = mesh.touch
    points = np.empty((len(elements) * x.value.shape[1] * y.value.shape[1], 3))
    contact_kernel.gauss_points(control, elements, x.value, y.value, unit, body.origin, body.rotation, points)
    return points
