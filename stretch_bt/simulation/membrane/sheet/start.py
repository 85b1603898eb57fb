"""Where Newton begins: flat, a tent over the indenter, or an earlier shape carried over."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stretch_bt.simulation.membrane.indenters.placed import Placed
from stretch_bt.simulation.membrane.sheet.mesh import Mesh
from stretch_bt.simulation.membrane.sheet.spline import Array

__all__ = ["carried", "clamped", "flat_guess", "tent"]

_TENT_WIDTH = 30.0


def clamped(mesh: Mesh, control: Array, span: float) -> Array:
    """Return the control points with their first and last row held straight, `span` apart."""
    held = control.copy()
    for row, side in ((0, -0.5), (-1, 0.5)):
        held[row, :, 0] = mesh.rest[row, :, 0]
        held[row, :, 1] = side * span
        held[row, :, 2] = 0.0
    return held


def flat_guess(mesh: Mesh, span: float) -> Array:
    """Return control points (ny, nx, 3) of a flat sheet that narrows between its clamps roughly as it should."""
    length = float(mesh.y.breaks[-1] - mesh.y.breaks[0])
    stretch = span / length
    away = np.minimum(1.0, (0.5 - np.abs(mesh.rest[..., 1]) / length) * 5)
    control = np.zeros(mesh.shape)
    control[..., 0] = mesh.rest[..., 0] * (1 - 0.55 * (1 - stretch**-0.5) * away)
    control[..., 1] = mesh.rest[..., 1] * stretch
    return clamped(mesh, control, span)


def tent(flat: Array, bodies: Sequence[Placed], span: float, unit: float) -> Array:
    """Return the flat control points raised to a tent over each body, whichever is higher.

    A flat start lets the sheet slide down the shank of a deep indenter and converge beside it without contact.
    """
    raised = flat.copy()
    for body in bodies:
        px, py = (body.origin[:2] / unit).tolist()
        crest_x, crest_y = (half / unit for half in body.indenter.crest(body.rotation))
        dx = np.maximum(np.abs(flat[..., 0] - px) - crest_x, 0.0)
        dy = np.abs(flat[..., 1] - py)
        room = np.where(flat[..., 1] > py, span / 2 - py, span / 2 + py)
        plateau = np.minimum(crest_y, 0.8 * room)
        along = np.maximum(dy - plateau, 0.0) / np.maximum(room - plateau, 1e-3)
        height = body.top / unit * np.maximum(0.0, 1 - np.hypot(dx / _TENT_WIDTH, along))
        raised[..., 2] = np.maximum(raised[..., 2], height)
    return raised


def carried(old: Mesh, control: Array, new: Mesh) -> Array:
    """Return the control points on a new mesh that follow an earlier shape; exact for straight lines."""
    return old.evaluate(control, new.x.greville, new.y.greville)
