"""Coulomb friction between the sheet and a body, and its memory from one press to the next.

A point in contact sticks to an anchor on the body by a spring; where that would pull harder than mu times the
pressure the point slides, and the anchor with it (the return map of Laursen and Simo 1993). During a solve the pressure is taken
from the solve before, so that the tractions are the gradient of an energy; solves are repeated until it settles.
A point that comes into contact has no anchor yet: it is pulled as its neighbours are that were in contact before.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.membrane.indenters.placed import Placed
from stretch_bt.simulation.membrane.sheet import friction_kernel
from stretch_bt.simulation.membrane.sheet.elastic_kernel import GRADIENT
from stretch_bt.simulation.membrane.sheet.mesh import Mesh
from stretch_bt.simulation.membrane.sheet.spline import Array

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.sheet.problem import ContactPenalty

__all__ = ["FrictionMemory", "LaggedFriction", "remember"]

Mask = npt.NDArray[np.bool_]
_STIFF = 4.0  # stiffness of the springs over the contact's: stiffer ones change a force by 0.2 %, and cost more steps
_REACH = 12  # Gauss points; further from the contact before, a point begins without traction


@dataclass(frozen=True, slots=True)
class FrictionMemory:
    """Pressure (NY, NX) and frictional traction on the sheet (NY, NX, 3) at all Gauss points, in the body's frame.

    Both are per unstretched area, over shear modulus x thickness / sheet unit; `weight` (NY, NX) is the area of each.
    """

    pressure: Array
    traction: Array
    weight: Array

    def force(self, body: Placed) -> Array:
        """Return the frictional force (3,) on the sheet in the membrane frame."""
        return np.asarray(body.rotation @ np.einsum("yx,yxc->c", self.weight, self.traction))

    def on(self, old: Mesh, new: Mesh) -> FrictionMemory:
        """Return the memory at the Gauss points of another mesh, each taking after the nearest old one."""
        if old is new:
            return self
        rows, columns = _nearest(*_places(old)[::-1], *_places(new)[::-1])
        picked = np.ix_(rows, columns)
        return FrictionMemory(self.pressure[picked], np.ascontiguousarray(self.traction[picked]), _weights(new))


@dataclass(frozen=True, slots=True)
class LaggedFriction:
    """Friction during one solve: anchors and normals (NY, NX, 3) and the limit of the traction (NY, NX); sheet units.

    Points whose limit is 0 are free. `held` says which have an anchor at all.
    """

    coefficient: float
    stiffness: float
    anchor: Array
    normal: Array
    limit: Array
    held: Mask
    elements: npt.NDArray[np.int64]

    @classmethod
    def after(
        cls,
        memory: FrictionMemory,
        places: Array,
        old: Placed,
        contact: ContactPenalty,
        coefficient: float,
        unit: float,
    ) -> LaggedFriction:
        """Return friction that goes on from a memory at `places` (NY, NX, 3), sheet units, on the body where it was.

        A ball of another size is taken for the same below its highest point.
        """
        held, limit = memory.pressure > 0, coefficient * memory.pressure
        stiffness = _STIFF * contact.stiffness
        local = (places * unit - old.origin) @ old.rotation + memory.traction * (unit / stiffness)
        anchor = local @ contact.body.rotation.T + contact.body.origin
        if contact.body.indenter != old.indenter:
            anchor[..., 2] += contact.body.rise - old.rise
        normal = _normals(contact.body, anchor, held)
        return cls(coefficient, stiffness, anchor / unit, normal, limit, held, _elements(limit))

    def add(self, control: Array, mesh: Mesh, mode: int, gradient: Array, band: Array, row: Array) -> float:
        """Add gradient, Hessian and force at control points; return the energy."""
        x, y = mesh.touch
        return float(
            friction_kernel.friction(
                self.elements, control, self.anchor, self.normal, self.limit, self.stiffness,
                x.value, x.weight, y.value, y.weight, mode, gradient, band, row,
            )
        )  # fmt: skip

    def energy(self, control: Array, mesh: Mesh) -> float:
        """Return the work done against friction since the last press, with the energy in its springs."""
        return self.add(control, mesh, GRADIENT, np.zeros(control.shape), np.empty((0, 0)), np.zeros(8))

    def renewed(self, control: Array, mesh: Mesh, contact: ContactPenalty, unit: float) -> tuple[LaggedFriction, float]:
        """Return it with the pressure and normals of a solved shape, and how much the limits changed as a whole."""
        places = _surface(control, mesh)
        pressure, normal = _pressure(places, contact, unit)
        limit = self.coefficient * pressure
        share = _shares(self.tractions(places), self.limit, self.held & (self.limit > 0), limit > 0)
        anchor = np.where(self.held[..., None], self.anchor, places + share * limit[..., None] / self.stiffness)
        weight = _weights(mesh)
        change = float(np.sum(weight * np.abs(limit - self.limit)))
        most = float(np.sum(weight * limit)) or 1.0
        new = replace(self, anchor=anchor, normal=normal, limit=limit, elements=_elements(limit))
        return new, change / most

    def tractions(self, places: Array) -> Array:
        """Return the traction (NY, NX, 3) on the sheet at places (NY, NX, 3)."""
        out = np.zeros(places.shape)
        friction_kernel.tractions(places, self.anchor, self.normal, self.limit, self.stiffness, out)
        return out


def remember(control: Array, mesh: Mesh, contact: ContactPenalty, unit: float) -> FrictionMemory:
    """Return the memory of a solved shape for the next press."""
    places = _surface(control, mesh)
    pressure, _ = _pressure(places, contact, unit)
    traction = np.zeros(places.shape) if contact.friction is None else contact.friction.tractions(places)
    return FrictionMemory(pressure, traction @ contact.body.rotation, _weights(mesh))


def _shares(traction: Array, limit: Array, known: Mask, wanted: Mask) -> Array:
    """Return traction over limit (NY, NX, 3) where known, and step by step the known neighbours' where wanted."""
    share, known = np.where(known[..., None], traction / np.where(known, limit, 1.0)[..., None], 0.0), known.copy()
    for _ in range(_REACH):
        if np.all(known | ~wanted):
            break
        count = _around(known.astype(float)[..., None])
        near = ~known & (count[..., 0] > 0)
        share[near] = (_around(share)[near]) / count[near]
        known |= near
    return share


def _around(field: Array) -> Array:
    """Return the sum (NY, NX, c) over each point and its eight neighbours."""
    rows, columns, _ = field.shape
    padded = np.pad(field, ((1, 1), (1, 1), (0, 0)))
    return np.asarray(sum(padded[j : j + rows, i : i + columns] for j in range(3) for i in range(3)))


def _pressure(places: Array, contact: ContactPenalty, unit: float) -> tuple[Array, Array]:
    """Return pressure (NY, NX) and outward normal (NY, NX, 3) at the places of all Gauss points."""
    gap = contact.body.gap(np.ascontiguousarray(places.reshape(-1, 3) * unit))
    depth = contact.offset - gap.distance.reshape(places.shape[:2]) / unit
    return contact.stiffness * np.maximum(depth, 0.0), np.ascontiguousarray(gap.normal.reshape(places.shape))


def _normals(body: Placed, anchor: Array, held: Mask) -> Array:
    normal = np.zeros(anchor.shape)
    normal[held] = body.gap(np.ascontiguousarray(anchor[held])).normal
    return normal


def _elements(limit: Array) -> npt.NDArray[np.int64]:
    """Return the elements in which any point may carry traction."""
    rows, columns = limit.shape
    any_there = (limit.reshape(rows // 4, 4, columns // 4, 4) > 0).any(axis=(1, 3))
    return np.flatnonzero(any_there)


def _places(mesh: Mesh) -> tuple[Array, Array]:
    """Return the places (NX,) and (NY,) of the Gauss points on the unstretched sheet."""
    x, y = mesh.touch
    return x.place.ravel(), y.place.ravel()


def _surface(control: Array, mesh: Mesh) -> Array:
    """Return the places (NY, NX, 3) of all Gauss points."""
    return np.ascontiguousarray(mesh.evaluate(control, *_places(mesh)))


def _weights(mesh: Mesh) -> Array:
    x, y = mesh.touch
    return np.outer(y.weight.ravel(), x.weight.ravel())


def _nearest(old_y: Array, old_x: Array, new_y: Array, new_x: Array) -> tuple[npt.NDArray[np.intp], ...]:
    pairs = ((old_y, new_y), (old_x, new_x))
    return tuple(np.searchsorted((old[1:] + old[:-1]) / 2, new) for old, new in pairs)
