"""Presses whose answer is known from elsewhere, and an energy whose slope is the force."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stretch_bt.accuracy.points import REFERENCE, Point
from stretch_bt.simulation.membrane.axisymmetric import CircularMembrane
from stretch_bt.simulation.membrane.materials import NeoHookean
from stretch_bt.simulation.membrane.press import press
from stretch_bt.simulation.membrane.sheet.settings import Settings

__all__ = ["axisymmetric", "sheet"]

# of an independent shooting program, good to 1e-8: prestretch, depth over the clamp radius, force over
# shear modulus x thickness x clamp radius; the sphere's radius is 0.2 of the clamp's
_ROUND = ((1.0, 0.3, 0.12680261), (1.2, 0.3, 0.54221102), (1.5, 0.6, 1.21905393))
_SPHERE = 0.2
# of an independent finite-element program, good to 0.4 %: depth, m, force over shear modulus, m^2
_SHEET = ((0.005, 5.74e-6), (0.010, 15.19e-6), (0.015, 27.42e-6))
_DIFFERENCE = 1e-3
_CENTRAL = {-2: 1 / 12, -1: -8 / 12, 1: 8 / 12, 2: -1 / 12}  # fourth order


def axisymmetric(quick: bool) -> Iterator[Point]:
    """Yield the axisymmetric solver against known forces, and against the slope of its own energy."""
    for prestretch, depth, force in _ROUND[:1] if quick else _ROUND:
        membrane = CircularMembrane(1.0, 1.0, NeoHookean(1.0), prestretch)
        solved = membrane.press(_SPHERE, depth)
        case = f"round membrane, prestretch {prestretch:g}, depth {depth:g} of its radius"
        error = abs(solved.force / force - 1)
        yield Point(case, "axisymmetric, round membrane: known force, good to 1e-8", "force", error, solved.seconds)
        energies = [membrane.press(_SPHERE, depth + k * _DIFFERENCE).energy for k in _CENTRAL]
        slope = float(np.dot(list(_CENTRAL.values()), energies)) / _DIFFERENCE
        error = abs(solved.force / slope - 1)
        yield Point(case, "axisymmetric, round membrane: slope of its energy", "force", error, solved.seconds)


def sheet(quick: bool) -> Iterator[Point]:
    """Yield the sheet's reference against known forces."""
    for depth, force in _SHEET[1:2] if quick else _SHEET:
        solved = press("sphere:20mm", 0.03, depth, shear_modulus=1.0, settings=Settings(mesh=0.5e-3, growth=1.2))
        case = f"sphere 20 mm, stretch 30 mm, depth {depth * 1e3:g} mm"
        error = abs(solved.force / force - 1)
        yield Point(case, "reference: known force, good to 0.4 %", "force", error, solved.seconds, REFERENCE)
