"""The membrane sags under its own weight."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from stretch_bt.simulation.advisor.case import DENSITY, GAUGE, Case
from stretch_bt.simulation.advisor.power_law import PowerLaw
from stretch_bt.simulation.effects.base import MembraneEffect, Size

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.sheet.effects import Effects as SheetEffects
    from stretch_bt.simulation.objects.base import Holds

__all__ = ["Sag"]

_USUAL = 0.01535  # weight of 100 mm of silicone over the usual shear modulus, for which these hold
#: for each shape that holds the membrane up: change of the force as a part of it, of the height over the middle, m, and of a length at four
#: fifths of the depth, m, fitted to sheets solved with weight and without (benchmarks/effect_estimates.py)
_FORCE: Mapping[Holds, PowerLaw] = {
    "rim": PowerLaw(0.0304, depth=-1.0, strain=-0.5),
    "ridge": PowerLaw(0.0341, depth=-1.0, strain=-0.5),
    "crest": PowerLaw(0.0335, depth=-1.0, strain=-0.5),
    "dome": PowerLaw(0.0387, depth=-1.0, strain=-0.5),
    "point": PowerLaw(0.0423, depth=-1.0, strain=-0.5),
}
_HEIGHT: Mapping[Holds, PowerLaw] = {
    "rim": PowerLaw(0.0039e-3, contact=1.3, strain=-1.2),
    "ridge": PowerLaw(0.0025e-3, strain=-0.5),
    "crest": PowerLaw(0.002e-3, strain=-0.5),
    "dome": PowerLaw(0.002e-3, strain=-0.5),
    "point": PowerLaw(0.004e-3, strain=-0.5),
}
_SIZE: Mapping[Holds, PowerLaw] = {
    "rim": PowerLaw(0.50e-3, depth=-1.0, contact=-1.0, strain=-0.2),
    "ridge": PowerLaw(0.61e-3, depth=-1.0, strain=-0.2),
    "crest": PowerLaw(0.41e-3, depth=-1.0, strain=-0.2),
    "dome": PowerLaw(0.39e-3, depth=-1.0, strain=-0.2),
    "point": PowerLaw(0.40e-3, depth=-1.0, strain=-0.2),
}


class Sag(MembraneEffect):
    """The membrane sags under its own weight."""

    name = "sag"
    order = 1
    cost_ms = 2.0
    cost_per = "solve"
    under_one = ("height", "size")

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the sag of a membrane under tension, w L^2 / 8 T, that a press leaves, and the force that its weight adds.

        Where an object holds the membrane up it no longer sags; but it touched the object earlier by the sag, and is pressed harder.
        A stiffness depends on where the touch began: its change goes with the sag over the depth.
        """
        sag, holds = case.sag, case.rough.holds
        why = f"hangs by {sag * 1e3:.2g} mm at a tension of {case.hung:.3g} N/m"
        how = {"depth": case.depth, "contact": case.held_radius, "strain": max(case.strain, 1e-3)}
        heavy = DENSITY * 9.81 * GAUGE / case.scene.hand.shear_modulus / _USUAL
        yield Size("height", max(sag - case.depth, _HEIGHT[holds].at(**how) * heavy), why)
        yield Size("size", _SIZE[holds].at(**how) * heavy, why, way=-1)
        part = _FORCE[holds].at(**how) * heavy
        yield from case.from_force(part, why, way=1, stiffness=1.5 * sag / case.depth, gives=0.0)

    def on_sheet(self, effects: SheetEffects) -> SheetEffects:
        """Return the sheet's effects with it."""
        from stretch_bt.simulation.membrane.sheet.effects import DENSITY

        return replace(effects, sag=DENSITY)
