"""Which presses are measured, and how the sheet is solved."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

from stretch_bt.accuracy.points import Setting
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.cone import Cone
from stretch_bt.simulation.membrane.indenters.cube import Cube
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.several import Part, Several
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.indenters.wire import Wire
from stretch_bt.simulation.membrane.sheet.settings import Settings

__all__ = ["DEFAULT", "REFINEMENT", "STEP", "Case", "Variant", "cases", "quick_cases", "reference_settings", "variants"]

STEP = 1e-3  # m, of a warm start
REFINEMENT = 1.4  # length of the second reference's elements over the first's
_DEPTHS, _MIDDLE = (0.003, 0.008, 0.015), (0.008,)
_WIDE = (0.01, 0.03, 0.08)  # m, stretches
_GROWTH = 1.2  # at the usual 1.6 the coarse elements far off cost the force 0.06 %, whatever those in the contact do

DEFAULT = Settings()
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
        """Shape, stretch and depth of the press, in words."""
        return f"{self.shape}, stretch {self.stretch * 1e3:g} mm, depth {self.depth * 1e3:g} mm"


@dataclass(frozen=True, slots=True)
class Variant:
    """A way to solve the sheet; `costly` ones are run for few presses."""

    name: Setting
    settings: Settings
    warm: bool
    costly: bool = False

    def takes(self, case: Case) -> bool:
        """Whether this press is solved in this way."""
        return not self.costly or (case.depth in _MIDDLE and case.stretch == 0.03)


def quick_cases() -> list[Case]:
    """Return the presses that little time is given to."""
    return [
        Case("sphere 20 mm", Sphere(0.02), 0.03, 0.008),
        Case("sphere 8 mm", Sphere(0.008), 0.08, 0.008),
        Case("cylinder 20 mm", Cylinder(0.02), 0.03, 0.008),
    ]


def cases() -> list[Case]:
    """Return the presses."""
    pair = Several((Part(Sphere(0.012), (-0.014, 0.0)), Part(Sphere(0.012), (0.014, 0.0))))
    shapes: list[tuple[str, Indenter | Several, tuple[float, ...], tuple[float, ...], float]] = [
        ("sphere 20 mm", Sphere(0.02), (0.0, 0.01, 0.03, 0.06, 0.08), _DEPTHS, 0.5e-3),
        ("sphere 8 mm", Sphere(0.008), _WIDE, _MIDDLE, 0.5e-3),
        ("sphere 30 mm", Sphere(0.03), _WIDE, _MIDDLE, 0.5e-3),
        ("cylinder 20 mm", Cylinder(0.02), (0.03,), _DEPTHS, 0.5e-3),
        ("cone 45 degrees", Cone(math.pi / 4), (0.03,), _DEPTHS, 0.2e-3),
        ("cube 40 mm", Cube(0.04), (0.03,), _DEPTHS[:2], 0.5e-3),
        ("wire 1.5 mm", Wire(0.0015, 0.2), (0.03,), _MIDDLE, 0.3e-3),
        ("two spheres 12 mm", pair, (0.03,), _DEPTHS[:2], 0.5e-3),
    ]
    return [
        Case(name, indenter, stretch, depth, finest)
        for name, indenter, stretches, depths, finest in shapes
        for stretch, depth in product(stretches, depths)
    ]


def variants() -> list[Variant]:
    """Return the ways to solve the sheet, coarse ones first."""
    uniform = {f"{mm} mm": Settings(mesh=mm * 1e-3, growth=1.0) for mm in (8, 4, 2, 1)}
    graded = {f"Settings(coarsen={scale:g})": Settings(coarsen=scale) for scale in (2.2, 1.25, 1.0, 0.6)}
    graded = {"Settings()" if settings == DEFAULT else name: settings for name, settings in graded.items()}
    loop = {f"Settings.within({error:g})": Settings.within(error) for error in (0.03, 0.01, 0.003)}
    return [
        Variant(Setting(f"sheet from {start}{kind}", name), settings, start != "flat", settings.growth == 1)
        for start in ("flat", "the last press")
        for kind, ways in (("", graded), (", settled", loop), (", uniform elements", uniform))
        for name, settings in ways.items()
    ]


def reference_settings(case: Case) -> tuple[Settings, Settings]:
    """Return the settings of the reference, and of the coarser press that its own error is read from."""
    fine = Settings(mesh=case.finest, growth=_GROWTH, budget=_BUDGET)
    return fine, replace(fine, mesh=case.finest * REFINEMENT, growth=_GROWTH**REFINEMENT)
