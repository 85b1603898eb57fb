"""How far a body stands out of the sheet that should lie on it."""

from __future__ import annotations

import numpy as np

from stretch_bt.simulation.membrane.indenters.placed import Placed
from stretch_bt.simulation.membrane.sheet import contact_kernel
from stretch_bt.simulation.membrane.sheet.problem import Problem, near
from stretch_bt.simulation.membrane.sheet.spline import Array, Axis

__all__ = ["overhang"]

_PROBES = 4  # places along each side of an element, between and unlike its Gauss points
_SHARES = np.array([0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.14, 0.2, 0.3, 0.5, 1.0])


def overhang(problem: Problem, control: Array, depth: float) -> float:
    """Return how far a body's peak stands above the sheet with control points (ny, nx, 3), over the depth, sheet units.

    Soft contact leaves next to nothing. Under a sharp tip, or one smaller than an element, the sheet slides down the flanks
    without any sign of it in the balance of forces.
    """
    most, (vx, vy) = 0.0, (_values(axis) for axis in (problem.mesh.x, problem.mesh.y))
    for contact in problem.contacts:
        body = contact.body
        elements = near(problem.mesh, body, control, problem.unit, 0.0)
        points = np.empty((len(elements) * _PROBES**2, 3))
        contact_kernel.gauss_points(control, elements, vx, vy, problem.unit, body.origin, body.rotation, points)
        if len(points):
            most = max(most, _above(body, points, depth * problem.unit) / depth / problem.unit)
    return most


def _above(body: Placed, points: Array, depth: float) -> float:
    """Return how far a body, m, goes on straight above the point next to its peak, out of points (n, 3) as it sees them."""
    up = body.rotation.T @ [0.0, 0.0, 1.0]
    away = points - [*body.indenter.peak, 0.0]
    away -= np.outer(away @ up, up)
    foot = points[np.argmin((away * away).sum(axis=1))]
    inside = body.indenter.gap(foot + depth * _SHARES[:, None] * up).distance < 0
    return depth * float(_SHARES[inside].max(initial=0.0))


def _values(axis: Axis) -> Array:
    """Return the basis (e, q, 3) at evenly spaced places of each element."""
    shares = (np.arange(_PROBES) + 0.5) / _PROBES
    places = axis.breaks[:-1, None] + np.diff(axis.breaks)[:, None] * shares
    return axis.basis(np.arange(axis.elements)[:, None], places)[0]
