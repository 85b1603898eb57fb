"""The force of a press on a rigid body, from a press on soft contact.

With the pressure p of the soft contact and the gap g that it leaves, the value of the dual problem, W - integral p g, is the
energy of rigid contact but for the square of the residual (weak duality: Boyd and Vandenberghe, Convex Optimization,
2004, section 5.2). Its derivative by the place of the body is the force, to the same order.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stretch_bt.simulation.membrane.sheet.newton import Minimum, Newton
from stretch_bt.simulation.membrane.sheet.problem import Problem
from stretch_bt.simulation.membrane.sheet.spline import Array

__all__ = ["RigidForce", "rigid_energy", "rigid_force"]

_FIRST_ORDER = (
    0.2  # part of the force up to which a change is small; it is more where a sheet hardly resists to slide off a wire
)
_NOTHING = np.zeros(3)


class RigidForce(NamedTuple):
    """The change of the force by rigid bodies (3,), and the change that is not small and not added (3,), in units of the problem."""

    added: Array
    withheld: Array


def rigid_energy(problem: Problem, outcome: Minimum) -> float:
    """Return the energy that the sheet would have on rigid bodies."""
    totals = outcome.evaluation.totals
    made_up = sum(c.offset * t[3] for c, t in zip(problem.contacts, totals, strict=True))
    return outcome.evaluation.energy + float(totals[:, 7].sum()) - float(made_up)


def rigid_force(newton: Newton, outcome: Minimum) -> RigidForce:
    """Return the change by rigid bodies of the force on the sheet.

    Where it is not small, or the tangent is not positive, it is withheld and counts only as an error.

    As the bodies move by e the sheet follows by K^-1 L e, with the Hessian K and the contact's part L of it, and the
    pressure changes by stiffness x n (e - K^-1 L e); weighted by the penetration left over that is the derivative of
    `rigid_energy` less the force. The Hessian has to belong to the shape: one of a few steps before knows another contact.
    """
    problem = newton.problem
    excess, lift = problem.leftover(outcome.control)
    whole = excess.sum(axis=(0, 1))
    if problem.mesh.held:
        excess[:, [0, -1]] = 0.0
    follow = newton.solve(excess[1:-1])
    more = whole - lift[:, 1:-1].reshape(3, -1) @ follow.ravel()
    small = newton.positive and np.linalg.norm(more) <= _FIRST_ORDER * np.linalg.norm(outcome.evaluation.force)
    return RigidForce(more, _NOTHING) if small else RigidForce(_NOTHING, more)
