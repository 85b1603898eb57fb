"""The sheet while nothing touches it, under its own weight."""

from __future__ import annotations

import numpy as np

from stretch_bt.simulation.membrane.indenters.base import Zone
from stretch_bt.simulation.membrane.sheet.assemble import hanging_problem
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.newton import Newton
from stretch_bt.simulation.membrane.sheet.result import Shape
from stretch_bt.threads import one_thread

__all__ = ["hang", "lowest"]

_ELEMENT = 5.0  # sheet units; the shape is smooth
_FIRST = 0.02  # first guess of a slack sheet's sag over the gauge
_BUDGET = 400


def hang(sheet: Sheet, stretch: float) -> Shape:
    """Return the shape of the sheet at a stretch, m; without weight it is flat.

    Raises
    ------
    NoEquilibrium
        None was found within the budget.
    """
    half = sheet.width / sheet.unit / 2
    zones = [Zone(-half, half, _ELEMENT)], [Zone(-50.0, 50.0, _ELEMENT)]
    mesh = sheet.outline.mesh(2 * half, *zones, 1.5)
    span = sheet.span(stretch)
    guess = sheet.outline.flat(mesh, span)
    x, y = guess[..., 0] / half, guess[..., 1] / (span / 2)
    if sheet.weight > 0:
        guess[..., 2] = -100 * _FIRST * (1 - y * y) * (1 - 0.2 * x * x)
    with one_thread():
        newton = Newton(hanging_problem(sheet, mesh), sheet.outline.clamped(mesh, guess, span))
        found = newton.run(lambda step: step.size < 1e-5 or -step.promise < 1e-12, _BUDGET)
    assert np.isfinite(found.control).all()
    return Shape(mesh, found.control, sheet.unit)


def lowest(sheet: Sheet, stretch: float) -> float:
    """Return the sag of the sheet's middle below its plane at a stretch, m; raises as `hang` does."""
    return -float(hang(sheet, stretch).points(9, 41)[..., 2].min())
