"""Presses whose answer is known from elsewhere, and an energy whose slope is the force."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.points import REFERENCE, Answer, Setting
from stretch_bt.simulation.membrane.axisymmetric import CircularMembrane
from stretch_bt.simulation.membrane.materials import NeoHookean
from stretch_bt.simulation.membrane.press import press
from stretch_bt.simulation.membrane.sheet.settings import Settings

__all__ = ["jobs"]

# of an independent shooting program, good to 1e-8: prestretch, depth over the clamp radius, force over
# shear modulus x thickness x clamp radius; the sphere's radius is 0.2 of the clamp's
_ROUND, _ROUND_ERROR = ((1.0, 0.3, 0.12680261), (1.2, 0.3, 0.54221102), (1.5, 0.6, 1.21905393)), 1e-8
_SPHERE = 0.2
# of an independent finite-element program, good to 0.4 %: depth, m, force over shear modulus, m^2
_SHEET, _SHEET_ERROR = ((0.005, 5.74e-6), (0.010, 15.19e-6), (0.015, 27.42e-6)), 0.004
_DIFFERENCE = 1e-3
_CENTRAL = {-2: 1 / 12, -1: -8 / 12, 1: 8 / 12, 2: -1 / 12}  # fourth order
_SERIES = "axisymmetric, round membrane"


def jobs() -> Iterator[Job]:
    """Yield the axisymmetric solver against known forces and the slope of its own energy, and the sheet's reference against known forces."""
    for prestretch, depth, force in _ROUND:
        case = f"round membrane, prestretch {prestretch:g}, depth {depth:g} of its radius"
        known = partial(_known, prestretch, depth, force)
        yield Job(case, Setting(_SERIES, "known force"), "force", 2.0, known)
        yield Job(case, Setting(_SERIES, "slope of its energy"), "force", 6.0, partial(_slope, prestretch, depth))
    for depth, force in _SHEET:
        case = f"sphere 20 mm, stretch 30 mm, depth {depth * 1e3:g} mm"
        yield Job(case, Setting("reference", "known force"), "force", 1.5, partial(_sheet, depth, force))


def _membrane(prestretch: float) -> CircularMembrane:
    return CircularMembrane(1.0, 1.0, NeoHookean(1.0), prestretch)


def _known(prestretch: float, depth: float, force: float) -> list[Answer]:
    solved = _membrane(prestretch).press(_SPHERE, depth)
    return [Answer("force", abs(solved.force / force - 1), solved.seconds, _ROUND_ERROR)]


def _slope(prestretch: float, depth: float) -> list[Answer]:
    membrane = _membrane(prestretch)
    solved = membrane.press(_SPHERE, depth)
    energies = [membrane.press(_SPHERE, depth + k * _DIFFERENCE).energy for k in _CENTRAL]
    slope = float(np.dot(list(_CENTRAL.values()), energies)) / _DIFFERENCE
    return [Answer("force", abs(solved.force / slope - 1), solved.seconds)]


def _sheet(depth: float, force: float) -> list[Answer]:
    solved = press("sphere:20mm", 0.03, depth, shear_modulus=1.0, settings=Settings(mesh=0.5e-3, growth=1.2))
    error = abs(solved.force / force - 1)
    return [Answer("force", error, solved.seconds, _SHEET_ERROR, status=REFERENCE)]
