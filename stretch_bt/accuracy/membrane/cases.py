"""Which presses are measured, and how the sheet is solved."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.cone import Cone
from stretch_bt.simulation.membrane.indenters.cube import Cube
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.several import Part, Several
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.indenters.wire import Wire
from stretch_bt.simulation.membrane.sheet.settings import Settings

__all__ = ["REFINEMENT", "STEP", "Case", "Variant", "cases", "reference_settings", "variants"]

STEP = 1e-3  # m, of a warm start
REFINEMENT = 1.4  # elements of the second reference over those of the first
_DEPTHS, _MIDDLE = (0.003, 0.008, 0.015), (0.008,)
_GROWTH = 1.2  # at the usual 1.6 the coarse elements far off cost the force 0.06 %, whatever those in the contact do

_BUDGET = 5000  # a slack sheet needs more iterations the finer it is


class Case(NamedTuple):
    """One press: lengths in m; `finest` is the length of the smallest elements of its reference."""

    shape: str
    indenter: Indenter | Several
    stretch: float
    depth: float
    finest: float = 0.5e-3

    @property
    def name(self) -> str:
        """What is pressed how far, in words."""
        return f"{self.shape}, stretch {self.stretch * 1e3:g} mm, depth {self.depth * 1e3:g} mm"


@dataclass(frozen=True, slots=True)
class Variant:
    """A way to solve the sheet: `name` is a series and a variant of it; `costly` ones are run for few presses."""

    name: str
    settings: Settings
    warm: bool
    costly: bool = False

    def takes(self, case: Case) -> bool:
        """Whether this press is solved in this way."""
        return not self.costly or (case.depth in _MIDDLE and case.stretch == 0.03)


def cases(quick: bool) -> list[Case]:
    """Return the presses, of which `quick` takes three."""
    sphere, slender, cylinder = Sphere(0.02), Sphere(0.008), Cylinder(0.02)
    if quick:
        return [
            Case("sphere 20 mm", sphere, 0.03, 0.008),
            Case("sphere 8 mm", slender, 0.08, 0.008),
            Case("cylinder 20 mm", cylinder, 0.03, 0.008),
        ]
    pair = Several((Part(Sphere(0.012), (-0.014, 0.0)), Part(Sphere(0.012), (0.014, 0.0))))
    wide = [0.01, 0.03, 0.08]
    shapes: list[tuple[str, Indenter | Several, list[float], float]] = [
        ("sphere 20 mm", sphere, [0.0, 0.01, 0.03, 0.06, 0.08], 0.5e-3),
        ("sphere 8 mm", slender, wide, 0.5e-3),
        ("sphere 30 mm", Sphere(0.03), wide, 0.5e-3),
        ("cylinder 20 mm", cylinder, [0.03], 0.5e-3),
        ("cone 45 degrees", Cone(math.pi / 4), [0.03], 0.2e-3),
        ("cube 40 mm", Cube(0.04), [0.03], 0.5e-3),
        ("wire 1.5 mm", Wire(0.0015, 0.2), [0.03], 0.3e-3),
        ("two spheres 12 mm", pair, [0.03], 0.5e-3),
    ]
    return [
        Case(name, indenter, stretch, depth, finest)
        for name, indenter, stretches, finest in shapes
        for stretch, depth in product(stretches, _DEPTHS)
    ]


def variants(quick: bool) -> list[Variant]:
    """Return the ways to solve the sheet, coarse ones first."""
    uniform = [(f"uniform, exact: {mm} mm", Settings(mesh=mm * 1e-3, growth=1.0)) for mm in (8, 4, 2, 1)]
    graded = [(f"graded, exact: {scale:g} of the default", Settings(coarsen=scale)) for scale in (2.2, 1.25, 1.0, 0.6)]
    loop = [(f"graded, settled: within {error * 100:g} %", Settings.within(error)) for error in (0.03, 0.01, 0.003)]
    if quick:
        uniform, graded = uniform[:2], [graded[0], graded[2]]
    return [
        Variant(f"sheet {start}, {name}", settings, start == "warm", costly=settings.mesh == 1e-3)
        for start in ("cold", "warm")
        for name, settings in uniform + graded + loop
    ]


def reference_settings(case: Case) -> tuple[Settings, Settings]:
    """Return the settings of the reference, and of the coarser press that its own error is read from."""
    fine = Settings(mesh=case.finest, growth=_GROWTH, budget=_BUDGET)
    return fine, replace(fine, mesh=case.finest * REFINEMENT, growth=_GROWTH**REFINEMENT)
