"""The membrane sticks to the object as far as Coulomb friction allows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.advisor.power_law import PowerLaw
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import MembraneEffect, Size
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.sheet.effects import Effects as SheetEffects
    from stretch_bt.simulation.objects.base import Holds

__all__ = ["Friction"]

#: for each shape that holds the membrane up: change of the force as a part of it, of the height over the middle, m, and of a length at four
#: fifths of the depth, m, fitted to sheets solved with friction and without (benchmarks/effect_estimates.py)
_FORCE: Mapping[Holds, PowerLaw] = {
    "rim": PowerLaw(0.0256, depth=1.05, contact=-0.1, strain=0.55, friction=0.65, wide=-1.0),
    "ridge": PowerLaw(0.0306, depth=0.95, contact=0.2, friction=0.6, wide=-0.45),
    "crest": PowerLaw(0.0347, depth=0.7, contact=-1.14, strain=0.2, friction=0.5, wide=-0.35, aspect=0.74),
    "dome": PowerLaw(0.0175, depth=1.25, strain=0.7, friction=0.8),
    "point": PowerLaw(0.0122, depth=1.0, strain=0.7, friction=0.5),
}
#: the same change of the force over a flat top with corners
_CORNERED = PowerLaw(0.0395, depth=1.1, contact=-0.69, strain=0.66, friction=0.5, wide=-1.51, aspect=0.55)
#: and over several objects, whatever they are: the sheet slides from one to the next
_BESIDE = PowerLaw(0.0219, depth=0.62, strain=0.09, friction=0.6)
_HEIGHT: Mapping[Holds, PowerLaw] = {
    "rim": PowerLaw(0.015e-3, depth=1.7, friction=1.0),
    "ridge": PowerLaw(0.006e-3, depth=1.7, friction=1.0),
    "crest": PowerLaw(0.006e-3, depth=1.7, friction=1.0),
    "dome": PowerLaw(0.013e-3, depth=1.7, friction=1.0),
    "point": PowerLaw(0.030e-3, depth=1.7, friction=1.0),
}
_SIZE: Mapping[Holds, PowerLaw] = {
    "rim": PowerLaw(0.60e-3, depth=0.95, contact=-1.2, strain=1.0, friction=0.7),
    "ridge": PowerLaw(0.34e-3, depth=1.3, strain=0.4, friction=0.9),
    "crest": PowerLaw(0.38e-3, depth=1.3, strain=0.4, friction=0.9),
    "dome": PowerLaw(0.70e-3, depth=1.1, strain=0.8, friction=0.8),
    "point": PowerLaw(0.45e-3, depth=1.2, strain=0.5, friction=0.8),
}


class Parameters(base.Parameters):
    """Coulomb's coefficient."""

    coefficient: Annotated[float, Within(0.0, 5.0)] = Field(
        default=0.5, description="coefficient of friction; 0.25 to 0.75 is usual for silicone"
    )


class Friction(MembraneEffect):
    """The membrane sticks to the object as far as Coulomb friction allows."""

    name = "friction"
    order = 4
    cost_ms = 50.0
    cost_per = "reading"
    under_one = ("height", "size")
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the effect of keeping the sheet from sliding over the body: the sheet pulls harder, the further it would slide.

        It slides towards the clamps, so that a long top that lies across the hand holds less of it than one that lies along the stretch.
        """
        mu = max(parameters.coefficient, 1e-3)
        why = f"a coefficient of {parameters.coefficient:g} at a strain of {case.taut:.2g}"
        how = {"depth": case.depth, "contact": case.held_radius, "strain": case.taut, "friction": mu}
        holds = case.rough.holds
        law = _BESIDE if case.rough.several else _CORNERED if case.rough.cornered else _FORCE[holds]
        yield from case.from_force(law.at(**how, aspect=case.rough.aspect), why, way=1)
        yield Size("height", _HEIGHT[holds].at(**how), why)
        yield Size("size", _SIZE[holds].at(**how), why, way=1)

    def on_sheet(self, effects: SheetEffects) -> SheetEffects:
        """Return the sheet's effects with it."""
        return replace(effects, friction=self.parameters.coefficient)
