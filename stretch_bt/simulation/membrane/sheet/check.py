"""Measures a solved press and refuses one that is not an equilibrium worth the name."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from stretch_bt.errors import Impossible, NoEquilibrium
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.height_field import HeightField
from stretch_bt.simulation.membrane.indenters.placed import Placed
from stretch_bt.simulation.membrane.sheet.error_law import side_error
from stretch_bt.simulation.membrane.sheet.layout import Layout
from stretch_bt.simulation.membrane.sheet.mesh import Mesh
from stretch_bt.simulation.membrane.sheet.newton import Minimum, Newton
from stretch_bt.simulation.membrane.sheet.overhang import overhang
from stretch_bt.simulation.membrane.sheet.problem import Evaluation, Problem, near
from stretch_bt.simulation.membrane.sheet.reach import MeshTooCoarse
from stretch_bt.simulation.membrane.sheet.result import Memory, Shape, SheetPress
from stretch_bt.simulation.membrane.sheet.rigid import RigidForce, rigid_energy
from stretch_bt.simulation.membrane.sheet.spline import Array

__all__ = ["OUT_OF_REACH", "check", "check_reach", "measure"]

OUT_OF_REACH = "the indenter does not reach the flat sheet, which rests as it is"

_WRAPPED = 0.02  # share of the pressure on flanks that look away from the sheet
_PIERCED = 0.15  # height of a body's peak over the sheet, over the depth
_CREEPING = 1e-3  # largest nodal force left, over the force
_ON_BORDER = 0.05  # share of the pressure next to the sharp edge in which a height field ends
_SUNK = 0.1  # mean penetration over the radius of the body's tip, or over a third of the depth if that is more


def measure(
    layout: Layout, newton: Newton, outcome: Minimum, more: RigidForce, memory: Memory, *, settles: bool
) -> SheetPress:
    """Return the result of an outcome in SI units, with the figures that its checks look at.

    `more` is the force that rigid bodies would add; `settles` says whether the contact no longer changes.
    """
    sheet, problem, here = layout.sheet, newton.problem, outcome.evaluation
    pierced = overhang(problem, outcome.control, layout.depth)
    if pierced > _PIERCED:
        raise NoEquilibrium(
            f"the indenter stands out of the sheet by {pierced * 100:.0f} % of the depth: use a finer mesh"
        )
    scale, force, inner = sheet.force_unit, here.force + more.added, here.gradient[1:-1]
    strength, nodes = float(np.linalg.norm(force)) or 1.0, int(here.totals[:, 5].sum())
    error, side = _errors(layout, nodes, force, more, pierced)
    return SheetPress(
        sheet=sheet,
        load=layout.load,
        settings=layout.settings,
        force=force * scale,
        force_error=error * scale,
        side_error=side * scale,
        reaction=(here.reaction - more.added) * scale,
        balance=float(np.linalg.norm(inner.sum(axis=(0, 1)))) / strength,
        shape=Shape(problem.mesh, outcome.control, sheet.unit),
        contacts=tuple(problem.contacts),
        nodes=nodes,
        energy=rigid_energy(problem, outcome) * scale * sheet.unit,
        residual=float(np.abs(inner).max()) / strength,
        pivot=1 if newton.positive else -1,
        iterations=0,
        factors=0,
        seconds=0.0,
        warnings=tuple(_warnings(problem, here, positive=newton.positive, settles=settles)),
        memory=memory,
    )


def _errors(layout: Layout, nodes: int, force: Array, more: RigidForce, pierced: float) -> tuple[float, float]:
    """Return the estimated errors of a force (3,) along z and of either part across, in units of the problem."""
    along, added = abs(float(force[2])) or 1.0, np.abs(more.added)
    across = float(np.hypot(added[0], added[1])) / along
    sideways = float(np.hypot(force[0], force[1])) / along
    relative = layout.error(nodes, float(added[2]) / along, across, sideways, pierced)
    side = side_error(
        relative,
        sideways,
        (across, float(added[2]) / along),
        face=layout.face,
        tilted=layout.load.tilt != (0.0, 0.0),
        overhang=pierced,
    )
    error = math.hypot(relative * along, float(more.withheld[2]))
    return error, math.hypot(side * along, *more.withheld[:2].tolist())


def _warnings(problem: Problem, here: Evaluation, *, positive: bool, settles: bool) -> Iterator[str]:
    """Yield the warnings that a user of the result should know."""
    finest = problem.mesh.finest
    if math.sqrt(float(here.totals[:, 4].sum()) / math.pi) < finest:
        yield f"the contact is smaller than an element of {finest * problem.unit * 1e3:.3g} mm: use a finer mesh"
    if not positive:
        yield "the tangent is not positive: a slack part of the sheet would wrinkle or fold"
    if not settles:
        yield "the contact has not settled: its penetration, or the limits of friction, still change from solve to solve"
    if np.abs(here.gradient[1:-1]).max() > _CREEPING * np.linalg.norm(here.force):
        yield "a slack part of the sheet still creeps, which hardly changes the force"
    rows = zip(problem.contacts, here.totals, strict=True)
    if any(_is_post(c.body.indenter) and t[6] > _WRAPPED * t[3] for c, t in rows):
        yield "the sheet also presses on the sides of the indenter"


def check(result: SheetPress, problem: Problem, outcome: Minimum) -> None:
    """Raise NoEquilibrium where a converged state is no answer."""
    totals = outcome.evaluation.totals
    if not (np.isfinite(result.force).all() and np.isfinite(outcome.control).all()):
        raise NoEquilibrium("the solution is not finite")
    if not result.force[2] > 0:
        raise NoEquilibrium(
            "the sheet is not in contact although it was pressed: it slid off beside the indenter, or the press is too "
            "shallow to be distinguished from rounding"
        )
    _check_borders(problem, outcome)
    for contact, row in zip(problem.contacts, totals, strict=True):
        if not _is_post(contact.body.indenter) and row[6] > _WRAPPED * row[3]:
            raise NoEquilibrium("the sheet wraps around the indenter past its widest place (limit point)")
        sunk = row[3] / max(row[4], 1e-300) / contact.stiffness
        if sunk * result.sheet.unit > _SUNK * max(contact.body.indenter.tip_radius, 0.3 * result.load.travel):
            finest = problem.mesh.finest * problem.unit * 1e3
            raise MeshTooCoarse(
                f"the indenter sinks through the sheet between elements of {finest:.2g} mm, which are too coarse for it: "
                f"use a finer mesh, such as one of {finest / 2:.2g} mm"
            )


def _is_post(body: Indenter) -> bool:
    """Return whether the sides of a body are its own; others stand on a shank that only holds them."""
    return bool(getattr(body, "post", body.flat > 0))


def _check_borders(problem: Problem, outcome: Minimum) -> None:
    """Raise NoEquilibrium where the sheet rests on the border of a height field."""
    for contact in problem.contacts:
        body = contact.body.indenter
        if isinstance(body, HeightField):
            points, pressure = problem.pressures(contact, outcome.control)
            border = body.at_border(points, problem.mesh.finest * problem.unit / 3)
            if pressure[border].sum() > _ON_BORDER * pressure.sum():
                raise NoEquilibrium(
                    "the sheet rests on the border of the height field, beyond which no heights are known: let the grid "
                    "reach to where nothing touches"
                )


def check_reach(mesh: Mesh, bodies: Sequence[Placed], flat: Array, unit: float) -> None:
    """Raise Impossible where no body comes near the flat sheet with control points (ny, nx, 3).

    A body of finite thickness may have risen past it.
    """
    if not any(math.isfinite(b.indenter.bulk) or len(near(mesh, b, flat, unit, 0.0)) for b in bodies):
        raise Impossible(OUT_OF_REACH)
