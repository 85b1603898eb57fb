"""How far a body stands out of the sheet that should lie on it."""

from __future__ import annotations

import numpy as np

from stretch_bt.simulation.membrane.indenters.placed import Placed
from stretch_bt.simulation.membrane.sheet.problem import Problem, around, seen
from stretch_bt.simulation.membrane.sheet.spline import Array

__all__ = ["overhang"]

_NEAREST = 4  # elements whose Gauss points are looked at
_SHARES = np.array([0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.14, 0.2, 0.3, 0.5, 1.0])


def overhang(problem: Problem, control: Array, depth: float) -> float:
    """Return how far a body's peak stands above the sheet with control points (ny, nx, 3), over the depth, sheet units.

    Soft contact leaves next to nothing. Under a sharp tip, or one smaller than an element, the sheet slides down the flanks
    without any sign of it in the balance of forces.
    """
    reach = depth * problem.unit
    return max([0.0, *(_above(problem, contact.body, control, reach) for contact in problem.contacts)])


def _above(problem: Problem, body: Placed, control: Array, depth: float) -> float:
    """Return how far a body goes on straight above the place of the sheet next to its peak, over the depth, m."""
    up = body.rotation[2]
    centres, radii = around(problem.mesh, body, control, problem.unit)
    away = _aside(centres, body, up)
    away[body.indenter.gap(centres).distance >= radii] = np.inf
    next_to = np.argsort(away)[:_NEAREST]
    points = seen(problem.mesh, body, control, problem.unit, next_to)
    foot = points[np.argmin(_aside(points, body, up))]
    inside = body.indenter.gap(foot + depth * _SHARES[:, None] * up).distance < 0
    return float(_SHARES[inside].max(initial=0.0))


def _aside(points: Array, body: Placed, up: Array) -> Array:
    """Return the squared distances (n,) of points (n, 3), as a body sees them, from the straight line up through its peak."""
    away = points - [*body.indenter.peak, 0.0]
    return np.asarray((away * away).sum(axis=1) - (away @ up) ** 2)
