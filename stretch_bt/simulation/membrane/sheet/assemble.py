"""Puts the equations of a press together: mesh, material, bodies, and the effects that act."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.layout import Layout
from stretch_bt.simulation.membrane.sheet.mesh import Mesh
from stretch_bt.simulation.membrane.sheet.problem import ContactPenalty, Problem
from stretch_bt.simulation.membrane.sheet.result import SheetPress
from stretch_bt.simulation.membrane.sheet.spline import Array

__all__ = ["assemble", "flat_problem", "hanging_problem"]


def flat_problem(layout: Layout, mesh: Mesh) -> Problem:
    """Return the equations of the sheet in its plane, before anything touches it."""
    problem = Problem(mesh, layout.sheet.law(), [], layout.unit, flat=True)
    return _with_effects(problem, layout.sheet, None)


def hanging_problem(sheet: Sheet, mesh: Mesh) -> Problem:
    """Return the equations of a sheet that nothing touches."""
    return _with_effects(Problem(mesh, sheet.law(), [], sheet.unit), sheet, None)


def assemble(layout: Layout, mesh: Mesh, offsets: Sequence[float] = (), past: SheetPress | None = None) -> Problem:
    """Return the equations of a press; `past` is the earlier one that softening and friction remember."""
    contacts = [ContactPenalty(b, k) for b, k in zip(layout.bodies, layout.stiffnesses(), strict=True)]
    for contact, offset in zip(contacts, offsets, strict=False):
        contact.offset = offset
    problem = _with_effects(Problem(mesh, layout.sheet.law(), contacts, layout.unit), layout.sheet, past)
    if layout.sheet.effects.friction and past is not None and past.memory.frictions:
        from stretch_bt.simulation.membrane.sheet import friction_state

        friction_state.resume(problem, past, layout.sheet.effects.friction)
    return problem


def _with_effects(problem: Problem, sheet: Sheet, past: SheetPress | None) -> Problem:
    mesh = problem.mesh
    problem.weight = sheet.weight
    if sheet.effects.bending:
        from stretch_bt.simulation.membrane.sheet.bending import BendingMatrices

        problem.bending = BendingMatrices.of(mesh, (sheet.thickness / sheet.unit) ** 2 / 3)
    if sheet.effects.mullins is not None:
        problem.peak = np.zeros((mesh.y.elements, mesh.x.elements, 2, 2)) if past is None else _peak(past, mesh)
    return problem


def _peak(past: SheetPress, mesh: Mesh) -> Array:
    """Return the largest energy seen at each Gauss point of a mesh, interpolated from an earlier press."""
    old, peak = past.shape.mesh, past.memory.peak
    assert peak is not None
    if old is mesh:
        return peak.copy()
    (ox, oy), (x, y) = old.strain, mesh.strain
    field = peak.transpose(0, 2, 1, 3).reshape(oy.place.size, ox.place.size)
    field = _between(oy.place.ravel(), field, y.place.ravel())
    field = _between(ox.place.ravel(), field.T, x.place.ravel()).T
    return np.ascontiguousarray(field.reshape(*y.place.shape, *x.place.shape).transpose(0, 2, 1, 3))


def _between(old: Array, field: Array, new: Array) -> Array:
    """Return a field (n, m) over places `old` (n,) at places `new`, on straight lines, level beyond the ends."""
    right = np.clip(np.searchsorted(old, new), 1, len(old) - 1)
    share = np.clip((new - old[right - 1]) / (old[right] - old[right - 1]), 0.0, 1.0)[:, None]
    return np.asarray((1 - share) * field[right - 1] + share * field[right])
