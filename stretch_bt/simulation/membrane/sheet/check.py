"""Measures a solved press and refuses what is not an equilibrium worth the name."""

from __future__ import annotations

import math

import numpy as np

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.newton import Outcome, Tangent
from stretch_bt.simulation.membrane.sheet.problem import Problem
from stretch_bt.simulation.membrane.sheet.result import Load, Memory, Shape, SheetPress
from stretch_bt.simulation.membrane.sheet.rigid import rigid_energy, rigid_force

__all__ = ["check", "measure"]

_WRAPPED = 0.02  # share of the pressure on flanks that look away from the sheet
_SUNK = 0.1  # mean penetration over the radius of the body's tip, or over a third of the depth if that is more


def measure(
    sheet: Sheet, load: Load, problem: Problem, outcome: Outcome, memory: Memory, relative_error: float
) -> SheetPress:
    """Return the result of an outcome in SI units, with the figures that its checks look at."""
    scale, here = sheet.force_unit, outcome.evaluation
    tangent = Tangent(problem, outcome.control)
    more = rigid_force(problem, outcome, tangent)
    force, inner = here.force + more, here.gradient[1:-1]
    strength = float(np.linalg.norm(force)) or 1.0
    radius = math.sqrt(float(here.totals[:, 4].sum()) / math.pi)
    warnings = []
    if radius < problem.mesh.finest:
        warnings.append(
            f"the contact is smaller than an element of {problem.mesh.finest * sheet.unit * 1e3:.3g} mm: use a finer mesh"
        )
    if not tangent.positive:
        warnings.append("the tangent is not positive: a slack part of the sheet would wrinkle or fold")
    if any(
        c.body.indenter.flat > 0 and t[6] > _WRAPPED * t[3] for c, t in zip(problem.contacts, here.totals, strict=True)
    ):
        warnings.append("the sheet also presses on the sides of the indenter")
    return SheetPress(
        sheet=sheet,
        load=load,
        force=force * scale,
        force_error=relative_error * float(force[2]) * scale,
        reaction=(here.reaction - more) * scale,
        balance=float(np.linalg.norm(inner.sum(axis=(0, 1)))) / strength,
        shape=Shape(problem.mesh, outcome.control, sheet.unit),
        contacts=tuple(problem.contacts),
        nodes=int(here.totals[:, 5].sum()),
        energy=rigid_energy(problem, outcome) * scale * sheet.unit,
        residual=float(np.abs(inner).max()) / strength,
        pivot=1 if tangent.positive else -1,
        iterations=0,
        factors=1,
        seconds=0.0,
        warnings=tuple(warnings),
        memory=memory,
    )


def check(result: SheetPress, problem: Problem, outcome: Outcome) -> None:
    """Raise NoEquilibrium where a converged state is no answer."""
    totals = outcome.evaluation.totals
    if not (np.isfinite(result.force).all() and np.isfinite(outcome.control).all()):
        raise NoEquilibrium("the solution is not finite")
    if not result.force[2] > 0:
        raise NoEquilibrium("the sheet is not in contact although it was pressed: it slid off beside the indenter")
    for contact, row in zip(problem.contacts, totals, strict=True):
        if contact.body.indenter.flat == 0 and row[6] > _WRAPPED * row[3]:
            raise NoEquilibrium("the sheet wraps around the indenter past its widest place (limit point)")
        sunk = row[3] / max(row[4], 1e-300) / contact.stiffness
        if sunk * result.sheet.unit > _SUNK * max(contact.body.indenter.tip_radius, 0.3 * result.load.depth):
            raise NoEquilibrium("the indenter sinks through the sheet: the press is past its limit point")
