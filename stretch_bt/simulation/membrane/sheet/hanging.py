"""The sheet while nothing touches it, under its own weight."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.membrane.indenters.base import Indenter, Zone
from stretch_bt.simulation.membrane.indenters.several import Part, Several
from stretch_bt.simulation.membrane.sheet.assemble import hanging_problem
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.newton import Newton
from stretch_bt.simulation.membrane.sheet.result import Shape
from stretch_bt.threads import one_thread

if TYPE_CHECKING:
    from scipy.interpolate import RegularGridInterpolator

__all__ = ["hang", "lift", "lowest", "profile"]

_ELEMENT = 5.0  # sheet units; the shape is smooth
_FIRST = 0.02  # first guess of a slack sheet's sag over the gauge
_BUDGET = 400
_ALONG, _ACROSS = 41, 9  # places at which it is known how far the membrane hangs
_WAYS = ((0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))


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


def profile(shape: Shape) -> RegularGridInterpolator:
    """Return how far a free sheet hangs, m, by the place along it and across it, each from -1/2 to 1/2; 0 beyond."""
    from scipy.interpolate import RegularGridInterpolator

    down = -shape.points(_ACROSS, _ALONG)[..., 2]
    grid = np.linspace(-0.5, 0.5, _ALONG), np.linspace(-0.5, 0.5, _ACROSS)
    return RegularGridInterpolator(grid, down, bounds_error=False, fill_value=0.0)


def lift(
    hangs: RegularGridInterpolator, sheet: Sheet, stretch: float, body: Indenter | Several, at: tuple[float, float]
) -> float:
    """Return how far a free sheet hangs, m, over the top of a body at a place, or over that part of it where it hangs most."""
    tops, length = _tops(body, at), sheet.span(stretch) * sheet.unit
    down = hangs((tops[:, 1] / length, tops[:, 0] / sheet.width))
    return max(0.0, float((down - tops[:, 2]).max()))


def _tops(body: Indenter | Several, at: tuple[float, float]) -> npt.NDArray[np.float64]:
    """Return (n, 3) float, m: where the tops of a body are, the ends of flat ones too, and how far below the highest."""
    found = []
    for part in body.parts if isinstance(body, Several) else (Part(body, (0.0, 0.0)),):
        middle = np.add(np.add(at, part.at), part.indenter.peak)
        found += [(*(middle + part.indenter.flat * np.array(way)), part.below) for way in _WAYS]
    return np.array(found)
